// SPDX-License-Identifier: MIT
// The effect switches on the device. Read outputs have the bits of the C++ build of the full decoder, others are 0, and
// what a shader was compiled without makes sampling return false.
//
// Comparisons are of bits, with subnormal numbers taken as zero: devices may flush them.
#include "shader/TestDevice.h"
#include "shader/effects/EffectShader.h"
#include "support/DeviceBits.h"

#include "effect_linear.h"
#include "effect_masks.h"
#include "effect_maths.h"
#include "effect_switches.h"

#include "openntc/decode/ReferenceDecoder.h"
#include "openntc/inference/BufferPacking.h"
#include "openntc/inference/Synthesis.h"
#include "openntc/permutation/PermutationKey.h"
#include "openntc/texture_set/TextureSetMetadata.h"

#include <doctest/doctest.h>

#include <bit>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

using namespace openntc;
using namespace openntc::harness;

namespace {

constexpr std::uint32_t kColorSpaces = 0x80040021; // sRGB in channels 0 and 9, HLG in 2 and 15
constexpr std::uint32_t kFill = 0x429A0000;        // 77.0f, what the shader fills its outputs with

struct TestSet {
    TextureSetMetadata metadata;
    std::vector<std::byte> latents;
};

TestSet MakeSet(int networkVersion, int width, int height, int mips, std::uint32_t seed) {
    SynthesisDesc synthesis;
    synthesis.seed = seed;
    synthesis.desc = {width, height, 16, mips};
    synthesis.networkVersion = networkVersion;
    synthesis.shape = {4, 4 * networkVersion, 16, 2, 4};
    synthesis.channelColorSpaces = kColorSpaces;
    synthesis.withFP8 = true;
    MemoryStream stream;
    const auto written = SynthesizeTextureSet(stream, synthesis);
    REQUIRE_MESSAGE(written.has_value(), std::string(written.error().GetText()));
    REQUIRE(stream.Seek(0));
    Expected<TextureSetMetadata> metadata = TextureSetMetadata::Load(stream);
    REQUIRE_MESSAGE(metadata.has_value(), std::string(metadata.error().GetText()));
    const Expected<StreamRange> range = metadata->GetStreamRangeForLatents(0, mips);
    REQUIRE(range);
    const auto bytes = stream.GetBytes().subspan(static_cast<std::size_t>(range->offset),
                                                 static_cast<std::size_t>(range->size));
    return {std::move(*metadata), std::vector<std::byte>(bytes.begin(), bytes.end())};
}

NtcTextureSetConstants MakeConstants(const TestSet& set, InferenceWeightType type) {
    const Expected<StreamRange> range = set.metadata.GetStreamRangeForLatents(0, set.metadata.GetDesc().mips);
    REQUIRE(range);
    const auto constants = MakeInferenceData(set.metadata, *range, type);
    REQUIRE_MESSAGE(constants.has_value(), std::string(constants.error().GetText()));
    return *constants;
}

struct Decoded {
    std::vector<std::uint32_t> effects;
    std::vector<std::uint32_t> returned; ///< per texel
    std::vector<std::uint32_t> outputs;  ///< 16 per texel
};

/// Runs one permutation; latents and weights may be the same buffer.
Decoded Dispatch(Context& context, std::span<const std::uint32_t> words,
                 const NtcTextureSetConstants& constants, std::span<const std::byte> latents,
                 std::span<const std::byte> weights, const EffectPush& push) {
    constexpr BufferSlot kSlots[] = {{0, BufferKind::Uniform},
                                     {1, BufferKind::Storage},
                                     {2, BufferKind::Storage},
                                     {3, BufferKind::Storage}};
    const auto upload = [&](std::span<const std::byte> bytes, BufferKind kind) {
        auto buffer = context.CreateBuffer(bytes, kind, BufferMemory::HostVisible);
        REQUIRE_MESSAGE(buffer.has_value(), std::string(buffer.error().GetText()));
        return std::move(*buffer);
    };
    const Buffer constantsBuffer = upload(std::as_bytes(std::span(&constants, 1)), BufferKind::Uniform);
    const Buffer latentsBuffer = upload(latents, BufferKind::Storage);
    const Buffer weightsBuffer = upload(weights, BufferKind::Storage);
    const std::size_t texels = static_cast<std::size_t>(push.width) * static_cast<std::size_t>(push.height);
    std::vector<std::uint32_t> results(NTC_EFFECT_COUNT + 17 * texels);
    auto resultBuffer =
        context.CreateBuffer(results.size() * 4, BufferKind::Storage, BufferMemory::HostVisible);
    REQUIRE(resultBuffer);
    auto pipeline = context.CreateComputePipeline(words, kSlots, sizeof(EffectPush));
    REQUIRE_MESSAGE(pipeline.has_value(), std::string(pipeline.error().GetText()));
    const BoundBuffer bound[] = {
        {0, &constantsBuffer}, {1, &latentsBuffer}, {2, &weightsBuffer}, {3, &*resultBuffer}};
    DispatchRequest request;
    request.pipeline = &*pipeline;
    request.buffers = bound;
    request.pushConstants = std::as_bytes(std::span(&push, 1));
    request.groups[0] = static_cast<std::uint32_t>((texels + 63) / 64);
    const auto timing = context.Dispatch(request);
    REQUIRE_MESSAGE(timing.has_value(), std::string(timing.error().GetText()));
    REQUIRE(context.Read(*resultBuffer, 0, std::as_writable_bytes(std::span(results))));
    Decoded decoded;
    decoded.effects.assign(results.begin(), results.begin() + NTC_EFFECT_COUNT);
    for (std::size_t t = 0; t < texels; ++t) {
        const auto texel = results.begin() + static_cast<std::ptrdiff_t>(NTC_EFFECT_COUNT + 17 * t);
        decoded.returned.push_back(*texel);
        decoded.outputs.insert(decoded.outputs.end(), texel + 1, texel + 17);
    }
    return decoded;
}

std::vector<float> DecodeHere(const NtcTextureSetConstants& constants, std::span<const std::byte> latents,
                              std::span<const std::byte> weights, int networkVersion, DecodeMath math,
                              int mip, Rect rect, bool linear) {
    const DecodeSource source = {&constants, latents, weights, networkVersion, GetDecodeWeights(math)};
    std::vector<float> outputs(16 * static_cast<std::size_t>(rect.width) *
                               static_cast<std::size_t>(rect.height));
    const auto result =
        DecodeReference(source, mip, rect, {.math = math, .convertToLinear = linear}, outputs);
    REQUIRE_MESSAGE(result.has_value(), std::string(result.error().GetText()));
    return outputs;
}

/// Outputs that differ from what they should be: those read in their bits, the others from 0.
int CountDifferent(const Decoded& decoded, std::span<const float> expected, std::uint32_t mask) {
    REQUIRE(decoded.outputs.size() == expected.size());
    int different = 0;
    for (std::size_t i = 0; i < expected.size(); ++i) {
        const bool isRead = (mask >> (i % 16) & 1u) != 0;
        const std::uint32_t bits = isRead ? std::bit_cast<std::uint32_t>(expected[i]) : 0u;
        different += openntc_tests::GetDeviceBits(decoded.outputs[i]) != openntc_tests::GetDeviceBits(bits);
    }
    for (const std::uint32_t returned : decoded.returned)
        different += returned != 1;
    return different;
}

/// Texels that a refusal did not leave alone.
int CountTouched(const Decoded& decoded) {
    int touched = 0;
    for (const std::uint32_t returned : decoded.returned)
        touched += returned != 0;
    for (const std::uint32_t output : decoded.outputs)
        touched += output != kFill;
    return touched;
}

} // namespace

