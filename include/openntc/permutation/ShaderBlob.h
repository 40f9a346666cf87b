// SPDX-License-Identifier: MIT
// Stability: stable
// One file with many shader permutations, as openntc_add_shaders(OUTPUT BLOB) and `ntc compile-shaders
// --blob` write it.
//
// The index is text, so that build scripts can write it and people can read it (`head -c 2000 shaders.bin`):
//
//   NTCSHADERS 1                       magic and version, 13 bytes with the line feed
//   CCCCCCCC TTTTTTTT                  permutations; bytes before the first SPIR-V word (a multiple of 4)
//   NTC_MATH=6 ...                     defines left out for want of a compiler; mostly an empty line
//   OOOOOOOO SSSSSSSS SOURCE|DEFINES   a line for every permutation: offset and size in bytes, both multiples
//                                      of 4
//
// then 0 to 3 line feeds and the SPIR-V modules, little-endian words. Numbers are eight lower-case
// hexadecimal digits, offsets count from the first byte of the file. Lines are sorted by the bytes of
// "SOURCE|DEFINES", the words of DEFINES likewise; SOURCE is a file name without its folder.
#pragma once

#include "openntc/core/Allocator.h"
#include "openntc/core/Expected.h"
#include "openntc/core/Stream.h"
#include "openntc/permutation/PermutationCover.h"
#include "openntc/permutation/ShaderLookup.h"

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// Looks permutations up in a blob that the caller keeps in memory. Immutable; may be used from any thread.
class ShaderBlob {
public:
    /// Checks the whole index; what it accepts, GetShader and Find never leave. `words`: the file's bytes.
    /// Errors: FileUnrecognized (not a blob of this version, or damaged; the text names the field).
    static Expected<ShaderBlob> Open(std::span<const std::uint32_t> words) noexcept {
        static_assert(std::endian::native == std::endian::little, "SPIR-V is read as it lies in the file");
        ShaderBlob blob;
        blob.words_ = words;
        OPENNTC_CHECK(blob.ReadHeader());
        OPENNTC_CHECK(blob.CheckIndex());
        return blob;
    }

    std::size_t GetCount() const noexcept { return count_; }

    struct Shader {
        ShaderKey key;
        std::span<const std::uint32_t> words;
    };

    /// Calls `visit(const Shader&)` for every permutation, in the order of the index.
    template <typename Visit>
    void ForEach(const Visit& visit) const {
        for (std::size_t line = firstLine_; line < endOfLines_; line = GetNextLine(line))
            visit(ReadLine(line));
    }

    /// The SPIR-V of `source` compiled with exactly `defines`, separated by spaces, in any order.
    /// Errors: ShaderUnavailable, naming the permutation that is not there and the nearest that are.
    Expected<std::span<const std::uint32_t>> Find(std::string_view source,
                                                  std::string_view defines) const noexcept {
        std::size_t begin = firstLine_;
        std::size_t end = endOfLines_;
        while (begin < end) { // the first line that does not lie before "SOURCE|"
            std::size_t middle = begin + (end - begin) / 2;
            while (middle > begin && GetText()[middle - 1] != '\n')
                --middle;
            if (IsBeforeSource(middle, source))
                begin = GetNextLine(middle);
            else
                end = middle;
        }
        for (std::size_t line = begin; line < endOfLines_; line = GetNextLine(line)) {
            const Shader shader = ReadLine(line);
            if (shader.key.source != source)
                break;
            if (HaveSameDefines(shader.key.defines, defines))
                return shader.words;
        }
        std::size_t line = firstLine_;
        return FailMissingShader({source, defines}, leftOut_, count_,
                                 [&](std::size_t i) { return ReadKey(i, line); });
    }

    /// The SPIR-V of the cheapest permutation of `source` that does all that `key` asks for, with the same
    /// bits of what the scene reads (PermutationCover.h). `ownDefines`: macros of the engine's, all that the
    /// permutation has besides the key's. Errors: ShaderUnavailable, naming what to compile.
    Expected<CoveringShader> FindCovering(std::string_view source, const PermutationKey& key,
                                          std::string_view ownDefines = {}) const noexcept {
        std::size_t line = firstLine_;
        OPENNTC_ASSIGN(const CoverMatch match, FindCover(source, key, ownDefines, leftOut_, count_,
                                                         [&](std::size_t i) { return ReadKey(i, line); }));
        line = firstLine_;
        for (std::size_t i = 0; i < match.index; ++i)
            line = GetNextLine(line);
        const Shader shader = ReadLine(line);
        return CoveringShader{shader.words, shader.key.defines, match.key};
    }

private:
    static constexpr std::size_t kHeaderBytes = 31;
    static constexpr std::size_t kNumbersBytes = 18; // two numbers with a space behind each

    ShaderBlob() = default;

    std::string_view GetText() const noexcept {
        return {reinterpret_cast<const char*>(words_.data()), textBytes_};
    }

    /// Eight hexadecimal digits and `end`; false if there is anything else.
    static bool ReadNumber(std::string_view text, std::size_t at, char end, std::uint32_t& number) noexcept {
        if (at > text.size() || text.size() - at < 9 || text[at + 8] != end)
            return false;
        number = 0;
        for (const char c : text.substr(at, 8)) {
            const bool digit = c >= '0' && c <= '9';
            if (!digit && (c < 'a' || c > 'f'))
                return false;
            number = number * 16 + static_cast<std::uint32_t>(digit ? c - '0' : c - 'a' + 10);
        }
        return true;
    }

    std::size_t GetNextLine(std::size_t line) const noexcept { return GetText().find('\n', line) + 1; }

