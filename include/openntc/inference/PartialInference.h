// SPDX-License-Identifier: MIT
// Stability: experimental
// Slices of texture sets: the latents of a rectangle and what lies below it, and the constants to decode them
// with. The ordinary shader functions and CPU decoders take both, with the coordinates of the whole image.
//
//   const SliceDesc desc = {0, 4, {256, 128, 128, 128}};                // 128 x 128 texels, mips 0 to 3
//   std::uint64_t bytes = GetPartialLatentBufferSize(set, desc);
//   PartialInferenceData slice = MakePartialInferenceData(set, file, desc, weightType, buffer);
//
// An engine that keeps many slices of a set in one buffer needs the 624 bytes once, and a row of 32 bytes for
// each slice and latent image:
//
//   SliceLayout layout = GetSliceLayout(set, desc);
//   ReadSlice(layout, file, bytes of the buffer from `place` on);
//   NtcSliceConstants row = MoveSliceConstants(MakeSliceConstants(layout, neuralMip), place);
//   PatchConstants(constants, neuralMip, row);        // C++; shaders: NtcSampleSlice of streaming/Slices.h
//
// SliceLayout.h has the geometry and says what a slice holds.
#pragma once

#include "openntc/InferenceConstants.h"
#include "openntc/core/CheckedMath.h"
#include "openntc/core/Expected.h"
#include "openntc/core/Stream.h"
#include "openntc/inference/InferenceData.h"
#include "openntc/inference/LatentMipSlice.h"
#include "openntc/inference/SliceLayout.h"
#include "openntc/inference/detail/SliceRows.h"
#include "openntc/texture_set/TextureSetMetadata.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// Bytes that the latents of a slice take, of sets of every generation. Errors: as GetSliceLayout and
/// GetLatentMipSlices.
inline Expected<std::uint64_t> GetPartialLatentBufferSize(const TextureSetMetadata& metadata,
                                                          const SliceDesc& desc) noexcept {
    if (metadata.GetGeneration() > 1) {
        OPENNTC_ASSIGN(const LatentMipSliceLayout layered, GetLatentMipSlices(metadata, desc));
        return layered.bytes;
    }
    SliceLayout layout;
    OPENNTC_CHECK(detail::FillSliceLayout(metadata, desc, layout));
    return layout.bytes;
}

/// Reads the latents of a slice into the first layout.bytes bytes of `destination`: one ReadAt for each run
/// of rows, or for up to 16 KiB of rows that lie at most 4 KiB apart, in increasing order within a grid, and
/// no byte behind the last row. Nothing is allocated. Errors: OutOfRange, naming the
/// size that is needed, if the destination is smaller; IOError. After an error the destination holds
/// anything.
inline Expected<void> ReadSlice(const SliceLayout& layout, Stream& stream,
                                std::span<std::byte> destination) noexcept {
    if (const std::span<const std::byte> memory = stream.GetMemory(); !memory.empty())
        return detail::ReadSliceRows(layout, detail::MemoryRows{memory, 0}, destination);
    return detail::ReadSliceRows(layout, detail::StreamRows(stream), destination);
}

/// The same from memory: `source` holds the bytes of the stream from `sourceOffset` on, so far as the slice
/// needs them (GetStreamRangeForLatents is more than enough). Errors: OutOfRange for a destination that is
/// too small; IOError if the source ends before a row.
inline Expected<void> ReadSlice(const SliceLayout& layout, std::span<const std::byte> source,
                                std::uint64_t sourceOffset, std::span<std::byte> destination) noexcept {
    return detail::ReadSliceRows(layout, detail::MemoryRows{source, sourceOffset}, destination);
}

/// The row of one latent image; all zero (absent) if the slice has none of it.
inline NtcSliceConstants MakeSliceConstants(const SliceLayout& layout, int neuralMip) noexcept {
    NtcSliceConstants row{};
    for (const SliceGrid& grid : layout.GetGrids()) {
        if (grid.neuralMip != neuralMip)
            continue;
        const auto pack = [](int low, int high) {
            return static_cast<std::uint32_t>(low) | static_cast<std::uint32_t>(high) << 16;
        };
        (grid.isLowRes ? row.lowRes
                       : row.highRes) = {grid.dataOffset, pack(grid.imageWidth, grid.imageHeight),
                                         pack(grid.left, grid.top), pack(grid.width, grid.height)};
    }
    return row;
}

/// The row of latent image `neuralMip`, of later generations of that latent mip and the next, of a slice of a
/// set of any generation. Errors: as GetPartialLatentBufferSize.
inline Expected<NtcSliceConstants> MakeSliceConstants(const TextureSetMetadata& metadata,
                                                      const SliceDesc& desc, int neuralMip) noexcept {
    if (metadata.GetGeneration() > 1) {
        OPENNTC_ASSIGN(const LatentMipSliceLayout layered, GetLatentMipSlices(metadata, desc));
        return MakeSliceConstants(metadata, layered, neuralMip);
    }
    SliceLayout layout;
    OPENNTC_CHECK(detail::FillSliceLayout(metadata, desc, layout));
    return MakeSliceConstants(layout, neuralMip);
}

/// The row of latent image `neuralMip` in constants; absent for numbers outside 0 … 7.
inline NtcSliceConstants GetSliceConstants(const NtcTextureSetConstants& constants, int neuralMip) noexcept {
    if (neuralMip < 0 || neuralMip >= NTC_MAX_NEURAL_MIPS)
        return {};
    return {constants.highResNeuralMips[neuralMip], constants.lowResNeuralMips[neuralMip]};
}