TEST_CASE("from scene needs to texels: masks of 1, 3, 9 and 16 channels in every network") {
    OPENNTC_REQUIRE_DEVICE(context);
    constexpr int kSide = 80; // with 4 masks of 4 networks, 102 400 texels
    int texels = 0;
    for (int version = NTC_NETWORK_SMALL; version <= NTC_NETWORK_XLARGE; ++version) {
        CAPTURE(version);
        const TestSet set = MakeSet(version, kSide, kSide, 1, 5);
        const NtcTextureSetConstants constants = MakeConstants(set, InferenceWeightType::GenericInt8);
        const auto weights = *set.metadata.GetInferenceWeights(InferenceWeightType::GenericInt8);
        const std::vector<float> expected = DecodeHere(constants, set.latents, weights, version,
                                                       DecodeMath::Int8, 0, {0, 0, kSide, kSide}, false);
        for (const std::uint32_t mask : {0x1u, 0x7u, 0x1FFu, 0xFFFFu}) {
            CAPTURE(mask);
            SceneNeeds needs;
            needs.channels = mask;
            const auto permutation = MakePermutation(set.metadata, needs);
            REQUIRE_MESSAGE(permutation.has_value(), std::string(permutation.error().GetText()));
            const DefineList defines = permutation->key.ToDefines();
            const auto words = FindEffectShader(effect_masks::FindShader, defines.View());
            const Decoded decoded =
                Dispatch(*context, words, constants, set.latents, weights, {0, 0, kSide, kSide, 0, 0, 0, 0});
            CHECK(CountDifferent(decoded, expected, mask) == 0);
            // The shader reports the effects that the key asked for.
            CHECK(
                std::equal(decoded.effects.begin(), decoded.effects.end(), permutation->key.effects.begin()));
            texels += kSide * kSide;
            // This shader has no code for linear light, and none for other mips.
            CHECK(CountTouched(Dispatch(*context, words, constants, set.latents, weights,
                                        {0, 0, 3, 3, 0, 1, 0, 0})) == 0);
            CHECK(CountTouched(Dispatch(*context, words, constants, set.latents, weights,
                                        {0, 0, 3, 3, 1, 0, 0, 0})) == 0);
        }
    }
    MESSAGE("texels compared: " << texels);
}

