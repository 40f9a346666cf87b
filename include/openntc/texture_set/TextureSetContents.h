// SPDX-License-Identifier: MIT
// Stability: internal
// The data behind TextureSetMetadata: the loader fills it.
#pragma once

#include "openntc/container/Document.h"
#include "openntc/core/Allocator.h"
#include "openntc/texture_set/InferenceWeights.h"
#include "openntc/texture_set/LatentShape.h"
#include "openntc/texture_set/MipChain.h"
#include "openntc/texture_set/TextureSetTypes.h"

#include <array>

#include "openntc/core/HideMacros.h"

namespace openntc::detail {

struct TextureSetContents {
    explicit TextureSetContents(Allocator& allocator) noexcept
        : weights(allocator), textures(allocator), bcModes(allocator), blockModes(allocator) {}

    container::Document document;
    TextureSetDesc desc;
    LatentShape latentShape;
    InferenceWeights weights;
    Array<Texture> textures;
    Array<BlockCompressionMode> bcModes;                         // of all textures, one after the other
    Array<BlockModeBuffer> blockModes;                           // likewise
    std::array<LatentImage, NTC_MAX_NEURAL_MIPS> latentImages{}; // generation 1
    int latentImageCount = 0;
    std::array<LatentMip, NTC_MAX_NEURAL_MIPS> latentMips{}; // generations 2 and 3
    int latentMipCount = 0;
    std::array<ColorMip, NTC_MAX_MIPS> colorMips{};
};

} // namespace openntc::detail

#include "openntc/core/RestoreMacros.h"
