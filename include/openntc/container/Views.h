// SPDX-License-Identifier: MIT
// Stability: internal
// Buffer views of a file: whether one is as large as its reader needs, and its bytes.
#pragma once

#include "openntc/container/Document.h"
#include "openntc/core/Expected.h"
#include "openntc/core/Stream.h"

#include <cstddef>
#include <cstdint>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc::container {

/// Names an element of an array of the document in messages: "mlp" + ".layers" + [2]. Only failures format
/// it.
struct ElementPath {
    const char* owner;
    const char* array;
    std::size_t index;
};

/// Checks the index of a view and that it stores at least `minimumBytes`, not compressed; that it lies inside
/// the binary chunk is what ReadContainer has checked. `member` names the field. Errors: FileUnrecognized.
inline Expected<void> CheckView(std::span<const BufferView> views, std::uint32_t index,
                                std::uint64_t minimumBytes, const ElementPath& path,
                                const char* member) noexcept {
    if (index >= views.size())
        return Fail(Status::FileUnrecognized, "%s%s[%zu].%s: %u: the file has %zu views", path.owner,
                    path.array, path.index, member, index, views.size());
    if (views[index].storedSize < minimumBytes)
        return Fail(Status::FileUnrecognized,
                    "%s%s[%zu].%s: views[%u].storedSize: %llu: needs at least %llu bytes", path.owner,
                    path.array, path.index, member, index,
                    static_cast<unsigned long long>(views[index].storedSize),
                    static_cast<unsigned long long>(minimumBytes));
    if (views[index].compression == Compression::GDeflate)
        return Fail(
            Status::FileUnrecognized,
            "%s%s[%zu].%s: views[%u].compression: GDeflate: only latents and BC7 modes may be compressed",
            path.owner, path.array, path.index, member, index);
    return {};
}

/// Where the views of a file are. The stream and the document outlive it.
struct BinaryChunk {
    Stream* stream;
    std::uint64_t offset; ///< of the binary chunk in the stream
    std::span<const BufferView> views;
};

/// Reads the first bytes of a checked view. Errors: IOError.
inline Expected<void> ReadView(const BinaryChunk& chunk, std::uint32_t view,
                               std::span<std::byte> destination) noexcept {
    const std::uint64_t offset = chunk.offset + chunk.views[view].offset;
    if (!chunk.stream->Seek(offset) || !chunk.stream->Read(destination.data(), destination.size()))
        return Fail(Status::IOError, "views[%u]: %zu bytes at %llu: cannot be read", view, destination.size(),
                    static_cast<unsigned long long>(offset));
    return {};
}

} // namespace openntc::container

#include "openntc/core/RestoreMacros.h"
