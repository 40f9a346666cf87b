// SPDX-License-Identifier: MIT
// Options of images and their mips that `encode`, `bake` and `convert-gltf` share.
#pragma once

#include "encode/EncodeInputs.h"

#include <CLI/CLI.hpp>

namespace openntc::tool {

/// --weight NAME=W. `weights` must live as long as the command.
void AddWeightOption(CLI::App& command, std::vector<NamedNumber>& weights);

/// --mips, --mip-filter, --mip-wrap, --normal-map, --weight and --keep-coverage. `inputs` must live as long as the command.
void AddInputOptions(CLI::App& command, InputOptions& inputs);

} // namespace openntc::tool
