// SPDX-License-Identifier: MIT
// What code for the conversion of colour spaces costs a pass that converts nothing. A measurement, which asserts
// nothing of what it measures, and therefore runs only when OPENNTC_MEASURE is set.
#include "PassDevice.h"

#include "decompress_shaders.h"

#include "shader/TestDevice.h"
#include "unit/decode/ModeSets.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>

using namespace openntc;
using namespace openntc::harness;
using namespace passes_test;

TEST_CASE("cost of conversion that nobody asks for") {
    if (std::getenv("OPENNTC_MEASURE") == nullptr) {
        MESSAGE("SKIP: cost of conversion: a measurement, no test; OPENNTC_MEASURE=1 makes it");
        return;
    }
    OPENNTC_REQUIRE_DEVICE(context);
    constexpr int kSide = 256;
    const decode_test::ModeSet set = decode_test::MakeModeSet(NTC_NETWORK_SMALL, kSide, kSide);
    const DecodeSource source = set.GetSource(DecodeWeights::Int8);
    PassDevice device(*context, source.latents, source.weights);
    std::vector<DecompressionOutput> outputs;
    for (int i = 0; i < 4; ++i) {
        outputs.push_back({.firstChannel = 4 * i, .numChannels = 4});
        const auto space = [&](int channel) {
            return static_cast<ColorSpace>(source.constants->channelColorSpaces >> (2 * channel) & 3u);
        };
        outputs.back().rgbColorSpace = space(4 * i); // as it is stored
        outputs.back().alphaColorSpace = space(4 * i + 3);
    }
    const auto images = device.MakeImages(outputs.size(), ImageFormat::RGBA8, kSide, kSide);
    DecompressionRequest request;
    request.outputs = outputs;

    SceneNeeds needs;
    needs.device.integerDotProduct = context->GetDevice().features.Has(Feature::IntegerDotProduct);
    needs.device.subgroupShuffle =
        context->GetDevice().hasSubgroupShuffle && context->GetDevice().subgroupSize >= 8;
    needs.device.isCpu = context->GetDevice().isCpu;
    const DecompressionPass pass =
        Take(MakeDecompressionPass(set.GetMetadata(), *source.constants, request, needs));
    REQUIRE_FALSE(pass.convertsColors);
    const auto find = [&](const char* ownDefines) {
        const auto shader = decompress_shaders::FindCoveringShader("DecompressToTextures.comp",
                                                                   pass.permutation.key, ownDefines);
        REQUIRE_MESSAGE(shader.has_value(), std::string(shader.error().GetText()));
        return shader->words;
    };
    const std::pair<const char*, std::span<const std::uint32_t>> kShaders[] = {
        {"with code for conversion", find("")}, {"without", find(pass.GetOwnDefines())}};
    std::vector<double> times[2];
    constexpr int kRounds = 12; // in turns; the first one compiles
    for (int round = 0; round < kRounds; ++round) {
        for (std::size_t i = 0; i < 2; ++i) {
            const std::clock_t start = std::clock();
            device.Run(pass, kShaders[i].second, images);
            if (round > 0)
                times[i].push_back(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
        }
    }
    for (std::size_t i = 0; i < 2; ++i) {
        std::sort(times[i].begin(), times[i].end());
        const double texel = 1e9 / (double{kSide} * kSide);
        std::printf("%-26s %zu bytes of SPIR-V  %.0f ns a texel of processor time, median (%.0f - %.0f)\n",
                    kShaders[i].first, kShaders[i].second.size_bytes(), texel * times[i][times[i].size() / 2],
                    texel * times[i].front(), texel * times[i].back());
    }
}
