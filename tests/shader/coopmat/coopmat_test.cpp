// SPDX-License-Identifier: MIT
// Decoding with cooperative matrices: the shader with matrices emulated by arrays, on any device, every network, both
// forms, both maths modes, layouts of the accumulator that nobody has and NVIDIA's: the reference decoder's bits. What
// the host refuses.
#include "shader/TestDevice.h"
#include "support/DeviceBits.h"
#include "unit/decode/ModeSets.h"

#include "coopmat_shaders.h"

#include "openntc/decode/ReferenceDecoder.h"
#include "openntc/inference/CooperativeMatrices.h"
#include "openntc/passes/PassConstants.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <numeric>
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

/// What ProbeCoopMat writes for a layout with these orders of rows and columns.
std::vector<std::int32_t> MakeProbe(const std::array<int, 16>& rows, const std::array<int, 16>& columns,
                                    const std::array<int, 32>& lanes) {
    std::vector<std::int32_t> probe(kCoopMatLanes * kCoopMatProbeNumbers);
    for (std::size_t i = 0; i < 32; ++i) {
        const std::size_t pair = i / 4, group = i % 4;
        const std::size_t at = static_cast<std::size_t>(lanes[i]) * kCoopMatProbeNumbers;
        for (std::size_t e = 0; e < 8; ++e)
            probe[at + e] = 16 * rows[2 * pair + e / 4] + columns[4 * group + e % 4];
        probe[at + 8] = 8;
    }
    return probe;
}

/// Lane l has rows l / 4 and 8 + l / 4, columns 2 (l % 4), the next, and the same 8 further, as on NVIDIA's GPUs.
std::vector<std::int32_t> MakeKnownProbe() {
    std::array<int, 16> rows{}, columns{};
    for (int i = 0; i < 16; ++i) {
        rows[static_cast<std::size_t>(i)] = i / 2 + 8 * (i % 2);
        columns[static_cast<std::size_t>(i)] = 2 * (i / 4) + i % 2 + 8 * (i / 2 % 2);
    }
    std::array<int, 32> lanes{};
    std::iota(lanes.begin(), lanes.end(), 0);
    return MakeProbe(rows, columns, lanes);
}

std::vector<std::int32_t> MakeRandomProbe(std::mt19937& random) {
    std::array<int, 16> rows{}, columns{};
    std::array<int, 32> lanes{};
    std::iota(rows.begin(), rows.end(), 0);
    std::iota(columns.begin(), columns.end(), 0);
    std::iota(lanes.begin(), lanes.end(), 0);
    std::shuffle(rows.begin(), rows.end(), random);
    std::shuffle(columns.begin(), columns.end(), random);
    std::shuffle(lanes.begin(), lanes.end(), random);
    return MakeProbe(rows, columns, lanes);
}

std::vector<float> DecodeOnDevice(Context& context, const DecodeSource& source,
                                  std::span<const std::byte> weights, const std::string& defines,
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
                                           static_cast<std::uint32_t>(rect.height)};
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
    for (int version = NTC_NETWORK_SMALL; version <= NTC_NETWORK_XLARGE; ++version) {
        const decode_test::ModeSet set = decode_test::MakeModeSet(version, kWidth, kHeight);
        const DecodeSource source = set.GetSource(DecodeWeights::Int8);
        for (const DecodeMath math : {DecodeMath::Int8, DecodeMath::Int8Half}) {
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
                                            " NTC_MATH=" + std::to_string(static_cast<int>(math)) +
                                            " NTC_COOPMAT_EMULATED=1 NTC_RESULT_BITS=32 NTC_COOPMAT_LANES=" +
                                            (isByLanes ? "1" : "0") +
                                            " NTC_COOPMAT_ROLLED=" + (version % 2 == 0 ? "1" : "0");
                const Rect rect = version % 2 == 0 ? Rect{3, 5, 29, 18} : Rect{0, 0, kWidth, kHeight};
                std::vector<float> expected(static_cast<std::size_t>(rect.width * rect.height) * 16);
                REQUIRE(DecodeReference(source, 0, rect, {.math = math, .convertToLinear = false}, expected));
                const std::vector<float> outputs =
                    DecodeOnDevice(*context, source, weights->AsSpan(), defines, rect);
                std::size_t different = 0;
                for (std::size_t i = 0; i < outputs.size(); ++i)
                    different += GetDeviceBits(outputs[i]) != GetDeviceBits(expected[i]) ? 1 : 0;
                CHECK(different == 0);
            }
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
    std::vector<std::byte> infinite(generic.begin(), generic.end());
    const std::uint32_t infinity = 0x7F800000u;
    std::memcpy(infinite.data() + network.int8ScaleOffsets[2], &infinity, 4);
    CHECK(GetWeightStatus(MakeCoopMatWeights(NTC_NETWORK_SMALL, infinite, &*layout)) == Status::Unsupported);
}
