// SPDX-License-Identifier: MIT
// The sample materials, size x size, seamless. Write… writes the images and a manifest, NAME.json, and
// returns false if that fails.
#pragma once

#include "Images.h"

namespace materials {

/// Linear; what a material lacks is empty.
struct MaterialImages {
    Image color{0, 0}, height{0, 0}, roughness{0, 0}, metalness{0, 0}, normal{0, 0}, occlusion{0, 0},
        emission{0, 0};
};

MaterialImages MakeBricks(int size);
MaterialImages MakeGrille(int size);

bool WriteBricks(const std::filesystem::path& folder, int size);
bool WriteGrille(const std::filesystem::path& folder, int size);

} // namespace materials
