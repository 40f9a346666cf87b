// SPDX-License-Identifier: MIT
// Stability: experimental
// What tells whether two tile sources were made from the same file.
#pragma once

#include "openntc/core/Allocator.h"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <system_error>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// For TileSource::GetIdentity: the file's absolute path without links, its size, and when it was written; so
/// a file that was written again is another one. Empty if the system does not say: then it is like no other.
/// Errors: OutOfMemory.
inline Expected<Array<std::byte>> MakeFileIdentity(const std::filesystem::path& path,
                                                   Allocator& allocator = GetDefaultAllocator()) {
    Array<std::byte> identity(allocator);
    std::error_code error;
    const std::filesystem::path canonical = std::filesystem::canonical(path, error);
    if (error)
        return identity;
    const std::uint64_t size = std::filesystem::file_size(canonical, error);
    if (error)
        return identity;
    const auto written = std::filesystem::last_write_time(canonical, error).time_since_epoch().count();
    if (error)
        return identity;
    const std::filesystem::path::string_type& name = canonical.native();
    const std::size_t nameBytes = name.size() * sizeof(name[0]);
    OPENNTC_CHECK(identity.Resize(sizeof(size) + sizeof(written) + nameBytes));
    std::memcpy(identity.data(), &size, sizeof(size));
    std::memcpy(identity.data() + sizeof(size), &written, sizeof(written));
    if (nameBytes > 0)
        std::memcpy(identity.data() + sizeof(size) + sizeof(written), name.data(), nameBytes);
    return identity;
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
