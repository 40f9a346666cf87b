// SPDX-License-Identifier: MIT
// Stability: experimental
// Block compression on a GPU: which permutation of shaders/openntc/passes/CompressBlocks a request needs, its
// push constants and its dispatch. No GPU object is made; what binds where the pass says.
#pragma once

#include "openntc/bc/BlockFormat.h"
#include "openntc/bc/BlockFormats.h"
#include "openntc/bc/detail/BlockBatch.h"
#include "openntc/core/Expected.h"
#include "openntc/passes/PassConstants.h"
#include "openntc/permutation/PermutationDefines.h"

#include <cstddef>
#include <cstdint>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc::bc {

/// Where the pass reads texels or writes blocks. Values equal NTC_BC_BUFFER and NTC_BC_IMAGE.
enum class PassMemory : std::uint8_t { Buffer = 0, Image = 1 };

/// Rows in a buffer of 32-bit words.
struct PassRows {
    std::uint32_t firstWord = 0;
    std::uint32_t rowWords = 0; ///< from one row to the next; 0: rows follow each other
};

struct BlockCompressionDesc {
    BlockFormat format = BlockFormat::Bc7;
    BlockQuality quality = BlockQuality::Normal;

    /// The rectangle of texels of the source. Its edge is repeated where blocks reach beyond it. For parts of
    /// a larger image take multiples of 4, or what ends at its edge: then the blocks are those of the whole.
    std::int32_t left = 0;
    std::int32_t top = 0;
    std::int32_t width = 0;  ///< 1 or more
    std::int32_t height = 0; ///< 1 or more

    PassMemory source = PassMemory::Image;
    std::int32_t sourceWidth =
        0; ///< of the image's mip or the buffer's rows, texels; the rectangle lies in it
    std::int32_t sourceHeight = 0; ///< likewise
    std::int32_t sourceMip = 0;    ///< images
    PassRows sourceRows;           ///< buffers: one word a texel, for Bc6 two

    PassMemory destination = PassMemory::Buffer;
    std::int32_t destinationLeft = 0; ///< images: where the first block goes, blocks
    std::int32_t destinationTop = 0;
    PassRows destinationRows; ///< buffers: two words a block (Bc1, Bc4) or four

    int alphaThreshold = -1; ///< Bc1: alpha at most this is transparent, 0 … 255; -1: all is opaque
    std::uint32_t allowedModes = 0xFF; ///< Bc7: bit m allows mode m; not 0
    bool hasHints = false;             ///< Bc7: a word for each block says what to try
    PassRows hintRows;

    /// Bc7 in GLSL: the device has shaderIntegerDotProduct. The same blocks, faster. (HLSL: compile with
    /// NTC_DOT4_SM64, by a compiler that knows shader model 6.4.)
    bool integerDotProduct = false;
};

/// What an engine needs for one dispatch.
struct BlockCompressionPass {
    NtcCompressBlocksConstants constants = {}; ///< push constants, 60 bytes
    std::uint32_t groups[3] = {0, 0, 1};       ///< of the dispatch
    std::uint32_t blocksWide = 0;
    std::uint32_t blocksHigh = 0;
    std::uint64_t destinationWords = 0; ///< buffers: words that the destination must have at least
    DefineList defines;                 ///< the permutation of CompressBlocks, for FindShader() or ShaderBlob
};

namespace detail {

/// Fills in rows that follow each other; the words behind the last one.
inline Expected<std::uint64_t> CheckPassRows(const char* name, PassRows& rows, std::uint64_t usedWords,
                                             std::uint64_t count) noexcept {
    if (rows.rowWords == 0)
        rows.rowWords = usedWords <= 0xFFFFFFFFU ? static_cast<std::uint32_t>(usedWords) : 0;
    if (rows.rowWords < usedWords)
        return Fail(Status::OutOfRange, "%s: %u words a row: %llu are needed", name, rows.rowWords,
                    static_cast<unsigned long long>(usedWords));
    const std::uint64_t end = rows.firstWord + (count - 1) * rows.rowWords + usedWords;
    // HLSL counts bytes in 32 bits.
    if (end > 0x40000000U)
        return Fail(Status::OutOfRange, "%s: %llu words: shaders reach 4 GiB", name,
                    static_cast<unsigned long long>(end));
    return end;
}

inline Expected<void> CheckCompressionRect(const BlockCompressionDesc& desc) noexcept {
    if (desc.left < 0 || desc.top < 0 || desc.width < 1 || desc.height < 1)
        return Fail(Status::OutOfRange,
                    "rectangle: %d x %d texels at (%d, %d): 1 x 1 or more at (0, 0) or more", desc.width,
                    desc.height, desc.left, desc.top);
    if (desc.left > desc.sourceWidth - desc.width || desc.top > desc.sourceHeight - desc.height)
        return Fail(Status::OutOfRange,
                    "rectangle: %d x %d texels at (%d, %d): not within the source, %d x %d", desc.width,
                    desc.height, desc.left, desc.top, desc.sourceWidth, desc.sourceHeight);
    if (desc.sourceMip < 0)
        return Fail(Status::OutOfRange, "sourceMip: %d: 0 or more", desc.sourceMip);
    if (desc.destinationLeft < 0 || desc.destinationTop < 0)
        return Fail(Status::OutOfRange, "destination: block (%d, %d): 0 or more", desc.destinationLeft,
                    desc.destinationTop);
    return {};
}

} // namespace detail

