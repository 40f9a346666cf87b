// SPDX-License-Identifier: MIT
// Stability: stable
// Latents and weights of many texture sets in few buffers.
//
//   auto total = PlanPacking(requests, limits, placements);        // where everything goes
//   for each set: CopyPacked(placements[i], latents, weights, mappedBuffers[placements[i].buffer]);
//   shader: NtcSampleTextureSet(desc, buffer, latentsOffset, buffer, weightsOffset, ...)
// or with offsets 0 in the shader, after MoveConstants(constants, placement.latentsOffset,
// placement.weightsOffset).
#pragma once

#include "openntc/InferenceConstants.h"
#include "openntc/core/CheckedMath.h"
#include "openntc/core/Expected.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// What buffers may look like. Sizes and offsets in bytes.
struct PackingLimits {
    /// Largest buffer: the device's maxStorageBufferRange. The default is what every Vulkan device has.
    /// Shaders address bytes with 32 bits, so that a buffer never grows beyond 4 GiB.
    std::uint64_t maxBufferBytes = std::uint64_t{1} << 27;
    /// Of each set's latents, and of the buffer's last byte: shaders read whole words, so at least 4. Where
    /// descriptors start inside the buffer it must be the device's minStorageBufferOffsetAlignment.
    std::uint32_t latentAlignment = 16;
    /// Of each set's weights: 16 for wide loads; cooperative-vector matrices want 64.
    std::uint32_t weightAlignment = 64;
};

struct PackRequest {
    std::uint64_t latentBytes = 0; ///< 0: latents live elsewhere
    std::uint64_t weightBytes = 0; ///< 0: weights live elsewhere (shared with another set, for example)
};

/// Where the bytes of one set are: offsets in buffer number `buffer`.
struct PackedSet {
    std::uint32_t buffer = 0;
    std::uint32_t latentsOffset = 0;
    std::uint32_t weightsOffset = 0;
    std::uint64_t latentBytes = 0;
    std::uint64_t weightBytes = 0;
};

struct PackingSummary {
    std::uint32_t buffers = 0;
    std::uint64_t largestBufferBytes = 0; ///< a size that fits every buffer
    std::uint64_t lastBufferBytes = 0;
    std::uint64_t paddingBytes = 0; ///< lost to alignment, in all buffers
};

/// Places the sets in order, latents before weights, and starts a new buffer where a set does not fit the
/// present one. Errors: InvalidArgument for alignments that are not powers of two from 4 on, or fewer
/// placements than requests; OutOfRange for a set that does not fit any buffer.
inline Expected<PackingSummary> PlanPacking(std::span<const PackRequest> requests,
                                            const PackingLimits& limits,
                                            std::span<PackedSet> placements) noexcept {
    for (const std::uint32_t alignment : {limits.latentAlignment, limits.weightAlignment}) {
        if (alignment < 4 || !std::has_single_bit(alignment))
            return Fail(Status::InvalidArgument, "alignment: %u: must be a power of two from 4 on",
                        alignment);
    }
    if (placements.size() < requests.size())
        return Fail(Status::InvalidArgument, "placements: %zu: must be at least %zu", placements.size(),
                    requests.size());
    const std::uint64_t limit = std::min<std::uint64_t>(limits.maxBufferBytes, std::uint64_t{1} << 32);
    const auto align = [](std::uint64_t offset, std::uint32_t alignment) {
        return (offset + alignment - 1) & ~std::uint64_t{alignment - 1};
    };
    PackingSummary summary;
    std::uint64_t used = 0;
    for (std::size_t i = 0; i < requests.size(); ++i) {
        const PackRequest& request = requests[i];
        // Neither is more than 4 GiB from here on, so that nothing wraps.
        if (request.latentBytes > limit || request.weightBytes > limit)
            return Fail(Status::OutOfRange, "requests[%zu]: %llu and %llu bytes: a buffer holds %llu", i,
                        static_cast<unsigned long long>(request.latentBytes),
                        static_cast<unsigned long long>(request.weightBytes),
                        static_cast<unsigned long long>(limit));
        std::uint64_t latents = 0;
        std::uint64_t weights = 0;
        std::uint64_t end = 0;
        const auto place = [&](std::uint64_t start) {
            latents = align(start, limits.latentAlignment);
            weights = align(latents + request.latentBytes, limits.weightAlignment);
            end = align(weights + request.weightBytes, 4);
            return end <= limit;
        };
        if (summary.buffers == 0)
            summary.buffers = 1;
        if (!place(used)) {
            if (used == 0 || !place(0))
                return Fail(Status::OutOfRange,
                            "requests[%zu]: %llu bytes with alignment: a buffer holds %llu", i,
                            static_cast<unsigned long long>(end), static_cast<unsigned long long>(limit));
            ++summary.buffers;
            used = 0;
        }
        // An empty part at the very end of 4 GiB has no 32-bit offset, and nothing that would need one.
        const auto narrow = [](std::uint64_t offset) {
            return static_cast<std::uint32_t>(
                std::min<std::uint64_t>(offset, std::numeric_limits<std::uint32_t>::max()));
        };
        placements[i] = {summary.buffers - 1, narrow(latents), narrow(weights), request.latentBytes,
                         request.weightBytes};
        summary.paddingBytes += end - used - request.latentBytes - request.weightBytes;
        used = end;
        summary.largestBufferBytes = std::max(summary.largestBufferBytes, end);
        summary.lastBufferBytes = end;
    }
    return summary;
}

