// SPDX-License-Identifier: MIT
// A texture set in the place of images that are gone: what it decodes to, as inputs of an encoding.
#pragma once

#include "TextureSet.h"
#include "encode/EncodeInputs.h"

namespace openntc::tool {

/// Textures, formats, colour spaces and mips as the set has them; texels are those of its Int8 network, of
/// UNORM formats and of the mask (-1: none) within 0 ... 1. Warnings say what is lost. Throws
/// CommandError(BadInput) for sets without textures or with channels that no texture of a material describes.
EncodeInputs LoadArchivedSet(TextureSet& set, int maskChannel);

} // namespace openntc::tool