TEST_CASE("linear light: at run time and compiled for exactly the channels that need it") {
    OPENNTC_REQUIRE_DEVICE(context);
    constexpr int kSide = 24;
    const TestSet set = MakeSet(NTC_NETWORK_SMALL, kSide, kSide, 1, 6);
    NtcTextureSetConstants constants = MakeConstants(set, InferenceWeightType::GenericInt8);
    const auto weights = *set.metadata.GetInferenceWeights(InferenceWeightType::GenericInt8);
    const Rect rect = {0, 0, kSide, kSide};
    const std::vector<float> stored =
        DecodeHere(constants, set.latents, weights, NTC_NETWORK_SMALL, DecodeMath::Int8, 0, rect, false);
    const std::vector<float> linear =
        DecodeHere(constants, set.latents, weights, NTC_NETWORK_SMALL, DecodeMath::Int8, 0, rect, true);
    for (const std::uint32_t mask : {0x1u, 0x8421u, 0xFFFFu}) {
        for (const bool isCompiled : {false, true}) {
            CAPTURE(mask);
            CAPTURE(isCompiled);
            char defines[128];
            std::snprintf(defines, sizeof defines,
                          "NETWORK_VERSION=1 NTC_MATH=1 NTC_CHANNEL_COLOR_SPACES=0x%X", kColorSpaces);
            std::string list = defines;
            if (mask != 0xFFFFu) {
                std::snprintf(defines, sizeof defines, " NTC_OUTPUT_MASK=0x%X", mask);
                list += defines;
            }
            if (isCompiled)
                list += " NTC_LINEARISE=2";
            const auto words = FindEffectShader(effect_linear::FindShader, list);
            const EffectPush push = {0, 0, kSide, kSide, 0, 0, 0, 0};
            EffectPush linearPush = push;
            linearPush.convertToLinear = 1;
            CHECK(CountDifferent(Dispatch(*context, words, constants, set.latents, weights, push), stored,
                                 mask) == 0);
            const Decoded decoded = Dispatch(*context, words, constants, set.latents, weights, linearPush);
            int different = 0;
            int converted = 0;
            for (std::size_t i = 0; i < linear.size(); ++i) {
                const unsigned c = static_cast<unsigned>(i % 16);
                const float value = std::bit_cast<float>(decoded.outputs[i]);
                if ((mask >> c & 1u) == 0) {
                    different += value != 0.0f;
                } else if ((kColorSpaces >> 2 * c & 3u) == NTC_COLOR_SPACE_LINEAR) {
                    different += openntc_tests::GetDeviceBits(decoded.outputs[i]) !=
                                 openntc_tests::GetDeviceBits(std::bit_cast<std::uint32_t>(linear[i]));
                } else {
                    // pow and exp of Vulkan's precision: exp2 is exact to 3 + 2 |x| units in the last place, log2 to
                    // 2^-21 or 3 units. Outputs here are below 64, so exponents below 2.4 · log2(61) = 14.3 (sRGB) or
                    // e^(64 / 0.179) would overflow (HLG): there the bound is on the exponent x = h / 0.179 of up
                    // to 128, whose relative error of 2^-22 becomes 128 · 2^-22 = 2^-15 of the result.
                    ++converted;
                    const float bound = std::ldexp(1.0f, -14) * std::fabs(linear[i]) + 1e-6f;
                    if (std::isfinite(linear[i]))
                        different += !(std::fabs(value - linear[i]) <= bound);
                }
            }
            CHECK(different == 0);
            CHECK(converted > 0);
            if (isCompiled) {
                // Constants that say something else of an output that is read are refused; of others they may.
                NtcTextureSetConstants other = constants;
                other.channelColorSpaces ^= 1u;
                CHECK(CountTouched(Dispatch(*context, words, other, set.latents, weights, linearPush)) == 0);
                other = constants;
                other.channelColorSpaces ^= 0x0000000Cu; // channel 1
                const Decoded unread = Dispatch(*context, words, other, set.latents, weights, linearPush);
                if ((mask & 2u) == 0)
                    CHECK(unread.outputs == decoded.outputs);
                else
                    CHECK(CountTouched(unread) == 0);
            }
        }
    }
}

