// SPDX-License-Identifier: MIT
// Stability: internal
// JSON text to Document: RapidJSON's parser, without memory of its own, feeding DocumentHandler, which ends
// its recursion at kMaxJsonDepth levels. (Its parser without recursion is slower: `ntc bench load`.)
#pragma once

#include "openntc/container/DocumentChecks.h"
#include "openntc/container/DocumentHandler.h"
#include "openntc/container/RapidJson.h"
#include "openntc/container/Utf8.h"

#include <cstddef>
#include <span>
#include <string_view>

#include "openntc/core/HideMacros.h"

namespace openntc::container {
namespace detail {

/// Memory for RapidJSON's stack: one fixed block, so that it can never ask for more.
class ParserStackAllocator {
public:
    static constexpr bool kNeedFree = false;
    static constexpr std::size_t kBytes = 1024;

    void* Malloc(std::size_t bytes) noexcept { return bytes <= kBytes ? block_ : nullptr; }
    void* Realloc(void*, std::size_t, std::size_t bytes) noexcept {
        return bytes <= kBytes ? block_ : nullptr;
    }
    static void Free(void*) noexcept {}

private:
    alignas(std::max_align_t) unsigned char block_[kBytes];
};

} // namespace detail

/// What ParseDocument takes from its allocator at most, at any time: 8 bytes for each of the text, and what
/// the few elements need that may be empty objects (16 networks, 16 channels and 16 mips, of 3 bytes of text
/// each).
constexpr std::size_t GetMaxDocumentBytes(std::size_t jsonBytes) noexcept {
    return 8 * jsonBytes + 4096;
}

/// Parses JSON text in place: `text` is overwritten and its last character must be NUL; what follows the
/// first NUL is ignored. The document's memory comes from `allocator`; peak memory is below
/// GetMaxDocumentBytes. Enumeration strings are compared case-insensitively, a bare object stands for an
/// array of one, the last of repeated scalars counts; keys that the generation does not have are skipped.
/// Errors: FileUnrecognized with the JSON path, OutOfMemory.
inline Expected<Document> ParseDocument(std::span<char> text, Allocator& allocator) noexcept {
    if (text.empty() || text.back() != '\0')
        return Fail(Status::InvalidArgument, "JSON: text: must end with NUL");
    // RapidJSON can validate too, but only byte by byte.
    if (!IsValidUtf8(std::string_view(text.data())))
        return Fail(Status::FileUnrecognized, "JSON: text: must be UTF-8");
    const std::string_view view(text.data());
    const std::uint32_t generation = detail::FindSchemaVersion(view).value_or(kMinSchemaVersion);
    const bool isVersionNamed = view.find("schemaVersion") != std::string_view::npos;
    OPENNTC_CHECK(CheckSchemaVersion(generation));
    Document document = MakeRecord<Document>(allocator);
    detail::ParserStackAllocator stack;
    rapidjson::GenericReader<rapidjson::UTF8<>, rapidjson::UTF8<>, detail::ParserStackAllocator> reader(
        &stack, detail::ParserStackAllocator::kBytes);
    rapidjson::InsituStringStream stream(text.data());
    detail::DocumentHandler handler(document, generation, isVersionNamed, allocator);
    constexpr unsigned kFlags = rapidjson::kParseInsituFlag | rapidjson::kParseNumbersAsStringsFlag;
    const rapidjson::ParseResult parsed = reader.Parse<kFlags>(stream, handler);
    OPENNTC_CHECK(handler.Finish(parsed));
    if (document.schemaVersion != generation)
        return Fail(Status::FileUnrecognized, "schemaVersion: %u: its key: must be written without escapes",
                    document.schemaVersion);
    return document;
}

} // namespace openntc::container

#include "openntc/core/RestoreMacros.h"
