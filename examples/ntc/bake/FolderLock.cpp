// SPDX-License-Identifier: MIT
#include "bake/FolderLock.h"

#include "Failure.h"
#include "Interrupt.h"
#include "Output.h"
#include "bake/BakeRecord.h"
#include "encode/ContentKey.h"

#include "openntc/core/FileStream.h"

#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <thread>

#if defined(_WIN32)
#include <fcntl.h>
#include <io.h>
#include <share.h>
#include <sys/locking.h>
#include <sys/stat.h>
#else
#include <fcntl.h>
#include <unistd.h>
#endif

namespace openntc::tool {

namespace {

/// A byte of the lock's file for a name, behind the first, which is the folder's. Two names on one byte would only wait
/// for each other.
long GetByte(const std::string& name) {
    constexpr unsigned long kBytes = 1ul << 30;
    const std::string digest = MakeDigest(std::as_bytes(std::span(name)));
    return 1 + static_cast<long>(std::strtoull(digest.substr(digest.rfind('-') + 1).c_str(), nullptr, 16) %
                                 kBytes);
}

#if defined(_WIN32)

int OpenLock(const char* path) {
    int file = -1;
    _sopen_s(&file, path, _O_RDWR | _O_CREAT | _O_BINARY, _SH_DENYNO, _S_IREAD | _S_IWRITE);
    return file;
}
void CloseLock(int file) {
    _close(file);
}
// The runtime's locks are exclusive: those who work at parts leave the folder's byte alone there.
bool TryLock(int file, long byte, bool isShared) {
    return isShared || (_lseek(file, byte, SEEK_SET) == byte && _locking(file, _LK_NBLCK, 1) == 0);
}
void Unlock(int file, long byte) {
    _lseek(file, byte, SEEK_SET);
    _locking(file, _LK_UNLCK, 1);
}
std::string DescribeOwner(int) {
    return "another bake";
}

#else

struct flock MakeLock(long byte, short type) {
    struct flock lock = {};
    lock.l_type = type;
    lock.l_whence = SEEK_SET;
    lock.l_start = byte;
    lock.l_len = 1;
    return lock;
}
int OpenLock(const char* path) {
    return open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0666);
}
void CloseLock(int file) {
    close(file);
}
bool TryLock(int file, long byte, bool isShared) {
    struct flock lock = MakeLock(byte, isShared ? F_RDLCK : F_WRLCK);
    return fcntl(file, F_SETLK, &lock) == 0;
}
void Unlock(int file, long byte) {
    struct flock lock = MakeLock(byte, F_UNLCK);
    fcntl(file, F_SETLK, &lock);
}
std::string DescribeOwner(int file) {
    struct flock lock = MakeLock(0, F_WRLCK);
    if (fcntl(file, F_GETLK, &lock) != 0 || lock.l_type == F_UNLCK || lock.l_pid <= 0)
        return "another bake";
    return Format("another bake (process %ld)", static_cast<long>(lock.l_pid));
}

#endif

} // namespace

FolderLock::FolderLock(const std::string& folder, Scope scope)
    : path_((std::filesystem::path(GetBakeFolder(folder)) / "lock").string()), scope_(scope) {
    std::error_code error;
    std::filesystem::create_directories(GetBakeFolder(folder), error);
    if (error)
        throw CommandError(ExitCode::Failed, folder, "folder: cannot be made: " + error.message());
    file_ = OpenLock(path_.c_str());
    if (file_ < 0)
        throw CommandError(ExitCode::Failed, path_,
                           Format("lock: cannot be opened: %s", SystemReason(errno).GetText()));
    if (TryLock(file_, 0, scope == Scope::Part))
        return;
    const int reason = errno;
    const bool isTaken = reason == EACCES || reason == EAGAIN;
    const std::string text = isTaken ? DescribeOwner(file_) + " works in this folder"
                                     : Format("cannot be taken: %s", SystemReason(reason).GetText());
    CloseLock(file_);
    throw CommandError(ExitCode::Failed, folder, "lock: " + text);
}

FolderLock::~FolderLock() {
    CloseLock(file_);
}

void FolderLock::LockName(const std::string& name) {
    constexpr std::chrono::milliseconds kPause{100};
    while (scope_ == Scope::Part && !TryLock(file_, GetByte(name), false)) {
        ThrowIfInterrupted();
        std::this_thread::sleep_for(kPause);
    }
}

void FolderLock::UnlockName(const std::string& name) {
    if (scope_ == Scope::Part)
        Unlock(file_, GetByte(name));
}

} // namespace openntc::tool
