// SPDX-License-Identifier: MIT
// Any texel of any slice decodes to the bits that it has in the whole set: random sets, mips, rectangles, all
// quantisations, on the reference decoder and on the fast one.
#include "support/RandomSlices.h"
#include "support/SpecificationVectors.h"

#include "openntc/decode/FastDecoder.h"
#include "openntc/decode/ReferenceDecoder.h"

#include <doctest/doctest.h>

#include <cstring>
#include <optional>
#include <string>
#include <vector>

using namespace openntc;
using namespace openntc_tests;

namespace {

struct SlicedSet {
    std::vector<std::byte> file;
    TextureSetMetadata metadata;
    NtcTextureSetConstants constants;         // of the whole set
    std::vector<std::vector<float>> expected; // of each mip, 16 a texel
    DecodeOptions options;
};

std::span<const std::byte> GetWeightsOf(const SlicedSet& set) {
    const auto weights = set.metadata.GetInferenceWeights(
        GetDecodeWeights(set.options.math) == DecodeWeights::FP8 ? InferenceWeightType::GenericFP8
                                                                 : InferenceWeightType::GenericInt8);
    REQUIRE(weights);
    return *weights;
}

DecodeSource GetSourceOf(const SlicedSet& set, const NtcTextureSetConstants& constants,
                         std::span<const std::byte> latents) {
    return {&constants, latents, GetWeightsOf(set), set.metadata.GetNetworkVersion(),
            GetDecodeWeights(set.options.math)};
}

InferenceWeightType GetType(DecodeMath math) {
    return GetDecodeWeights(math) == DecodeWeights::FP8 ? InferenceWeightType::GenericFP8
                                                        : InferenceWeightType::GenericInt8;
}

SlicedSet MakeSet(SynthesisDesc synthesis, DecodeMath math) {
    synthesis.withFP8 = true;
    std::vector<std::byte> file = MakeFile(synthesis);
    ReadOnlyMemoryStream stream(file);
    Expected<TextureSetMetadata> metadata = TextureSetMetadata::Load(stream);
    REQUIRE(metadata);
    const auto constants = MakeInferenceData(*metadata, kEntireStream, GetType(math));
    REQUIRE(constants);
    SlicedSet set{std::move(file), std::move(*metadata), *constants, {}, {math, false}};
    for (const ColorMip& mip : set.metadata.GetColorMips()) {
        std::vector<float> texels(static_cast<std::size_t>(mip.width) * static_cast<std::size_t>(mip.height) *
                                  16);
        REQUIRE(DecodeReference(GetSourceOf(set, set.constants, set.file),
                                static_cast<int>(set.expected.size()), {0, 0, mip.width, mip.height},
                                set.options, texels));
        set.expected.push_back(std::move(texels));
    }
    return set;
}

/// Texels of a rectangle that are not those of the whole set.
std::size_t CountDifferent(const SlicedSet& set, int mip, const Rect& rect, std::span<const float> texels) {
    const int width = set.metadata.GetColorMips()[static_cast<std::size_t>(mip)].width;
    const std::vector<float>& expected = set.expected[static_cast<std::size_t>(mip)];
    std::size_t different = 0;
    for (int y = 0; y < rect.height; ++y) {
        for (int x = 0; x < rect.width; ++x) {
            const std::size_t at = static_cast<std::size_t>(y * rect.width + x) * 16;
            const std::size_t whole = static_cast<std::size_t>((rect.top + y) * width + rect.left + x) * 16;
            different += std::memcmp(&texels[at], &expected[whole], 16 * sizeof(float)) != 0 ? 1u : 0u;
        }
    }
    return different;
}

/// Different texels of all mips of a slice, by the reference decoder or a fast one; `texels` counts all.
std::size_t CompareSlice(const SlicedSet& set, const SliceDesc& slice,
                         const NtcTextureSetConstants& constants, std::span<const std::byte> latents,
                         bool isFast, std::size_t& texels) {
    const DecodeSource source = GetSourceOf(set, constants, latents);
    std::optional<FastDecoder> fast;
    if (isFast) {
        Expected<FastDecoder> decoder =
            FastDecoder::Create(source, {.target = SimdTarget::Best, .threads = 1});
        if (!decoder)
            FAIL(std::string(decoder.error().GetText()));
        fast.emplace(std::move(*decoder));
    }
    std::size_t different = 0;
    for (int k = 0; k < slice.numMips; ++k) {
        const Rect held = GetHeldTexels(set.metadata, slice, k);
        if (held.width == 0 || held.height == 0)
            continue;
        std::vector<float> outputs(static_cast<std::size_t>(held.width) *
                                   static_cast<std::size_t>(held.height) * 16);
        const int mip = slice.firstMip + k;
        const auto decoded = isFast ? fast->Decode(mip, held, set.options, outputs)
                                    : DecodeReference(source, mip, held, set.options, outputs);
        if (!decoded)
            FAIL(std::string(decoded.error().GetText()));
        different += CountDifferent(set, mip, held, outputs);
        texels += outputs.size() / 16;
    }
    return different;
}

struct SliceInMemory {
    NtcTextureSetConstants constants;
    std::vector<std::byte> latents;
};

SliceInMemory CutSlice(const SlicedSet& set, const SliceDesc& slice) {
    const auto bytes = GetPartialLatentBufferSize(set.metadata, slice);
    REQUIRE(bytes);
    SliceInMemory result;
    result.latents.assign(static_cast<std::size_t>(*bytes), std::byte{0x5A});
    ReadOnlyMemoryStream stream(set.file);
    const auto data =
        MakePartialInferenceData(set.metadata, stream, slice, GetType(set.options.math), result.latents);
    if (!data)
        FAIL(std::string(data.error().GetText()));
    result.constants = data->constants;
    const auto conservative = GetConservativeLatentBufferSize(set.metadata, slice.firstMip, slice.numMips,
                                                              slice.rect.width, slice.rect.height);
    REQUIRE(conservative);
    CHECK(*conservative >= *bytes);
    return result;
}

/// Several slices in one buffer, the constants of the whole set, and a row for each slice and latent image.
void CheckRows(const SlicedSet& set, const std::vector<SliceDesc>& slices, SliceRandom& random,
               std::size_t& texels) {
    std::vector<std::byte> buffer;
    std::vector<std::uint32_t> places;
    for (const SliceDesc& slice : slices) {
        const auto layout = GetSliceLayout(set.metadata, slice);
        REQUIRE(layout);
        buffer.resize(buffer.size() + static_cast<std::size_t>(4 * random.Pick(0, 5)), std::byte{0xEE});
        places.push_back(static_cast<std::uint32_t>(buffer.size()));
        buffer.resize(buffer.size() + static_cast<std::size_t>(layout->bytes), std::byte{0xEE});
        REQUIRE(ReadSlice(*layout, std::span<const std::byte>(set.file).subspan(64), 64,
                          std::span(buffer).subspan(places.back())));
    }
    for (std::size_t i = 0; i < slices.size(); ++i) {
        const auto layout = GetSliceLayout(set.metadata, slices[i]);
        REQUIRE(layout);
        NtcTextureSetConstants patched = set.constants;
        for (int image = 0; image < NTC_MAX_NEURAL_MIPS; ++image) {
            const auto row = MoveSliceConstants(MakeSliceConstants(*layout, image), places[i]);
            REQUIRE(row);
            REQUIRE(PatchConstants(patched, image, *row));
            const NtcSliceConstants kept = GetSliceConstants(patched, image);
            CHECK(std::memcmp(&kept, &*row, sizeof kept) == 0);
        }
        INFO("slice in a shared buffer: " << ToText(slices[i]));
        CHECK(CompareSlice(set, slices[i], patched, buffer, false, texels) == 0);
    }
}

} // namespace

