// SPDX-License-Identifier: MIT
// Sets of one form, each of which differs from the one before in a single thing: what a decoder keeps of the set before
// gives wrong texels.
#include "SuiteBuilder.h"

#include <algorithm>
#include <cstring>

namespace openntc::conformance {

namespace {

constexpr int kMips = 4;

EditableSet MakeSet(std::uint32_t seed, const LatentShape& shape) {
    return SynthesizeEditableSet(Describe(seed, 40, 40, kMips, shape, NTC_NETWORK_MEDIUM));
}

void ReplaceWeights(EditableSet& set, EditableSet& other) {
    for (std::size_t layer = 0; layer < 4; ++layer) {
        const std::span<std::byte> to = set.GetInt8Weights(layer);
        std::memcpy(to.data(), other.GetInt8Weights(layer).data(), to.size());
    }
}

} // namespace

void AddSequence(SuiteBuilder& builder) {
    EditableSet set = MakeSet(1100, {2, 4, 8, 2, 4});
    EditableSet other = MakeSet(1101, {2, 4, 8, 2, 4});
    for (ColorMip& mip : set.mips) { // not those of the formula: that mistake has another name
        mip.positionLod += 0.125f;
        mip.positionScale *= 0.75f;
    }
    const auto add = [&](const std::string& what, const std::string& about) -> SuiteCase& {
        const std::string name = "state-" + what;
        builder.AddSet(name, WriteSet(set));
        return builder.AddCase(name, DecodeMath::Int8, builder.ListFewTexels(6), about);
    };
    const auto addChange = [&](const std::string& what, const std::string& thing) -> SuiteCase& {
        return add(what, "a set that differs from the one before in its " + thing);
    };
    add("first", "the first of a row of sets each of which differs from the one before in one thing");
    ReplaceWeights(set, other);
    addChange("weights", "weights");
    for (std::size_t layer = 0; layer < 4; ++layer) {
        for (std::size_t row = 0; row < (layer == 3 ? 16u : 64u); ++row)
            set.SetInt8Scale(layer, row, other.GetInt8Scale(layer, row));
    }
    addChange("scales", "scales");
    for (std::size_t layer = 0; layer < 4; ++layer) {
        for (std::size_t row = 0; row < (layer == 3 ? 16u : 64u); ++row)
            set.SetInt8Bias(layer, row, static_cast<std::int32_t>(row * 211 + layer * 97) - 5000);
    }
    addChange("biases", "biases");
    set.latents = other.latents;
    addChange("latents", "latents");
    other = MakeSet(1102, {2, 4, 8, 4, 8});
    set.shape = other.shape;
    set.latents = other.latents;
    addChange("bits", "bit widths of latents");
    other = MakeSet(1103, {2, 8, 4, 4, 8});
    set.shape = other.shape;
    set.latents = other.latents;
    addChange("features", "numbers of features");
    for (ColorMip& mip : set.mips) {
        mip.positionLod += 0.25f;
        mip.positionScale *= 1.5f;
    }
    addChange("lods", "levels of detail and position scales");
    for (ColorMip& mip : set.mips)
        mip.neuralMip = 1 - mip.neuralMip;
    addChange("images", "latent images of mips");
    for (std::uint32_t channel = 0; channel < 16; ++channel)
        set.channelColorSpaces |= (channel + 1) % 3 << (2 * channel);
    addChange("colours", "colour spaces").linear = true;
    for (std::size_t n = 0; n < set.latents.size(); ++n) {
        // Grids of other sizes, out of the same bytes.
        const auto shrink = [&](LatentGrid& grid, int features, int bits, std::vector<std::byte>& bytes) {
            grid.width = std::max(grid.width - 3, 1);
            grid.height = std::max(grid.height - 1, 1);
            bytes.resize(
                static_cast<std::size_t>(GetLatentGridBytes(grid.width, grid.height, features, bits)));
        };
        shrink(set.latents[n].image.highRes, set.shape.highResFeatures, set.shape.highResQuantBits,
               set.latents[n].highRes);
        shrink(set.latents[n].image.lowRes, set.shape.lowResFeatures, set.shape.lowResQuantBits,
               set.latents[n].lowRes);
    }
    addChange("grids", "sizes of grids");
}

} // namespace openntc::conformance
