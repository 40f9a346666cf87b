// SPDX-License-Identifier: MIT
// From a command line (images, a folder or a manifest) to a material.
#pragma once

#include "encode/Manifest.h"

#include "openntc/encode/Material.h"

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace openntc::tool {

struct InputOptions {
    std::vector<std::string> paths;        ///< images, or one folder, or one manifest (.json)
    std::optional<Manifest> manifest = {}; ///< instead; paths[0] then only names it in errors
    int mips = 0;                          ///< 0: the full chain
    bool strict = false;                   ///< images of another size are an error, not resampled
};

struct EncodeInputs {
    encode::Material material;
    int maskChannel = -1; ///< from the manifest's labels
    std::array<float, 16> lossScales{};
    std::vector<std::string> warnings;
};

/// Throws CommandError: BadInput for files, Failed for sizes that differ with --strict, Usage for channels that do
/// not fit.
EncodeInputs LoadInputs(const InputOptions& options);

} // namespace openntc::tool
