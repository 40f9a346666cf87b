// SPDX-License-Identifier: MIT
// What a scene wants of a texture set, and what the device can do: the request behind a PermutationKey.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace openntc {

/// How texels are filtered. The decoder gives single texels; filters are the caller's, of several decoded texels.
enum class Filter : std::uint8_t { Point };

/// Which maths mode to choose among those that the set's weights and the device allow.
enum class MathPreference : std::uint8_t {
    Exact,    ///< Int8: the same bits on every device
    Fastest,  ///< cooperative vectors with FP8 weights, then with Int8 weights, then Int8
    Specific, ///< SceneNeeds::math or an error
};

/// What the device offers, as the engine has found and enabled it.
struct DeviceFeatures {
    bool integerDotProduct = false;     ///< shaderIntegerDotProduct
    bool float16 = false;               ///< shaderFloat16, rounding to nearest even, subnormals kept
    bool cooperativeVectorInt8 = false; ///< VK_NV_cooperative_vector, signed Int8 matrices
    bool cooperativeVectorFP8 = false;  ///< the same with E4M3 matrices
    bool subgroupShuffle = false;       ///< in the stage that decodes, with 8 lanes or more
    bool isCpu = false;                 ///< an implementation on the CPU, such as lavapipe
};

/// A request. The default reads every channel of every texture as stored, on any device.
struct SceneNeeds {
    std::span<const std::string_view> textures; ///< names of the textures that are read
    std::uint32_t channels = 0;                 ///< bit c: output c is read, besides those of `textures`
    bool linear = false;                        ///< in linear light, else as stored
    Filter filter = Filter::Point;
    bool firstMipOnly = false;  ///< only mip 0 is sampled
    bool wholeLatents = true;   ///< latents are uploaded whole, not as slices
    bool texelsInside = false;  ///< the shader asks for texels inside the mip only
    bool foldConstants = false; ///< outputs that are constants are given to the host instead of evaluated
    /// Every lane of a subgroup is active and decodes this set, as in a pass over a whole image.
    bool oneSetPerSubgroup = false;
    /// The shader decodes blocks: it calls NtcSampleTextureSetTexels, with the texels per invocation of the key.
    bool decodesBlocks = false;
    /// weightsOffset is a multiple of 16, as PlanPacking places weights, or 0.
    bool alignedWeights = true;
    MathPreference preference = MathPreference::Exact;
    int math = 0; ///< NTC_MATH_*, with MathPreference::Specific
    DeviceFeatures device;
};

} // namespace openntc