TEST_CASE("latents that are not there: slices without width or height, latent images outside the format") {
    OPENNTC_REQUIRE_DEVICE(context);
    constexpr int kSide = 16;
    const TestSet set = MakeSet(NTC_NETWORK_SMALL, kSide, kSide, 1, 9);
    const NtcTextureSetConstants whole = MakeConstants(set, InferenceWeightType::GenericInt8);
    const auto weights = *set.metadata.GetInferenceWeights(InferenceWeightType::GenericInt8);
    const auto words = FindEffectShader(effect_linear::FindShader,
                                        "NETWORK_VERSION=1 NTC_MATH=1 NTC_CHANNEL_COLOR_SPACES=0x80040021");
    const EffectPush push = {0, 0, kSide, kSide, 0, 0, 0, 0};
    const auto countTouched = [&](const NtcTextureSetConstants& constants) {
        return CountTouched(Dispatch(*context, words, constants, set.latents, weights, push));
    };
    REQUIRE(countTouched(whole) != 0); // decodes
    for (NtcNeuralMipConstants(NtcTextureSetConstants::*grids)[NTC_MAX_NEURAL_MIPS] :
         {&NtcTextureSetConstants::highResNeuralMips, &NtcTextureSetConstants::lowResNeuralMips}) {
        for (const std::uint32_t kept : {0u, 0xFFFFu, 0xFFFF0000u}) {
            CAPTURE(kept);
            NtcTextureSetConstants constants = whole;
            (constants.*grids)[0].sliceWidthHeight &= kept;
            CHECK(countTouched(constants) == 0);
        }
    }
    // The last latent image is as good as the first, so that only the number can be what is refused.
    NtcTextureSetConstants constants = whole;
    constants.highResNeuralMips[NTC_MAX_NEURAL_MIPS - 1] = whole.highResNeuralMips[0];
    constants.lowResNeuralMips[NTC_MAX_NEURAL_MIPS - 1] = whole.lowResNeuralMips[0];
    constants.colorMips[0].neuralMip = NTC_MAX_NEURAL_MIPS - 1;
    CHECK(countTouched(constants) != 0);
    for (const int image : {NTC_MAX_NEURAL_MIPS, NTC_MAX_NEURAL_MIPS + 1, -1}) {
        CAPTURE(image);
        constants.colorMips[0].neuralMip = image;
        CHECK(countTouched(constants) == 0);
    }
}

