// SPDX-License-Identifier: MIT
// The device's own cooperative matrices and vectors, with the SPIR-V that is kept: the reference decoder's bits for
// networks of every generation. FP8, which hardware evaluates in its own way, is compared by bench_gpu.
#include "shader/TestDevice.h"
#include "support/DeviceBits.h"
#include "unit/decode/ModeSets.h"
#include "vulkan_harness/GpuDecoder.h"

#include "bench_coopvec.h"

#include "openntc/decode/ReferenceDecoder.h"
#include "openntc/inference/CooperativeVectors.h"

#include <doctest/doctest.h>

#include <cstring>
#include <string>
#include <vector>

using namespace openntc;
using namespace openntc::harness;
using namespace openntc_tests;

namespace {

constexpr int kSetWidth = 64;
constexpr int kSetHeight = 40; // BenchDecode.comp decodes 8 x 8 texels at a time

std::vector<float> DecodeExpected(const DecodeSource& source, const DecodeOptions& options) {
    std::vector<float> expected(std::size_t{16} * kSetWidth * kSetHeight);
    REQUIRE(DecodeReference(source, 0, {0, 0, kSetWidth, kSetHeight}, options, expected));
    return expected;
}

std::size_t CountUnequal(const std::vector<float>& outputs, const std::vector<float>& expected) {
    std::size_t different = 0;
    for (std::size_t i = 0; i < expected.size(); ++i)
        different += GetDeviceBits(outputs[i]) != GetDeviceBits(expected[i]) ? 1 : 0;
    return different;
}

/// Int8 weights with a bias whose sums pass 2^22, which the lanes' form does not take.
std::vector<std::byte> MakeLarge(const DecodeSource& source) {
    std::vector<std::byte> weights(source.weights.begin(), source.weights.end());
    const std::int32_t bias = 4'194'303;
    std::memcpy(weights.data() + GetNetworkDescription(source.networkVersion).int8BiasOffsets[1], &bias, 4);
    return weights;
}

/// mip 0 with NTC_MATH_COOPVEC_INT8.
std::vector<float> DecodeOnVectors(Context& context, const DecodeSource& source) {
    const auto spirv = bench_coopvec::FindShader(
        "BenchDecode.comp", "NETWORK_VERSION=" + std::to_string(source.networkVersion) +
                                " NTC_MATH=6 NTC_TEXELS_PER_INVOCATION=1 BENCH_STAGE=0 BENCH_RESULT_BITS=32");
    REQUIRE_MESSAGE(spirv.has_value(), std::string(spirv.error().GetText()));
    auto weights =
        MakeCoopVecWeights(InferenceWeightType::CoopVecInt8, source.networkVersion, source.weights);
    REQUIRE(weights);
    const auto converted = context.ConvertWeights(*weights);
    REQUIRE_MESSAGE(converted.has_value(), std::string(converted.error().GetText()));
    NtcTextureSetConstants constants = *source.constants;
    SetCoopVecOffsets(*weights, constants);
    static constexpr BufferSlot kSlots[] = {{0, BufferKind::Uniform},
                                            {1, BufferKind::Storage},
                                            {2, BufferKind::Storage},
                                            {3, BufferKind::Storage}};
    const std::span<const std::byte> contents[] = {std::as_bytes(std::span(&constants, 1)), source.latents,
                                                   *converted};
    std::vector<Buffer> buffers;
    for (std::size_t i = 0; i < 3; ++i) {
        auto buffer = context.CreateBuffer(contents[i], kSlots[i].kind, BufferMemory::DeviceLocal);
        REQUIRE(buffer);
        buffers.push_back(std::move(*buffer));
    }
    std::vector<float> outputs(std::size_t{16} * kSetWidth * kSetHeight);
    const auto results =
        context.CreateBuffer(outputs.size() * 4, BufferKind::Storage, BufferMemory::HostVisible);
    REQUIRE(results);
    const auto pipeline = context.CreateComputePipeline(*spirv, kSlots, 4);
    REQUIRE_MESSAGE(pipeline.has_value(), std::string(pipeline.error().GetText()));
    const BoundBuffer bound[] = {{0, &buffers[0]}, {1, &buffers[1]}, {2, &buffers[2]}, {3, &*results}};
    const std::uint32_t width = kSetWidth;
    DispatchRequest request;
    request.pipeline = &*pipeline;
    request.buffers = bound;
    request.pushConstants = std::as_bytes(std::span(&width, 1));
    request.groups[0] = kSetWidth / 8;
    request.groups[1] = kSetHeight / 8;
    REQUIRE(context.Dispatch(request));
    REQUIRE(context.Read(*results, 0, std::as_writable_bytes(std::span(outputs))));
    return outputs;
}

} // namespace

