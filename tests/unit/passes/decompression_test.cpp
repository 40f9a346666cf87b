// SPDX-License-Identifier: MIT
// MakeDecompressionPass: constants, dispatch and permutation, and what it refuses. shader/passes runs the passes.
#include "openntc/core/Stream.h"
#include "openntc/inference/Synthesis.h"
#include "openntc/passes/DecompressTexel.h"
#include "openntc/passes/DecompressionPass.h"
#include "openntc/texture_set/LatentShape.h"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

using namespace openntc;

namespace {

constexpr int kPassWidth = 100;
constexpr int kPassHeight = 70;

TextureSetMetadata MakePassSet(std::span<const Texture> textures, MemoryStream& stream) {
    SynthesisDesc synthesis;
    synthesis.desc = {kPassWidth, kPassHeight, 16, 4};
    synthesis.networkVersion = NTC_NETWORK_MEDIUM;
    synthesis.shape = {4, 8, 8, 2, 2};
    synthesis.textures = textures;
    REQUIRE(SynthesizeTextureSet(stream, synthesis));
    auto metadata = TextureSetMetadata::Load(stream);
    REQUIRE(metadata);
    return std::move(*metadata);
}

Status GetPassStatus(const Expected<DecompressionPass>& pass) {
    return pass ? Status::Ok : pass.error().GetStatus();
}

} // namespace

