// SPDX-License-Identifier: MIT
// Stability: experimental
// How BC7 blocks were coded, kept for encoding the same texels again: mode, partition, rotation and index
// selector of every block, 9 bits each, in the encoding of generation 3's mode buffers. With them an encoder
// tries one coding a block. They help only where texels are the very ones that they were gathered from.
//
// A side file (NAME.bcmodes) holds the maps of a set. Little-endian; a header of 40 bytes: "NTCBCMAP",
// version (1), number of maps, size (8 bytes) and CRC-32 of the file that the texels come from, CRC-32 of all
// maps' records, size of the file (8 bytes). Then 40 bytes a map: texture, mip, blocks wide, blocks high,
// offset (8 bytes), size, CRC-32; CRC-32 of the texels, and a byte each of maths mode, sRGB (0 or 1) and
// BlockQuality, and a 0. Then the maps, each 4 ceil(9 blocks / 32) bytes.
#pragma once

#include "openntc/MathModes.h"
#include "openntc/bc/BlockFormat.h"
#include "openntc/bc/detail/BlockBatch.h"
#include "openntc/core/Crc32.h"
#include "openntc/core/Expected.h"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc::bc {

/// A hint of BlockOptions::hints from its parts: mode 0 … 7, partition 0 … 63 (modes 4 to 6: 0), rotation 0 …
/// 3 (modes 4 and 5), index selector 0 or 1 (mode 4). The bits are those of NtcBc7Hint (bc/Bc7Tables.h),
/// which would bring all encoders with it; a test compares them.
constexpr std::int32_t MakeBlockHint(int mode, int partition, int rotation, int selector) noexcept {
    return mode | partition << 3 | rotation << 9 | selector << 11;
}

/// How a BC7 block of 16 bytes is coded; -1 for the reserved code.
inline std::int32_t GetBlockHint(const std::byte* block) noexcept {
    const auto word = static_cast<std::uint32_t>(block[0]) | static_cast<std::uint32_t>(block[1]) << 8 |
                      static_cast<std::uint32_t>(block[2]) << 16;
    int mode = 0;
    while (mode < 8 && (word >> mode & 1) == 0)
        ++mode;
    if (mode == 8)
        return -1;
    constexpr std::uint32_t kMasks[8] = {15, 63, 63, 63, 7, 3, 0, 63};
    const auto rest = static_cast<int>(word >> (mode + 1) & kMasks[mode]);
    if (mode == 4 || mode == 5)
        return MakeBlockHint(mode, 0, rest & 3, rest >> 2);
    return MakeBlockHint(mode, rest, 0, 0);
}

/// Bytes of a packed map of so many blocks.
constexpr std::uint64_t GetBlockHintBytes(std::uint64_t blocks) noexcept {
    return (blocks * 9 + 31) / 32 * 4;
}

/// The 9 bits of a hint: mode 64 + partition, of modes 4 and 5 rotation + 4 selector; 0: none.
inline std::uint32_t PackBlockHint(std::int32_t hint) noexcept {
    if (hint < 0)
        return 0;
    const auto bits = static_cast<std::uint32_t>(hint);
    const std::uint32_t mode = bits & 7;
    const std::uint32_t low = mode == 4 || mode == 5 ? bits >> 9 & 7 : bits >> 3 & 63;
    const std::uint32_t value = mode * 64 + low;
    return value == 0 ? 0x1BF : value;
}

/// The hint of 9 bits; -1 for 0 and for numbers that no block has.
inline std::int32_t UnpackBlockHint(std::uint32_t value) noexcept {
    if (value == 0x1BF)
        return MakeBlockHint(0, 0, 0, 0);
    const auto mode = static_cast<int>(value >> 6 & 7);
    const auto low = static_cast<int>(value & 63);
    constexpr int kLimits[8] = {16, 64, 64, 64, 8, 4, 1, 64};
    if (value == 0 || value > 511 || low >= kLimits[mode])
        return -1;
    if (mode == 4 || mode == 5)
        return MakeBlockHint(mode, 0, low & 3, low >> 2);
    return MakeBlockHint(mode, low, 0, 0);
}