TEST_CASE("the device's cooperative matrices: every network, form and maths mode has the reference decoder's "
          "bits") {
    OPENNTC_REQUIRE_DEVICE(context);
    if (!context->GetDevice().hasByteMatrices) {
        MESSAGE("SKIP: the device has no cooperative matrices of signed bytes, 16 x 16 x 32");
        return;
    }
    for (int version = NTC_NETWORK_SMALL; version <= NTC_NETWORK_GENERATION_3; ++version) {
        CAPTURE(version);
        const decode_test::ModeSet set = decode_test::MakeModeSet(version, kSetWidth, kSetHeight);
        DecodeSource source = set.GetSource(DecodeWeights::Int8);
        const std::vector<std::byte> large = MakeLarge(source);
        for (const bool isLarge : {false, true}) {
            CAPTURE(isLarge);
            if (isLarge)
                source.weights = large;
            auto decoder = GpuDecoder::Create(*context, source, {.matrices = MatrixUse::Required});
            REQUIRE_MESSAGE(decoder.has_value(), std::string(decoder.error().GetText()));
            if (isLarge)
                CHECK_FALSE(decoder->HasMatrixLanes());
            else if (!decoder->HasMatrixLanes())
                MESSAGE("SKIP: the lanes' form: the device's accumulator has another layout");
            for (const DecodeMath math : {DecodeMath::Int8, DecodeMath::Int8Half}) {
                CAPTURE(static_cast<int>(math));
                const DecodeOptions options = {.math = math, .convertToLinear = false};
                const std::vector<float> expected = DecodeExpected(source, options);
                std::vector<float> outputs(expected.size());
                const auto timing = decoder->Decode(0, {0, 0, kSetWidth, kSetHeight}, options, outputs);
                REQUIRE_MESSAGE(timing.has_value(), std::string(timing.error().GetText()));
                CHECK(CountUnequal(outputs, expected) == 0);
            }
        }
    }
    CHECK(context->GetValidationLog().errors.empty());
}

TEST_CASE("the device's cooperative vectors: COOPVEC_INT8 has the reference decoder's bits, every network") {
    OPENNTC_REQUIRE_DEVICE(context);
    const CoopVecDevice& vectors = context->GetDevice().cooperativeVectors;
    if (!vectors.hasCooperativeVectors || !vectors.hasInt8) {
        MESSAGE("SKIP: the device has no cooperative vectors of signed bytes");
        return;
    }
    for (int version = NTC_NETWORK_SMALL; version <= NTC_NETWORK_GENERATION_3; ++version) {
        CAPTURE(version);
        const decode_test::ModeSet set = decode_test::MakeModeSet(version, kSetWidth, kSetHeight);
        const DecodeSource source = set.GetSource(DecodeWeights::Int8);
        CHECK(CountUnequal(DecodeOnVectors(*context, source),
                           DecodeExpected(source, {.math = DecodeMath::Int8, .convertToLinear = false})) ==
              0);
    }
    CHECK(context->GetValidationLog().errors.empty());
}
