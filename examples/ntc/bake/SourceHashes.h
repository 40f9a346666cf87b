// SPDX-License-Identifier: MIT
// Contents of source files as digests, read again only where size or time of a file say that it may have changed.
#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string>

namespace openntc::tool {

/// What a file system says of a file without reading it.
struct FileStamp {
    std::uint64_t bytes = 0;
    std::int64_t time = 0; ///< of the last change, in ticks of the file system's clock

    bool operator==(const FileStamp&) const = default;
};

/// nullopt: there is no such regular file.
std::optional<FileStamp> ReadStamp(const std::string& path);

struct SourceHash {
    FileStamp stamp;
    std::string digest; ///< MakeFileDigest
    /// False: another change may have left the stamp as it is; only reading tells.
    bool isSettled = true;

    bool operator==(const SourceHash&) const = default;
};

/// May be asked from several threads.
class SourceHashes {
public:
    /// What an earlier run knows of a file.
    void Remember(const std::string& path, const SourceHash& hash);

    /// The digest of the file as it is. Throws CommandError(BadInput).
    SourceHash Get(const std::string& path);

    /// The digest, if it is known without reading the file.
    std::optional<SourceHash> Find(const std::string& path) const;

private:
    mutable std::mutex mutex_;
    std::map<std::string, SourceHash> known_; // by path
};

} // namespace openntc::tool