TEST_CASE("any texel of any slice has the bits of the whole set") {
    const std::uint64_t seed = openntc::test::GetTestSeed();
    MESSAGE("OPENNTC_TEST_SEED=" << seed);
    SliceRandom random(seed);
    std::size_t texels = 0;
    std::size_t halfBytePixels = 0;
    for (int i = 0; i < 96; ++i) {
        const SynthesisDesc synthesis = PickSet(random, i % 4 == 0 ? 12 : 48);
        const DecodeMath math = i % 6 == 5 ? static_cast<DecodeMath>(random.Pick(3, 5))
                                           : static_cast<DecodeMath>(random.Pick(1, 2));
        const SlicedSet set = MakeSet(synthesis, math);
        INFO("OPENNTC_TEST_SEED=" << seed << ": " << ToText(synthesis));
        std::vector<SliceDesc> slices;
        for (int j = 0; j < 6; ++j) {
            const SliceDesc slice = PickSlice(random, set.metadata);
            INFO("slice " << ToText(slice));
            const SliceInMemory memory = CutSlice(set, slice);
            CHECK(CompareSlice(set, slice, memory.constants, memory.latents, false, texels) == 0);
            if (math == DecodeMath::Int8 || math == DecodeMath::Int8Half)
                CHECK(CompareSlice(set, slice, memory.constants, memory.latents, true, texels) == 0);
            const NtcNeuralMipConstants& grid = set.constants.highResNeuralMips[0];
            if (synthesis.shape.highResFeatures * synthesis.shape.highResQuantBits % 8 != 0 &&
                grid.imageWidthHeight % 2 != 0)
                ++halfBytePixels;
            slices.push_back(slice);
        }
        CheckRows(set, slices, random, texels);
    }
    MESSAGE("compared " << texels << " texels; " << halfBytePixels
                        << " slices with half-byte pixels in odd rows");
    CHECK(texels > 0);
}

