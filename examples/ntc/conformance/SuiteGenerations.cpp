// SPDX-License-Identifier: MIT
// Sets of generations 2 and 3. Their latents are sampled as OpenNTC defines it, which decoders with texture units need not
// match: no case must be passed.
#include "RawFile.h"
#include "SuiteBuilder.h"

#include "../Output.h"

#include "openntc/format/NetworkDescription.h"

#include <cstring>

namespace openntc::conformance {

namespace {

SynthesisDesc DescribeLater(std::uint32_t seed, int network, int width, int height, int scale, int features) {
    SynthesisDesc synthesis = Describe(seed, width, height, 4, MakeLayeredShape(scale, features), network);
    synthesis.withFP8 = true;
    return synthesis;
}

template <typename T>
void StoreAt(std::vector<std::byte>& bytes, std::size_t index, T value) {
    std::memcpy(bytes.data() + index * sizeof value, &value, sizeof value);
}

/// Weights -1, 0 and 1 and scales of 1/160, with which every other sum lies in the middle between two integers.
std::vector<std::byte> MakeTies(std::span<const std::byte> file) {
    RawFile raw(file);
    openntc::detail::SynthesisGenerator generator(831);
    const NetworkDescription network = GetNetworkDescription(NTC_NETWORK_GENERATION_3);
    for (std::size_t layer = 0; layer < 3; ++layer) {
        const rapidjson::Value& record = raw.json["mlpVersions"][0]["layers"][static_cast<unsigned>(layer)];
        const auto inputs = static_cast<std::size_t>(network.inputs[layer]);
        for (std::size_t row = 0; row < static_cast<std::size_t>(network.outputs[layer]); ++row) {
            std::int32_t sum = 0;
            for (std::size_t i = 0; i < inputs; ++i) {
                const int weight = generator.Next() % 3 - 1;
                sum += weight;
                StoreAt(raw.views[record["weightView"].GetUint()], row * inputs + i,
                        static_cast<std::int8_t>(weight));
            }
            const std::int32_t bias = generator.Next() % 512;
            StoreAt(raw.views[record["scaleView"].GetUint()], row, 0.00625f);
            StoreAt(raw.views[record["biasView"].GetUint()], row, layer == 0 ? bias : bias + 113 * sum);
        }
    }
    return raw.Write();
}

void AddNetwork(SuiteBuilder& builder, const SynthesisDesc& synthesis) {
    const std::string name = tool::Format("generation-%d", GetGeneration(synthesis.networkVersion));
    builder.AddSet(name, SynthesizeBytes(synthesis));
    for (const DecodeMath math :
         {DecodeMath::Int8, DecodeMath::Int8Half, DecodeMath::FP8, DecodeMath::FP16, DecodeMath::FP32})
        builder.AddCase(
            name + "-" + tool::GetName(math), math, builder.ListAllTexels(13),
            tool::Format("the network of %s in maths mode %s", name.c_str(), tool::GetName(math)));
}

} // namespace

void AddGenerations(SuiteBuilder& builder) {
    const std::size_t first = builder.CountCases();
    AddNetwork(builder, DescribeLater(820, NTC_NETWORK_GENERATION_2, 26, 22, 3, 12));
    builder.AddMistakeCase({Mistake::LatentsOfOtherGeneration, Mistake::FloatEpilogueOfGeneration2},
                           DecodeMath::Int8, "latents truncated to bytes, and binary16 between the layers");
    AddNetwork(builder, DescribeLater(830, NTC_NETWORK_GENERATION_3, 30, 26, 3, 12));
    builder.AddMistakeCase({Mistake::ClampedBorders}, DecodeMath::Int8,
                           "latents at the borders of latent mips");
    builder.AddMistakeCase({Mistake::ReversedLayers, Mistake::ReversedTexelCodes, Mistake::SixteenSteps},
                           DecodeMath::Int8, "layers of latent mips, and the codes of a texel");
    builder.AddMistakeCase({Mistake::OneLatentMip}, DecodeMath::Int8, "features of the second latent mip");
    builder.AddMistakeCase({Mistake::AbsentLayersAsCodes}, DecodeMath::Int8,
                           "inputs of layers that the set lacks");
    builder.AddMistakeCase({Mistake::TriangleWaves, Mistake::FrequenciesOfGeneration1, Mistake::FlooredWaves},
                           DecodeMath::Int8, "sawtooth waves of the position");
    builder.AddMistakeCase({Mistake::HalfEpilogueOfGeneration3, Mistake::ExactThird}, DecodeMath::Int8,
                           "binary32 between the layers of generation 3, and 0.333333");
    builder.AddWholeMip("mips-whole-mip", DecodeMath::Int8, 1, builder.ListAllTexels(),
                        "a whole mip of generation 3");
    builder.AddSet("generation-3-ties",
                   MakeTies(SynthesizeBytes(DescribeLater(831, NTC_NETWORK_GENERATION_3, 64, 64, 4, 4))));
    builder.AddMistakeCase({Mistake::OffsetBeforeRounding}, DecodeMath::Int8,
                           "the activation of generation 3: -113 behind rounding");
    builder.MakeOptional(first);
}

} // namespace openntc::conformance