TEST_CASE("a covering permutation gives the texels that the scene reads") {
    OPENNTC_REQUIRE_DEVICE(context);
    constexpr int kSide = 16;
    const TestSet set = MakeSet(NTC_NETWORK_SMALL, kSide, kSide, 1, 9);
    const NtcTextureSetConstants constants = MakeConstants(set, InferenceWeightType::GenericInt8);
    const auto weights = *set.metadata.GetInferenceWeights(InferenceWeightType::GenericInt8);
    const std::vector<float> expected = DecodeHere(constants, set.latents, weights, NTC_NETWORK_SMALL,
                                                   DecodeMath::Int8, 0, {0, 0, kSide, kSide}, false);
    const auto everything = FindEffectShader(
        effect_linear::FindShader, "NETWORK_VERSION=1 NTC_MATH=1 NTC_CHANNEL_COLOR_SPACES=0x80040021");
    for (const bool isLinear : {false, true}) {
        CAPTURE(isLinear);
        SceneNeeds needs;
        needs.channels = 0x5; // linear: one of sRGB and one of HLG
        needs.linear = isLinear;
        needs.device.integerDotProduct = true;
        const auto permutation = MakePermutation(set.metadata, needs);
        REQUIRE_MESSAGE(permutation.has_value(), std::string(permutation.error().GetText()));
        CHECK_FALSE(effect_linear::FindShader("EffectTexels.comp", permutation->key.ToDefines().View()));
        const auto found = effect_linear::FindCoveringShader("EffectTexels.comp", permutation->key);
        REQUIRE_MESSAGE(found.has_value(), std::string(found.error().GetText()));
        // Channel 1 too; compiled colour spaces serve where none are asked for.
        CHECK(found->key.effects[NTC_EFFECT_OUTPUT_MASK] == 0x7);
        CHECK(found->key.effects[NTC_EFFECT_LINEARISE] ==
              (isLinear ? NTC_LINEARISE_RUNTIME : NTC_LINEARISE_CHANNELS));
        const EffectPush push = {0, 0, kSide, kSide, 0, isLinear ? 1u : 0u, 0, 0};
        const Decoded decoded = Dispatch(*context, found->words, constants, set.latents, weights, push);
        CHECK(std::equal(decoded.effects.begin(), decoded.effects.end(), found->key.effects.begin()));
        if (!isLinear)
            CHECK(CountDifferent(decoded, expected, 0x7) == 0);
        // The same bits as from the shader that does everything, also in linear light.
        const Decoded other = Dispatch(*context, everything, constants, set.latents, weights, push);
        int different = 0;
        for (std::size_t i = 0; i < decoded.outputs.size(); ++i)
            different += (0x5u >> (i % 16) & 1u) != 0 && decoded.outputs[i] != other.outputs[i];
        CHECK(different == 0);
        CHECK(decoded.returned == std::vector<std::uint32_t>(kSide * kSide, 1));
    }
}

TEST_CASE("a mask with gaps in the other maths modes") {
    OPENNTC_REQUIRE_DEVICE(context);
    constexpr int kSide = 16;
    const TestSet set = MakeSet(NTC_NETWORK_SMALL, kSide, kSide, 1, 7);
    struct Mode {
        int macro;
        DecodeMath math;
    };
    for (const Mode mode :
         {Mode{NTC_MATH_INT8_HALF, DecodeMath::Int8Half}, Mode{NTC_MATH_FP8, DecodeMath::FP8},
          Mode{NTC_MATH_FP16, DecodeMath::FP16}, Mode{NTC_MATH_FP32, DecodeMath::FP32}}) {
        CAPTURE(mode.macro);
        SceneNeeds needs;
        needs.channels = 0x8421;
        needs.preference = MathPreference::Specific;
        needs.math = mode.macro;
        const auto permutation = MakePermutation(set.metadata, needs);
        REQUIRE_MESSAGE(permutation.has_value(), std::string(permutation.error().GetText()));
        const NtcTextureSetConstants constants = MakeConstants(set, permutation->weightType);
        const auto weights = *set.metadata.GetInferenceWeights(permutation->weightType);
        const std::vector<float> expected = DecodeHere(constants, set.latents, weights, NTC_NETWORK_SMALL,
                                                       mode.math, 0, {0, 0, kSide, kSide}, false);
        const auto words = FindEffectShader(effect_maths::FindShader, permutation->key.ToDefines().View());
        const Decoded decoded =
            Dispatch(*context, words, constants, set.latents, weights, {0, 0, kSide, kSide, 0, 0, 0, 0});
        CHECK(CountDifferent(decoded, expected, 0x8421) == 0);
    }
}

