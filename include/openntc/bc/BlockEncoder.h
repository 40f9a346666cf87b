// SPDX-License-Identifier: MIT
// Stability: experimental
// The block encoders on the CPU: the shaders' source (shaders/openntc/bc), compiled for many blocks at once
// and spread over threads. The blocks are those that the passes make on a GPU, bit for bit, whatever the
// instruction set and the number of threads.
#pragma once

#include "openntc/bc/BlockFormat.h"
#include "openntc/bc/BlockImage.h"
#include "openntc/bc/detail/BlockGather.h"
#include "openntc/bc/detail/Kernels.h"
#include "openntc/core/Expected.h"
#include "openntc/core/ThreadTeam.h"
#include "openntc/decode/DecodeTypes.h"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc::bc {

struct BlockOptions {
    BlockQuality quality = BlockQuality::Normal;
    int alphaThreshold = -1; ///< Bc1: alpha at most this is transparent, 0 … 255; -1: everything is opaque
    std::uint32_t allowedModes = 0xFF;   ///< Bc7: bit m allows mode m; not 0
    std::span<const std::int32_t> hints; ///< Bc7: one a block of the rectangle, row by row; empty: search
    int lanes = 0;   ///< 1, 4, 8 or 16 blocks at once, if there is code for it; 0: the most
    int threads = 0; ///< 0: one per hardware thread; otherwise at most this many
};

namespace detail {

/// The kernels of at most `lanes` lanes (0: any number) that this machine runs.
inline const BlockKernels& ChooseBlockKernels(int lanes) noexcept {
    const int limit = lanes > 0 ? lanes : kMaxLanes;
#if OPENNTC_FAST_X86
    const ProcessorFeatures& features = GetProcessorFeatures();
    if (limit >= 16 && features.avx512Vnni)
        return lanes16::kKernels;
    if (limit >= 8 && features.avx2)
        return lanes8::kKernels;
#endif
#if defined(__GNUC__)
    if (limit >= 4)
        return lanes4::kKernels;
#endif
    return lanes1::kKernels;
}

inline Expected<void> CheckBlockRequest(BlockFormat format, const BlockImage& image, BlockRect rect,
                                        const BlockOptions& options, std::size_t outputBytes) noexcept {
    const auto number = static_cast<unsigned>(format);
    if (number >= static_cast<unsigned>(kBlockFormatCount))
        return Fail(Status::OutOfRange, "format: %u: 0 ... %d", number, kBlockFormatCount - 1);
    if (image.channels < 1 || image.channels > 4)
        return Fail(Status::OutOfRange, "channels: %d: 1 ... 4", image.channels);
    if (image.width == 0 || image.height == 0)
        return Fail(Status::OutOfRange, "image: %u x %u: each side must be 1 or more", image.width,
                    image.height);
    const TexelType expected =
        format == BlockFormat::Bc6Unsigned || format == BlockFormat::Bc6Signed ? TexelType::Half
        : format == BlockFormat::Bc4Signed || format == BlockFormat::Bc5Signed ? TexelType::Signed8
                                                                               : TexelType::Unsigned8;
    if (image.type != expected)
        return Fail(Status::InvalidArgument, "type: %d: %s takes %d", static_cast<int>(image.type),
                    BlockFormatToString(format), static_cast<int>(expected));
    const std::size_t texelBytes =
        static_cast<std::size_t>(image.channels) * (image.type == TexelType::Half ? 2 : 1);
    const std::size_t tight = texelBytes * image.width;
    const std::size_t rowBytes = image.rowBytes != 0 ? image.rowBytes : tight;
    if (rowBytes < tight)
        return Fail(Status::OutOfRange, "rowBytes: %zu: at least %zu", rowBytes, tight);
    if (image.bytes.size() < tight || (image.bytes.size() - tight) / rowBytes < image.height - 1)
        return Fail(Status::OutOfRange, "bytes: %zu: %u rows of %zu are needed", image.bytes.size(),
                    image.height, rowBytes);
    const std::uint32_t columns = CountBlocks(image.width);
    const std::uint32_t rows = CountBlocks(image.height);
    if (rect.width == 0 || rect.height == 0 || rect.left >= columns || rect.top >= rows ||
        rect.width > columns - rect.left || rect.height > rows - rect.top)
        return Fail(Status::OutOfRange, "rect: %u x %u blocks at (%u, %u): not within %u x %u", rect.width,
                    rect.height, rect.left, rect.top, columns, rows);
    const std::uint64_t blocks = std::uint64_t{rect.width} * rect.height;
    if (outputBytes / GetBytesPerBlock(format) < blocks)
        return Fail(Status::OutOfRange, "output: %zu bytes: %llu blocks of %zu are needed", outputBytes,
                    static_cast<unsigned long long>(blocks), GetBytesPerBlock(format));
    if (options.alphaThreshold < -1 || options.alphaThreshold > 255)
        return Fail(Status::OutOfRange, "alphaThreshold: %d: -1 ... 255", options.alphaThreshold);
    if ((options.allowedModes & 0xFF) == 0)
        return Fail(Status::OutOfRange, "allowedModes: 0x%X: at least one of the bits 0 ... 7",
                    options.allowedModes);
    if (!options.hints.empty() && options.hints.size() < blocks)
        return Fail(Status::OutOfRange, "hints: %zu: one for each of %llu blocks", options.hints.size(),
                    static_cast<unsigned long long>(blocks));
    return {};
}

/// The order in which blocks first … first + count - 1 are encoded: blocks of one mode (and selector) after
/// each other, since a batch does the work of every mode that any of its lanes wants.
inline void OrderByHint(std::span<const std::int32_t> hints, std::uint64_t count,
                        std::uint16_t* order) noexcept {
    constexpr int kKinds = 17; // mode and selector, or none
    const auto kindOf = [&](std::uint64_t i) {
        const std::int32_t hint = hints[static_cast<std::size_t>(i)];
        return hint < 0 ? kKinds - 1 : (hint & 7) * 2 + (hint >> 11 & 1);
    };
    int starts[kKinds + 1] = {};
    for (std::uint64_t i = 0; i < count; ++i)
        ++starts[kindOf(i) + 1];
    for (int kind = 0; kind < kKinds; ++kind)
        starts[kind + 1] += starts[kind];
    for (std::uint64_t i = 0; i < count; ++i)
        order[starts[kindOf(i)]++] = static_cast<std::uint16_t>(i);
}

} // namespace detail