TEST_CASE("a decompression pass: the mip's constants, the dispatch and the permutation") {
    MemoryStream stream;
    const TextureSetMetadata set = MakePassSet({}, stream);
    const std::array<DecompressionOutput, 2> outputs = {
        {{.image = 3, .firstChannel = 15, .numChannels = 1, .ditherScale = 0.25f},
         {.image = 1,
          .firstChannel = 2,
          .numChannels = 4,
          .rgbColorSpace = ColorSpace::sRGB,
          .alphaColorSpace = ColorSpace::HLG}}};
    DecompressionRequest request;
    request.mip = 1;
    request.rect = Rect{3, 5, 33, 17};
    request.destination = TexelOffset{8, 9};
    request.outputs = outputs;
    request.firstImage = 10;
    const auto pass = MakeDecompressionPass(set, kEntireStream, request, {});
    REQUIRE_MESSAGE(pass.has_value(), std::string(pass.error().GetText()));
    const NtcDecompressConstants& c = pass->constants;
    CHECK(c.desc.imageWidth == kPassWidth / 2);
    CHECK(c.desc.imageHeight == kPassHeight / 2);
    CHECK(c.desc.imageMips == 1);
    CHECK(c.desc.colorMips[0].neuralMip == 0);
    CHECK(std::array{c.left, c.top, c.width, c.height} == std::array{3, 5, 33, 17});
    CHECK(c.destinationLeft == 8);
    CHECK(c.destinationTop == 9);
    CHECK(c.outputCount == 2);
    CHECK(c.outputs[0].channels == (15u | 1u << 4));
    CHECK(c.outputs[0].ditherScale == 0.25f);
    CHECK(c.outputs[0].noise == 1);
    CHECK(c.outputs[0].image == 13);
    CHECK(c.outputs[1].channels == (2u | 4u << 4 | std::uint32_t{NTC_COLOR_SPACE_SRGB} << 8 |
                                    std::uint32_t{NTC_COLOR_SPACE_HLG} << 10));
    CHECK(c.outputs[1].noise == 2);
    CHECK(c.outputs[1].image == 11);
    CHECK(std::array{pass->groups[0], pass->groups[1], pass->groups[2]} ==
          std::array<std::uint32_t, 3>{3, 3, 1});
    const PermutationKey& key = pass->permutation.key;
    CHECK(key.networkVersion == NTC_NETWORK_MEDIUM);
    CHECK(key.effects[NTC_EFFECT_OUTPUT_MASK] == 0x803Cu);
    CHECK(key.effects[NTC_EFFECT_SINGLE_MIP] == 1);
    CHECK(key.effects[NTC_EFFECT_LATENT_SLICES] == 0);
    // Stored linear: sRGB and HLG must be made, and without them nothing is.
    CHECK(pass->convertsColors);
    CHECK(std::string(pass->GetOwnDefines()).empty());
    DecompressionRequest plain = request;
    const DecompressionOutput stored[] = {{.firstChannel = 2, .numChannels = 4}};
    plain.outputs = stored;
    const auto asStored = MakeDecompressionPass(set, kEntireStream, plain, {});
    REQUIRE(asStored);
    CHECK_FALSE(asStored->convertsColors);
    CHECK(std::string(asStored->GetOwnDefines()) == "NTC_DECOMPRESS_CONVERT=0");

    // Two texels an invocation halve the groups.
    SceneNeeds fast;
    fast.device.integerDotProduct = true;
    const auto wide = MakeDecompressionPass(set, kEntireStream, request, fast);
    REQUIRE(wide);
    CHECK(wide->permutation.key.texelsPerInvocation == 2);
    CHECK(wide->groups[0] == 2);

    // On matrices all outputs are evaluated, and a workgroup has 20 blocks of 8 x 4 texels at once, or 8.
    fast.preference = MathPreference::Fastest;
    fast.device.cooperativeMatrixInt8 = true;
    fast.device.cooperativeMatrixLanes = true;
    const auto lanes = MakeDecompressionPass(set, kEntireStream, request, fast);
    REQUIRE(lanes);
    CHECK(lanes->permutation.key.math == NTC_MATH_COOPMAT_INT8);
    CHECK(lanes->permutation.weightType == InferenceWeightType::CoopMatInt8);
    CHECK(lanes->permutation.key.effects[NTC_EFFECT_OUTPUT_MASK] == 0xFFFFu);
    CHECK(lanes->groups[0] == 2); // of 5 x 5 blocks
    CHECK(lanes->groups[1] == 1);
    CHECK(lanes->constants.desc.highResNeuralMips[0].dataOffset ==
          pass->constants.desc.highResNeuralMips[0].dataOffset);
    fast.preference = MathPreference::Specific;
    fast.math = NTC_MATH_COOPMAT_INT8_HALF;
    fast.device.cooperativeMatrixLanes = false;
    const auto portable = MakeDecompressionPass(set, kEntireStream, request, fast);
    REQUIRE(portable);
    CHECK(portable->groups[0] == 4);
    CHECK(GetCoopMatGroups(4096, 4096, 20) == 264);
    CHECK(GetCoopMatGroups(1 << 20, 1 << 20, 4) == 1320);
    CHECK(GetCoopMatGroups(1, 1, 20) == 1);
}

TEST_CASE("a decompression pass of generation 3: latents in a buffer, or in a texture at the mip's level") {
    MemoryStream stream;
    SynthesisDesc synthesis;
    synthesis.desc = {128, 64, 16, 8};
    synthesis.networkVersion = NTC_NETWORK_GENERATION_3;
    synthesis.shape = MakeLayeredShape(2, 8);
    REQUIRE(SynthesizeTextureSet(stream, synthesis));
    const auto set = TextureSetMetadata::Load(stream);
    REQUIRE(set);
    const auto constants = MakeInferenceData(*set, 0, 8, InferenceWeightType::GenericInt8);
    REQUIRE(constants);
    DecompressionRequest request;
    request.mip = 7;
    const DecompressionOutput stored[] = {{.firstChannel = 2, .numChannels = 4}};
    request.outputs = stored;
    const int level = constants->colorMips[7].neuralMip;
    REQUIRE(level > 0);
    for (const bool isTexture : {false, true}) {
        SceneNeeds needs;
        needs.preference = MathPreference::Fastest;
        needs.device.cooperativeMatrixInt8 = needs.device.cooperativeMatrixLanes = true;
        needs.latentTextures = isTexture;
        const auto pass = MakeDecompressionPass(*set, *constants, request, needs);
        REQUIRE_MESSAGE(pass.has_value(), std::string(pass.error().GetText()));
        CHECK(pass->permutation.key.math == NTC_MATH_COOPMAT_INT8);
        CHECK(pass->permutation.key.latentFetch == (isTexture ? NTC_LATENTS_TEXTURE : NTC_LATENTS_BUFFER));
        CHECK(pass->constants.desc.colorMips[0].neuralMip == (isTexture ? level : 0));
        CHECK(pass->constants.desc.highResNeuralMips[0].dataOffset ==
              constants->highResNeuralMips[level].dataOffset);
    }
}