/// Copies one set to its place. Errors: InvalidArgument if the spans do not have the sizes that were planned
/// for or the buffer ends too early.
inline Expected<void> CopyPacked(const PackedSet& placement, std::span<const std::byte> latents,
                                 std::span<const std::byte> weights, std::span<std::byte> buffer) noexcept {
    if (latents.size() != placement.latentBytes || weights.size() != placement.weightBytes)
        return Fail(Status::InvalidArgument,
                    "latents, weights: %zu and %zu bytes: planned were %llu and %llu", latents.size(),
                    weights.size(), static_cast<unsigned long long>(placement.latentBytes),
                    static_cast<unsigned long long>(placement.weightBytes));
    if (!IsRangeInside(placement.latentsOffset, placement.latentBytes, buffer.size()) ||
        !IsRangeInside(placement.weightsOffset, placement.weightBytes, buffer.size()))
        return Fail(Status::InvalidArgument, "buffer: %zu bytes: ends before the set does", buffer.size());
    if (!latents.empty())
        std::memcpy(buffer.data() + placement.latentsOffset, latents.data(), latents.size());
    if (!weights.empty())
        std::memcpy(buffer.data() + placement.weightsOffset, weights.data(), weights.size());
    return {};
}

/// Adds the offsets of a set in shared buffers to its constants, so that the shader's own offsets are 0.
/// Errors: InvalidArgument for offsets that are not multiples of 4; OutOfRange for latents at 4 GiB or
/// behind, and weights at 2 GiB or behind (the constants hold signed offsets: give the shader weightsOffset
/// there). The constants are then unchanged.
inline Expected<void> MoveConstants(NtcTextureSetConstants& constants, std::uint32_t latentsOffset,
                                    std::uint32_t weightsOffset) noexcept {
    if (latentsOffset % 4 != 0 || weightsOffset % 4 != 0)
        return Fail(Status::InvalidArgument, "offsets: %u and %u: must be multiples of 4", latentsOffset,
                    weightsOffset);
    NtcTextureSetConstants moved = constants;
    for (const std::span<NtcNeuralMipConstants> grids :
         {std::span<NtcNeuralMipConstants>(moved.highResNeuralMips),
          std::span<NtcNeuralMipConstants>(moved.lowResNeuralMips)}) {
        for (NtcNeuralMipConstants& grid : grids) {
            if (grid.sliceWidthHeight == 0)
                continue;
            if (grid.dataOffset > std::numeric_limits<std::uint32_t>::max() - latentsOffset)
                return Fail(Status::OutOfRange, "latentsOffset: %u: latents would lie at 4 GiB or behind",
                            latentsOffset);
            grid.dataOffset += latentsOffset;
        }
    }
    for (std::int32_t* const offset :
         {&moved.networkWeightOffset0, &moved.networkWeightOffset1, &moved.networkWeightOffset2,
          &moved.networkWeightOffset3, &moved.networkScaleBiasOffset}) {
        const std::int64_t sum = std::int64_t{*offset} + weightsOffset;
        if (sum > std::numeric_limits<std::int32_t>::max())
            return Fail(Status::OutOfRange, "weightsOffset: %u: weights would lie at 2 GiB or behind",
                        weightsOffset);
        *offset = static_cast<std::int32_t>(sum);
    }
    constants = moved;
    return {};
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
