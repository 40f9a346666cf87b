// SPDX-License-Identifier: MIT
// A texture set in the place of images that are gone: what it decodes to, as inputs of an encoding.
#pragma once

#include "TextureSet.h"
#include "encode/EncodeInputs.h"

namespace openntc::tool {

/// What options say of the set's textures and of the new file.
struct ArchivedSetOptions {
    int maskChannel = -1;                  ///< -1: none
    std::vector<NamedNumber> weights = {}; ///< of textures' errors
    std::vector<NamedNumber> targets = {}; ///< dB of textures
    int generation = 1;                    ///< of the new file
    bool newModes = false;                 ///< it gets BC7 modes of its own
};

/// Textures, formats, colour spaces and mips as the set has them; texels are those of its Int8 network (FP8
/// where it has no other), of UNORM formats and of the mask within 0 ... 1. Warnings say what is lost. Throws
/// CommandError: Usage for names that no texture has, BadInput for sets without textures or with channels that
/// no texture of a material describes.
EncodeInputs LoadArchivedSet(TextureSet& set, const ArchivedSetOptions& options);

} // namespace openntc::tool