/// True if EncodeBlocks knows the format.
inline bool HasBlockEncoder(BlockFormat format) noexcept {
    const auto number = static_cast<std::size_t>(format);
    return number < static_cast<std::size_t>(kBlockFormatCount) && lanes1::kKernels.encode[number] != nullptr;
}

/// Encodes a rectangle of blocks of an image; blocks follow each other row by row in `output`. Texels beyond
/// the image repeat its edge; no memory outside of it is read. Errors: OutOfRange for numbers,
/// InvalidArgument for texels of another type than the format takes (Half for Bc6, Signed8 for signed
/// formats), Unsupported for a format without an encoder.
inline Expected<void> EncodeBlocks(BlockFormat format, const BlockImage& image, BlockRect rect,
                                   const BlockOptions& options, std::span<std::byte> output) noexcept {
    OPENNTC_CHECK(detail::CheckBlockRequest(format, image, rect, options, output.size()));
    const BlockKernels& kernels = detail::ChooseBlockKernels(options.lanes);
    const EncodeLanes encode = kernels.encode[static_cast<std::size_t>(format)];
    if (encode == nullptr)
        return Fail(Status::Unsupported, "format: %s: there is no encoder", BlockFormatToString(format));
    const std::size_t rowBytes = image.rowBytes != 0 ? image.rowBytes
                                                     : static_cast<std::size_t>(image.width) *
                                                           static_cast<std::size_t>(image.channels) *
                                                           (image.type == TexelType::Half ? 2 : 1);
    const detail::GatherSource source = {
        &image, rowBytes, static_cast<std::size_t>(image.channels) * (image.type == TexelType::Half ? 2 : 1)};
    const bool isPacked = format <= BlockFormat::Bc5Signed;
    const std::size_t lanes = static_cast<std::size_t>(kernels.lanes);
    const std::size_t blockBytes = GetBytesPerBlock(format);
    const std::uint64_t blocks = std::uint64_t{rect.width} * rect.height;

    // Jobs of many batches: fetching one costs an atomic operation.
    constexpr std::uint64_t kJobBlocks = 256;
    const std::uint64_t jobs = (blocks + kJobBlocks - 1) / kJobBlocks;
    if (jobs > 0x7FFFFFFF)
        return Fail(Status::OutOfRange, "rect: %llu blocks: too many for one call",
                    static_cast<unsigned long long>(blocks));
    const int available = options.threads > 0 ? options.threads : CountHardwareThreads();
    ThreadTeam team(static_cast<int>(
        jobs < static_cast<std::uint64_t>(available) ? jobs : static_cast<std::uint64_t>(available)));
    team.Run(static_cast<int>(jobs), [&](int job, int) noexcept {
        BlockBatch batch;
        batch.quality = options.quality;
        batch.alphaThreshold = options.alphaThreshold;
        batch.allowedModes = options.allowedModes & 0xFF;
        batch.isSigned = image.type == TexelType::Signed8;
        const std::uint64_t first = static_cast<std::uint64_t>(job) * kJobBlocks;
        const std::uint64_t end = first + kJobBlocks < blocks ? first + kJobBlocks : blocks;
        auto column = static_cast<std::uint32_t>(first % rect.width);
        auto row = static_cast<std::uint32_t>(first / rect.width);
        std::uint16_t order[kJobBlocks];
        if (!options.hints.empty())
            detail::OrderByHint(options.hints.subspan(static_cast<std::size_t>(first)), end - first, order);
        for (std::uint64_t begin = first; begin < end; begin += lanes) {
            for (std::size_t l = 0; l < lanes; ++l) {
                // Lanes without a block of their own repeat the last one.
                const std::uint64_t place = begin + l < end ? begin + l : end - 1;
                batch.hints[l] = -1;
                if (!options.hints.empty()) {
                    const std::uint64_t block = first + order[place - first];
                    column = static_cast<std::uint32_t>(block % rect.width);
                    row = static_cast<std::uint32_t>(block / rect.width);
                    batch.hints[l] = options.hints[static_cast<std::size_t>(block)];
                }
                (isPacked ? detail::GatherPacked : detail::GatherTexels)(source, rect.left + column,
                                                                         rect.top + row, batch, l, lanes);
                if (begin + l + 1 < end && ++column == rect.width) {
                    column = 0;
                    ++row;
                }
            }
            encode(batch);
            const std::uint64_t count = end - begin < lanes ? end - begin : lanes;
            for (std::uint64_t l = 0; l < count; ++l) {
                const std::uint64_t block =
                    options.hints.empty() ? begin + l : first + order[begin + l - first];
                std::memcpy(output.data() + block * blockBytes, batch.words + 4 * l, blockBytes);
            }
        }
    });
    return {};
}

} // namespace openntc::bc

#include "openntc/core/RestoreMacros.h"