    bool IsBeforeSource(std::size_t line, std::string_view source) const noexcept {
        const std::string_view key = GetText().substr(line + kNumbersBytes);
        const int order = key.substr(0, source.size()).compare(source);
        return order != 0
                   ? order < 0
                   : key.size() > source.size() && static_cast<unsigned char>(key[source.size()]) < '|';
    }

    /// A line that CheckIndex has accepted.
    Shader ReadLine(std::size_t line) const noexcept {
        const std::string_view text = GetText();
        std::uint32_t offset = 0, bytes = 0;
        ReadNumber(text, line, ' ', offset);
        ReadNumber(text, line + 9, ' ', bytes);
        const std::size_t key = line + kNumbersBytes;
        const std::string_view whole = text.substr(key, text.find('\n', key) - key);
        const std::size_t bar = whole.find('|');
        return {{whole.substr(0, bar), whole.substr(bar + 1)}, words_.subspan(offset / 4, bytes / 4)};
    }

    /// The name in line `i` of the index, which is `line`; moves on to the next one. Number 0 begins anew.
    ShaderKey ReadKey(std::size_t i, std::size_t& line) const noexcept {
        if (i == 0)
            line = firstLine_;
        const ShaderKey key = ReadLine(line).key;
        line = GetNextLine(line);
        return key;
    }

    Expected<void> ReadHeader() noexcept {
        constexpr std::string_view kMagic = "NTCSHADERS 1\n";
        textBytes_ = words_.size_bytes();
        std::uint32_t count = 0, textBytes = 0;
        if (!GetText().starts_with(kMagic))
            return Fail(Status::FileUnrecognized,
                        "magic: absent: a shader blob begins with \"NTCSHADERS 1\"");
        if (!ReadNumber(GetText(), kMagic.size(), ' ', count) ||
            !ReadNumber(GetText(), kMagic.size() + 9, '\n', textBytes))
            return Fail(Status::FileUnrecognized, "header: damaged: two numbers of eight hexadecimal digits");
        if (textBytes > words_.size_bytes() || textBytes % 4 != 0)
            return Fail(Status::FileUnrecognized,
                        "index size: %u: a multiple of 4, at most the file's %zu bytes", textBytes,
                        words_.size_bytes());
        textBytes_ = textBytes;
        count_ = count;
        const std::size_t end = GetText().find('\n', kHeaderBytes);
        if (end == std::string_view::npos)
            return Fail(Status::FileUnrecognized, "index: %zu bytes: ends within its third line", textBytes_);
        leftOut_ = GetText().substr(kHeaderBytes, end - kHeaderBytes);
        firstLine_ = end + 1;
        return {};
    }

    Expected<void> CheckIndex() noexcept {
        const std::string_view text = GetText();
        std::string_view previous;
        std::size_t line = firstLine_;
        for (std::size_t i = 0; i < count_; ++i) {
            const std::size_t end = text.find('\n', line);
            std::uint32_t offset = 0, bytes = 0;
            if (end == std::string_view::npos || end - line < kNumbersBytes ||
                !ReadNumber(text, line, ' ', offset) || !ReadNumber(text, line + 9, ' ', bytes))
                return Fail(Status::FileUnrecognized, "index: line %zu of %zu: damaged", i + 1, count_);
            const std::string_view key = text.substr(line + kNumbersBytes, end - line - kNumbersBytes);
            if (key.find('|') == std::string_view::npos || key.front() == '|' || (i > 0 && key <= previous))
                return Fail(Status::FileUnrecognized, "index: line %zu: \"SOURCE|DEFINES\", sorted", i + 1);
            if (offset % 4 != 0 || bytes % 4 != 0 || bytes < 4 || offset < textBytes_ ||
                offset > words_.size_bytes() || bytes > words_.size_bytes() - offset)
                return Fail(Status::FileUnrecognized,
                            "index: line %zu: offset %u, size %u: words after %zu bytes of index, "
                            "at most the file's %zu bytes",
                            i + 1, offset, bytes, textBytes_, words_.size_bytes());
            if (words_[offset / 4] != 0x07230203u)
                return Fail(Status::FileUnrecognized, "index: line %zu: offset %u: no SPIR-V is there", i + 1,
                            offset);
            previous = key;
            line = end + 1;
        }
        endOfLines_ = line;
        return {};
    }

    std::span<const std::uint32_t> words_;
    std::size_t textBytes_ = 0;
    std::size_t count_ = 0;
    std::size_t firstLine_ = 0;
    std::size_t endOfLines_ = 0;
    std::string_view leftOut_;
};

/// Reads a whole blob, for ShaderBlob::Open. Errors: IOError, OutOfMemory, FileUnrecognized (size is not a
/// multiple of 4).
inline Expected<Array<std::uint32_t>> ReadShaderBlob(Stream& stream,
                                                     Allocator& allocator = GetDefaultAllocator()) {
    const std::uint64_t bytes = stream.Size();
    if (bytes % 4 != 0 || bytes > 0xFFFFFFFFu)
        return Fail(Status::FileUnrecognized, "size: %llu bytes: a multiple of 4 below 4 GiB",
                    static_cast<unsigned long long>(bytes));
    Array<std::uint32_t> words(allocator);
    OPENNTC_CHECK(words.Resize(static_cast<std::size_t>(bytes / 4)));
    if (!stream.Seek(0) || !stream.Read(words.data(), static_cast<std::size_t>(bytes)))
        return Fail(Status::IOError, "shader blob: %llu bytes: cannot be read",
                    static_cast<unsigned long long>(bytes));
    return words;
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
