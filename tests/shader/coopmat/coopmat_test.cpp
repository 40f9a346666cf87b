// SPDX-License-Identifier: MIT
// Decoding with cooperative matrices: the shader with matrices emulated by arrays, on any device, every network, both
// forms, both maths modes, layouts of the accumulator that nobody has and NVIDIA's: the reference decoder's bits. What
// the host refuses.
#include "shader/TestDevice.h"
#include "shader/coopmat/Probes.h"
#include "shader/passes/PassDevice.h"
#include "support/DeviceBits.h"
#include "unit/decode/ModeSets.h"

#include "coopmat_shaders.h"

#include "openntc/decode/ReferenceDecoder.h"
#include "openntc/inference/CooperativeMatrices.h"
#include "openntc/passes/DecompressTexel.h"
#include "openntc/passes/DecompressionPass.h"
#include "openntc/passes/PassConstants.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <random>
#include <string>
#include <vector>

using namespace openntc;
using namespace openntc::harness;
using namespace openntc_tests;

namespace {

constexpr unsigned kLayoutSeed = 31;
constexpr int kWidth = 61;
constexpr int kHeight = 39;

std::vector<float> DecodeOnDevice(Context& context, const DecodeSource& source,
                                  std::span<const std::byte> weights, const std::string& defines, int mip,
                                  const Rect& rect) {
    static constexpr BufferSlot kSlots[] = {{0, BufferKind::Uniform},
                                            {1, BufferKind::Storage},
                                            {2, BufferKind::Storage},
                                            {3, BufferKind::Storage}};
    const auto spirv = coopmat_shaders::FindShader("DecodeBlocks.comp", defines);
    REQUIRE_MESSAGE(spirv.has_value(), std::string(spirv.error().GetText()));
    const auto pipeline = context.CreateComputePipeline(*spirv, kSlots, sizeof(NtcDecodeBlocksConstants));
    REQUIRE_MESSAGE(pipeline.has_value(), std::string(pipeline.error().GetText()));
    const auto make = [&](std::span<const std::byte> bytes, BufferKind kind) {
        auto buffer = context.CreateBuffer(bytes, kind, BufferMemory::DeviceLocal);
        REQUIRE(buffer);
        return std::move(*buffer);
    };
    const Buffer constants = make(std::as_bytes(std::span(source.constants, 1)), BufferKind::Uniform);
    const Buffer latents = make(source.latents, BufferKind::Storage);
    const Buffer weightBuffer = make(weights, BufferKind::Storage);
    std::vector<float> outputs(static_cast<std::size_t>(rect.width * rect.height) * 16);
    auto results = context.CreateBuffer(outputs.size() * 4, BufferKind::Storage, BufferMemory::HostVisible);
    REQUIRE(results);
    const NtcDecodeBlocksConstants push = {rect.left, rect.top, static_cast<std::uint32_t>(rect.width),
                                           static_cast<std::uint32_t>(rect.height), mip};
    const BoundBuffer bound[] = {{0, &constants}, {1, &latents}, {2, &weightBuffer}, {3, &*results}};
    DispatchRequest request;
    request.pipeline = &*pipeline;
    request.buffers = bound;
    request.pushConstants = std::as_bytes(std::span(&push, 1));
    request.groups[0] = 7; // fewer than blocks: each takes several
    const auto timing = context.Dispatch(request);
    REQUIRE_MESSAGE(timing.has_value(), std::string(timing.error().GetText()));
    REQUIRE(context.Read(*results, 0, std::as_writable_bytes(std::span(outputs))));
    return outputs;
}

Status GetWeightStatus(const Expected<Array<std::byte>>& weights) {
    return weights ? Status::Ok : weights.error().GetStatus();
}

} // namespace