/// Packs hints, one a block, row by row. Errors: OutOfRange if `output` has not
/// GetBlockHintBytes(hints.size()).
inline Expected<void> PackBlockHints(std::span<const std::int32_t> hints,
                                     std::span<std::byte> output) noexcept {
    const std::uint64_t size = GetBlockHintBytes(hints.size());
    if (output.size() < size)
        return Fail(Status::OutOfRange, "output: %zu bytes: %zu hints need %llu", output.size(), hints.size(),
                    static_cast<unsigned long long>(size));
    std::memset(output.data(), 0, static_cast<std::size_t>(size));
    for (std::size_t i = 0; i < hints.size(); ++i) {
        const std::uint64_t bit = std::uint64_t{i} * 9;
        const std::uint32_t shifted = PackBlockHint(hints[i]) << (bit % 8);
        const auto at = static_cast<std::size_t>(bit / 8);
        output[at] |= static_cast<std::byte>(shifted & 0xFF);
        output[at + 1] |= static_cast<std::byte>(shifted >> 8);
    }
    return {};
}

/// The texels that hints were gathered from, and how.
struct BlockHintTexels {
    std::uint32_t crc = 0;                     ///< CRC-32 of the mip: RGBA bytes, row by row
    std::uint8_t math = NTC_MATH_INT8;         ///< NTC_MATH_* of the decoder
    bool srgb = false;                         ///< colours are sRGB; otherwise linear
    BlockQuality quality = BlockQuality::Best; ///< of the search
    friend bool operator==(const BlockHintTexels&, const BlockHintTexels&) = default;
};

/// The packed map of one mip of one texture. Nothing is owned.
struct BlockHintMap {
    std::uint32_t texture = 0; ///< index in the set
    std::uint32_t mip = 0;
    std::uint32_t width = 0;  ///< blocks
    std::uint32_t height = 0; ///< blocks
    std::span<const std::byte> packed;
    BlockHintTexels texels = {};
};

/// The hints of a rectangle of a map's blocks, row by row, as BlockOptions::hints takes them. Errors:
/// OutOfRange for a rectangle beyond the map, a map shorter than its size says, or too small an output.
inline Expected<void> UnpackBlockHints(const BlockHintMap& map, std::uint32_t left, std::uint32_t top,
                                       std::uint32_t width, std::uint32_t height,
                                       std::span<std::int32_t> output) noexcept {
    if (left > map.width || width > map.width - left || top > map.height || height > map.height - top)
        return Fail(Status::OutOfRange, "hints: %u x %u blocks at (%u, %u): not within %u x %u", width,
                    height, left, top, map.width, map.height);
    if (map.packed.size() < GetBlockHintBytes(std::uint64_t{map.width} * map.height))
        return Fail(
            Status::OutOfRange, "hints: %zu bytes: %u x %u blocks need %llu", map.packed.size(), map.width,
            map.height,
            static_cast<unsigned long long>(GetBlockHintBytes(std::uint64_t{map.width} * map.height)));
    if (output.size() / (width > 0 ? width : 1) < height)
        return Fail(Status::OutOfRange, "output: %zu hints: %u x %u are needed", output.size(), width,
                    height);
    std::size_t to = 0;
    for (std::uint32_t y = top; y < top + height; ++y) {
        for (std::uint32_t x = left; x < left + width; ++x) {
            const std::uint64_t bit = (std::uint64_t{y} * map.width + x) * 9;
            const auto at = static_cast<std::size_t>(bit / 8);
            const auto pair = static_cast<std::uint32_t>(map.packed[at]) |
                              static_cast<std::uint32_t>(map.packed[at + 1]) << 8;
            output[to++] = UnpackBlockHint(pair >> (bit % 8) & 511);
        }
    }
    return {};
}

namespace detail {

inline constexpr std::size_t kHintHeaderBytes = 40;
inline constexpr std::size_t kHintRecordBytes = 40;
inline constexpr char kHintMagic[] = "NTCBCMAP";

inline void StoreNumber(std::byte* to, std::uint64_t value, int bytes) noexcept {
    for (int i = 0; i < bytes; ++i)
        to[i] = static_cast<std::byte>(value >> (8 * i) & 0xFF);
}

inline std::uint64_t LoadNumber(const std::byte* from, int bytes) noexcept {
    std::uint64_t value = 0;
    for (int i = 0; i < bytes; ++i)
        value |= static_cast<std::uint64_t>(from[i]) << (8 * i);
    return value;
}

} // namespace detail

/// What a side file says about the file that its texels come from.
struct BlockHintSource {
    std::uint64_t bytes = 0;
    std::uint32_t crc = 0;
    friend bool operator==(const BlockHintSource&, const BlockHintSource&) = default;
};

/// Bytes of a side file with these maps.
inline std::uint64_t GetBlockHintFileBytes(std::span<const BlockHintMap> maps) noexcept {
    std::uint64_t size = detail::kHintHeaderBytes + detail::kHintRecordBytes * std::uint64_t{maps.size()};
    for (const BlockHintMap& map : maps)
        size += map.packed.size();
    return size;
}