/// The row for latents that were copied to `offset` bytes behind where its dataOffset counts from. Errors:
/// InvalidArgument for an offset that is no multiple of 4; OutOfRange if latents would lie at 4 GiB or
/// behind.
inline Expected<NtcSliceConstants> MoveSliceConstants(const NtcSliceConstants& row,
                                                      std::uint32_t offset) noexcept {
    if (offset % 4 != 0)
        return Fail(Status::InvalidArgument, "offset: %u: must be a multiple of 4", offset);
    NtcSliceConstants moved = row;
    for (NtcNeuralMipConstants* const grid : {&moved.highRes, &moved.lowRes}) {
        if (grid->sliceWidthHeight == 0)
            continue;
        if (grid->dataOffset > std::numeric_limits<std::uint32_t>::max() - offset)
            return Fail(Status::OutOfRange, "offset: %u: latents would lie at 4 GiB or behind", offset);
        grid->dataOffset += offset;
    }
    return moved;
}

/// Puts the row of latent image `neuralMip` into constants; the row of zeros takes it out. Errors: OutOfRange
/// for numbers outside 0 … 7.
inline Expected<void> PatchConstants(NtcTextureSetConstants& constants, int neuralMip,
                                     const NtcSliceConstants& row) noexcept {
    if (neuralMip < 0 || neuralMip >= NTC_MAX_NEURAL_MIPS)
        return Fail(Status::OutOfRange, "neuralMip: %d: must be 0 … %d", neuralMip, NTC_MAX_NEURAL_MIPS - 1);
    constants.highResNeuralMips[neuralMip] = row.highRes;
    constants.lowResNeuralMips[neuralMip] = row.lowRes;
    return {};
}

/// Makes the constants of a set those of a slice: latent images that the slice has not are taken out.
inline void PatchConstants(NtcTextureSetConstants& constants, const SliceLayout& layout) noexcept {
    for (int image = 0; image < NTC_MAX_NEURAL_MIPS; ++image) {
        const NtcSliceConstants row = MakeSliceConstants(layout, image);
        constants.highResNeuralMips[image] = row.highRes;
        constants.lowResNeuralMips[image] = row.lowRes;
    }
}

/// What MakePartialInferenceData makes besides the latents.
struct PartialInferenceData {
    NtcTextureSetConstants constants; ///< dataOffset counts from the start of the slice's latents
    std::uint64_t latentBytes = 0;
};

/// Reads the latents of a slice into `latents` and makes the constants to decode them with, for sets of every
/// generation (compressed latents take memory of the default allocator meanwhile). A size query is
/// GetPartialLatentBufferSize; a size for all positions GetConservativeLatentBufferSize. For shuffled or
/// cooperative-vector weights take the constants of MakeInferenceData with an empty range, PatchConstants and
/// ReadSlice. Errors, in the order of the checks: InvalidArgument if weightType is not a type; Unsupported if
/// the set has no such weights, or they are for cooperative vectors; OutOfRange as GetSliceLayout;
/// OutOfRange, naming the size that is needed, if `latents` is too small; IOError.
inline Expected<PartialInferenceData> MakePartialInferenceData(const TextureSetMetadata& metadata,
                                                               Stream& stream, const SliceDesc& desc,
                                                               InferenceWeightType weightType,
                                                               std::span<std::byte> latents) noexcept {
    OPENNTC_CHECK(detail::CheckWeightType(weightType));
    if (metadata.GetGeneration() > 1) {
        OPENNTC_CHECK(detail::CheckWeights(metadata, weightType, metadata.GetWeights()));
        OPENNTC_ASSIGN(const LatentMipSliceLayout layered, GetLatentMipSlices(metadata, desc));
        OPENNTC_CHECK(ReadLatentMipSlices(metadata, layered, stream, latents));
        OPENNTC_ASSIGN(const NtcTextureSetConstants c, MakeSliceInferenceData(metadata, layered, weightType));
        return PartialInferenceData{c, layered.bytes};
    }
    const Expected<NtcTextureSetConstants> constants = MakeInferenceData(metadata, StreamRange{}, weightType);
    if (!constants)
        return PassError(constants);
    SliceLayout layout;
    OPENNTC_CHECK(detail::FillSliceLayout(metadata, desc, layout));
    OPENNTC_CHECK(ReadSlice(layout, stream, latents));
    // In the place of the result: copies of it take as long as the latents.
    Expected<PartialInferenceData> data(tl::in_place, PartialInferenceData{*constants, layout.bytes});
    PatchConstants(data->constants, layout);
    return data;
}

namespace detail {

/// Every latent pixel that texels [begin, begin + count) of an axis read is among those of the slice.
constexpr bool IsAxisPresent(int size, int latents, int sliceStart, int sliceSize, int begin,
                             int count) noexcept {
    const int first = GetFirstTap(size, latents, begin);
    const int last = std::min(GetFirstTap(size, latents, begin + count - 1) + 1, latents - 1);
    return first >= sliceStart && last < sliceStart + sliceSize;
}

} // namespace detail

/// True if a grid of generation 1, whole or a slice, holds all latents that the texels of `rect` read, which
/// is inside its mip of width × height texels. Of later generations: HoldsLatentTexels.
constexpr bool HoldsLatents(const NtcNeuralMipConstants& grid, int width, int height,
                            const Rect& rect) noexcept {
    return detail::IsSlicePresent(grid, width, height, rect, detail::IsAxisPresent);
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