/// Errors: OutOfRange for the format, the rectangle (empty, negative, not within the source), offsets,
/// thresholds and modes, buffers beyond 4 GiB, and more groups than every device has (65535 a side).
inline Expected<BlockCompressionPass> MakeBlockCompressionPass(const BlockCompressionDesc& desc) noexcept {
    const auto number = static_cast<unsigned>(desc.format);
    if (number >= static_cast<unsigned>(kBlockFormatCount))
        return Fail(Status::OutOfRange, "format: %u: 0 ... %d", number, kBlockFormatCount - 1);
    if (static_cast<unsigned>(desc.quality) > 2)
        return Fail(Status::OutOfRange, "quality: %u: 0 ... 2", static_cast<unsigned>(desc.quality));
    OPENNTC_CHECK(detail::CheckCompressionRect(desc));
    if (desc.alphaThreshold < -1 || desc.alphaThreshold > 255)
        return Fail(Status::OutOfRange, "alphaThreshold: %d: -1 ... 255", desc.alphaThreshold);
    if ((desc.allowedModes & 0xFF) == 0)
        return Fail(Status::OutOfRange, "allowedModes: 0x%X: at least one of the bits 0 ... 7",
                    desc.allowedModes);

    BlockCompressionPass pass;
    pass.blocksWide = CountBlocks(static_cast<std::uint32_t>(desc.width));
    pass.blocksHigh = CountBlocks(static_cast<std::uint32_t>(desc.height));
    pass.groups[0] = (pass.blocksWide + NTC_COMPRESS_BLOCKS_GROUP - 1) / NTC_COMPRESS_BLOCKS_GROUP;
    pass.groups[1] = (pass.blocksHigh + NTC_COMPRESS_BLOCKS_GROUP - 1) / NTC_COMPRESS_BLOCKS_GROUP;
    if (pass.groups[0] > 65535 || pass.groups[1] > 65535)
        return Fail(Status::OutOfRange, "rectangle: %d x %d texels: more than %d of a side in one dispatch",
                    desc.width, desc.height, 65535 * 4 * NTC_COMPRESS_BLOCKS_GROUP);

    PassRows source = desc.sourceRows;
    PassRows destination = desc.destinationRows;
    PassRows hints = desc.hintRows;
    const bool isHalf = desc.format == BlockFormat::Bc6Unsigned || desc.format == BlockFormat::Bc6Signed;
    if (desc.source == PassMemory::Buffer)
        OPENNTC_CHECK(detail::CheckPassRows("source", source,
                                            static_cast<std::uint64_t>(desc.sourceWidth) * (isHalf ? 2 : 1),
                                            static_cast<std::uint64_t>(desc.sourceHeight)));
    if (desc.destination == PassMemory::Buffer) {
        OPENNTC_ASSIGN(pass.destinationWords,
                       detail::CheckPassRows("destination", destination,
                                             pass.blocksWide * (GetBytesPerBlock(desc.format) / 4),
                                             pass.blocksHigh));
    }
    const bool hasHints = desc.hasHints && desc.format == BlockFormat::Bc7;
    if (hasHints)
        OPENNTC_CHECK(detail::CheckPassRows("hints", hints, pass.blocksWide, pass.blocksHigh));

    pass.constants = {desc.left,
                      desc.top,
                      desc.width,
                      desc.height,
                      desc.sourceMip,
                      source.firstWord,
                      source.rowWords,
                      static_cast<std::uint32_t>(desc.destinationLeft),
                      static_cast<std::uint32_t>(desc.destinationTop),
                      destination.firstWord,
                      destination.rowWords,
                      desc.alphaThreshold,
                      desc.allowedModes & 0xFF,
                      hints.firstWord,
                      hints.rowWords};
    pass.defines.Add("NTC_BC_FORMAT", number, false);
    if (hasHints)
        pass.defines.Add("NTC_BC_HINTS", 1, false);
    pass.defines.Add("NTC_BC_QUALITY", static_cast<std::uint32_t>(desc.quality), false);
    pass.defines.Add("NTC_BC_SOURCE", static_cast<std::uint32_t>(desc.source), false);
    pass.defines.Add("NTC_BC_TARGET", static_cast<std::uint32_t>(desc.destination), false);
    if (desc.integerDotProduct && desc.format == BlockFormat::Bc7)
        pass.defines.Add(GetDotProductMacro(ShaderLanguage::Glsl), 1, false);
    return pass;
}

} // namespace openntc::bc

#include "openntc/core/RestoreMacros.h"