TEST_CASE("cooperative matrices as arrays: every network and form has the reference decoder's bits") {
    OPENNTC_REQUIRE_DEVICE(context);
    MESSAGE("seed " << kLayoutSeed);
    std::mt19937 random(kLayoutSeed);
    for (int version = NTC_NETWORK_SMALL; version <= NTC_NETWORK_GENERATION_3; ++version) {
        const decode_test::ModeSet set = decode_test::MakeModeSet(version, kWidth, kHeight);
        const DecodeSource source = set.GetSource(DecodeWeights::Int8);
        const bool isRolled = version == NTC_NETWORK_MEDIUM || version == NTC_NETWORK_XLARGE;
        for (const DecodeMath math : {DecodeMath::Int8, DecodeMath::Int8Half}) {
            if (version == NTC_NETWORK_GENERATION_2 && math == DecodeMath::Int8Half)
                continue; // its modes have one epilogue
            for (const bool isByLanes : {false, true}) {
                CAPTURE(version);
                CAPTURE(static_cast<int>(math));
                CAPTURE(isByLanes);
                const auto layout =
                    ReadCoopMatLayout(math == DecodeMath::Int8 ? MakeRandomProbe(random) : MakeKnownProbe());
                REQUIRE_MESSAGE(layout.has_value(), std::string(layout.error().GetText()));
                const auto weights =
                    MakeCoopMatWeights(version, source.weights, isByLanes ? &*layout : nullptr);
                REQUIRE_MESSAGE(weights.has_value(), std::string(weights.error().GetText()));
                const std::string defines = "NETWORK_VERSION=" + std::to_string(version) +
                                            (math == DecodeMath::Int8 ? " NTC_MATH=8" : " NTC_MATH=9") +
                                            " NTC_COOPMAT_EMULATED=1 NTC_RESULT_BITS=32 NTC_COOPMAT_LANES=" +
                                            (isByLanes ? "1" : "0") +
                                            " NTC_COOPMAT_ROLLED=" + (isRolled ? "1" : "0");
                const int mip = isRolled && isByLanes ? 1 : 0; // 30 x 19 texels
                const Rect rect = isRolled ? Rect{3, 5, 26, 14} : Rect{0, 0, kWidth, kHeight};
                std::vector<float> expected(static_cast<std::size_t>(rect.width * rect.height) * 16);
                REQUIRE(
                    DecodeReference(source, mip, rect, {.math = math, .convertToLinear = false}, expected));
                const std::vector<float> outputs =
                    DecodeOnDevice(*context, source, weights->AsSpan(), defines, mip, rect);
                std::size_t different = 0;
                for (std::size_t i = 0; i < outputs.size(); ++i)
                    different += GetDeviceBits(outputs[i]) != GetDeviceBits(expected[i]) ? 1 : 0;
                CHECK(different == 0);
            }
        }
    }
    CHECK(context->GetValidationLog().errors.empty());
}

TEST_CASE("cooperative matrices as arrays: DecompressToTextures writes the reference decoder's texels") {
    OPENNTC_REQUIRE_DEVICE(context);
    MESSAGE("seed " << kLayoutSeed);
    std::mt19937 random(kLayoutSeed);
    const auto layout = ReadCoopMatLayout(MakeRandomProbe(random));
    REQUIRE(layout);
    for (const int network : {NTC_NETWORK_SMALL, NTC_NETWORK_LARGE, NTC_NETWORK_GENERATION_3}) {
        CAPTURE(network);
        const bool isByLanes = network != NTC_NETWORK_LARGE;
        const decode_test::ModeSet set = decode_test::MakeModeSet(network, kWidth, kHeight);
        const DecodeSource source = set.GetSource(DecodeWeights::Int8);
        SceneNeeds needs;
        needs.preference = isByLanes ? MathPreference::Fastest : MathPreference::Specific;
        needs.math = NTC_MATH_COOPMAT_INT8;
        needs.device.cooperativeMatrixInt8 = true;
        needs.device.cooperativeMatrixLanes = isByLanes;
        // As stored: one to four channels, not at multiples of four, and the last channel.
        const std::pair<int, int> kChannels[] = {{0, 4}, {5, 3}, {14, 2}, {3, 1}, {11, 4}, {8, 4}};
        std::vector<DecompressionOutput> outputs;
        for (const auto& [first, count] : kChannels) {
            const auto space = [&](int channel) {
                return static_cast<ColorSpace>(source.constants->channelColorSpaces >> (2 * channel) & 3u);
            };
            outputs.push_back({.firstChannel = first, .numChannels = count});
            outputs.back().rgbColorSpace = space(first);
            outputs.back().alphaColorSpace = count == 4 ? space(first + 3) : ColorSpace::Linear;
            for (int k = 0; k < std::min(count, 3); ++k) // others are converted, and not compared
                if (space(first + k) != space(first))
                    outputs.back().numChannels = std::min(outputs.back().numChannels, k);
        }
        DecompressionRequest request;
        request.mip = 1;
        request.rect = Rect{1, 2, 27, 15};
        request.destination = TexelOffset{3, 1};
        request.outputs = outputs;
        const DecompressionPass pass =
            passes_test::Take(MakeDecompressionPass(set.GetMetadata(), *source.constants, request, needs));
        CHECK(pass.permutation.weightType == InferenceWeightType::CoopMatInt8);
        REQUIRE(pass.permutation.key.matrixLanes == isByLanes);
        REQUIRE_FALSE(pass.convertsColors);
        int plain = 0; // outputs that the shader reads as one vector
        for (std::size_t o = 0; o < outputs.size(); ++o)
            plain +=
                shader::NtcIsPlainOutput(pass.constants.outputs[o], pass.constants.desc.channelColorSpaces)
                    ? 1
                    : 0;
        CHECK(plain == 2);
        const std::string own =
            std::string("NTC_COOPMAT_EMULATED=1") + (isByLanes ? "" : " NTC_DECOMPRESS_CONVERT=0");
        const auto shader =
            coopmat_shaders::FindCoveringShader("DecompressToTextures.comp", pass.permutation.key, own);
        REQUIRE_MESSAGE(shader.has_value(), std::string(shader.error().GetText()));
        const auto weights = MakeCoopMatWeights(source.networkVersion, source.weights,
                                                pass.permutation.key.matrixLanes ? &*layout : nullptr);
        REQUIRE(weights);
        passes_test::PassDevice device(*context, source.latents, weights->AsSpan());
        const auto images = device.MakeImages(outputs.size(), ImageFormat::RGBA32F, 32, 20);
        device.Run(pass, shader->words, images);
        std::vector<float> expected(27 * 15 * 16);
        REQUIRE(DecodeReference(source, 1, *request.rect,
                                {.math = DecodeMath::Int8, .convertToLinear = false}, expected));
        for (std::size_t o = 0; o < outputs.size(); ++o) {
            CAPTURE(o);
            const auto texels = device.ReadTexels(images[o]);
            std::size_t different = 0;
            for (std::size_t at = 0; at < texels.size(); ++at) {
                const int x = static_cast<int>(at % 32) - 3, y = static_cast<int>(at / 32) - 1;
                const bool isInside = x >= 0 && y >= 0 && x < 27 && y < 15;
                for (int k = 0; k < 4; ++k) {
                    float value = isInside && k == 3 ? 1.0f : 0.0f; // images are zero before
                    if (isInside && k < outputs[o].numChannels)
                        value = expected[static_cast<std::size_t>(16 * (27 * y + x) +
                                                                  outputs[o].firstChannel + k)];
                    different +=
                        GetDeviceBits(texels[at][static_cast<std::size_t>(k)]) != GetDeviceBits(value) ? 1
                                                                                                       : 0;
                }
            }
            CHECK(different == 0);
        }
    }
    CHECK(context->GetValidationLog().errors.empty());
}