TEST_CASE("a decompression pass without outputs writes the set's textures, more than sixteen in batches") {
    std::vector<Texture> textures(20);
    for (std::size_t i = 0; i < textures.size(); ++i) {
        textures[i].name = "t";
        textures[i].firstChannel = static_cast<int>(i % 16);
        textures[i].numChannels = 1;
        textures[i].channelFormat = i % 2 == 0 ? ChannelFormat::UNORM8 : ChannelFormat::FLOAT16;
        textures[i].rgbColorSpace = i % 3 == 0 ? ColorSpace::sRGB : ColorSpace::Linear;
    }
    MemoryStream stream;
    const TextureSetMetadata set = MakePassSet(textures, stream);
    DecompressionRequest request;
    for (request.batch = 0; request.batch < 2; ++request.batch) {
        const auto pass = MakeDecompressionPass(set, kEntireStream, request, {});
        REQUIRE_MESSAGE(pass.has_value(), std::string(pass.error().GetText()));
        CHECK(pass->batchCount == 2);
        REQUIRE(pass->constants.outputCount == (request.batch == 0 ? 16 : 4));
        for (int i = 0; i < pass->constants.outputCount; ++i) {
            const std::size_t texture = static_cast<std::size_t>(16 * request.batch + i);
            const NtcDecompressOutput& output = pass->constants.outputs[i];
            CHECK(output.image == texture);
            CHECK(output.noise == texture + 1);
            CHECK((output.channels & 15u) == texture % 16);
            CHECK((output.channels >> 8 & 3u) ==
                  (texture % 3 == 0 ? NTC_COLOR_SPACE_SRGB : NTC_COLOR_SPACE_LINEAR));
            CHECK(output.ditherScale == (texture % 2 == 0 ? 1.0f / 255.0f : 0.0f));
            CHECK((output.channels >> 12 & 31u) == (texture % 2 == 0 ? 8u : 0u));
        }
        CHECK(pass->constants.width == kPassWidth);
        CHECK(pass->constants.height == kPassHeight);
    }
    CHECK(GetPassStatus(MakeDecompressionPass(set, kEntireStream, request, {})) == Status::OutOfRange);
}

TEST_CASE("codes of normalised textures are the nearest, whatever the value") {
    const auto model = [](float value, std::uint32_t most) {
        if (!(value > 0))
            return 0u;
        // 24 + 16 bits of product, and one half: exact in binary64.
        return value >= 1 ? most : static_cast<std::uint32_t>(std::floor(double{value} * most + 0.5));
    };
    std::vector<float> values = {0.0f,
                                 -0.0f,
                                 1.0f,
                                 1.5f,
                                 -1.0f,
                                 0x1p-149f,
                                 0x1p-126f,
                                 0x1p-18f,
                                 0x1p-17f,
                                 0x1.fffffep-18f,
                                 0x1.fffffep-1f,
                                 std::numeric_limits<float>::infinity(),
                                 -std::numeric_limits<float>::infinity(),
                                 std::numeric_limits<float>::quiet_NaN(),
                                 -std::numeric_limits<float>::quiet_NaN()};
    std::uint32_t state = 1;
    for (int i = 0; i < 20000; ++i)
        values.push_back(shader::asfloat((state = state * 1664525u + 1013904223u) >> 2)); // 0 … 2
    for (const std::uint32_t most : {1u, 3u, 255u, 1023u, 65535u}) {
        std::vector<float> tried = values;
        for (std::uint32_t code = 0; code < most; code += std::max(1u, most / 1000)) { // about halves
            const auto half = static_cast<float>((code + 0.5) / most);
            for (const float value : {std::nextafter(half, 0.0f), half, std::nextafter(half, 1.0f)})
                tried.push_back(value);
        }
        std::size_t wrong = 0;
        for (const float value : tried)
            wrong += shader::NtcQuantiseUnorm(value, most) != model(value, most) ? 1 : 0;
        CAPTURE(most);
        CHECK(wrong == 0);
    }
}

