// SPDX-License-Identifier: MIT
// Shapes of latents, latent images, sizes of images and numbers of channels.
#include "RawFile.h"
#include "SuiteBuilder.h"

#include "../Output.h"

#include <algorithm>

namespace openntc::conformance {

namespace {

using tool::Format;

// Sum and products in the field of four elements: they make a table of 16 rows in which any two of the columns
// a, b, a + b, a + 2 b, a + 3 b hold all 16 pairs.
constexpr int kTimes2[] = {0, 2, 3, 1};
constexpr int kTimes3[] = {0, 3, 1, 2};

void AddPairs(SuiteBuilder& builder) {
    static constexpr int kFeatures[] = {4, 8, 12, 16};
    static constexpr int kBits[] = {1, 2, 4, 8};
    for (int a = 0; a < 4; ++a) {
        for (int b = 0; b < 4; ++b) {
            const LatentShape shape{2, kFeatures[a], kFeatures[a ^ b], kBits[b], kBits[a ^ kTimes2[b]]};
            const int network = std::max(a, a ^ kTimes3[b]) + 1;
            const std::string name =
                Format("shape-%dx%d-%dx%d", shape.highResFeatures, shape.highResQuantBits,
                       shape.lowResFeatures, shape.lowResQuantBits);
            const auto seed = static_cast<std::uint32_t>(600 + 4 * a + b);
            builder.AddSet(name, SynthesizeBytes(Describe(seed, 11, 10, 2, shape, network)));
            builder.AddCase(name, DecodeMath::Int8, builder.ListAllTexels(4),
                            Format("%d features of %d bits, %d of %d, in a %s network; grids of odd widths",
                                   shape.highResFeatures, shape.highResQuantBits, shape.lowResFeatures,
                                   shape.lowResQuantBits, GetNetworkName(network)));
        }
    }
}

// A small network with wide low-resolution grids, and every code of 8 bits in both grids.
void AddMoreShapes(SuiteBuilder& builder) {
    for (const int features : {12, 16}) {
        const std::string name = Format("shape-4x2-%dx4-small", features);
        builder.AddSet(name, SynthesizeBytes(Describe(static_cast<std::uint32_t>(616 + features), 11, 10, 2,
                                                      {2, 4, features, 2, 4}, NTC_NETWORK_SMALL)));
        builder.AddCase(name, DecodeMath::Int8, builder.ListAllTexels(4),
                        Format("%d low-resolution features in a small network", features));
    }
    EditableSet set = SynthesizeEditableSet(Describe(640, 20, 20, 3, {2, 16, 16, 8, 8}));
    for (EditableSet::Latents& latents : set.latents) {
        for (std::vector<std::byte>* codes : {&latents.highRes, &latents.lowRes}) {
            for (std::size_t i = 0; i < codes->size(); ++i)
                (*codes)[i] = static_cast<std::byte>(i * 77 + i / 256);
        }
    }
    builder.AddSet("codes-of-8-bits", WriteSet(set));
    builder.AddCase("codes-of-8-bits", DecodeMath::Int8, builder.ListAllTexels(9),
                    "16 and 16 features of 8 bits with every code");
}

// Gives the set `count` latent images of the sizes of encoders, with codes of other sets.
void SetImageCount(EditableSet& set, std::size_t count) {
    while (set.latents.size() < count) {
        const int n = static_cast<int>(set.latents.size());
        EditableSet::Latents latents;
        latents.image = openntc::detail::MakeLatentImage(set.desc, set.shape.gridSizeScale, n);
        openntc::detail::SynthesisGenerator generator(static_cast<std::uint32_t>(700 + n));
        const auto fill = [&](const LatentGrid& grid, int features, int bits, std::vector<std::byte>& bytes) {
            bytes.resize(
                static_cast<std::size_t>(GetLatentGridBytes(grid.width, grid.height, features, bits)));
            for (std::byte& byte : bytes)
                byte = static_cast<std::byte>(generator.Next() & 255);
        };
        fill(latents.image.highRes, set.shape.highResFeatures, set.shape.highResQuantBits, latents.highRes);
        fill(latents.image.lowRes, set.shape.lowResFeatures, set.shape.lowResQuantBits, latents.lowRes);
        set.latents.push_back(std::move(latents));
    }
}

void AddImages(SuiteBuilder& builder) {
    EditableSet set = SynthesizeEditableSet(Describe(650, 1024, 8, 11, {2, 4, 4, 2, 2}));
    SetImageCount(set, 8);
    for (std::size_t m = 0; m < set.mips.size(); ++m)
        set.mips[m].neuralMip = std::min(static_cast<int>(m), 7);
    builder.AddSet("images-8", WriteSet(set));
    builder.AddMistakeCase({Mistake::TwoLatentImages, Mistake::LowResOfImage0}, DecodeMath::Int8,
                           "eight latent images, mips to the last");
    builder.AddCase("images-8-mips", DecodeMath::Int8, builder.ListFewTexels(6),
                    "eight latent images: texels of every mip");
    static constexpr int kImages[] = {7, 3, 0, 6, 1, 5, 2, 4, 0, 7, 1};
    for (std::size_t m = 0; m < set.mips.size(); ++m)
        set.mips[m].neuralMip = kImages[m];
    builder.AddSet("images-order", WriteSet(set));
    builder.AddMistakeCase({Mistake::ImageOfEarlierMip}, DecodeMath::Int8,
                           "mips whose latent images are in no order");

    for (int scale = 2; scale <= 8; ++scale) {
        const auto seed = static_cast<std::uint32_t>(660 + scale);
        const std::string name = Format("images-scale-%d", scale);
        builder.AddSet(name, SynthesizeBytes(Describe(seed, 512, 512, 10, {scale, 4, 4, 1, 1})));
        builder.AddCase(name, DecodeMath::Int8, builder.ListFewTexels(7),
                        Format("one latent pixel for %d x %d texels, %zu latent images", scale, scale,
                               builder.GetMetadata().GetLatentImages().size()));
    }
    builder.AddSet("big-grid", SynthesizeBytes(Describe(670, 512, 512, 10, {2, 16, 16, 1, 1})));
    builder.AddCase("big-grid", DecodeMath::Int8, builder.ListFewTexels(9),
                    "grids of more than 65536 bytes and of a million latents");

    // Any sizes that 16 bits hold: finer than the image, coarser by other factors, low resolution finer than high.
    set = SynthesizeEditableSet(Describe(671, 60, 36, 4, {2, 4, 4, 4, 2}));
    set.latents.resize(1);
    SetImageCount(set, 3);
    static constexpr int kSizes[3][4] = {{61, 35, 7, 50}, {13, 40, 29, 1}, {1, 9, 3, 2}};
    for (std::size_t n = 0; n < 3; ++n) {
        EditableSet::Latents& latents = set.latents[n];
        const auto resize = [&](LatentGrid& grid, int width, int height, int features, int bits,
                                std::vector<std::byte>& bytes) {
            grid.width = width;
            grid.height = height;
            const auto size = static_cast<std::size_t>(GetLatentGridBytes(width, height, features, bits));
            for (std::size_t i = bytes.size(); i < size; ++i)
                bytes.push_back(static_cast<std::byte>(i * 151 + n * 31));
            bytes.resize(size);
        };
        resize(latents.image.highRes, kSizes[n][0], kSizes[n][1], 4, 4, latents.highRes);
        resize(latents.image.lowRes, kSizes[n][2], kSizes[n][3], 4, 2, latents.lowRes);
    }
    for (std::size_t m = 0; m < set.mips.size(); ++m)
        set.mips[m].neuralMip = std::min(static_cast<int>(m), 2);
    builder.AddSet("grid-sizes", WriteSet(set));
    builder.AddMistakeCase({Mistake::FormulaGrids}, DecodeMath::Int8,
                           "grids of sizes that no formula gives, finer than the image too");
}

void AddSizes(SuiteBuilder& builder) {
    for (const auto& [width, height] : {std::pair(16384, 1), std::pair(1, 16384)}) {
        const std::string name = Format("size-%dx%d", width, height);
        builder.AddSet(name, SynthesizeBytes(Describe(680, width, height, 15, {2, 4, 4, 1, 2})));
        builder.AddCase(name, DecodeMath::Int8, builder.ListFewTexels(6),
                        "the longest side, 15 mips, grids of 8192 latents a side");
    }
    // More mips than the image has halvings: the last ones are one texel.
    EditableSet set = SynthesizeEditableSet(Describe(681, 9, 5, 4, {2, 4, 4, 2, 4}));
    set.desc.mips = 4;
    builder.AddSet("size-9x5", WriteSet(set));
    builder.AddCase("size-9x5", DecodeMath::Int8, builder.ListAllTexels(), "all texels of all mips to 1 x 1");
}

void AddChannels(SuiteBuilder& builder) {
    for (const int channels : {1, 3, 10}) {
        SynthesisDesc synthesis =
            Describe(static_cast<std::uint32_t>(690 + channels), 12, 10, 2, kPlainShape);
        synthesis.desc.channels = channels;
        for (int c = 0; c < channels; ++c)
            synthesis.channelColorSpaces |= static_cast<std::uint32_t>((c + 1) % 3) << (2 * c);
        RawFile file(SynthesizeBytes(synthesis));
        file.json["numChannels"].SetInt(channels); // our writer makes odd numbers even
        while (file.json["channels"].Size() > static_cast<unsigned>(channels))
            file.json["channels"].PopBack();
        builder.AddSet(Format("channels-%d", channels), file.Write());
        const std::string about = Format("a set of %d channels: all 16 outputs are expected", channels);
        if (channels == 3)
            builder.AddMistakeCase({Mistake::UndeclaredZero}, DecodeMath::Int8, about);
        else
            builder.AddCase(Format("channels-%d", channels), DecodeMath::Int8, builder.ListAllTexels(5),
                            about);
        builder
            .AddCase(Format("channels-%d-linear", channels), DecodeMath::Int8Half, builder.ListAllTexels(7),
                     about + "; those that it does not declare are linear")
            .linear = true;
    }
}

} // namespace

void AddShapes(SuiteBuilder& builder) {
    AddPairs(builder);
    AddMoreShapes(builder);
    AddImages(builder);
    AddSizes(builder);
    AddChannels(builder);
}

} // namespace openntc::conformance
