// SPDX-License-Identifier: MIT
// The decoders that every hard case runs on, and the independent model that they are compared with.
#pragma once

#include "Decoder.h"
#include "conformance/EditableSet.h"
#include "conformance/Model.h"

#include "openntc/inference/SliceLayout.h"
#include "openntc/texture_set/TextureSetMetadata.h"

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace numerics {

using Outputs = std::array<float, 16>;

struct Texel {
    int mip = 0;
    int x = 0;
    int y = 0;
};

/// A texture set in memory with what decoders need of it.
class TestSet {
public:
    explicit TestSet(std::vector<std::byte> file);

    const openntc::TextureSetMetadata& GetMetadata() const { return *metadata_; }
    openntc::tool::DecodeData GetData(openntc::DecodeMath math) const;
    openntc::tool::DecodeData GetSliceData(openntc::DecodeMath math, const openntc::SliceDesc& slice) const;
    /// By the independent model.
    Outputs GetExpected(openntc::DecodeMath math, bool linear, const Texel& texel) const;
    /// Every `stride`-th texel of all mips, and the last of each.
    std::vector<Texel> ListTexels(std::size_t stride = 1) const;

private:
    std::vector<std::byte> file_;
    openntc::conformance::Model model_; // of file_
    std::optional<openntc::TextureSetMetadata> metadata_;
};

/// One decoder, made when it is first needed.
class TestDecoder {
public:
    TestDecoder(std::string name, openntc::tool::BackendOptions options)
        : name_(std::move(name)), options_(std::move(options)) {}

    const std::string& GetName() const { return name_; }
    bool IsDevice() const { return options_.backend == openntc::tool::Backend::Vulkan; }
    /// False, with the reason printed once, if the device is absent or has no form of the maths mode.
    bool Take(std::shared_ptr<const openntc::tool::DecodeData> data);
    std::vector<Outputs> Decode(const openntc::DecodeOptions& options, const TestSet& set,
                                std::span<const Texel> texels);

private:
    std::string name_;
    openntc::tool::BackendOptions options_;
    std::shared_ptr<const openntc::tool::DecodeData> data_;
    std::unique_ptr<openntc::tool::Decoder> decoder_;
    openntc::DecodeMath math_{};
    bool isAbsent_ = false;
};

/// Reference, fast and Vulkan (lavapipe, or the device of OPENNTC_TEST_DEVICE).
std::span<TestDecoder> GetDecoders();

/// Makes the model wrong while it lives: tests that the cases notice.
class PlantedMistake {
public:
    explicit PlantedMistake(openntc::conformance::Mistake mistake);
    ~PlantedMistake();
    PlantedMistake(const PlantedMistake&) = delete;
    PlantedMistake& operator=(const PlantedMistake&) = delete;
};

/// Largest difference of any decoder from the model over these texels, stored outputs; infinite where one is
/// NaN or infinite and the other is not. On devices subnormal numbers count as zero.
double Compare(const TestSet& set, openntc::DecodeMath math, std::span<const Texel> texels);
/// The same for decoders that have the latents of a slice alone.
double CompareSlice(const TestSet& set, openntc::DecodeMath math, const openntc::SliceDesc& slice,
                    std::span<const Texel> texels);

/// A set of one texel whose network outputs are what the caller wants: see ForceOutputs and ForceActivations.
openntc::conformance::EditableSet MakeOneTexelSet(std::uint32_t channelColorSpaces = 0);
/// Output c is values[c], exactly: weights 0, bias 1, scale values[c].
void ForceOutputs(openntc::conformance::EditableSet& set, std::span<const float, 16> values);
/// Third hidden layer and outputs for SetActivations.
void PrepareActivations(openntc::conformance::EditableSet& set);
/// The third hidden layer gets z[0] ... z[31]; output c is X(z[c]) + 15 X(z[16 + c]), X being the
/// activation's integer.
void SetActivations(openntc::tool::DecodeData& data, std::span<const float, 32> z);

} // namespace numerics
