// SPDX-License-Identifier: MIT
// One file to encode: load, train (or search for a quality), write; interrupted work is kept for later.
#pragma once

#include "encode/EncodeInputs.h"

#include "openntc/encode/EncodeOptions.h"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace openntc::tool {

/// What `encode` and `convert-gltf` let users choose about training.
struct TrainingChoices {
    encode::EncodeOptions encode;
    int generation = 1;                      ///< of the file; the network in `encode` follows
    double targetPsnr = 0.0;                 ///< > 0: the smallest known shape that reaches it
    std::vector<NamedNumber> textureTargets; ///< and these, of single textures
    double maximumBits = 0.0;                ///< > 0: limit of that search
    std::optional<std::string> device;       ///< Vulkan device that trains: index or part of its name
    bool hasShape = false;   ///< the size was said: targets, a manifest's then, are only checked
    bool blockModes = false; ///< generation 3: search for BC7 blocks, and keep their modes in the set
    bool strict = false;     ///< sizes that differ are refused; changed mask texels are a failure
};

struct EncodeJob {
    InputOptions inputs;
    std::function<EncodeInputs()> load = {}; ///< makes them instead, once
    std::string output;
    TrainingChoices training;
    bool resume = false;
    bool keepsState = true;     ///< an interrupt leaves a state, for `resume`
    std::string statePath = {}; ///< of that state; empty: OUTPUT.state
    bool json = false;          ///< events are JSON, one object a line
    bool quiet = false;         ///< no progress
    bool explains = false;      ///< says on standard output how each image was understood, before training
    double saveSeconds = 120.0; ///< between states, where one is kept
    bool isAlone = true;        ///< no other job runs in this process
    /// Called on the thread of RunEncodeJob as training goes on.
    std::function<void(const encode::Progress&)> watch = {};

    std::string GetStatePath() const;
};

struct EncodedFile {
    encode::EncodeResult result;
    std::vector<UnderstoodTexture> textures;
    int channelCount = 0;
    std::uint32_t declaredChannels = 0;
    std::uint64_t bytes = 0;
    std::string missed; ///< targets that were not reached, for people
};

/// Writes the file of `job`. Throws CommandError; an interrupt leaves the state where wanted and throws Failed.
EncodedFile RunEncodeJob(const EncodeJob& job);

/// dB of a texture's channels together, from those of each.
double GetTexturePsnr(const encode::EncodeResult& result, int firstChannel, int channels);

/// Throws CommandError(Failed) if a written file misses a target or, with `strict`, changes mask texels.
void CheckGoals(const EncodeJob& job, const EncodedFile& file);

} // namespace openntc::tool