TEST_CASE("half-byte pixels in rows of odd length: every position and size") {
    SynthesisDesc synthesis;
    synthesis.seed = 7;
    synthesis.desc = {15, 11, 4, 2};
    synthesis.shape = {2, 12, 4, 1, 1}; // grids of 7x5 and 3x2 latent pixels of 12 and 4 bits
    const SlicedSet set = MakeSet(synthesis, DecodeMath::Int8);
    REQUIRE(set.constants.highResNeuralMips[0].imageWidthHeight == (7u | 5u << 16));
    REQUIRE(set.constants.lowResNeuralMips[0].imageWidthHeight == (3u | 2u << 16));
    std::size_t texels = 0;
    int cutRows = 0;
    for (int left = 0; left < 15; left += 2) {
        for (int width = 1; left + width <= 15; width += 3) {
            for (int top = 0; top < 11; top += 3) {
                for (int height = 1; top + height <= 11; height += 4) {
                    const SliceDesc slice{0, 2, {left, top, width, height}};
                    INFO("slice " << ToText(slice));
                    const auto layout = GetSliceLayout(set.metadata, slice);
                    REQUIRE(layout);
                    for (const SliceGrid& grid : layout->GetGrids()) {
                        CHECK(grid.left + grid.width <= grid.imageWidth);
                        CHECK(grid.top + grid.height <= grid.imageHeight);
                        for (int run = 0; run < GetSliceRunCount(grid); ++run)
                            cutRows += GetSliceRun(grid, run).IsAligned() ? 0 : 1;
                    }
                    const SliceInMemory memory = CutSlice(set, slice);
                    CHECK(CompareSlice(set, slice, memory.constants, memory.latents, false, texels) == 0);
                }
            }
        }
    }
    CHECK(cutRows > 0);
    CHECK(texels > 0);
}

TEST_CASE("sizes that do not halve: the published cut lacks latents, slices do not") {
    SynthesisDesc synthesis;
    synthesis.seed = 9;
    synthesis.desc = {71, 16, 4, 4}; // 71, 35, 17, 8 texels: the last mip's 8 cover 64 of the 71
    synthesis.shape = {4, 4, 4, 8, 8};
    const SlicedSet set = MakeSet(synthesis, DecodeMath::Int8);
    SliceDesc slice{0, 4, {64, 0, 7, 16}};
    std::size_t texels = 0;
    const SliceInMemory whole = CutSlice(set, slice);
    CHECK(CompareSlice(set, slice, whole.constants, whole.latents, false, texels) == 0);
    CHECK(texels == 7 * 16 + 3 * 8 + 1 * 4); // mip 3 ends before
    slice.coverage = SliceCoverage::Published;
    const SliceInMemory published = CutSlice(set, slice);
    CHECK(published.latents.size() < whole.latents.size());
    CHECK(CompareSlice(set, slice, published.constants, published.latents, false, texels) > 0);
}