TEST_CASE("cooperative matrices: layouts and weights that do not fit are refused") {
    const std::vector<std::int32_t> known = MakeKnownProbe();
    REQUIRE(ReadCoopMatLayout(known));
    const auto refuse = [&known](Status status, auto change) {
        std::vector<std::int32_t> probe = known;
        change(probe);
        const auto layout = ReadCoopMatLayout(probe);
        REQUIRE_FALSE(layout);
        CHECK(layout.error().GetStatus() == status);
    };
    using Probe = std::vector<std::int32_t>;
    refuse(Status::InvalidArgument, [](Probe& p) { p.pop_back(); });
    refuse(Status::Unsupported, [](Probe& p) { p[8] = 4; });
    refuse(Status::Unsupported, [](Probe& p) { p[3] = -1; });
    refuse(Status::Unsupported, [](Probe& p) { p[0] = 256; });
    refuse(Status::Unsupported, [](Probe& p) { std::swap(p[0], p[1]); }); // columns of the second row differ
    refuse(Status::Unsupported, [](Probe& p) { std::copy_n(p.begin(), 9, p.begin() + 9); }); // held twice
    refuse(Status::Unsupported, [](Probe& p) {
        for (std::size_t e = 0; e < 8; e += 4) // a fifth order of columns
            std::swap(p[9 * 31 + e], p[9 * 31 + e + 1]);
    });

    const decode_test::ModeSet set = decode_test::MakeModeSet(NTC_NETWORK_SMALL, 8, 8);
    const std::span<const std::byte> generic = set.GetSource(DecodeWeights::Int8).weights;
    const auto layout = ReadCoopMatLayout(known);
    CHECK(GetWeightStatus(MakeCoopMatWeights(0, generic, nullptr)) == Status::InvalidArgument);
    CHECK(GetWeightStatus(MakeCoopMatWeights(NTC_NETWORK_LARGE, generic, nullptr)) ==
          Status::InvalidArgument);
    CHECK(GetWeightStatus(MakeCoopMatWeights(NTC_NETWORK_SMALL, generic, &*layout)) == Status::Ok);
    const NetworkDescription network = GetNetworkDescription(NTC_NETWORK_SMALL);
    std::vector<std::byte> large(generic.begin(), generic.end());
    const std::int32_t bias = 4'000'000;
    std::memcpy(large.data() + network.int8BiasOffsets[1], &bias, 4);
    CHECK(GetWeightStatus(MakeCoopMatWeights(NTC_NETWORK_SMALL, large, &*layout)) == Status::Unsupported);
    CHECK(GetWeightStatus(MakeCoopMatWeights(NTC_NETWORK_SMALL, large, nullptr)) == Status::Ok);
    CHECK(FitsCoopMatLanes(NTC_NETWORK_SMALL, generic));
    CHECK_FALSE(FitsCoopMatLanes(NTC_NETWORK_SMALL, large));
    CHECK_FALSE(FitsCoopMatLanes(NTC_NETWORK_LARGE, generic));
    CHECK_FALSE(FitsCoopMatLanes(0, generic));
    std::vector<std::byte> infinite(generic.begin(), generic.end());
    const std::uint32_t infinity = 0x7F800000u;
    std::memcpy(infinite.data() + network.int8ScaleOffsets[2], &infinity, 4);
    CHECK(GetWeightStatus(MakeCoopMatWeights(NTC_NETWORK_SMALL, infinite, &*layout)) == Status::Unsupported);
}
