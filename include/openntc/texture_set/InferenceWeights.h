// SPDX-License-Identifier: MIT
// Stability: stable
// The weight buffers of a texture set with what a permutation of the outputs changes along with them:
// filled by the loader, permuted in copies by inference.
#pragma once

#include "openntc/core/Allocator.h"
#include "openntc/core/Expected.h"
#include "openntc/format/Enums.h"
#include "openntc/format/NetworkDescription.h"

#include <cstddef>
#include <cstdint>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// Weight buffers in the generic layouts of NetworkDescription. Made by TextureSetMetadata and
/// ShuffleInferenceOutputs.
struct InferenceWeights {
    InferenceWeights() noexcept = default;
    explicit InferenceWeights(Allocator& allocator) noexcept : int8(allocator), fp8(allocator) {}

    int networkVersion = NTC_NETWORK_UNKNOWN;
    std::uint32_t validChannelMask =
        0; ///< bit c: output c is covered by a texture (or is a shuffled constant)
    std::uint32_t channelColorSpaces = 0; ///< storage colour space of output c in bits 2c and 2c + 1
    Array<std::byte> int8;                ///< "generic Int8" buffer, empty if the set has no such network
    Array<std::byte> fp8;                 ///< "generic FP8" buffer, empty if the set has no such network

    /// The bytes of one storage form, little-endian, 16-byte aligned; empty if there are none.
    std::span<const std::byte> Get(InferenceWeightType type) const noexcept {
        switch (type) {
        case InferenceWeightType::GenericInt8:
            return int8.AsSpan();
        case InferenceWeightType::GenericFP8:
            return fp8.AsSpan();
        case InferenceWeightType::Unknown:
        case InferenceWeightType::CoopVecInt8:
        case InferenceWeightType::CoopVecFP8:
        case InferenceWeightType::CoopMatInt8:
            break;
        }
        return {};
    }

    /// A deep copy. Errors: OutOfMemory.
    Expected<InferenceWeights> Clone(Allocator& allocator) const noexcept {
        InferenceWeights copy(allocator);
        copy.networkVersion = networkVersion;
        copy.validChannelMask = validChannelMask;
        copy.channelColorSpaces = channelColorSpaces;
        OPENNTC_CHECK(copy.int8.Assign(int8.AsSpan()));
        OPENNTC_CHECK(copy.fp8.Assign(fp8.AsSpan()));
        return copy;
    }
};

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
