// SPDX-License-Identifier: MIT
// Stability: experimental
// Modes and partitions of BC7 blocks as files of generation 3 store them: 9 bits for each block, row by row,
// for encoders that search only what the set's own encoder found best. Source: the format specification,
// generations, "BC7 mode buffers".
#pragma once

#include "openntc/core/Allocator.h"
#include "openntc/core/Expected.h"
#include "openntc/core/Stream.h"
#include "openntc/texture_set/StoredDataReader.h"
#include "openntc/texture_set/TextureSetTypes.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// Mode of a BC7 block and, for modes with partitions, its number; for mode 4 rotation and index selector,
/// for mode 5 the rotation.
struct BlockMode {
    std::uint8_t mode = 0;      ///< below kBlockModes
    std::uint8_t partition = 0; ///< below kBlockPartitions

    friend constexpr bool operator==(const BlockMode&, const BlockMode&) noexcept = default;
};

/// What the first bits of an encoded block say; a block of no mode counts as one of mode 7.
constexpr BlockMode GetBlockMode(std::uint32_t firstWord) noexcept {
    constexpr std::array<std::uint8_t, kBlockModes> kMasks = {15, 63, 63, 63, 7, 3, 0, 63};
    const int mode = std::min(std::countr_zero(firstWord), kBlockModes - 1);
    return {static_cast<std::uint8_t>(mode),
            static_cast<std::uint8_t>((firstWord >> (mode + 1)) & kMasks[static_cast<std::size_t>(mode)])};
}

/// Bytes of the modes of that many blocks.
constexpr std::uint64_t GetBlockModeBytes(std::uint64_t blocks) noexcept {
    return (9 * blocks + 31) / 32 * 4;
}

namespace detail {

inline constexpr unsigned kModeBits = 9;
/// Stands for mode 0 with partition 0, whose own number means that there is no mode.
inline constexpr std::uint32_t kFirstModeCode = 0x1BF;

constexpr std::uint32_t EncodeBlockMode(BlockMode mode) noexcept {
    const std::uint32_t code = std::uint32_t{mode.mode} * 64 + mode.partition;
    return code == 0 ? kFirstModeCode : code;
}

constexpr BlockMode DecodeBlockMode(std::uint32_t code) noexcept {
    if (code == kFirstModeCode)
        return {};
    return {static_cast<std::uint8_t>(code >> 6), static_cast<std::uint8_t>(code & 63u)};
}

} // namespace detail

/// Packs the modes of encoded BC7 blocks, 16 bytes each, row by row. Errors: InvalidArgument for half a
/// block, OutOfMemory.
inline Expected<Array<std::byte>> PackBlockModes(std::span<const std::byte> blocks,
                                                 Allocator& allocator = GetDefaultAllocator()) noexcept {
    constexpr std::size_t kBlockBytes = 16;
    if (blocks.size() % kBlockBytes != 0)
        return Fail(Status::InvalidArgument, "blocks: %zu bytes: must be a multiple of %zu", blocks.size(),
                    kBlockBytes);
    const std::size_t count = blocks.size() / kBlockBytes;
    Array<std::byte> packed(allocator);
    OPENNTC_CHECK(packed.Resize(static_cast<std::size_t>(GetBlockModeBytes(count))));
    for (std::size_t i = 0; i < count; ++i) {
        std::uint32_t word = 0;
        std::memcpy(&word, blocks.data() + kBlockBytes * i, sizeof word);
        const std::size_t bit = detail::kModeBits * i;
        const std::uint32_t code = detail::EncodeBlockMode(GetBlockMode(word)) << (bit % 8);
        packed[bit / 8] |= static_cast<std::byte>(code & 0xFFu);
        packed[bit / 8 + 1] |=
            static_cast<std::byte>(code >> 8); // 9 bits reach a second byte wherever they start
    }
    return packed;
}

/// The mode of block `index` in packed modes that hold it; false where none is stored.
inline bool FindBlockMode(std::span<const std::byte> packed, std::size_t index, BlockMode& mode) noexcept {
    const std::size_t bit = detail::kModeBits * index;
    const std::uint32_t bytes =
        static_cast<std::uint32_t>(packed[bit / 8]) | static_cast<std::uint32_t>(packed[bit / 8 + 1]) << 8;
    const std::uint32_t code = (bytes >> (bit % 8)) & 0x1FFu;
    mode = detail::DecodeBlockMode(code);
    return code != 0;
}

/// Reads the packed modes of a mip of `width` x `height` texels; `stream` is the one that the set was loaded
/// from. Errors: FileUnrecognized for a buffer of another size or corrupt data, IOError, OutOfMemory.
inline Expected<Array<std::byte>> ReadBlockModes(const BlockModeBuffer& modes, Stream& stream, int width,
                                                 int height,
                                                 Allocator& allocator = GetDefaultAllocator()) noexcept {
    const auto countBlocks = [](int size) { return (static_cast<std::uint64_t>(size) + 3) / 4; };
    const std::uint64_t bytes = GetBlockModeBytes(countBlocks(width) * countBlocks(height));
    if (modes.data.bytes != bytes || bytes > std::numeric_limits<std::size_t>::max())
        return Fail(Status::FileUnrecognized, "bcModeBuffers: %llu bytes: a mip of %d x %d has %llu",
                    static_cast<unsigned long long>(modes.data.bytes), width, height,
                    static_cast<unsigned long long>(bytes));
    Array<std::byte> packed(allocator);
    OPENNTC_CHECK(packed.Resize(static_cast<std::size_t>(bytes)));
    StoredDataReader reader(stream, allocator);
    OPENNTC_CHECK(reader.Read(modes.data, packed.AsSpan(), "bcModeBuffers"));
    return packed;
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
