// SPDX-License-Identifier: MIT
// Options of training that `encode` and `convert-gltf` share.
#pragma once

#include "encode/EncodeJob.h"

#include <CLI/CLI.hpp>

#include <memory>

namespace openntc::tool {

/// --bits-per-pixel, --latent-shape, --network, --target-psnr, --effort, --seconds, --steps, --seed, --threads, …
/// `choices` must live as long as the command.
void AddTrainingOptions(CLI::App& command, TrainingChoices& choices);

} // namespace openntc::tool
