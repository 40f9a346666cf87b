// SPDX-License-Identifier: MIT
// Keeps two bakes of one folder apart. The system gives locks back however a process ends, and most file systems of
// networks keep them for all machines.
#pragma once

#include <string>

namespace openntc::tool {

class FolderLock {
public:
    enum class Scope {
        Whole, ///< nobody else
        Part,  ///< others of this scope, each with materials of its own (LockMaterial)
    };

    /// Throws CommandError(Failed) if the folder is locked by somebody else, or cannot be.
    FolderLock(const std::string& folder, Scope scope);
    ~FolderLock();
    FolderLock(const FolderLock&) = delete;
    FolderLock& operator=(const FolderLock&) = delete;

    /// With Scope::Part: waits until nobody else has the name, for this process until UnlockName or its end. Throws
    /// CommandError(Failed) on an interrupt.
    void LockName(const std::string& name);
    void UnlockName(const std::string& name);

private:
    std::string path_;
    Scope scope_;
    int file_ = -1;
};

} // namespace openntc::tool
