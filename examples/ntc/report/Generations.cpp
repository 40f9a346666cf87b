// SPDX-License-Identifier: MIT
#include "report/Generations.h"

#include "Failure.h"
#include "Output.h"
#include "report/Analysis.h"
#include "report/Cases.h"

#include "openntc/core/Stream.h"
#include "openntc/texture_set/Rewrite.h"

#include <algorithm>
#include <cstring>
#include <tuple>

namespace openntc::report {

namespace {

constexpr NetworkDescription kSecond = GetNetworkDescription(NTC_NETWORK_GENERATION_2);
constexpr NetworkDescription kThird = GetNetworkDescription(NTC_NETWORK_GENERATION_3);

/// Copies parts of a weight buffer of generation 3 to where generation 2 has them.
class NetworkPadder {
public:
    NetworkPadder(std::span<const std::byte> from, std::span<std::byte> to) : from_(from), to_(to) {}

    void CopyMatrix(std::size_t layer) {
        for (int row = 0; row < kThird.outputs[layer]; ++row)
            Copy(kThird.weightOffsets[layer] + row * kThird.inputs[layer],
                 kSecond.weightOffsets[layer] + row * kSecond.inputs[layer], kThird.inputs[layer]);
    }
    void Copy(int from, int to, int bytes) {
        std::memcpy(to_.data() + to, from_.data() + from, static_cast<std::size_t>(bytes));
    }

private:
    std::span<const std::byte> from_;
    std::span<std::byte> to_;
};

/// Outputs that are added have weights, scales and biases of 0; nothing that reads them has a weight.
void PadInt8(std::span<const std::byte> from, std::span<std::byte> to) {
    NetworkPadder padder(from, to);
    for (std::size_t layer = 0; layer < kNetworkLayers; ++layer) {
        padder.CopyMatrix(layer);
        const int bytes = 4 * kThird.outputs[layer];
        padder.Copy(kThird.int8ScaleOffsets[layer], kSecond.int8ScaleOffsets[layer], bytes);
        padder.Copy(kThird.int8BiasOffsets[layer], kSecond.int8BiasOffsets[layer], bytes);
    }
}

void PadFP8(std::span<const std::byte> from, std::span<std::byte> to) {
    NetworkPadder padder(from, to);
    for (std::size_t layer = 0; layer < kNetworkLayers; ++layer) {
        padder.CopyMatrix(layer);
        padder.Copy(kThird.fp8BiasOffsets[layer], kSecond.fp8BiasOffsets[layer],
                    (layer < 3 ? 2 : 4) * kThird.outputs[layer]);
    }
    padder.Copy(kThird.fp8ScaleOffset, kSecond.fp8ScaleOffset, 4 * kThird.outputs[3]);
}

Expected<InferenceWeights> PadWeights(const InferenceWeights& third) {
    OPENNTC_ASSIGN(InferenceWeights second, third.Clone(GetDefaultAllocator()));
    second.networkVersion = NTC_NETWORK_GENERATION_2;
    second.int8.clear();
    second.fp8.clear();
    OPENNTC_CHECK(second.int8.Resize(static_cast<std::size_t>(kSecond.int8Bytes)));
    OPENNTC_CHECK(second.fp8.Resize(static_cast<std::size_t>(kSecond.fp8Bytes)));
    PadInt8(third.Get(InferenceWeightType::GenericInt8), second.int8.AsSpan());
    PadFP8(third.Get(InferenceWeightType::GenericFP8), second.fp8.AsSpan());
    return second;
}

Expected<void> WriteGeneration2(tool::TextureSet& third, Stream& destination) {
    const TextureSetMetadata& metadata = third.metadata;
    OPENNTC_ASSIGN(const InferenceWeights weights, PadWeights(metadata.GetWeights()));
    WritableTextureSet set;
    OPENNTC_CHECK(
        set.SetDescription(metadata.GetDesc(), metadata.GetLatentShape(), weights.channelColorSpaces, 2));
    OPENNTC_CHECK(set.AddNetwork(weights, InferenceWeightType::GenericInt8));
    OPENNTC_CHECK(set.AddNetwork(weights, InferenceWeightType::GenericFP8));
    for (const Texture& texture : metadata.GetTextures())
        OPENNTC_CHECK(set.AddTexture(texture));
    Array<std::byte> layers;
    for (const LatentMip& mip : metadata.GetLatentMips()) {
        layers.clear();
        for (std::size_t i = 0; i < static_cast<std::size_t>(mip.layers); ++i)
            OPENNTC_CHECK(detail::AppendStored(third.input.GetStream(), mip.layerData[i], layers));
        OPENNTC_CHECK(set.AddLatentMip(mip.width, mip.height, std::as_const(layers).AsSpan()));
    }
    for (const ColorMip& mip : metadata.GetColorMips())
        OPENNTC_CHECK(set.AddColorMip(mip));
    return set.Write(destination);
}

auto GetShared(const CaseRecord& c) {
    return std::tie(c.instructions, c.math, c.bitsPerPixel);
}

} // namespace

std::vector<std::byte> MakeGeneration2(tool::TextureSet& third) {
    MemoryStream file;
    tool::Require(WriteGeneration2(third, file), tool::ExitCode::Failed, third.input.GetName());
    const std::span<const std::byte> bytes = file.GetBytes();
    return {bytes.begin(), bytes.end()};
}

int GetGenerationOfNetwork(const std::string& network) {
    for (const int version : {NTC_NETWORK_GENERATION_2, NTC_NETWORK_GENERATION_3}) {
        if (network == GetNetworkName(version))
            return GetGeneration(version);
    }
    return 1;
}

std::string DescribeShared(const CaseRecord& c) {
    return c.math + tool::Format(", %g bpp", c.bitsPerPixel) +
           (c.instructions.empty() ? "" : ", " + c.instructions) +
           (c.latents.empty() ? "" : ", " + c.latents);
}

std::vector<const CaseRecord*> ListGenerations(const ReportRecord& report, const std::string& device) {
    std::vector<const CaseRecord*> cases = ListAxis(report, device, kGenerationAxis);
    // In the order of the report, which is that of Cases.h.
    std::vector<std::string> maths, instructions;
    for (const CaseRecord* c : cases) {
        maths.push_back(c->math);
        instructions.push_back(c->instructions);
    }
    const auto find = [](const std::vector<std::string>& names, const std::string& name) {
        return std::find(names.begin(), names.end(), name) - names.begin();
    };
    const auto getKey = [&](const CaseRecord& c) {
        return std::tuple(find(instructions, c.instructions), find(maths, c.math), c.bitsPerPixel, c.latents,
                          GetGenerationOfNetwork(c.network));
    };
    std::stable_sort(cases.begin(), cases.end(),
                     [&](const CaseRecord* a, const CaseRecord* b) { return getKey(*a) < getKey(*b); });
    return cases;
}

void CompareGenerations(ReportRecord& report) {
    for (CaseRecord& c : report.cases) {
        if (GetGenerationOfNetwork(c.network) == 1)
            continue;
        for (const CaseRecord* first : ListAxis(report, c.device, kGenerationAxis)) {
            if (GetGenerationOfNetwork(first->network) != 1 || GetShared(*first) != GetShared(c))
                continue;
            std::vector<double> ratios;
            for (std::size_t i = 0; i < std::min(c.repeats.size(), first->repeats.size()); ++i)
                ratios.push_back(c.repeats[i] / first->repeats[i]);
            c.againstGeneration1 = Summarise(std::move(ratios));
        }
    }
}

} // namespace openntc::report
