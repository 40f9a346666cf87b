// SPDX-License-Identifier: MIT
// The reference decoders against a device's sampler, on random blocks of every format, mode, partition and rotation,
// reserved codes too: BC6H and BC7 bit for bit, BC1 to BC5 within what Direct3D, or this device, allows itself.
#include "shader/TestDevice.h"

#include "openntc/bc/BlockDecoder.h"

#include "bc_sample_shaders.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <random>
#include <set>
#include <string>
#include <vector>

using namespace openntc;
using namespace openntc::bc;
using namespace openntc::harness;
using namespace openntc_tests;

namespace {

constexpr std::uint32_t kSampledSide = 1024; // 65536 blocks

/// Four floats a texel, as the device samples them; empty after printing why it cannot.
std::vector<float> SampleBlocks(Context& context, BlockFormat format, std::span<const std::byte> blocks) {
    const auto image = context.CreateImage(
        static_cast<ImageFormat>(static_cast<int>(ImageFormat::BC1) + static_cast<int>(format)), kSampledSide,
        kSampledSide);
    if (!image && image.error().GetStatus() == Status::Unsupported) {
        MESSAGE("SKIP: ", std::string(image.error().GetText()));
        return {};
    }
    REQUIRE_MESSAGE(image.has_value(), std::string(image ? "" : image.error().GetText()));
    REQUIRE(context.Write(*image, blocks).has_value());
    std::vector<float> texels(std::size_t{4} * kSampledSide * kSampledSide);
    const auto buffer =
        context.CreateBuffer(texels.size() * sizeof(float), BufferKind::Storage, BufferMemory::HostVisible);
    REQUIRE(buffer.has_value());
    const auto spirv = bc_sample_shaders::FindShader("SampleBlocks.comp", "");
    REQUIRE(spirv.has_value());
    const BufferSlot slots[] = {{0, BufferKind::Texture}, {1, BufferKind::Storage}};
    const auto pipeline = context.CreateComputePipeline(*spirv, slots, 0);
    REQUIRE_MESSAGE(pipeline.has_value(), std::string(pipeline ? "" : pipeline.error().GetText()));
    const BoundBuffer buffers[] = {{1, &*buffer}};
    const BoundImage images[] = {{0, &*image}};
    DispatchRequest request;
    request.pipeline = &*pipeline;
    request.buffers = buffers;
    request.images = images;
    request.groups[0] = request.groups[1] = kSampledSide / 8;
    const auto timing = context.Dispatch(request);
    REQUIRE_MESSAGE(timing.has_value(), std::string(timing ? "" : timing.error().GetText()));
    REQUIRE(context.Read(*buffer, 0, std::as_writable_bytes(std::span(texels))).has_value());
    return texels;
}

std::vector<std::byte> MakeRandomBlocks(BlockFormat format, std::uint32_t seed) {
    std::mt19937 random(seed);
    std::vector<std::byte> blocks(GetBytesPerBlock(format) * kSampledSide * kSampledSide / 16);
    for (std::byte& byte : blocks)
        byte = static_cast<std::byte>(random() >> 24);
    return blocks;
}

/// The value of texel t, channel c of a block of the image.
float GetSampled(const std::vector<float>& texels, std::size_t block, std::size_t t, std::size_t c) {
    const std::size_t x = block % (kSampledSide / 4) * 4 + t % 4;
    const std::size_t y = block / (kSampledSide / 4) * 4 + t / 4;
    return texels[4 * (y * kSampledSide + x) + c];
}

} // namespace

TEST_CASE("block decoder: BC7 equals the sampler bit for bit, every mode, partition, rotation and selector") {
    OPENNTC_REQUIRE_DEVICE(context);
    const std::uint32_t seed = std::random_device{}();
    INFO("seed ", seed);
    std::vector<std::byte> blocks = MakeRandomBlocks(BlockFormat::Bc7, seed);
    std::set<int> choices;
    for (std::size_t b = 0; b < blocks.size() / 16; ++b) {
        // Modes in turn, and 8: the reserved code.
        const int mode = static_cast<int>(b % 9);
        int bits = static_cast<int>(blocks[16 * b]) | static_cast<int>(blocks[16 * b + 1]) << 8;
        bits = (bits >> (mode + 1) << (mode + 1)) | (mode < 8 ? 1 << mode : 0);
        if (mode == 8)
            bits &= 0xFF00;
        blocks[16 * b] = static_cast<std::byte>(bits & 255);
        blocks[16 * b + 1] = static_cast<std::byte>(bits >> 8);
        constexpr int kChoiceBits[9] = {4, 6, 6, 6, 3, 2, 0, 6, 0};
        choices.insert(mode << 8 | (bits >> (mode + 1) & ((1 << kChoiceBits[mode]) - 1)));
    }
    CHECK(choices.size() == 16 + 64 + 64 + 64 + 8 + 4 + 1 + 64 + 1);
    const std::vector<float> sampled = SampleBlocks(*context, BlockFormat::Bc7, blocks);
    if (sampled.empty())
        return;
    std::array<std::size_t, 9> wrong{};
    for (std::size_t b = 0; b < blocks.size() / 16; ++b) {
        std::uint8_t texels[64];
        DecodeBlockBytes(BlockFormat::Bc7, &blocks[16 * b], texels);
        for (std::size_t i = 0; i < 64; ++i)
            wrong[b % 9] += std::lround(GetSampled(sampled, b, i / 4, i % 4) * 255.0f) != texels[i] ? 1u : 0u;
    }
    for (std::size_t mode = 0; mode < 9; ++mode)
        CHECK_MESSAGE(wrong[mode] == 0, "mode ", mode);
}

