// SPDX-License-Identifier: MIT
// Blocks of texels on cooperative matrices that are arrays, with latents in a texture: the bits of single texels that the same
// device decodes with them.
#include "shader/TestDevice.h"
#include "shader/coopmat/Probes.h"
#include "support/DeviceBits.h"
#include "unit/decode/LatentMipSets.h"

#include "coopmat_shaders.h"

#include "openntc/inference/CooperativeMatrices.h"
#include "openntc/passes/PassConstants.h"

#include <doctest/doctest.h>

#include <string>
#include <vector>

using namespace openntc;
using namespace openntc::harness;
using namespace openntc_tests;

namespace {

std::vector<float> RunOnTexture(Context& context, const char* source, const char* defines,
                                std::span<const std::byte> constants, const Image& latents,
                                std::span<const std::byte> weights, std::span<const std::byte> push,
                                std::uint32_t groups, std::size_t texels) {
    static constexpr BufferSlot kSlots[] = {{0, BufferKind::Uniform},
                                            {1, BufferKind::FilteredTexture},
                                            {2, BufferKind::Storage},
                                            {3, BufferKind::Storage}};
    const auto spirv = coopmat_shaders::FindShader(source, defines);
    REQUIRE_MESSAGE(spirv.has_value(), std::string(spirv.error().GetText()));
    const auto pipeline =
        context.CreateComputePipeline(*spirv, kSlots, static_cast<std::uint32_t>(push.size()));
    REQUIRE_MESSAGE(pipeline.has_value(), std::string(pipeline.error().GetText()));
    std::vector<float> outputs(16 * texels);
    const auto uniform = context.CreateBuffer(constants, BufferKind::Uniform, BufferMemory::DeviceLocal);
    const auto matrices = context.CreateBuffer(weights, BufferKind::Storage, BufferMemory::DeviceLocal);
    const auto results =
        context.CreateBuffer(4 * outputs.size(), BufferKind::Storage, BufferMemory::HostVisible);
    REQUIRE((uniform && matrices && results));
    const BoundBuffer bound[] = {{0, &*uniform}, {2, &*matrices}, {3, &*results}};
    const BoundImage images[] = {{1, &latents}};
    DispatchRequest request;
    request.pipeline = &*pipeline;
    request.buffers = bound;
    request.images = images;
    request.pushConstants = push;
    request.groups[0] = groups;
    const auto timing = context.Dispatch(request);
    REQUIRE_MESSAGE(timing.has_value(), std::string(timing.error().GetText()));
    REQUIRE(context.Read(*results, 0, std::as_writable_bytes(std::span(outputs))));
    return outputs;
}

} // namespace

TEST_CASE("cooperative matrices as arrays: latents in a texture, every mip as texel by texel") {
    OPENNTC_REQUIRE_DEVICE(context);
    const decode_test::LatentMipSet set({51, NTC_NETWORK_GENERATION_3, 61, 39, 4, 4, 12});
    const unsigned size = set.GetGridSize(0);
    const auto image = context->CreateImageArray(ImageFormat::BGRA4, size & 0xFFFFu, size >> 16, 3,
                                                 static_cast<std::uint32_t>(set.GetLatentMips()));
    if (!image && image.error().GetStatus() == Status::Unsupported) {
        MESSAGE("SKIP: " << image.error().GetText());
        return;
    }
    REQUIRE_MESSAGE(image.has_value(), std::string(image.error().GetText()));
    for (int mip = 0; mip < set.GetLatentMips(); ++mip)
        REQUIRE(context->Write(*image, set.GetLatentBytes(mip), static_cast<std::uint32_t>(mip)));
    const DecodeSource source = set.GetSource(DecodeWeights::Int8);
    const std::span<const std::byte> constants = std::as_bytes(std::span(source.constants, 1));
    const auto layout = ReadCoopMatLayout(MakeKnownProbe());
    REQUIRE(layout);
    const auto weights = MakeCoopMatWeights(source.networkVersion, source.weights, &*layout);
    REQUIRE_MESSAGE(weights.has_value(), std::string(weights.error().GetText()));
    bool readsCoarserLevels = false;
    for (int mip = 0; mip < set.GetShape().mips; ++mip) {
        CAPTURE(mip);
        const int width = std::max(61 >> mip, 1), height = std::max(39 >> mip, 1);
        const auto texels = static_cast<std::size_t>(width * height);
        const NtcDecodeTexelsConstants one = {0, 0, width, height, mip, 0u};
        const NtcDecodeBlocksConstants blocks = {0, 0, static_cast<std::uint32_t>(width),
                                                 static_cast<std::uint32_t>(height), mip};
        const std::vector<float> expected = RunOnTexture(
            *context, "DecodeTexels.comp", "NETWORK_VERSION=6 NTC_MATH=1 NTC_LATENT_FETCH=2", constants,
            *image, source.weights, std::as_bytes(std::span(&one, 1)),
            static_cast<std::uint32_t>(texels + NTC_DECODE_TEXELS_GROUP - 1) / NTC_DECODE_TEXELS_GROUP,
            texels);
        const std::vector<float> outputs = RunOnTexture(
            *context, "DecodeBlocks.comp",
            "NETWORK_VERSION=6 NTC_MATH=8 NTC_COOPMAT_LANES=1 NTC_COOPMAT_EMULATED=1 "
            "NTC_RESULT_BITS=32 NTC_LATENT_FETCH=2",
            constants, *image, weights->AsSpan(), std::as_bytes(std::span(&blocks, 1)), 5, texels);
        std::size_t different = 0;
        for (std::size_t i = 0; i < outputs.size(); ++i)
            different += GetDeviceBits(outputs[i]) != GetDeviceBits(expected[i]) ? 1 : 0;
        CHECK(different == 0);
        readsCoarserLevels = readsCoarserLevels || source.constants->colorMips[mip].neuralMip > 0;
    }
    CHECK(readsCoarserLevels);
    CHECK(context->GetValidationLog().errors.empty());
}
