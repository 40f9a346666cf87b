// SPDX-License-Identifier: MIT
// How a glTF material addresses one of its textures. Textures of one set are sampled at one texel position, so only those
// with equal addressing can share a set.
#pragma once

#include "Json.h"

#include <array>
#include <string>

namespace openntc::tool {

/// Numbers are those of glTF (and OpenGL); 0: the model says nothing, which is taken as REPEAT, LINEAR and
/// LINEAR_MIPMAP_LINEAR.
struct TextureSampler {
    int wrapS = 0, wrapT = 0;
    int magFilter = 0, minFilter = 0;
};

/// KHR_texture_transform: uv' = offset + rotation * scale * uv.
struct TextureTransform {
    std::array<double, 2> offset{0.0, 0.0};
    double rotation = 0.0; ///< radians, counter-clockwise
    std::array<double, 2> scale{1.0, 1.0};

    bool operator==(const TextureTransform&) const = default;
};

struct TextureAddressing {
    int texCoord = 0;
    TextureSampler sampler;
    TextureTransform transform;
    std::string animation; ///< what moves the transform (KHR_animation_pointer); empty: nothing
};

/// What keeps the two textures out of one set, for people: `texCoord 1 instead of 0, wrapS CLAMP_TO_EDGE instead of
/// REPEAT`. Empty: they can share one.
std::string DescribeDifference(const TextureAddressing& texture, const TextureAddressing& first);

/// The name of a wrap mode or filter in glTF's schema; null for other numbers.
const char* FindSamplerName(int number);

/// Members texCoord, sampler, and transform where there is one.
void WriteAddressing(JsonWriter& json, const TextureAddressing& addressing);

} // namespace openntc::tool
