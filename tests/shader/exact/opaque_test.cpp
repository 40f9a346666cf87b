// SPDX-License-Identifier: MIT
// Shaders without `precise` and without loop attributes, whose roundings are kept by a uniform zero: every emulated maths
// mode and network has the C++ reference's bits, subnormal numbers taken as zero. (Without both qualifier and zero, Slang's
// SPIR-V on lavapipe had 88 of 262 144 INT8 numbers of the small network wrong, and 41 % of FP8's: a compiler may, and need
// not, so no test says that they differ.)
#include "shader/TestDevice.h"
#include "support/DeviceBits.h"

#include "opaque_shaders.h"

#include "openntc/MathModes.h"
#include "openntc/decode/ReferenceDecoder.h"
#include "openntc/inference/InferenceData.h"
#include "openntc/inference/Synthesis.h"
#include "openntc/texture_set/TextureSetMetadata.h"

#include <doctest/doctest.h>

#include <string>
#include <vector>

using namespace openntc;
using namespace openntc::harness;

TEST_CASE("without precise, with an opaque zero: the reference's bits in every mode and network") {
    OPENNTC_REQUIRE_DEVICE(context);
    constexpr int kWidth = 36;
    constexpr int kHeight = 25;
    std::size_t compared = 0;
    for (int network = NTC_NETWORK_SMALL; network <= NTC_NETWORK_XLARGE; ++network) {
        SynthesisDesc synthesis;
        synthesis.seed = 40 + static_cast<std::uint32_t>(network);
        synthesis.desc = {kWidth, kHeight, 16, 2};
        synthesis.networkVersion = network;
        synthesis.shape = {4, 4 * network, 16, 4, 4};
        synthesis.withInt8 = true;
        synthesis.withFP8 = true;
        MemoryStream stream;
        REQUIRE(SynthesizeTextureSet(stream, synthesis));
        REQUIRE(stream.Seek(0));
        const auto metadata = TextureSetMetadata::Load(stream);
        REQUIRE(metadata);
        const auto range = metadata->GetStreamRangeForLatents(0, 2);
        REQUIRE(range);
        const auto latents = stream.GetBytes().subspan(static_cast<std::size_t>(range->offset),
                                                       static_cast<std::size_t>(range->size));
        for (int math = NTC_MATH_INT8; math <= NTC_MATH_FP32; ++math) {
            const auto type =
                math == NTC_MATH_FP8 ? InferenceWeightType::GenericFP8 : InferenceWeightType::GenericInt8;
            const auto constants = MakeInferenceData(*metadata, *range, type);
            const auto weights = metadata->GetInferenceWeights(type);
            REQUIRE(constants);
            REQUIRE(weights);
            const auto mode = static_cast<DecodeMath>(math);
            const DecodeSource source = {&*constants, latents, *weights, network, GetDecodeWeights(mode)};
            const std::string defines =
                "NETWORK_VERSION=" + std::to_string(network) + " NTC_MATH=" + std::to_string(math);
            CAPTURE(defines);
            const auto spirv = opaque_shaders::FindShader("OpaqueTexels.comp", defines);
            REQUIRE_MESSAGE(spirv.has_value(), std::string(spirv.error().GetText()));
            const BufferSlot slots[] = {{0, BufferKind::Uniform},
                                        {1, BufferKind::Storage},
                                        {2, BufferKind::Storage},
                                        {3, BufferKind::Storage},
                                        {4, BufferKind::Uniform}};
            const auto pipeline = context->CreateComputePipeline(*spirv, slots, 12);
            REQUIRE_MESSAGE(pipeline.has_value(), std::string(pipeline.error().GetText()));
            const std::uint32_t zero[4] = {};
            const auto constantBuffer = context->CreateBuffer(std::as_bytes(std::span(&*constants, 1)),
                                                              BufferKind::Uniform, BufferMemory::HostVisible);
            const auto latentBuffer =
                context->CreateBuffer(latents, BufferKind::Storage, BufferMemory::HostVisible);
            const auto weightBuffer =
                context->CreateBuffer(*weights, BufferKind::Storage, BufferMemory::HostVisible);
            const auto zeroBuffer = context->CreateBuffer(std::as_bytes(std::span(zero)), BufferKind::Uniform,
                                                          BufferMemory::HostVisible);
            REQUIRE((constantBuffer && latentBuffer && weightBuffer && zeroBuffer));
            for (int mip = 0; mip < 2; ++mip) {
                const Rect rect = {0, 0, kWidth >> mip, kHeight >> mip};
                const auto texels = static_cast<std::uint32_t>(rect.width * rect.height);
                std::vector<float> reference(std::size_t{texels} * 16), outputs(reference.size());
                REQUIRE(DecodeReference(source, mip, rect, {.math = mode}, reference));
                const auto results = context->CreateBuffer(std::uint64_t{texels} * 64, BufferKind::Storage,
                                                           BufferMemory::HostVisible);
                REQUIRE(results);
                const BoundBuffer bound[] = {{0, &*constantBuffer},
                                             {1, &*latentBuffer},
                                             {2, &*weightBuffer},
                                             {3, &*results},
                                             {4, &*zeroBuffer}};
                const std::int32_t push[] = {rect.width, rect.height, mip};
                const auto dispatched = context->Dispatch(
                    {&*pipeline, bound, std::as_bytes(std::span(push)), {(texels + 63) / 64, 1, 1}});
                REQUIRE_MESSAGE(dispatched.has_value(), std::string(dispatched.error().GetText()));
                REQUIRE(context->Read(*results, 0, std::as_writable_bytes(std::span(outputs))));
                std::size_t different = 0;
                for (std::size_t i = 0; i < outputs.size(); ++i)
                    different += openntc_tests::GetDeviceBits(outputs[i]) !=
                                 openntc_tests::GetDeviceBits(reference[i]);
                CHECK(different == 0);
                compared += outputs.size();
            }
        }
    }
    MESSAGE("numbers compared: " << compared);
}
