// SPDX-License-Identifier: MIT
// From scene needs to permutations: keys, definitions, reasons, refusals; constant outputs.
#include "support/SpecificationVectors.h"

#include "openntc/permutation/PermutationCover.h"
#include "openntc/permutation/PermutationKey.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>
#include <set>
#include <string>
#include <vector>

using namespace openntc;
using namespace openntc_tests;

namespace {

/// 16 channels: albedo 0 – 2 (sRGB), normal 3 – 4, emission 5 – 7 (HLG), the rest "other".
TextureSetMetadata MakeMaterial(std::uint32_t seed, int mips, bool withFP8,
                                int networkVersion = NTC_NETWORK_SMALL) {
    SynthesisDesc synthesis;
    synthesis.seed = seed;
    synthesis.desc = {32, 32, 16, mips};
    synthesis.networkVersion = networkVersion;
    synthesis.shape = {4, 4, 8, 2, 4};
    if (GetGeneration(networkVersion) > 1)
        synthesis.shape = MakeLayeredShape(4, 8);
    synthesis.channelColorSpaces = 0xA815; // sRGB in 0 – 2, HLG in 5 – 7
    synthesis.withFP8 = withFP8;
    Texture textures[4];
    textures[0].name = "Albedo";
    textures[0].numChannels = 3;
    textures[1].name = "Normal";
    textures[1].firstChannel = 3;
    textures[1].numChannels = 2;
    textures[2].name = "Emission";
    textures[2].firstChannel = 5;
    textures[2].numChannels = 3;
    textures[3].name = "Other";
    textures[3].firstChannel = 8;
    textures[3].numChannels = 8;
    synthesis.textures = textures;
    const std::vector<std::byte> file = MakeFile(synthesis);
    ReadOnlyMemoryStream stream(file);
    auto set = TextureSetMetadata::Load(stream);
    REQUIRE_MESSAGE(set.has_value(), std::string(set.error().GetText()));
    return std::move(*set);
}

Permutation Make(const TextureSetMetadata& set, const SceneNeeds& needs) {
    const auto result = MakePermutation(set, needs);
    REQUIRE_MESSAGE(result.has_value(), std::string(result.error().GetText()));
    return *result;
}

Status GetRefusal(const TextureSetMetadata& set, const SceneNeeds& needs) {
    const auto result = MakePermutation(set, needs);
    REQUIRE_FALSE(result);
    return result.error().GetStatus();
}

} // namespace

TEST_CASE("the table that shaders share") {
    CHECK(std::string(kEffects[NTC_EFFECT_OUTPUT_MASK].macro) == "NTC_OUTPUT_MASK");
    CHECK(kEffects[NTC_EFFECT_OUTPUT_MASK].defaultValue == 0xFFFF);
    CHECK(std::string(kEffects[NTC_EFFECT_LINEARISE].macro) == "NTC_LINEARISE");
    CHECK(kEffects[NTC_EFFECT_LINEARISE].defaultValue == NTC_LINEARISE_RUNTIME);
    CHECK(std::string(kEffects[NTC_EFFECT_CHANNEL_COLOR_SPACES].macro) == "NTC_CHANNEL_COLOR_SPACES");
    CHECK(std::string(kEffects[NTC_EFFECT_SINGLE_MIP].macro) == "NTC_SINGLE_MIP");
    CHECK(std::string(kEffects[NTC_EFFECT_LATENT_SLICES].macro) == "NTC_LATENT_SLICES");
    CHECK(std::string(kEffects[NTC_EFFECT_CLAMP_TEXELS].macro) == "NTC_CLAMP_TEXELS");
    CHECK(std::string(kEffects[NTC_EFFECT_TILE_FALLBACK].macro) == "NTC_TILE_FALLBACK");
    CHECK(std::string(kEffects[NTC_EFFECT_TILE_REQUESTS].macro) == "NTC_TILE_REQUESTS");
    CHECK(std::string(kEffects[NTC_EFFECT_TILE_STAMPS].macro) == "NTC_TILE_STAMPS");
    CHECK(std::string(kEffects[NTC_EFFECT_TILE_FEEDBACK].macro) == "NTC_TILE_FEEDBACK");
    CHECK(std::string(kEffects[NTC_EFFECT_TILE_RATES].macro) == "NTC_TILE_RATES");
}