TEST_CASE("single mip, whole latents, texels inside: each and all, on every mip") {
    OPENNTC_REQUIRE_DEVICE(context);
    const TestSet set = MakeSet(NTC_NETWORK_LARGE, 40, 56, 6, 8);
    const NtcTextureSetConstants constants = MakeConstants(set, InferenceWeightType::GenericInt8);
    const auto weights = *set.metadata.GetInferenceWeights(InferenceWeightType::GenericInt8);
    NtcTextureSetConstants sliced = constants; // without the last row of latents
    for (NtcNeuralMipConstants* grids : {sliced.highResNeuralMips, sliced.lowResNeuralMips})
        grids[0].sliceWidthHeight -= 1u << 16;
    for (unsigned bits = 0; bits < 8; ++bits) {
        CAPTURE(bits);
        std::string list = "NETWORK_VERSION=3 NTC_MATH=1";
        const bool isSingle = (bits & 1u) != 0, isWhole = (bits & 2u) != 0, isInside = (bits & 4u) != 0;
        list += isSingle ? " NTC_SINGLE_MIP=1" : "";
        list += isWhole ? " NTC_LATENT_SLICES=0" : "";
        list += isInside ? " NTC_CLAMP_TEXELS=0" : "";
        const auto words = FindEffectShader(effect_switches::FindShader, list);
        for (int mip = 0; mip < 6; ++mip) {
            CAPTURE(mip);
            const ColorMip& colorMip = set.metadata.GetColorMips()[static_cast<std::size_t>(mip)];
            Rect rect = {0, 0, colorMip.width, colorMip.height};
            if (!isInside)
                rect = {-5, -3, colorMip.width + 9, colorMip.height + 9};
            const EffectPush push = {rect.left, rect.top, rect.width, rect.height, mip, 0, 0, 0};
            const Decoded decoded = Dispatch(*context, words, constants, set.latents, weights, push);
            if (isSingle && mip != 0) {
                CHECK(CountTouched(decoded) == 0);
                continue;
            }
            const std::vector<float> expected = DecodeHere(constants, set.latents, weights, NTC_NETWORK_LARGE,
                                                           DecodeMath::Int8, mip, rect, false);
            CHECK(CountDifferent(decoded, expected, 0xFFFF) == 0);
        }
        const Decoded decoded =
            Dispatch(*context, words, sliced, set.latents, weights, {0, 0, 40, 8, 0, 0, 0, 0});
        if (isWhole) {
            CHECK(CountTouched(decoded) == 0);
        } else {
            const std::vector<float> expected = DecodeHere(sliced, set.latents, weights, NTC_NETWORK_LARGE,
                                                           DecodeMath::Int8, 0, {0, 0, 40, 8}, false);
            CHECK(CountDifferent(decoded, expected, 0xFFFF) == 0);
        }
    }
}

TEST_CASE("two sets in one buffer at nonzero offsets, by arguments and by constants") {
    OPENNTC_REQUIRE_DEVICE(context);
    constexpr int kSide = 24;
    const TestSet sets[] = {MakeSet(NTC_NETWORK_SMALL, kSide, kSide, 1, 9),
                            MakeSet(NTC_NETWORK_SMALL, kSide, kSide, 1, 10)};
    std::vector<PackRequest> requests = {{.latentBytes = 100, .weightBytes = 0}}; // something in front
    for (const TestSet& set : sets)
        requests.push_back(
            {set.latents.size(), set.metadata.GetInferenceWeights(InferenceWeightType::GenericInt8)->size()});
    PackedSet placements[3];
    const auto summary = PlanPacking(requests, {}, placements);
    REQUIRE(summary);
    REQUIRE(summary->buffers == 1);
    std::vector<std::byte> buffer(static_cast<std::size_t>(summary->largestBufferBytes), std::byte{0xA5});
    for (std::size_t i = 0; i < 2; ++i)
        REQUIRE(CopyPacked(placements[i + 1], sets[i].latents,
                           *sets[i].metadata.GetInferenceWeights(InferenceWeightType::GenericInt8), buffer));
    const auto words =
        FindEffectShader(effect_masks::FindShader, "NETWORK_VERSION=1 NTC_MATH=1 NTC_LINEARISE=0 "
                                                   "NTC_SINGLE_MIP=1 NTC_LATENT_SLICES=0");
    for (std::size_t i = 0; i < 2; ++i) {
        CAPTURE(i);
        const PackedSet& place = placements[i + 1];
        CHECK(place.latentsOffset > 0);
        NtcTextureSetConstants constants = MakeConstants(sets[i], InferenceWeightType::GenericInt8);
        const auto weights = *sets[i].metadata.GetInferenceWeights(InferenceWeightType::GenericInt8);
        const std::vector<float> expected = DecodeHere(constants, sets[i].latents, weights, NTC_NETWORK_SMALL,
                                                       DecodeMath::Int8, 0, {0, 0, kSide, kSide}, false);
        EffectPush push = {0, 0, kSide, kSide, 0, 0, place.latentsOffset, place.weightsOffset};
        CHECK(CountDifferent(Dispatch(*context, words, constants, buffer, buffer, push), expected, 0xFFFF) ==
              0);
        REQUIRE(MoveConstants(constants, place.latentsOffset, place.weightsOffset));
        push.latentsOffset = 0;
        push.weightsOffset = 0;
        CHECK(CountDifferent(Dispatch(*context, words, constants, buffer, buffer, push), expected, 0xFFFF) ==
              0);
        // The C++ decoders take the moved constants too.
        CHECK(DecodeHere(constants, buffer, buffer, NTC_NETWORK_SMALL, DecodeMath::Int8, 0,
                         {0, 0, kSide, kSide}, false) == expected);
    }
    CHECK(context->GetValidationLog().errors.empty());
}
