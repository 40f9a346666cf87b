// SPDX-License-Identifier: MIT
// What a shader reads of a texture set: constants, weights and latents, of all mips or of some.
#pragma once

#include "TextureSet.h"

#include "openntc/inference/InferenceData.h"

#include <optional>
#include <span>
#include <string>

namespace CLI {
class App;
}

namespace openntc::tool {

struct ShaderInputsOptions {
    std::string file;
    std::string weights = "int8"; ///< or "fp8"
    std::optional<int> firstMip;
    std::optional<int> mips;
};

/// FILE, `--weights`, `--first-mip` and `--mips`.
void AddShaderInputsOptions(CLI::App& command, ShaderInputsOptions& options);

struct ShaderInputs {
    NtcTextureSetConstants constants;
    InferenceWeightType weightType;
    std::span<const std::byte> weights; ///< the set keeps them
    StreamRange latents;                ///< in the file; what shaders read is ReadLatents'
    std::size_t latentBufferBytes;      ///< of what ReadLatents makes
    int firstMip;
    int mips;
};

/// Throws CommandError: mips that the set does not have (Usage), weights that it does not have (BadInput).
ShaderInputs MakeShaderInputs(const TextureSet& set, const ShaderInputsOptions& options);

} // namespace openntc::tool
