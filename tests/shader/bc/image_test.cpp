// SPDX-License-Identifier: MIT
// passes/CompressBlocks from a sampled image, to a buffer and to an image of words: the blocks that the CPU makes.
#include "shader/TestDevice.h"

#include "openntc/bc/BlockEncoder.h"
#include "openntc/bc/CompressionPass.h"

#include "bc_image_hlsl_shaders.h"
#include "bc_image_shaders.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <random>
#include <string>
#include <vector>

using namespace openntc;
using namespace openntc::bc;
using namespace openntc::harness;
using namespace openntc_tests;

namespace {

constexpr std::uint32_t kSourceSide = 61;
constexpr std::uint32_t kTargetSide = 24; // blocks

} // namespace

TEST_CASE("block compression pass: from an image, to a buffer and to an image") {
    OPENNTC_REQUIRE_DEVICE(context);
    std::mt19937 random(31);
    std::vector<std::byte> texels(std::size_t{4} * kSourceSide * kSourceSide);
    for (std::byte& byte : texels)
        byte = static_cast<std::byte>(random() >> 24);
    const auto source = context->CreateImage(ImageFormat::RGBA8, kSourceSide, kSourceSide);
    if (!source && source.error().GetStatus() == Status::Unsupported) {
        MESSAGE("SKIP: ", std::string(source.error().GetText()));
        return;
    }
    REQUIRE(source.has_value());
    REQUIRE(context->Write(*source, texels).has_value());
    for (const BlockFormat format : {BlockFormat::Bc4Unsigned, BlockFormat::Bc5Unsigned}) {
        const std::size_t blockWords = GetBytesPerBlock(format) / 4;
        BlockOptions options;
        options.quality = BlockQuality::Fast;
        // Columns and rows 4 ... 60 of the image, whose last blocks reach beyond it.
        std::vector<std::uint32_t> expected(blockWords * 15 * 15);
        const BlockImage view{texels, kSourceSide, kSourceSide, 0, 4, TexelType::Unsigned8};
        REQUIRE(
            EncodeBlocks(format, view, {1, 1, 15, 15}, options, std::as_writable_bytes(std::span(expected)))
                .has_value());
        for (const PassMemory memory : {PassMemory::Buffer, PassMemory::Image}) {
            for (const bool isHlsl : {false, true}) {
                BlockCompressionDesc desc;
                desc.format = format;
                desc.quality = BlockQuality::Fast;
                desc.left = desc.top = 4;
                desc.width = desc.height = desc.sourceWidth = desc.sourceHeight = kSourceSide;
                desc.width -= 4;
                desc.height -= 4;
                desc.destination = memory;
                desc.destinationLeft = 5;
                desc.destinationTop = 7;
                const auto pass = MakeBlockCompressionPass(desc);
                REQUIRE(pass.has_value());
                const auto spirv =
                    isHlsl ? bc_image_hlsl_shaders::FindShader("CompressBlocks.hlsl", pass->defines.View())
                           : bc_image_shaders::FindShader("CompressBlocks.comp", pass->defines.View());
                REQUIRE_MESSAGE(spirv.has_value(), std::string(spirv ? "" : spirv.error().GetText()));
                const bool isImage = memory == PassMemory::Image;
                const BufferSlot slots[] = {{0, BufferKind::Texture},
                                            {1, isImage ? BufferKind::Image : BufferKind::Storage}};
                const auto pipeline = context->CreateComputePipeline(*spirv, slots, sizeof(pass->constants));
                REQUIRE_MESSAGE(pipeline.has_value(),
                                std::string(pipeline ? "" : pipeline.error().GetText()));
                const auto buffer = context->CreateBuffer(expected.size() * 4, BufferKind::Storage,
                                                          BufferMemory::HostVisible);
                const auto image = context->CreateImage(
                    blockWords == 2 ? ImageFormat::RG32UI : ImageFormat::RGBA32UI, kTargetSide, kTargetSide);
                REQUIRE(buffer.has_value());
                REQUIRE(image.has_value());
                const BoundBuffer buffers[] = {{1, &*buffer}};
                const BoundImage images[] = {{0, &*source}, {1, &*image}};
                DispatchRequest request;
                request.pipeline = &*pipeline;
                request.buffers = std::span(buffers).first(isImage ? 0 : 1);
                request.images = std::span(images).first(isImage ? 2 : 1);
                request.pushConstants = std::as_bytes(std::span(&pass->constants, 1));
                std::copy_n(pass->groups, 3, request.groups);
                const auto timing = context->Dispatch(request);
                REQUIRE_MESSAGE(timing.has_value(), std::string(timing ? "" : timing.error().GetText()));
                std::vector<std::uint32_t> words(expected.size());
                if (!isImage) {
                    REQUIRE(context->Read(*buffer, 0, std::as_writable_bytes(std::span(words))).has_value());
                    CHECK(words == expected);
                    continue;
                }
                words.resize(blockWords * kTargetSide * kTargetSide);
                REQUIRE(context->Read(*image, std::as_writable_bytes(std::span(words))).has_value());
                std::vector<std::uint32_t> wanted(words.size(), 0); // images begin as zeros
                for (std::size_t y = 0; y < 15; ++y)
                    std::copy_n(&expected[blockWords * 15 * y], blockWords * 15,
                                &wanted[blockWords * ((y + 7) * kTargetSide + 5)]);
                CHECK(words == wanted);
            }
        }
    }
}
