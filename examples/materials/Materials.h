// SPDX-License-Identifier: MIT
// The sample materials. Each writes its images (size x size, seamless) and a manifest, NAME.json, and returns false if that fails.
#pragma once

#include "Images.h"

namespace materials {

bool WriteBricks(const std::filesystem::path& folder, int size);
bool WriteGrille(const std::filesystem::path& folder, int size);

} // namespace materials