TEST_CASE("a key of defaults defines the network and the maths mode alone") {
    PermutationKey key;
    key.networkVersion = NTC_NETWORK_MEDIUM;
    for (std::size_t i = 0; i < NTC_EFFECT_COUNT; ++i)
        key.effects[i] = kEffects[i].defaultValue;
    CHECK(std::string(key.ToDefines().View()) == "NETWORK_VERSION=2 NTC_MATH=1");
}

TEST_CASE("the longest list of definitions fits") {
    PermutationKey key;
    key.networkVersion = NTC_NETWORK_XLARGE;
    key.integerDotProduct = true;
    key.nativeFloat16 = true;
    key.latentFetch = NTC_LATENTS_TEXTURE;
    key.weightFetch = NTC_FETCH_SUBGROUP;
    key.texelsPerInvocation = 8;
    key.wideWeightLoads = true;
    key.floatDot = true;
    key.effects.fill(0xFFFFFFFFu);
    CHECK(std::string(key.ToDefines().View()) ==
          "NETWORK_VERSION=4 NTC_MATH=1 NTC_DOT4_SPIRV=1 NTC_NATIVE_FLOAT16=1 NTC_LATENT_FETCH=2 "
          "NTC_WEIGHT_FETCH=3 "
          "NTC_SUBGROUP_DECODES_ONE_SET=1 NTC_TEXELS_PER_INVOCATION=8 NTC_WIDE_WEIGHT_LOADS=1 "
          "NTC_FLOAT_DOT=1 NTC_OUTPUT_MASK=0xFFFFFFFF NTC_LINEARISE=4294967295 "
          "NTC_CHANNEL_COLOR_SPACES=0xFFFFFFFF NTC_SINGLE_MIP=4294967295 NTC_LATENT_SLICES=4294967295 "
          "NTC_CLAMP_TEXELS=4294967295 NTC_TILE_FALLBACK=4294967295 NTC_TILE_REQUESTS=4294967295 "
          "NTC_TILE_STAMPS=4294967295 NTC_TILE_FEEDBACK=4294967295 NTC_TILE_RATES=4294967295");
}

TEST_CASE("a scene of tiles pays for what it calls for; others have the keys that they had") {
    const TextureSetMetadata set = MakeMaterial(1, 6, false);
    SceneNeeds needs;
    needs.channels = 0x7;
    needs.firstMipOnly = true;
    needs.tiles.requests = needs.tiles.feedback = false; // of no shader that reads tiles
    CHECK(std::string(Make(set, needs).key.ToDefines().View()) ==
          "NETWORK_VERSION=1 NTC_MATH=1 NTC_OUTPUT_MASK=0x7 NTC_LINEARISE=0 NTC_SINGLE_MIP=1 "
          "NTC_LATENT_SLICES=0");
    needs.tiles = {};
    needs.tiles.used = true;
    Permutation all = Make(set, needs);
    CHECK(std::string(all.key.ToDefines().View()) ==
          "NETWORK_VERSION=1 NTC_MATH=1 NTC_OUTPUT_MASK=0x7 NTC_LINEARISE=0");
    needs.tiles = {true, false, false, false, false, false};
    const Permutation none = Make(set, needs);
    CHECK(std::string(none.key.ToDefines().View()) ==
          "NETWORK_VERSION=1 NTC_MATH=1 NTC_OUTPUT_MASK=0x7 NTC_LINEARISE=0 NTC_TILE_FALLBACK=0 "
          "NTC_TILE_REQUESTS=0 NTC_TILE_STAMPS=0 NTC_TILE_FEEDBACK=0 NTC_TILE_RATES=0");
    for (std::size_t i = NTC_EFFECT_TILE_FALLBACK; i <= NTC_EFFECT_TILE_RATES; ++i) {
        CHECK(none.effects[i].isReduced);
        CHECK_FALSE(all.effects[i].isReduced);
        CHECK(std::string(none.effects[i].reason) != all.effects[i].reason);
    }
    // What does everything serves a scene that wants less, not the other way round, and costs more.
    CHECK(Covers(all.key, none.key));
    CHECK_FALSE(Covers(none.key, all.key));
    CHECK(GetCoverCost(none.key, none.key) < GetCoverCost(all.key, none.key));
    PermutationKey read;
    CHECK(ReadDefines(none.key.ToDefines().View(), "", ShaderLanguage::Glsl, read));
    CHECK(read == none.key);
}

