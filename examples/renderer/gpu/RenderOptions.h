// SPDX-License-Identifier: MIT
// What is rendered, and how.
#pragma once

#include "renderer/gpu/MaterialEffects.h"

#include "textures/BlockCoding.h"

#include <cstdint>
#include <optional>
#include <string>

namespace openntc::renderer {

enum class Mode {
    Reference,  ///< source images, uncompressed, mips by the project's filter
    OnLoad,     ///< texture sets decoded to textures when the model is loaded
    OnSample,   ///< texture sets decoded texel by texel where pixels are shaded
    OnFeedback, ///< texture sets decoded to tiles of textures, those that pixels have read
};

enum class TextureFilter { Nearest, Bilinear, Trilinear, Cubic, CatmullRom, Mitchell, Gaussian, Anisotropic };

/// How a filter's texels are read; values equal NTCR_FILTER of shaders/MaterialTexels.glsl.
enum class Stochastic { Off = 0, OneTap = 1, Quads = 2, Collaborative = 3 };

enum class ShadingPath { Compute, Fragment };

/// Where masks of surfaces are decoded, with ShadingPath::Compute.
enum class MaskPath { Compute, Fragment };

struct RenderOptions {
    Mode mode = Mode::Reference;
    TextureFilter filter = TextureFilter::Trilinear;
    Stochastic stochastic = Stochastic::Off;
    ShadingPath path = ShadingPath::Compute;
    MaskPath masks = MaskPath::Compute;
    bool randomR2 = false; ///< numbers that fill their range over frames; else hashed
    std::uint32_t seed = 0;
    int math = 1;                  ///< NTC_MATH_* of on-sample, or kFastestMath (MathChoice.h)
    bool allowsVectorsInt8 = true; ///< cooperative vectors, where they are asked for or the fastest
    bool allowsVectorsFP8 = true;
    tool::BlockChoice blocks; ///< of on-load and on-feedback
    bool keepsTexels = false; ///< likewise: no block compression
    tool::BlockEffort effort = tool::BlockEffort::Fast;
    int tileSize = 64;      ///< of on-feedback, texels of a side: 16 ... 1024, a power of two
    int tilesPerFrame = 64; ///< of on-feedback: decoded after a frame at most
    double budgetMiB = 0.0; ///< of on-feedback, for atlases; 0: no limit
    int settle = -1; ///< of on-feedback: frames drawn again at most until tiles are there; -1: until they are
    int width = 640;
    int height = 480;
    float exposure = 1.0f;       ///< factor
    int toneCurve = 0;           ///< NTCR_TONE_*
    EffectSet forcedEffects = 0; ///< on whether or not a material calls for them
    bool counts = false;         ///< texels read and decoded

    bool operator==(const RenderOptions&) const = default;
};

/// Whether the same textures serve both.
inline bool UseSameTextures(const RenderOptions& a, const RenderOptions& b) {
    return a.mode == b.mode && a.math == b.math && a.allowsVectorsInt8 == b.allowsVectorsInt8 &&
           a.allowsVectorsFP8 == b.allowsVectorsFP8 && a.blocks == b.blocks &&
           a.keepsTexels == b.keepsTexels && a.effort == b.effort && a.forcedEffects == b.forcedEffects &&
           a.tileSize == b.tileSize && a.budgetMiB == b.budgetMiB;
}

} // namespace openntc::renderer