TEST_CASE(
    "block decoder: BC6H equals the sampler bit for bit, every mode and partition, reserved codes too") {
    OPENNTC_REQUIRE_DEVICE(context);
    for (const BlockFormat format : {BlockFormat::Bc6Unsigned, BlockFormat::Bc6Signed}) {
        const std::uint32_t seed = std::random_device{}();
        INFO("seed ", seed);
        const std::vector<std::byte> blocks = MakeRandomBlocks(format, seed);
        std::set<int> choices;
        for (std::size_t b = 0; b < blocks.size() / 16; ++b) {
            const int code = static_cast<int>(blocks[16 * b]) & 31;
            const int partition =
                static_cast<int>(blocks[16 * b + 9]) >> 5 | (static_cast<int>(blocks[16 * b + 10]) & 3) << 3;
            choices.insert((code & 3) < 2 ? code & 3 : (code & 3) == 2 ? code << 8 | partition : code << 8);
            if ((code & 3) < 2)
                choices.insert((code & 3) << 16 | partition << 2);
        }
        // Ten modes of 32 partitions (for the two short codes the mode itself too), four without, four reserved.
        CHECK(choices.size() >= 10 * 32 + 8);
        const std::vector<float> sampled = SampleBlocks(*context, format, blocks);
        if (sampled.empty())
            return;
        std::array<std::size_t, 32> wrong{};
        for (std::size_t b = 0; b < blocks.size() / 16; ++b) {
            float texels[64];
            DecodeBlockFloats(format, &blocks[16 * b], texels);
            for (std::size_t i = 0; i < 64; ++i)
                wrong[static_cast<std::size_t>(blocks[16 * b]) & 31] +=
                    std::bit_cast<std::uint32_t>(GetSampled(sampled, b, i / 4, i % 4)) !=
                            std::bit_cast<std::uint32_t>(texels[i])
                        ? 1u
                        : 0u;
        }
        for (std::size_t code = 0; code < 32; ++code)
            CHECK_MESSAGE(wrong[code] == 0, std::string(BlockFormatToString(format)), " code ", code, ": ",
                          wrong[code]);
    }
}

TEST_CASE("block decoder: BC1 to BC5 within the tolerance of the sampler") {
    OPENNTC_REQUIRE_DEVICE(context);
    const bool isLavapipe = context->GetDevice().name.find("llvmpipe") != std::string::npos;
    for (int number = 0; number <= static_cast<int>(BlockFormat::Bc5Signed); ++number) {
        const auto format = static_cast<BlockFormat>(number);
        const std::uint32_t seed = std::random_device{}();
        INFO("seed ", seed);
        std::vector<std::byte> blocks = MakeRandomBlocks(format, seed);
        const std::size_t bytes = GetBytesPerBlock(format);
        // Every pair of endpoints of BC4.
        for (std::size_t b = 0; number >= 3 && b < 65536; ++b) {
            blocks[bytes * b] = static_cast<std::byte>(b & 255);
            blocks[bytes * b + 1] = static_cast<std::byte>(b >> 8);
        }
        const std::vector<float> sampled = SampleBlocks(*context, format, blocks);
        if (sampled.empty())
            return;
        std::size_t wrong = 0;
        double worst = 0;
        for (std::size_t b = 0; b < 65536; ++b) {
            float texels[64];
            DecodeBlockFloats(format, &blocks[bytes * b], texels);
            // The same endpoints with all indices 0, and with all 1: how far apart they are.
            std::array<std::byte, 16> ends[2];
            float colors[2][64];
            for (std::size_t e = 0; e < 2; ++e) {
                std::memcpy(ends[e].data(), &blocks[bytes * b], bytes);
                if (format != BlockFormat::Bc4Unsigned && format != BlockFormat::Bc4Signed)
                    std::memset(ends[e].data() + bytes - 4, e == 0 ? 0 : 0x55, 4);
                DecodeBlockFloats(format, ends[e].data(), colors[e]);
            }
            for (std::size_t i = 0; i < 64; ++i) {
                const double got = GetSampled(sampled, b, i / 4, i % 4);
                const double error = std::abs(got - texels[i]);
                // Alpha of BC2 is stored as it is; that of BC3 is as BC4.
                const bool isLikeBc4 = number >= 3 || (format == BlockFormat::Bc3 && i % 4 == 3);
                const bool isSigned = format == BlockFormat::Bc4Signed || format == BlockFormat::Bc5Signed;
                // Measured: lavapipe's weights are rounded 256ths, an H200 is up to 6.7 steps off.
                const double steps = !isLavapipe ? 6.8 : isSigned ? 1.81 : 1.6;
                const double bound = isLikeBc4
                                         ? steps / (isSigned ? 127 : 255)
                                         : 1.0 / 255 + 0.03 * std::abs(colors[0][i % 4] - colors[1][i % 4]);
                wrong += error > bound + 1e-6 ? 1u : 0u;
                worst = std::max(worst, error * (isSigned ? 127 : 255));
                // What is 0, 1 or -1 is exactly that.
                if (!isLikeBc4 && (texels[i] == 0.0f || texels[i] == 1.0f))
                    wrong += got != texels[i] ? 1u : 0u;
            }
        }
        MESSAGE(std::string(BlockFormatToString(format)), ": at most ", worst, " steps of a byte");
        CHECK_MESSAGE(wrong == 0, std::string(BlockFormatToString(format)), ": ", wrong);
    }
}