TEST_CASE("textures, channels and linear light become switches, with reasons") {
    const TextureSetMetadata set = MakeMaterial(1, 6, false);
    const std::string_view textures[] = {"Normal", "Albedo"};
    SceneNeeds needs;
    needs.textures = textures;
    Permutation result = Make(set, needs);
    CHECK(std::string(result.key.ToDefines().View()) ==
          "NETWORK_VERSION=1 NTC_MATH=1 NTC_OUTPUT_MASK=0x1F NTC_LINEARISE=0 NTC_LATENT_SLICES=0");
    CHECK(result.colorConversions == 0);
    // 48 · 64 + 64 · 64 · 2 weights in the hidden layers, 64 for an output.
    CHECK(result.multiplications == 48 * 64 + 2 * 64 * 64 + 5 * 64);
    CHECK(result.allMultiplications == 48 * 64 + 2 * 64 * 64 + 16 * 64);
    for (const EffectReport& effect : result.effects)
        CHECK(std::string(effect.reason) != "");
    CHECK(result.effects[NTC_EFFECT_OUTPUT_MASK].isReduced);
    CHECK_FALSE(result.effects[NTC_EFFECT_SINGLE_MIP].isReduced);

    needs.linear = true;
    needs.channels = 1u << 5;
    needs.wholeLatents = false;
    needs.texelsInside = true;
    needs.firstMipOnly = true;
    result = Make(set, needs);
    CHECK(std::string(result.key.ToDefines().View()) ==
          "NETWORK_VERSION=1 NTC_MATH=1 NTC_OUTPUT_MASK=0x3F NTC_LINEARISE=2 NTC_CHANNEL_COLOR_SPACES=0x815 "
          "NTC_SINGLE_MIP=1 NTC_CLAMP_TEXELS=0");
    CHECK(result.colorConversions == 4);

    // Linear light of channels that are linear as stored: the shader accepts the request and has nothing to
    // do.
    needs = {};
    needs.channels = 1u << 3;
    needs.linear = true;
    result = Make(set, needs);
    CHECK(result.colorConversions == 0);
    CHECK(std::string(result.key.ToDefines().View()) ==
          "NETWORK_VERSION=1 NTC_MATH=1 NTC_OUTPUT_MASK=0x8 NTC_LINEARISE=2 NTC_CHANNEL_COLOR_SPACES=0x0 "
          "NTC_LATENT_SLICES=0");
}

TEST_CASE("many materials collapse to few permutations, and keys have an order") {
    const std::string_view albedo[] = {"Albedo"};
    std::set<PermutationKey> keys;
    for (std::uint32_t seed = 1; seed <= 12; ++seed) {
        const TextureSetMetadata set = MakeMaterial(seed, 1 + static_cast<int>(seed % 3), seed % 2 == 0,
                                                    seed % 4 == 0 ? NTC_NETWORK_LARGE : NTC_NETWORK_SMALL);
        SceneNeeds needs;
        needs.textures = albedo;
        keys.insert(Make(set, needs).key);
        needs.linear = true;
        keys.insert(Make(set, needs).key);
        CHECK(Make(set, needs).key == Make(set, needs).key);
    }
    // Two networks, one or several mips, stored or linear.
    CHECK(keys.size() == 8);
}