TEST_CASE("decompression passes that are not possible are refused") {
    MemoryStream stream;
    const TextureSetMetadata set = MakePassSet({}, stream);
    const auto refuse = [&](Status status, auto change) {
        DecompressionOutput output;
        DecompressionRequest request;
        change(request, output);
        request.outputs = std::span(&output, 1);
        CHECK(GetPassStatus(MakeDecompressionPass(set, kEntireStream, request, {})) == status);
    };
    using Request = DecompressionRequest;
    using Output = DecompressionOutput;
    constexpr int kMost = std::numeric_limits<int>::max();
    refuse(Status::Ok, [](Request&, Output& o) { o.firstChannel = 15; });
    refuse(Status::OutOfRange, [](Request& r, Output&) { r.mip = -1; });
    refuse(Status::OutOfRange, [](Request& r, Output&) { r.mip = 4; });
    refuse(Status::OutOfRange, [](Request& r, Output&) { r.batch = 1; });
    refuse(Status::OutOfRange, [](Request& r, Output&) { r.batch = -1; });
    refuse(Status::OutOfRange, [](Request& r, Output&) { r.batch = kMost; });
    for (const Rect& rect :
         {Rect{0, 0, 0, 4}, Rect{0, 0, 4, 0}, Rect{0, 0, -1, 1}, Rect{-1, 0, 4, 4}, Rect{0, -1, 4, 4},
          Rect{97, 0, 4, 4}, Rect{0, 67, 4, 4}, Rect{kMost, 0, kMost, 4}, Rect{0, 0, 101, 1}})
        refuse(Status::OutOfRange, [&rect](Request& r, Output&) { r.rect = rect; });
    refuse(Status::OutOfRange, [](Request& r, Output&) { r.destination = TexelOffset{-1, 0}; });
    refuse(Status::OutOfRange, [](Request& r, Output&) { r.destination = TexelOffset{0, kMost}; });
    refuse(Status::InvalidArgument, [](Request&, Output& o) { o.firstChannel = -1; });
    refuse(Status::InvalidArgument, [](Request&, Output& o) { o.firstChannel = 16; });
    refuse(Status::InvalidArgument, [](Request&, Output& o) { o.numChannels = 0; });
    refuse(Status::InvalidArgument, [](Request&, Output& o) { o.numChannels = 5; });
    refuse(Status::InvalidArgument, [](Request&, Output& o) {
        o.firstChannel = 14;
        o.numChannels = 3;
    });
    refuse(Status::InvalidArgument, [](Request&, Output& o) { o.image = -1; });
    refuse(Status::InvalidArgument, [](Request& r, Output& o) {
        o.image = 1;
        r.firstImage = kMost;
    });
    refuse(Status::InvalidArgument,
           [](Request&, Output& o) { o.rgbColorSpace = static_cast<ColorSpace>(3); });
    refuse(Status::InvalidArgument,
           [](Request&, Output& o) { o.ditherScale = std::numeric_limits<float>::quiet_NaN(); });
    refuse(Status::InvalidArgument, [](Request&, Output& o) { o.unormBits = -1; });
    refuse(Status::InvalidArgument, [](Request&, Output& o) { o.unormBits = 17; });
    refuse(Status::Ok, [](Request&, Output& o) { o.unormBits = 16; });
    // Latents that are not in the buffer.
    const DecompressionOutput output;
    DecompressionRequest request;
    request.outputs = std::span(&output, 1);
    CHECK(GetPassStatus(MakeDecompressionPass(set, StreamRange{}, request, {})) == Status::OutOfRange);
    // The set's only texture has sixteen channels; textures on a GPU have four.
    CHECK(GetPassStatus(MakeDecompressionPass(set, kEntireStream, DecompressionRequest{}, {})) ==
          Status::InvalidArgument);
}

