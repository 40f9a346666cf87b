// SPDX-License-Identifier: MIT
// Stability: stable
// Writing a texture-set file: 40-byte header, JSON text with NUL, zeros up to a multiple of 4, then the views
// in index order, each followed by zeros up to a multiple of 4. Deterministic: the same input gives the same
// bytes.
#pragma once

#include "openntc/container/Header.h"
#include "openntc/container/JsonWriter.h"
#include "openntc/core/CheckedMath.h"
#include "openntc/core/FileStream.h"
#include "openntc/core/Stream.h"

#include <filesystem>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc::container {

/// What to write; the caller keeps it alive. `viewData[i]` are the bytes of `document->views[i]`, whose
/// offset and storedSize must be those that LayOutViews gives.
struct WriteRequest {
    const Document* document = nullptr;
    std::span<const std::span<const std::byte>> viewData;
};

/// Makes `document.views` fit the data: as many views, their sizes, and offsets one after the other at
/// multiples of 4. Compression, uncompressedSize and crc32 of views that exist already are kept. Errors:
/// OutOfRange, OutOfMemory.
inline Expected<void> LayOutViews(Document& document,
                                  std::span<const std::span<const std::byte>> viewData) noexcept {
    OPENNTC_CHECK(document.views.Resize(viewData.size()));
    std::uint64_t offset = 0;
    for (std::size_t i = 0; i < viewData.size(); ++i) {
        document.views[i].offset = offset;
        document.views[i].storedSize = viewData[i].size();
        const std::optional<std::uint64_t> end = CheckedAdd(offset, viewData[i].size());
        const std::optional<std::uint64_t> next = end ? CheckedAlignUp(*end, 4) : std::nullopt;
        if (!next)
            return Fail(Status::OutOfRange, "views[%zu]: the end of the view: must be below 2^64", i);
        offset = *next;
    }
    return {};
}

/// Writes a whole file from position 0 of the stream on. Nothing is written when the request is refused.
/// Errors: InvalidArgument and OutOfRange naming the JSON path for what a reader would refuse (schema
/// version, element counts, view indices, layout of the views, names, reals), IOError if the stream fails,
/// OutOfMemory.
inline Expected<void> WriteContainer(Stream& stream, const WriteRequest& request,
                                     Allocator& allocator = GetDefaultAllocator()) noexcept {
    if (request.document == nullptr)
        return Fail(Status::InvalidArgument, "document: null: is required");
    const Document& document = *request.document;
    if (document.schemaVersion < kMinSchemaVersion || document.schemaVersion > kMaxSchemaVersion)
        return Fail(Status::InvalidArgument, "schemaVersion: %u: must be %u to %u", document.schemaVersion,
                    kMinSchemaVersion, kMaxSchemaVersion);
    if (document.views.size() != request.viewData.size())
        return Fail(Status::InvalidArgument, "views: %zu elements: data is given for %zu",
                    document.views.size(), request.viewData.size());
    std::uint64_t binarySize = 0;
    for (std::size_t i = 0; i < document.views.size(); ++i) {
        const BufferView& view = document.views[i];
        if (view.storedSize != request.viewData[i].size() || view.offset != binarySize)
            return Fail(Status::InvalidArgument,
                        "views[%zu]: %llu bytes at offset %llu: must be %zu at offset %llu", i,
                        static_cast<unsigned long long>(view.storedSize),
                        static_cast<unsigned long long>(view.offset), request.viewData[i].size(),
                        static_cast<unsigned long long>(binarySize));
        const std::optional<std::uint64_t> end = CheckedAdd(binarySize, view.storedSize);
        const std::optional<std::uint64_t> next = end ? CheckedAlignUp(*end, 4) : std::nullopt;
        if (!next)
            return Fail(Status::OutOfRange, "views[%zu]: the end of the view: must be below 2^64", i);
        binarySize = *next;
    }
    if (const Expected<void> indices = CheckViewIndices(document); !indices)
        return Fail(Status::InvalidArgument, "%s", indices.error().GetText());
    OPENNTC_ASSIGN(Array<char> json, FormatDocument(document, allocator));
    OPENNTC_CHECK(json.PushBack('\0'));

    Header header;
    header.jsonSize = json.size();
    header.binaryOffset = (kHeaderBytes + json.size() + 3) & ~std::uint64_t{3};
    header.binarySize = binarySize;
    if (!CheckedAdd(header.binaryOffset, binarySize))
        return Fail(Status::OutOfRange, "views: the end of the file: must be below 2^64");

    constexpr std::byte kZeros[4] = {};
    const HeaderBytes headerBytes = EncodeHeader(header);
    const std::uint64_t gap = header.binaryOffset - kHeaderBytes - header.jsonSize;
    bool written = stream.Seek(0) && stream.Write(headerBytes.data(), headerBytes.size()) &&
                   stream.Write(json.data(), json.size()) &&
                   stream.Write(kZeros, static_cast<std::size_t>(gap));
    for (std::size_t i = 0; written && i < request.viewData.size(); ++i) {
        const std::span<const std::byte> data = request.viewData[i];
        written = stream.Write(data.data(), data.size()) && stream.Write(kZeros, (4 - data.size() % 4) % 4);
    }
    if (!written)
        return Fail(Status::IOError,
                    "writing: the stream: does not take the data (disk full or out of memory)");
    return {};
}

/// Writes a file under a temporary name in the same folder and renames it when it is complete; after an error
/// the destination is as it was. Errors: those of WriteContainer, FileUnavailable.
inline Expected<void> WriteContainerFile(const std::filesystem::path& path, const WriteRequest& request,
                                         Allocator& allocator = GetDefaultAllocator()) {
    OPENNTC_ASSIGN(FileWriter file, FileWriter::Create(path));
    OPENNTC_CHECK(WriteContainer(file, request, allocator));
    return file.Commit();
}

} // namespace openntc::container

#include "openntc/core/RestoreMacros.h"