/// Writes a side file. Errors: OutOfRange if a map has not the bytes that its size asks for, or `output` has
/// not GetBlockHintFileBytes(maps).
inline Expected<void> WriteBlockHintFile(std::span<const BlockHintMap> maps, const BlockHintSource& source,
                                         std::span<std::byte> output) noexcept {
    const std::uint64_t size = GetBlockHintFileBytes(maps);
    if (output.size() < size || maps.size() > 0xFFFFFFFF)
        return Fail(Status::OutOfRange, "output: %zu bytes: %llu are needed", output.size(),
                    static_cast<unsigned long long>(size));
    std::byte* const start = output.data();
    std::uint64_t at = detail::kHintHeaderBytes + detail::kHintRecordBytes * std::uint64_t{maps.size()};
    for (std::size_t i = 0; i < maps.size(); ++i) {
        const BlockHintMap& map = maps[i];
        const std::uint64_t wanted = GetBlockHintBytes(std::uint64_t{map.width} * map.height);
        if (map.packed.size() != wanted || wanted > 0xFFFFFFFF)
            return Fail(Status::OutOfRange, "maps[%zu]: %zu bytes: %u x %u blocks have %llu", i,
                        map.packed.size(), map.width, map.height, static_cast<unsigned long long>(wanted));
        std::byte* const record = start + detail::kHintHeaderBytes + detail::kHintRecordBytes * i;
        detail::StoreNumber(record, map.texture, 4);
        detail::StoreNumber(record + 4, map.mip, 4);
        detail::StoreNumber(record + 8, map.width, 4);
        detail::StoreNumber(record + 12, map.height, 4);
        detail::StoreNumber(record + 16, at, 8);
        detail::StoreNumber(record + 24, wanted, 4);
        detail::StoreNumber(record + 28, Crc32(map.packed), 4);
        detail::StoreNumber(record + 32, map.texels.crc, 4);
        detail::StoreNumber(record + 36, map.texels.math, 1);
        detail::StoreNumber(record + 37, map.texels.srgb ? 1 : 0, 1);
        detail::StoreNumber(record + 38, static_cast<std::uint64_t>(map.texels.quality), 1);
        detail::StoreNumber(record + 39, 0, 1);
        if (wanted > 0)
            std::memcpy(start + at, map.packed.data(), static_cast<std::size_t>(wanted));
        at += wanted;
    }
    std::memcpy(start, detail::kHintMagic, 8);
    detail::StoreNumber(start + 8, 1, 4);
    detail::StoreNumber(start + 12, maps.size(), 4);
    detail::StoreNumber(start + 16, source.bytes, 8);
    detail::StoreNumber(start + 24, source.crc, 4);
    detail::StoreNumber(
        start + 28,
        Crc32(std::span(start + detail::kHintHeaderBytes, detail::kHintRecordBytes * maps.size())), 4);
    detail::StoreNumber(start + 32, size, 8);
    return {};
}

/// A side file in memory that is not owned. Maps are checked when they are asked for.
class BlockHintFile {
public:
    /// Checks the header and the records. Errors: FileUnrecognized for another file, another version, or
    /// damage.
    static Expected<BlockHintFile> Parse(std::span<const std::byte> bytes) noexcept {
        if (bytes.size() < detail::kHintHeaderBytes || std::memcmp(bytes.data(), detail::kHintMagic, 8) != 0)
            return Fail(Status::FileUnrecognized, "bcmodes: not a file of BC7 hints");
        const std::byte* const start = bytes.data();
        const auto version = static_cast<unsigned>(detail::LoadNumber(start + 8, 4));
        if (version != 1)
            return Fail(Status::FileUnrecognized, "bcmodes: version %u: 1 is known", version);
        const std::uint64_t size = detail::LoadNumber(start + 32, 8);
        if (size != bytes.size())
            return Fail(Status::FileUnrecognized, "bcmodes: %zu bytes: its header says %llu", bytes.size(),
                        static_cast<unsigned long long>(size));
        const std::uint64_t count = detail::LoadNumber(start + 12, 4);
        if (count > (bytes.size() - detail::kHintHeaderBytes) / detail::kHintRecordBytes)
            return Fail(Status::FileUnrecognized, "bcmodes: %llu maps in %zu bytes",
                        static_cast<unsigned long long>(count), bytes.size());
        const auto records = bytes.subspan(detail::kHintHeaderBytes,
                                           static_cast<std::size_t>(count) * detail::kHintRecordBytes);
        if (Crc32(records) != detail::LoadNumber(start + 28, 4))
            return Fail(Status::FileUnrecognized, "bcmodes: the records' checksum is wrong");
        BlockHintFile file;
        file.bytes_ = bytes;
        file.count_ = static_cast<std::uint32_t>(count);
        return file;
    }