TEST_CASE("maths modes by preference, weights and device") {
    const TextureSetMetadata int8 = MakeMaterial(1, 1, false);
    const TextureSetMetadata both = MakeMaterial(1, 1, true);
    SceneNeeds needs;
    needs.preference = MathPreference::Fastest;
    CHECK(Make(both, needs).key.math == NTC_MATH_INT8);
    needs.device.cooperativeVectorInt8 = true;
    CHECK(Make(both, needs).key.math == NTC_MATH_COOPVEC_INT8);
    CHECK(Make(both, needs).weightType == InferenceWeightType::CoopVecInt8);
    needs.device.cooperativeVectorFP8 = true;
    CHECK(Make(both, needs).key.math == NTC_MATH_COOPVEC_INT8);
    needs.preference = MathPreference::FP8First;
    CHECK(Make(both, needs).key.math == NTC_MATH_COOPVEC_FP8);
    CHECK(Make(both, needs).weightType == InferenceWeightType::CoopVecFP8);
    CHECK(Make(int8, needs).key.math == NTC_MATH_COOPVEC_INT8);
    needs.device.cooperativeVectorInt8 = false; // which the last layer of the FP8 network needs
    CHECK(Make(both, needs).key.math == NTC_MATH_INT8);
    needs.device.cooperativeVectorInt8 = true;
    CHECK(Make(int8, needs).key.math == NTC_MATH_COOPVEC_INT8);
    needs.preference = MathPreference::Exact;
    needs.device.integerDotProduct = true;
    CHECK(Make(both, needs).key.math == NTC_MATH_INT8);
    CHECK(Make(both, needs).key.integerDotProduct);
    needs.preference = MathPreference::Specific;
    needs.math = NTC_MATH_FP8;
    CHECK(Make(both, needs).weightType == InferenceWeightType::GenericFP8);
    CHECK(GetRefusal(int8, needs) == Status::Unsupported);
    needs.math = NTC_MATH_COOPVEC_FP8;
    needs.device = {};
    CHECK(GetRefusal(both, needs) == Status::Unsupported);
    needs.math = 0;
    CHECK(GetRefusal(both, needs) == Status::OutOfRange);
    needs.preference = static_cast<MathPreference>(9);
    CHECK(GetRefusal(both, needs) == Status::InvalidArgument);
}

