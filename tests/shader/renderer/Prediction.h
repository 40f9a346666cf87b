// SPDX-License-Identifier: MIT
// What a picture must show, computed on the CPU apart from the renderer's passes: triangles, depth, texture coordinates,
// texels of the finest mip by the nearest one, masks, what is blended. Of the renderer it has the functions of light, which
// tests of their own hold to the specification.
//
// Known are pixels whose value does not hang on rounding: not on an edge, not between two texels, not on a mask's cutoff,
// and nowhere minified. There both compute the same real numbers in binary32, so that pictures differ by a step at most.
#pragma once

#include "renderer/scene/Scene.h"
#include "shader/renderer/Rendering.h"

#include "openntc/decode/DecodeTypes.h"

#include <glm/vec2.hpp>
#include <glm/vec4.hpp>

#include <cstddef>
#include <functional>
#include <vector>

namespace openntc_tests {

/// An orthographic camera at (center, 50) that looks along -z.
openntc::renderer::Camera MakeFrontCamera(glm::vec2 center, float unitsPerPixel, int width, int height);

/// A texel of a material's slot as shading takes it: base colour and alpha; roughness, metallic; specular, glossiness; normal
/// map, occlusion in x, emission, transmission in x. Linear light.
using ReadTexel =
    std::function<glm::vec4(int material, openntc::renderer::TextureSlot slot, glm::ivec2 texel)>;

/// Those of the source images.
ReadTexel MakeImageSource(const openntc::renderer::Scene& scene);

/// A texture set decoded on the CPU, for materials' slots that are of it; others are as in the source images. `rounds`: to
/// the 8 bits of a texture on load.
ReadTexel MakeSetSource(const openntc::renderer::Scene& scene, openntc::DecodeMath math, bool rounds);

struct Prediction {
    std::vector<std::uint8_t> picture; ///< RGBA
    std::vector<bool> isKnown;         ///< of pixels
    std::size_t covered = 0;           ///< pixels where something is
    std::size_t known = 0;             ///< of these
};

/// `camera`: one of MakeFrontCamera. Tone curve none.
Prediction Predict(const openntc::renderer::Scene& scene, const openntc::renderer::Camera& camera, int width,
                   int height, float exposure, const ReadTexel& texels);

/// The largest difference over known pixels, in steps of 255.
int GetLargestDifference(const Prediction& prediction, const Picture& picture);

} // namespace openntc_tests