TEST_CASE("decompression passes of later generations take mips, or the constants of a slice") {
    for (const int network : {NTC_NETWORK_GENERATION_2, NTC_NETWORK_GENERATION_3}) {
        SynthesisDesc synthesis;
        synthesis.desc = {kPassWidth, kPassHeight, 4, 4};
        synthesis.networkVersion = network;
        synthesis.shape = MakeLayeredShape(2, 8);
        MemoryStream stream;
        REQUIRE(SynthesizeTextureSet(stream, synthesis));
        const TextureSetMetadata set = *TextureSetMetadata::Load(stream);
        DecompressionRequest request;
        CHECK(GetPassStatus(MakeDecompressionPass(set, kEntireStream, request, {})) == Status::Unsupported);
        const auto whole = MakeDecompressionPass(set, 0, 4, request, {});
        REQUIRE_MESSAGE(whole.has_value(), std::string(whole.error().GetText()));
        CHECK(whole->permutation.key.networkVersion == network);
        CHECK(whole->permutation.key.effects[NTC_EFFECT_LATENT_SLICES] == 0);
        CHECK(whole->constants.desc.highResNeuralMips[0].imageWidthHeight == (35u << 16 | 50u));
        CHECK(whole->constants.desc.lowResNeuralMips[0].imageWidthHeight == (17u << 16 | 25u));
        // Mip 3 uses coarser latents: those of mips 0 … 1 are not enough, nor the other way round.
        request.mip = 3;
        CHECK(GetPassStatus(MakeDecompressionPass(set, 0, 4, request, {})) == Status::Ok);
        CHECK(GetPassStatus(MakeDecompressionPass(set, 0, 1, request, {})) == Status::OutOfRange);
        request.mip = 0;
        CHECK(GetPassStatus(MakeDecompressionPass(set, 3, 1, request, {})) == Status::OutOfRange);
        // A slice serves its own texels, at every edge, and none beyond what its border covers.
        for (const Rect& rect : {Rect{0, 0, 24, 16}, Rect{76, 54, 24, 16}, Rect{40, 30, 24, 16}}) {
            const LatentMipSliceLayout layout = *GetLatentMipSlices(set, {0, 1, rect});
            const auto constants = MakeSliceInferenceData(set, layout, InferenceWeightType::GenericInt8);
            REQUIRE(constants);
            const auto get = [&](const Rect& texels) {
                request.rect = texels;
                return GetPassStatus(MakeDecompressionPass(set, *constants, request, {}));
            };
            CHECK(get(rect) == Status::Ok);
            CHECK(get({rect.left + 5, rect.top + 5, 1, 1}) == Status::Ok);
            CHECK(get({rect.left == 0 ? 4 : rect.left - 4, rect.top, rect.width, rect.height}) ==
                  Status::OutOfRange);
            CHECK(get({rect.left, rect.top == 0 ? 4 : rect.top - 4, rect.width, rect.height}) ==
                  Status::OutOfRange);
            CHECK(get({rect.left == 0 ? 92 : 0, rect.top, 8, rect.height}) == Status::OutOfRange);
            CHECK(get({0, 0, kPassWidth, kPassHeight}) == Status::OutOfRange);
        }
        request.rect.reset();
    }
}