TEST_CASE("cooperative matrices: in passes that have them, where device, weights and language do") {
    const TextureSetMetadata set = MakeMaterial(1, 1, true);
    SceneNeeds needs;
    needs.preference = MathPreference::Fastest;
    needs.device.cooperativeVectorInt8 = true;
    needs.device.integerDotProduct = true;
    needs.device.cooperativeMatrixInt8 = true;
    needs.device.cooperativeMatrixLanes = true;
    CHECK(Make(set, needs).key.math == NTC_MATH_COOPVEC_INT8); // a shader that decodes texels
    needs.decodesOnMatrices = true;
    const Permutation lanes = Make(set, needs);
    CHECK(lanes.key.math == NTC_MATH_COOPMAT_INT8);
    CHECK(lanes.weightType == InferenceWeightType::CoopMatInt8);
    CHECK(lanes.key.matrixLanes);
    CHECK_FALSE(lanes.key.integerDotProduct);
    CHECK(std::string(lanes.key.ToDefines().View()).find("NTC_MATH=8 NTC_COOPMAT_LANES=1") !=
          std::string::npos);
    PermutationKey read;
    REQUIRE(ReadDefines(lanes.key.ToDefines().View(), {}, ShaderLanguage::Glsl, read));
    CHECK(read == lanes.key);
    // The portable form is slower than vectors: only by name, and its weights are others.
    needs.device.cooperativeMatrixLanes = false;
    CHECK(Make(set, needs).key.math == NTC_MATH_COOPVEC_INT8);
    needs.preference = MathPreference::Specific;
    for (const int math : {NTC_MATH_COOPMAT_INT8, NTC_MATH_COOPMAT_INT8_HALF}) {
        needs.math = math;
        const Permutation portable = Make(set, needs);
        CHECK(portable.key.math == math);
        CHECK_FALSE(portable.key.matrixLanes);
        CHECK(portable.weightType == InferenceWeightType::CoopMatInt8);
        CHECK_FALSE(Covers(portable.key, lanes.key));
    }
    needs.math = NTC_MATH_COOPMAT_INT8;
    PermutationKey other = lanes.key;
    other.matrixLanes = false;
    CHECK(other != lanes.key);
    CHECK_FALSE(Covers(other, lanes.key));
    needs.decodesOnMatrices = false;
    CHECK(GetRefusal(set, needs) == Status::Unsupported);
    needs.decodesOnMatrices = true;
    needs.language = ShaderLanguage::Hlsl;
    CHECK(GetRefusal(set, needs) == Status::Unsupported);
    needs.language = ShaderLanguage::Glsl;
    needs.device.cooperativeMatrixInt8 = false;
    CHECK(GetRefusal(set, needs) == Status::Unsupported);
    // Weights whose sums could pass 2^22: the next mode, or the portable form.
    needs.device.cooperativeMatrixInt8 = true;
    needs.device.cooperativeMatrixLanes = true;
    InferenceWeights large;
    const auto clone = set.GetWeights().Clone(GetDefaultAllocator());
    REQUIRE(clone);
    const NetworkDescription network = GetNetworkDescription(clone->networkVersion);
    std::vector<std::byte> bytes(clone->int8.begin(), clone->int8.end());
    const std::int32_t bias = 4'000'000;
    std::memcpy(bytes.data() + network.int8BiasOffsets[2], &bias, 4);
    large.networkVersion = clone->networkVersion;
    large.validChannelMask = clone->validChannelMask;
    REQUIRE(large.int8.Assign(bytes));
    const auto portable = MakePermutation(set, large, needs);
    REQUIRE(portable);
    CHECK_FALSE(portable->key.matrixLanes);
    needs.preference = MathPreference::Fastest;
    const auto vectors = MakePermutation(set, large, needs);
    REQUIRE(vectors);
    CHECK(vectors->key.math == NTC_MATH_COOPVEC_INT8);
}

TEST_CASE("networks of generations 2 and 3: keys of their own, with cooperative vectors and matrices too") {
    for (const int network : {NTC_NETWORK_GENERATION_2, NTC_NETWORK_GENERATION_3}) {
        const TextureSetMetadata set = MakeMaterial(9, 4, true, network);
        SceneNeeds needs;
        Permutation permutation = Make(set, needs);
        CHECK(permutation.key.networkVersion == network);
        CHECK(permutation.key.math == NTC_MATH_INT8);
        CHECK(permutation.weightType == InferenceWeightType::GenericInt8);
        CHECK(permutation.allMultiplications == (network == NTC_NETWORK_GENERATION_2 ? 12288 : 8192));
        needs.preference = MathPreference::Fastest;
        needs.device.cooperativeVectorInt8 = needs.device.cooperativeVectorFP8 = true;
        permutation = Make(set, needs);
        CHECK(permutation.key.math == NTC_MATH_COOPVEC_INT8);
        CHECK(permutation.weightType == InferenceWeightType::CoopVecInt8);
        needs.decodesOnMatrices = true;
        needs.device.cooperativeMatrixInt8 = needs.device.cooperativeMatrixLanes = true;
        permutation = Make(set, needs);
        CHECK(permutation.key.networkVersion == network);
        CHECK(permutation.key.math == NTC_MATH_COOPMAT_INT8);
        CHECK(permutation.key.matrixLanes);
        CHECK(permutation.weightType == InferenceWeightType::CoopMatInt8);
        needs.preference = MathPreference::Specific;
        needs.math = NTC_MATH_COOPVEC_FP8;
        CHECK(Make(set, needs).weightType == InferenceWeightType::CoopVecFP8);
        needs.device = {};
        for (const int math : {NTC_MATH_COOPVEC_INT8, NTC_MATH_COOPVEC_FP8, NTC_MATH_COOPMAT_INT8}) {
            needs.math = math;
            CHECK(GetRefusal(set, needs) == Status::Unsupported);
        }
    }
}