    /// Of the file that the texels come from, when the hints were gathered.
    BlockHintSource GetSource() const noexcept {
        return {detail::LoadNumber(bytes_.data() + 16, 8),
                static_cast<std::uint32_t>(detail::LoadNumber(bytes_.data() + 24, 4))};
    }

    std::uint32_t GetCount() const noexcept { return count_; }

    /// Map 0 … GetCount() - 1. Errors: OutOfRange for another one, FileUnrecognized for a size, a place or a
    /// checksum that is wrong.
    Expected<BlockHintMap> GetMap(std::uint32_t index) const noexcept {
        if (index >= count_)
            return Fail(Status::OutOfRange, "bcmodes: map %u of %u", index, count_);
        const std::byte* const record =
            bytes_.data() + detail::kHintHeaderBytes + detail::kHintRecordBytes * std::size_t{index};
        BlockHintMap map;
        map.texture = static_cast<std::uint32_t>(detail::LoadNumber(record, 4));
        map.mip = static_cast<std::uint32_t>(detail::LoadNumber(record + 4, 4));
        map.width = static_cast<std::uint32_t>(detail::LoadNumber(record + 8, 4));
        map.height = static_cast<std::uint32_t>(detail::LoadNumber(record + 12, 4));
        const std::uint64_t offset = detail::LoadNumber(record + 16, 8);
        const std::uint64_t size = detail::LoadNumber(record + 24, 4);
        // Sides up to 2^16 blocks: larger ones would not be textures, and their product would overflow.
        constexpr std::uint32_t kMaxSide = 0x10000;
        if (map.width > kMaxSide || map.height > kMaxSide ||
            size != GetBlockHintBytes(std::uint64_t{map.width} * map.height) || offset > bytes_.size() ||
            size > bytes_.size() - offset)
            return Fail(Status::FileUnrecognized,
                        "bcmodes: map %u: %u x %u blocks in %llu bytes at %llu of %zu", index, map.width,
                        map.height, static_cast<unsigned long long>(size),
                        static_cast<unsigned long long>(offset), bytes_.size());
        map.packed = bytes_.subspan(static_cast<std::size_t>(offset), static_cast<std::size_t>(size));
        if (Crc32(map.packed) != detail::LoadNumber(record + 28, 4))
            return Fail(Status::FileUnrecognized, "bcmodes: map %u: its checksum is wrong", index);
        OPENNTC_ASSIGN(map.texels, GetTexels(index, record));
        return map;
    }

    /// The map of a texture's mip. Errors: those of GetMap; OutOfRange if there is none.
    Expected<BlockHintMap> Find(std::uint32_t texture, std::uint32_t mip) const noexcept {
        for (std::uint32_t i = 0; i < count_; ++i) {
            const std::byte* const record =
                bytes_.data() + detail::kHintHeaderBytes + detail::kHintRecordBytes * std::size_t{i};
            if (detail::LoadNumber(record, 4) == texture && detail::LoadNumber(record + 4, 4) == mip)
                return GetMap(i);
        }
        return Fail(Status::OutOfRange, "bcmodes: no map of texture %u, mip %u", texture, mip);
    }

private:
    static Expected<BlockHintTexels> GetTexels(std::uint32_t index, const std::byte* record) noexcept {
        const auto numberAt = [&](int at) {
            return static_cast<std::uint8_t>(detail::LoadNumber(record + at, 1));
        };
        if (numberAt(36) < NTC_MATH_INT8 || numberAt(36) > NTC_MATH_COOPVEC_FP8 || numberAt(37) > 1 ||
            numberAt(38) > static_cast<std::uint8_t>(BlockQuality::Best))
            return Fail(Status::FileUnrecognized, "bcmodes: map %u: maths %u, sRGB %u, quality %u: not known",
                        index, numberAt(36), numberAt(37), numberAt(38));
        BlockHintTexels texels;
        texels.crc = static_cast<std::uint32_t>(detail::LoadNumber(record + 32, 4));
        texels.math = numberAt(36);
        texels.srgb = numberAt(37) != 0;
        texels.quality = static_cast<BlockQuality>(numberAt(38));
        return texels;
    }

    std::span<const std::byte> bytes_;
    std::uint32_t count_ = 0;
};

} // namespace openntc::bc

#include "openntc/core/RestoreMacros.h"
