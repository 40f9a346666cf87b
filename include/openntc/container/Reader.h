// SPDX-License-Identifier: MIT
// Stability: stable
// Reading a texture-set file: header, JSON document, and the ranges of its buffer views.
#pragma once

#include "openntc/container/DocumentChecks.h"
#include "openntc/container/Header.h"
#include "openntc/container/JsonReader.h"
#include "openntc/core/Stream.h"

#include "openntc/core/HideMacros.h"

namespace openntc::container {

/// Reads and checks everything but the binary chunk: header, JSON document, every view inside the binary
/// chunk (offset a multiple of 4) and every view index in range. What networks, latents and textures mean is
/// checked by TextureSetMetadata. Offsets in the file count from position 0 of the stream, wherever it stands
/// when called. Errors: IOError if the stream fails, OutOfMemory, FileUnrecognized naming the JSON path, the
/// value and the limit.
inline Expected<Container> ReadContainer(Stream& stream,
                                         Allocator& allocator = GetDefaultAllocator()) noexcept {
    HeaderBytes headerBytes;
    if (!stream.Seek(0) || !stream.Read(headerBytes.data(), headerBytes.size()))
        return Fail(Status::IOError, "header: cannot be read: the stream must have %llu bytes or more",
                    static_cast<unsigned long long>(kHeaderBytes));
    Container container;
    container.streamSize = stream.Size();
    OPENNTC_ASSIGN(const Header header, DecodeHeader(headerBytes, container.streamSize));
    container.binaryOffset = header.binaryOffset;
    container.binarySize = header.binarySize;

    const auto jsonBytes = static_cast<std::size_t>(header.jsonSize);
    Array<char> json(allocator);
    OPENNTC_CHECK(json.Resize(jsonBytes + 1));
    if (!stream.Seek(header.jsonOffset) || !stream.Read(json.data(), jsonBytes))
        return Fail(Status::IOError, "JSON chunk: %zu bytes at offset %llu: cannot be read", jsonBytes,
                    static_cast<unsigned long long>(header.jsonOffset));
    OPENNTC_ASSIGN(container.document, ParseDocument(json.AsSpan(), allocator));
    OPENNTC_CHECK(CheckViewRanges(container.document, container.binarySize));
    OPENNTC_CHECK(CheckViewIndices(container.document));
    return container;
}

} // namespace openntc::container

#include "openntc/core/RestoreMacros.h"