TEST_CASE("latents in a texture: a key of its own, for generations 2 and 3 and whole latents") {
    const TextureSetMetadata set = MakeMaterial(9, 4, true, NTC_NETWORK_GENERATION_3);
    SceneNeeds needs;
    needs.channels = 0x7;
    const PermutationKey buffer = Make(set, needs).key;
    needs.latentTextures = true;
    const PermutationKey texture = Make(set, needs).key;
    CHECK(std::string(texture.ToDefines().View()) ==
          "NETWORK_VERSION=6 NTC_MATH=1 NTC_LATENT_FETCH=2 NTC_OUTPUT_MASK=0x7 NTC_LINEARISE=0 "
          "NTC_LATENT_SLICES=0");
    CHECK(texture != buffer);
    CHECK((texture < buffer) != (buffer < texture));
    CHECK(Covers(texture, texture)); // neither serves the other: they bind other things and give other bits
    CHECK_FALSE(Covers(texture, buffer));
    CHECK_FALSE(Covers(buffer, texture));
    for (const std::string& defines :
         {std::string(texture.ToDefines().View()),
          std::string(
              "NTC_LATENT_FETCH=NTC_LATENTS_TEXTURE NETWORK_VERSION=6 NTC_OUTPUT_MASK=7 NTC_LINEARISE=0 "
              "NTC_LATENT_SLICES=0")}) {
        CAPTURE(defines);
        PermutationKey read;
        CHECK(ReadDefines(defines, "", ShaderLanguage::Glsl, read));
        CHECK(read == texture);
    }
    SceneNeeds matrices = needs;
    matrices.decodesOnMatrices = matrices.device.cooperativeMatrixInt8 =
        matrices.device.cooperativeMatrixLanes = true;
    matrices.preference = MathPreference::Fastest;
    CHECK(Make(set, matrices).key.math == NTC_MATH_COOPMAT_INT8);
    CHECK(Make(set, matrices).key.latentFetch == NTC_LATENTS_TEXTURE);
    needs.wholeLatents = false;
    CHECK(GetRefusal(set, needs) == Status::InvalidArgument);
    needs.wholeLatents = true;
    needs.tiles.used = true;
    CHECK(GetRefusal(set, needs) == Status::InvalidArgument);
    needs.tiles.used = false;
    CHECK(GetRefusal(MakeMaterial(9, 4, true), needs) == Status::Unsupported);
}

