// SPDX-License-Identifier: MIT
// Options of training that `encode` and `convert-gltf` share.
#pragma once

#include "Arguments.h"
#include "encode/EncodeJob.h"

#include <CLI/CLI.hpp>

#include <string>

namespace openntc::tool {

/// `values`' element of the name; a usage error that lists all names for another one.
template <typename T, std::size_t N>
T SelectName(const char* option, const std::string& name, const char* const (&names)[N],
             const T (&values)[N]) {
    std::string all;
    for (std::size_t i = 0; i < N; ++i) {
        if (name == names[i])
            return values[i];
        all += (i == 0 ? "" : ", ") + std::string(names[i]);
    }
    FailUsage(option, name + ": " + all);
}

/// NAME=NUMBER; the name may hold further `=`. A usage error for anything else and outside the limits.
NamedNumber ParseNamedNumber(const char* option, const std::string& text, const NumberLimits& limits);

/// --bits-per-pixel, --latent-shape, --network, --target-psnr, --effort, --seconds, --steps, --seed, --threads, …
/// `choices` must live as long as the command.
void AddTrainingOptions(CLI::App& command, TrainingChoices& choices);

} // namespace openntc::tool
