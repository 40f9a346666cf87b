// SPDX-License-Identifier: MIT
// A texture set as the independent model sees it: read from the bytes of a file by a reader of its own, written from the
// format specification's container document. The mistakes of a decoder that are no arithmetic are edits of it.
#pragma once

#include "Model.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace openntc::conformance {

/// One grid of latents in the file: element k of pixel (x, y) has `bits` bits at bit y * rowBits + (x * stride + k) * bits.
struct ModelGrid {
    int width = 0;
    int height = 0;
    int features = 0;
    int stride = 0; ///< elements from pixel to pixel: the features
    int bits = 0;
    std::size_t rowBits = 0;
    std::size_t offset = 0; ///< of the file, bytes
    std::size_t size = 0;   ///< elements behind it read as 0
};

struct ModelImage {
    ModelGrid high;
    ModelGrid low;
};

/// Of generations 2 and 3: layers of 16-bit texels of four codes.
struct ModelLatentMip {
    int width = 0;
    int height = 0;
    std::vector<std::size_t> layers; ///< of the file, bytes
};

struct ModelMip {
    int width = 0;
    int height = 0;
    int image = 0;
    float lod = 0;
    float scale = 0;
};

/// One row of a layer's weights after another. Int8 networks have scales and biases; of FP8 networks layers 0 to 2 have
/// E4M3 weights and binary16 biases.
struct ModelLayer {
    std::vector<std::uint8_t> weights;
    std::vector<float> scales;
    std::vector<std::int32_t> biases;
    std::vector<std::uint16_t> halfBiases;

    int GetWeight(std::size_t index) const { return static_cast<std::int8_t>(weights[index]); }
};

using ModelNetwork = std::array<ModelLayer, 4>;

struct ModelSet {
    int width = 0;
    int height = 0;
    int channels = 0;
    int highSlots = 0; ///< high-resolution features that the network has inputs for
    std::array<int, 16> colorSpaces{};
    std::array<float, 16> legacyScales{}; ///< "scale" and "bias" of channels: a record, not to be applied
    std::array<float, 16> legacyBiases{};
    int generation = 1;
    std::vector<ModelImage> images;         ///< of generation 1
    std::vector<ModelLatentMip> latentMips; ///< of the others
    std::vector<ModelMip> mips;
    std::optional<ModelNetwork> int8;
    std::optional<ModelNetwork> fp8;
    std::span<const std::byte> file;
};

/// Reads a file. Throws std::runtime_error for what the suite's files never are. `mistake`: those of readers are made.
ModelSet ReadModelSet(std::span<const std::byte> file, Mistake mistake = Mistake::None);

/// Makes those mistakes that are wrong contents of the set.
void EditSet(Mistake mistake, ModelSet& set);

/// The texel that a decoder with the mistake decodes in place of the one asked for; none: its outputs are zero.
std::optional<ModelRequest> EditRequest(Mistake mistake, const ModelSet& set, ModelRequest request);

/// What a decoder with the mistake makes of the 16 outputs, converted or not.
void EditOutputs(Mistake mistake, const ModelSet& set, DecodeMath math, std::array<double, 16>& outputs);

/// Stored to linear as a decoder with the mistake does it.
double ConvertWithMistake(Mistake mistake, const ModelSet& set, std::size_t channel, double stored);

/// The 16 outputs in storage colour space before EditOutputs.
std::array<double, 16> EvaluateModel(const ModelSet& set, const ModelRequest& request, Mistake mistake);

/// The network's inputs of a texel [2], in units of the maths mode.
std::vector<double> GetModelInputs(const ModelSet& set, const ModelRequest& request, Mistake mistake);

/// The same of a set of generation 2 or 3.
std::vector<double> GetLatentMipInputs(const ModelSet& set, const ModelRequest& request, Mistake mistake);

/// Binary32 to E4M3, with the mistakes that decoders make there.
double RoundToE4M3With(Mistake mistake, double x);

} // namespace openntc::conformance
