// SPDX-License-Identifier: MIT
// A synthesised texture set taken apart, so that hard cases can change one thing of it and write it again.
#pragma once

#include "openntc/inference/Synthesis.h"
#include "openntc/texture_set/TextureSetMetadata.h"

#include <cstddef>
#include <span>
#include <vector>

namespace openntc::conformance {

struct EditableSet {
    struct Latents {
        LatentImage image;
        std::vector<std::byte> highRes;
        std::vector<std::byte> lowRes;
    };

    TextureSetDesc desc;
    LatentShape shape;
    std::uint32_t channelColorSpaces = 0;
    InferenceWeights weights;
    std::vector<Latents> latents;
    std::vector<ColorMip> mips;

    /// Weights, scales and biases of one layer, in bytes of weights.int8.
    std::span<std::byte> GetInt8Weights(std::size_t layer);
    void SetInt8Scale(std::size_t layer, std::size_t row, float scale);
    float GetInt8Scale(std::size_t layer, std::size_t row);
    void SetInt8Bias(std::size_t layer, std::size_t row, std::int32_t bias);
};

/// Throws std::runtime_error for a description that no file can hold.
EditableSet SynthesizeEditableSet(const SynthesisDesc& synthesis);
std::vector<std::byte> WriteSet(const EditableSet& set);

/// The bytes of a synthesised file.
std::vector<std::byte> SynthesizeBytes(const SynthesisDesc& synthesis);

} // namespace openntc::conformance