TEST_CASE("weights on a device of the CPU: through subgroups where the host promises what that needs") {
    const TextureSetMetadata set = MakeMaterial(1, 1, true);
    SceneNeeds needs;
    needs.device.isCpu = true;
    needs.device.subgroupShuffle = true;
    needs.device.integerDotProduct = true;
    needs.decodesBlocks = true;
    CHECK(Make(set, needs).key.weightFetch == NTC_FETCH_DIRECT);
    CHECK(Make(set, needs).key.texelsPerInvocation == 1);
    CHECK_FALSE(Make(set, needs).key.wideWeightLoads);
    CHECK(Make(set, needs).key.integerDotProduct);
    needs.oneSetPerSubgroup = true;
    PermutationKey key = Make(set, needs).key;
    CHECK(key.weightFetch == NTC_FETCH_SUBGROUP);
    CHECK(key.texelsPerInvocation == 2);
    CHECK(key.floatDot);
    CHECK(key.wideWeightLoads);
    CHECK_FALSE(key.integerDotProduct);
    CHECK(std::string(key.ToDefines().View()) ==
          "NETWORK_VERSION=1 NTC_MATH=1 NTC_WEIGHT_FETCH=3 NTC_SUBGROUP_DECODES_ONE_SET=1 "
          "NTC_TEXELS_PER_INVOCATION=2 NTC_WIDE_WEIGHT_LOADS=1 NTC_FLOAT_DOT=1 NTC_LINEARISE=0 "
          "NTC_SINGLE_MIP=1 NTC_LATENT_SLICES=0");
    needs.alignedWeights = false;
    CHECK_FALSE(Make(set, needs).key.wideWeightLoads);
    needs.alignedWeights = true;
    needs.decodesBlocks = false;
    CHECK(Make(set, needs).key.texelsPerInvocation == 1);
    needs.device.subgroupShuffle = false;
    CHECK(Make(set, needs).key.weightFetch == NTC_FETCH_DIRECT);
    // The other forms of fetching are for the Int8 modes.
    needs.device.subgroupShuffle = true;
    needs.preference = MathPreference::Specific;
    needs.math = NTC_MATH_INT8_HALF;
    CHECK(Make(set, needs).key.weightFetch == NTC_FETCH_SUBGROUP);
    for (const int math : {NTC_MATH_FP8, NTC_MATH_FP16, NTC_MATH_FP32}) {
        needs.math = math;
        CHECK(Make(set, needs).key.weightFetch == NTC_FETCH_DIRECT);
    }
}

TEST_CASE("weights on a GPU: wide loads, two texels where a pass decodes blocks, no subgroups") {
    const TextureSetMetadata set = MakeMaterial(1, 1, true);
    SceneNeeds needs;
    needs.device.subgroupShuffle = true;
    needs.oneSetPerSubgroup = true;
    needs.decodesBlocks = true;
    // Nothing known of the device: the form that runs everywhere.
    CHECK(Make(set, needs).key.weightFetch == NTC_FETCH_DIRECT);
    CHECK_FALSE(Make(set, needs).key.wideWeightLoads);
    CHECK(Make(set, needs).key.texelsPerInvocation == 1);
    needs.device.integerDotProduct = true;
    PermutationKey key = Make(set, needs).key;
    CHECK(key.weightFetch == NTC_FETCH_DIRECT);
    CHECK(key.integerDotProduct);
    CHECK(key.wideWeightLoads);
    CHECK(key.texelsPerInvocation == 2);
    CHECK_FALSE(key.floatDot);
    needs.alignedWeights = false;
    CHECK_FALSE(Make(set, needs).key.wideWeightLoads);
    needs.alignedWeights = true;
    needs.decodesBlocks = false;
    CHECK(Make(set, needs).key.texelsPerInvocation == 1);
    needs.decodesBlocks = true;
    CHECK(Make(MakeMaterial(1, 1, true, NTC_NETWORK_XLARGE), needs).key.texelsPerInvocation == 2);
    // Cooperative vectors read matrices as a whole.
    needs.preference = MathPreference::Fastest;
    needs.device.cooperativeVectorInt8 = true;
    key = Make(set, needs).key;
    CHECK(key.math == NTC_MATH_COOPVEC_INT8);
    CHECK_FALSE(key.wideWeightLoads);
    CHECK(key.texelsPerInvocation == 1);
}

