// SPDX-License-Identifier: MIT
// Stability: stable
// What a scene wants of a texture set, and what the device can do: the request behind a PermutationKey.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// How texels are filtered. The decoder gives single texels; filters are the caller's, of several decoded
/// texels.
enum class Filter : std::uint8_t { Point };

/// Which maths mode to choose among those that the set's weights, the device and the language allow. On the
/// one GPU measured (NVIDIA H100, docs/benchmarks/h100-2026-11-22.md) COOPVEC_INT8 is exact, and COOPVEC_FP8,
/// which is not, takes 2.0 to 2.4 times as long; hence Fastest. FP8First is for sets encoded with care for
/// their FP8 network, and for devices where FP8 has been measured to be the faster.
enum class MathPreference : std::uint8_t {
    Exact, ///< INT8: the same bits on every device; FP8 for a set without Int8 weights
    /// COOPMAT_INT8 in passes that have it, by lanes (SceneNeeds::decodesOnMatrices), then COOPVEC_INT8, then
    /// COOPVEC_FP8, then INT8, then FP8: by what was measured
    Fastest,
    FP8First, ///< COOPVEC_FP8, then COOPVEC_INT8, then INT8, then FP8
    Specific, ///< SceneNeeds::math or an error
};

/// The language of the shader's source.
enum class ShaderLanguage : std::uint8_t {
    Glsl,
    Hlsl, ///< no cooperative vectors, weights by direct loads only; dot products need shader model 6.4 (DXC)
};

/// What the device offers, as the engine has found and enabled it.
struct DeviceFeatures {
    bool integerDotProduct = false;     ///< shaderIntegerDotProduct
    bool float16 = false;               ///< shaderFloat16, rounding to nearest even, subnormals kept
    bool cooperativeVectorInt8 = false; ///< VK_NV_cooperative_vector, signed Int8 matrices
    bool cooperativeVectorFP8 = false;  ///< the same with E4M3 matrices
    bool subgroupShuffle = false;       ///< in the stage that decodes, with 8 lanes or more
    bool isCpu = false;                 ///< an implementation on the CPU, such as lavapipe
    /// VK_KHR_cooperative_matrix: signed bytes, 16 x 16 x 32, sums of 32 bits, at subgroup scope; subgroups
    /// of 32 lanes, full ones, with shuffles; 32 KiB of shared memory.
    bool cooperativeMatrixInt8 = false;
    /// The same with an accumulator that ReadCoopMatLayout knows (inference/CooperativeMatrices.h),
    /// workgroups of 768 and 48 KiB of shared memory.
    bool cooperativeMatrixLanes = false;
};

/// What a shader that reads tiles (openntc/streaming/PageTable.h, Demand.h, Feedback.h) is called for. What
/// is not costs nothing; buffers that nothing is left to use need not be bound.
struct TileNeeds {
    bool used = false; ///< latents are tiles of a page table: slices of several mips
    bool fallback =
        true; ///< a coarser mip is shown where a tile is missing; else what is not resident is not used
    bool requests = true; ///< missing tiles are asked for through the launch state's queue
    bool stamps = true;   ///< slots that were read are marked, for the demand loader's eviction
    bool feedback = true; ///< what is wanted is recorded, for a tile manager
    bool rates = true;    ///< some launch has a request or feedback rate below 1
};

/// A request. The default reads every channel of every texture as stored, on any device.
struct SceneNeeds {
    std::span<const std::string_view> textures; ///< names of the textures that are read
    std::uint32_t channels = 0;                 ///< bit c: output c is read, besides those of `textures`
    bool linear = false;                        ///< in linear light, else as stored
    Filter filter = Filter::Point;
    bool firstMipOnly = false; ///< only mip 0 is sampled; not looked at with `tiles`
    bool wholeLatents = true;  ///< latents are uploaded whole, not as slices; likewise
    /// Latents of generation 2 or 3 are bound as a texture (openntc/LatentFetch.h), whole: the device filters
    /// them, which makes results depend on it. Else they are in a buffer.
    bool latentTextures = false;
    bool texelsInside = false;  ///< the shader asks for texels inside the mip only
    bool foldConstants = false; ///< outputs that are constants are given to the host instead of evaluated
    /// Every lane of a subgroup is active and decodes this set, as in a pass over a whole image.
    bool oneSetPerSubgroup = false;
    /// The shader decodes blocks: it calls NtcSampleTextureSetTexels, with the texels per invocation of the
    /// key.
    bool decodesBlocks = false;
    /// The shader is a pass that can be compiled for cooperative matrices: DecompressToTextures,
    /// DecodeBlocks, or one that calls NetworkCoopMat.h itself.
    bool decodesOnMatrices = false;
    /// weightsOffset is a multiple of 16, as PlanPacking places weights, or 0.
    bool alignedWeights = true;
    MathPreference preference = MathPreference::Exact;
    int math = 0; ///< NTC_MATH_*, with MathPreference::Specific
    ShaderLanguage language = ShaderLanguage::Glsl;
    DeviceFeatures device;
    TileNeeds tiles;
};

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
