// SPDX-License-Identifier: MIT
#include "bake/SourceHashes.h"

#include "Failure.h"
#include "encode/ContentKey.h"

#include <chrono>
#include <filesystem>

namespace openntc::tool {

namespace {

/// True if the file was changed so lately that another change may leave its stamp as it is.
bool IsRecent(const FileStamp& stamp) {
    constexpr std::chrono::seconds kCoarsest{2}; // FAT's clock; others tick faster
    const auto now = std::filesystem::file_time_type::clock::now().time_since_epoch();
    return std::filesystem::file_time_type::duration(stamp.time) > now - kCoarsest;
}

} // namespace

std::optional<FileStamp> ReadStamp(const std::string& path) {
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error))
        return std::nullopt;
    FileStamp stamp;
    stamp.bytes = std::filesystem::file_size(path, error);
    if (error)
        return std::nullopt;
    const auto time = std::filesystem::last_write_time(path, error);
    if (error)
        return std::nullopt;
    stamp.time = static_cast<std::int64_t>(time.time_since_epoch().count());
    return stamp;
}

void SourceHashes::Remember(const std::string& path, const SourceHash& hash) {
    const std::lock_guard lock(mutex_);
    known_[path] = hash;
}

std::optional<SourceHash> SourceHashes::Find(const std::string& path) const {
    const std::optional<FileStamp> stamp = ReadStamp(path);
    const std::lock_guard lock(mutex_);
    const auto found = known_.find(path);
    if (!stamp || found == known_.end() || !found->second.isSettled || !(found->second.stamp == *stamp))
        return std::nullopt;
    return found->second;
}

SourceHash SourceHashes::Get(const std::string& path) {
    if (const std::optional<SourceHash> known = Find(path))
        return *known;
    // The stamp of before the reading: a change meanwhile shows.
    const std::optional<FileStamp> stamp = ReadStamp(path);
    SourceHash hash{stamp.value_or(FileStamp{}), MakeFileDigest(path), stamp && !IsRecent(*stamp)};
    Remember(path, hash);
    return hash;
}

} // namespace openntc::tool