TEST_CASE("keys of HLSL ask for what HLSL has") {
    const TextureSetMetadata set = MakeMaterial(1, 1, true);
    SceneNeeds needs;
    needs.language = ShaderLanguage::Hlsl;
    needs.device.integerDotProduct = true;
    needs.channels = 1;
    PermutationKey key = Make(set, needs).key;
    CHECK(std::string(key.ToDefines().View()) ==
          "NETWORK_VERSION=1 NTC_MATH=1 NTC_DOT4_SM64=1 NTC_WIDE_WEIGHT_LOADS=1 NTC_OUTPUT_MASK=0x1 "
          "NTC_LINEARISE=0 NTC_SINGLE_MIP=1 NTC_LATENT_SLICES=0");
    needs.language = ShaderLanguage::Glsl;
    CHECK(key != Make(set, needs).key);
    CHECK(std::string(Make(set, needs).key.ToDefines().View()).find("NTC_DOT4_SPIRV=1") != std::string::npos);
    // Subgroups and cooperative vectors are for GLSL: never chosen, and refused when named.
    needs.language = ShaderLanguage::Hlsl;
    needs.device.isCpu = true;
    needs.device.subgroupShuffle = true;
    needs.oneSetPerSubgroup = true;
    CHECK(Make(set, needs).key.weightFetch == NTC_FETCH_DIRECT);
    needs.device.cooperativeVectorInt8 = true;
    needs.device.cooperativeVectorFP8 = true;
    for (const MathPreference preference : {MathPreference::Fastest, MathPreference::FP8First}) {
        needs.preference = preference;
        CHECK(Make(set, needs).key.math == NTC_MATH_INT8);
    }
    needs.preference = MathPreference::Specific;
    for (const int math : {NTC_MATH_COOPVEC_INT8, NTC_MATH_COOPVEC_FP8}) {
        needs.math = math;
        CHECK(GetRefusal(set, needs) == Status::Unsupported);
    }
    needs.preference = MathPreference::Exact;
    needs.language = static_cast<ShaderLanguage>(2);
    CHECK(GetRefusal(set, needs) == Status::InvalidArgument);
}

TEST_CASE("requests that cannot be met") {
    const TextureSetMetadata set = MakeMaterial(1, 1, false);
    const std::string_view unknown[] = {"Albedo", "albedo"};
    SceneNeeds needs;
    needs.textures = unknown;
    CHECK(GetRefusal(set, needs) == Status::InvalidArgument);
    needs = {};
    needs.channels = 1u << 16;
    CHECK(GetRefusal(set, needs) == Status::OutOfRange);
    needs = {};
    needs.filter = static_cast<Filter>(1);
    CHECK(GetRefusal(set, needs) == Status::InvalidArgument);
    // Nothing is read: every output was shuffled away.
    const std::array<ShuffleSource, NTC_MAX_CHANNELS> nothing{};
    const auto shuffled = ShuffleInferenceOutputs(set.GetWeights(), nothing);
    REQUIRE(shuffled);
    const auto result = MakePermutation(set, *shuffled, {});
    REQUIRE_FALSE(result);
    CHECK(result.error().GetStatus() == Status::InvalidArgument);
}

TEST_CASE("constant outputs are found and folded") {
    const TextureSetMetadata set = MakeMaterial(1, 1, false);
    CHECK(FindConstantOutputs(set.GetWeights()).mask == 0);
    std::array<ShuffleSource, NTC_MAX_CHANNELS> sources;
    for (int c = 0; c < NTC_MAX_CHANNELS; ++c)
        sources[static_cast<std::size_t>(c)] = ShuffleSource::Channel(c);
    sources[1] = ShuffleSource::Constant(0.25f);
    sources[4] = ShuffleSource::Constant(-3.5f);
    const auto shuffled = ShuffleInferenceOutputs(set.GetWeights(), sources);
    REQUIRE(shuffled);
    const ConstantOutputs constants = FindConstantOutputs(*shuffled);
    CHECK(constants.mask == 0x12);
    CHECK(constants.values[1] == 0.25f);
    CHECK(constants.values[4] == -3.5f);

    SceneNeeds needs;
    needs.channels = 0x7;
    needs.foldConstants = true;
    const auto folded = MakePermutation(set, *shuffled, needs);
    REQUIRE(folded);
    CHECK(folded->key.effects[NTC_EFFECT_OUTPUT_MASK] == 0x5);
    CHECK(folded->constantChannels == 0x2);
    needs.channels = 0x12; // nothing but constants: one output stays, so that there is a shader
    const auto rest = MakePermutation(set, *shuffled, needs);
    REQUIRE(rest);
    CHECK(rest->key.effects[NTC_EFFECT_OUTPUT_MASK] == 0x2);
    CHECK(rest->constantChannels == 0x10);
}
