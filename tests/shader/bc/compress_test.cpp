// SPDX-License-Identifier: MIT
// passes/CompressBlocks on the device: blocks equal the CPU encoder's, bit for bit, in GLSL and HLSL, for every format
// and quality; rectangles, offsets, edges, and guards around what is written.
#include "shader/TestDevice.h"

#include "openntc/bc/BlockEncoder.h"
#include "openntc/bc/CompressionPass.h"

#include "bc_dot_shaders.h"
#include "bc_hlsl_shaders.h"
#include "bc_shaders.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>
#include <random>
#include <string>
#include <vector>

using namespace openntc;
using namespace openntc::bc;
using namespace openntc::harness;
using namespace openntc_tests;

namespace {

constexpr std::uint32_t kBlockGuard = 0xA5A5A5A5u;

TexelType GetPassTexelType(BlockFormat format) {
    if (format == BlockFormat::Bc6Unsigned || format == BlockFormat::Bc6Signed)
        return TexelType::Half;
    return format == BlockFormat::Bc4Signed || format == BlockFormat::Bc5Signed ? TexelType::Signed8
                                                                                : TexelType::Unsigned8;
}

/// llvmpipe takes ten seconds to compile an encoder of BC6H and twenty for one of BC7, whose levels differ by constants
/// alone: each language and level once.
bool IsTriedOnDevice(BlockFormat format, BlockQuality quality, bool isHlsl) {
    if (format == BlockFormat::Bc6Unsigned)
        return !isHlsl || quality == BlockQuality::Best;
    if (format == BlockFormat::Bc7)
        return quality == BlockQuality::Best || isHlsl == (quality == BlockQuality::Normal);
    return format != BlockFormat::Bc6Signed || (quality == BlockQuality::Normal && isHlsl) ||
           (quality == BlockQuality::Best && !isHlsl);
}

/// Blocks of many kinds: smooth, two colours, solid, noise; channels equal or not, alpha opaque, clear or neither.
std::vector<std::byte> MakePassTexels(std::uint32_t width, std::uint32_t height, TexelType type,
                                      std::uint32_t seed) {
    std::mt19937 engine(seed);
    const auto random = [&] { return static_cast<std::uint32_t>(engine()); };
    const std::size_t size = type == TexelType::Half ? 2 : 1;
    std::vector<std::byte> bytes(4 * size * width * height);
    std::vector<std::uint32_t> kinds(std::size_t{(width + 3) / 4} * ((height + 3) / 4));
    for (std::uint32_t& kind : kinds)
        kind = random();
    for (std::uint32_t y = 0; y < height; ++y) {
        for (std::uint32_t x = 0; x < width; ++x) {
            const std::uint32_t kind = kinds[std::size_t{y / 4} * ((width + 3) / 4) + x / 4];
            for (std::uint32_t c = 0; c < 4; ++c) {
                const std::uint32_t base = (kind >> (4 * c)) & 0xFF;
                std::uint32_t value = base;
                switch (kind % 5) {
                case 0:
                    value = base + (x % 4) * (kind >> 28) + (y % 4) * (kind >> 20 & 7) + random() % 3;
                    break;
                case 1:
                    value = (random() & 1) != 0 ? base : base ^ (kind >> 12 & 0xFF);
                    break;
                case 2:
                    break;
                case 3:
                    value = random() & 0xFF;
                    break;
                default:
                    value = (c == 3 ? 255 : base) + random() % 16;
                    break;
                }
                if (c == 3 && kind % 7 < 3)
                    value = kind % 7 == 0 ? 255 : (random() & 1) * 255;
                const std::size_t at = (std::size_t{y} * width + x) * 4 + c;
                if (type == TexelType::Half) {
                    const auto bits = static_cast<std::uint16_t>(
                        kind % 5 == 3 ? random() : (value & 255) * 97 + 0x1000 + (kind & 0x8000));
                    std::memcpy(&bytes[2 * at], &bits, 2);
                } else {
                    bytes[at] = static_cast<std::byte>(std::min(value, 255u));
                }
            }
        }
    }
    return bytes;
}

/// Runs a pass on buffers; words in front of the blocks and behind them are guards.
std::vector<std::uint32_t> RunPass(Context& context, const BlockCompressionPass& pass,
                                   std::span<const std::byte> texels, bool isHlsl) {
    const bool hasDot = pass.defines.View().find("NTC_DOT4_SPIRV=1") != std::string_view::npos;
    const auto spirv = isHlsl   ? bc_hlsl_shaders::FindShader("CompressBlocks.hlsl", pass.defines.View())
                       : hasDot ? bc_dot_shaders::FindShader("CompressBlocks.comp", pass.defines.View())
                                : bc_shaders::FindShader("CompressBlocks.comp", pass.defines.View());
    REQUIRE_MESSAGE(spirv.has_value(), std::string(spirv ? "" : spirv.error().GetText()));
    std::vector<std::uint32_t> words(static_cast<std::size_t>(pass.destinationWords) + 16, kBlockGuard);
    const auto source = context.CreateBuffer(texels, BufferKind::Storage, BufferMemory::HostVisible);
    const auto blocks =
        context.CreateBuffer(std::as_bytes(std::span(words)), BufferKind::Storage, BufferMemory::HostVisible);
    REQUIRE(source.has_value());
    REQUIRE(blocks.has_value());
    const BufferSlot slots[] = {{0, BufferKind::Storage}, {1, BufferKind::Storage}};
    const auto pipeline = context.CreateComputePipeline(*spirv, slots, sizeof(pass.constants));
    REQUIRE_MESSAGE(pipeline.has_value(), std::string(pipeline ? "" : pipeline.error().GetText()));
    const BoundBuffer bound[] = {{0, &*source}, {1, &*blocks}};
    DispatchRequest request;
    request.pipeline = &*pipeline;
    request.buffers = bound;
    request.pushConstants = std::as_bytes(std::span(&pass.constants, 1));
    std::copy_n(pass.groups, 3, request.groups);
    const auto timing = context.Dispatch(request);
    REQUIRE_MESSAGE(timing.has_value(), std::string(timing ? "" : timing.error().GetText()));
    REQUIRE(context.Read(*blocks, 0, std::as_writable_bytes(std::span(words))).has_value());
    return words;
}

/// The CPU's blocks of a rectangle of texels, as an image of its own.
std::vector<std::uint32_t> EncodeRect(const BlockCompressionDesc& desc, std::span<const std::byte> texels) {
    const TexelType type = GetPassTexelType(desc.format);
    const std::size_t texelBytes = type == TexelType::Half ? 8 : 4;
    const std::size_t rowBytes = texelBytes * static_cast<std::size_t>(desc.sourceWidth);
    const BlockImage image{texels.subspan(rowBytes * static_cast<std::size_t>(desc.top) +
                                          texelBytes * static_cast<std::size_t>(desc.left)),
                           static_cast<std::uint32_t>(desc.width),
                           static_cast<std::uint32_t>(desc.height),
                           rowBytes,
                           4,
                           type};
    BlockOptions options;
    options.quality = desc.quality;
    options.alphaThreshold = desc.alphaThreshold;
    options.allowedModes = desc.allowedModes;
    const BlockRect rect{0, 0, CountBlocks(image.width), CountBlocks(image.height)};
    std::vector<std::uint32_t> words(GetBytesPerBlock(desc.format) / 4 * rect.width * rect.height);
    const auto done =
        EncodeBlocks(desc.format, image, rect, options, std::as_writable_bytes(std::span(words)));
    REQUIRE_MESSAGE(done.has_value(), std::string(done ? "" : done.error().GetText()));
    return words;
}

} // namespace

TEST_CASE("block compression pass: the CPU's blocks, bit for bit") {
    OPENNTC_REQUIRE_DEVICE(context);
    int formats = 0;
    for (int number = 0; number < kBlockFormatCount; ++number) {
        const auto format = static_cast<BlockFormat>(number);
        if (!HasBlockEncoder(format))
            continue;
        ++formats;
        const std::vector<std::byte> texels = MakePassTexels(83, 45, GetPassTexelType(format), 7);
        for (const BlockQuality quality : {BlockQuality::Fast, BlockQuality::Normal, BlockQuality::Best}) {
            for (const bool isHlsl : {false, true}) {
                if (!IsTriedOnDevice(format, quality, isHlsl))
                    continue;
                BlockCompressionDesc desc;
                desc.format = format;
                desc.quality = quality;
                desc.width = desc.sourceWidth = 83;
                desc.height = desc.sourceHeight = 45;
                desc.source = PassMemory::Buffer;
                desc.alphaThreshold = number % 2 == 0 ? 127 : -1;
                auto pass = MakeBlockCompressionPass(desc);
                REQUIRE_MESSAGE(pass.has_value(), std::string(pass ? "" : pass.error().GetText()));
                const auto expected = EncodeRect(desc, texels);
                auto words = RunPass(*context, *pass, texels, isHlsl);
                REQUIRE(words.size() == expected.size() + 16);
                std::size_t different = 0;
                for (std::size_t i = 0; i < expected.size(); ++i)
                    different += words[i] != expected[i] ? 1u : 0u;
                CHECK_MESSAGE(different == 0, std::string(BlockFormatToString(format)), " quality ",
                              static_cast<int>(quality), isHlsl ? " HLSL" : " GLSL", ": ", different, " of ",
                              expected.size(), " words");
                CHECK(std::all_of(words.end() - 16, words.end(),
                                  [](std::uint32_t word) { return word == kBlockGuard; }));
            }
        }
    }
    CHECK(formats > 0);
}

TEST_CASE("block compression pass: with the device's dot product the same blocks of BC7") {
    OPENNTC_REQUIRE_DEVICE(context);
    if (!context->GetDevice().features.Has(Feature::IntegerDotProduct)) {
        MESSAGE("SKIP: the device has no shaderIntegerDotProduct");
        return;
    }
    BlockCompressionDesc desc;
    desc.format = BlockFormat::Bc7;
    desc.quality = BlockQuality::Normal;
    desc.width = desc.sourceWidth = 83;
    desc.height = desc.sourceHeight = 45;
    desc.source = PassMemory::Buffer;
    desc.integerDotProduct = true;
    const std::vector<std::byte> texels = MakePassTexels(83, 45, TexelType::Unsigned8, 9);
    const auto pass = MakeBlockCompressionPass(desc);
    REQUIRE(pass.has_value());
    const auto expected = EncodeRect(desc, texels);
    auto words = RunPass(*context, *pass, texels, false);
    words.resize(expected.size());
    CHECK(words == expected);
    desc.format = BlockFormat::Bc5Unsigned; // a switch of BC7 alone
    const auto other = MakeBlockCompressionPass(desc);
    REQUIRE(other.has_value());
    CHECK(other->defines.View().find("NTC_DOT4") == std::string_view::npos);
}

TEST_CASE("block compression pass: rectangles, rows and offsets; nothing else is written") {
    OPENNTC_REQUIRE_DEVICE(context);
    const std::vector<std::byte> texels = MakePassTexels(70, 41, TexelType::Unsigned8, 8);
    struct Case {
        std::int32_t left, top, width, height;
    };
    for (const Case& part : {Case{0, 0, 1, 1}, Case{69, 40, 1, 1}, Case{5, 3, 27, 2}, Case{4, 8, 64, 32},
                             Case{68, 0, 2, 41}, Case{3, 1, 36, 33}}) {
        for (const bool isHlsl : {false, true}) {
            BlockCompressionDesc desc;
            desc.format = BlockFormat::Bc4Unsigned;
            desc.left = part.left;
            desc.top = part.top;
            desc.width = part.width;
            desc.height = part.height;
            desc.source = PassMemory::Buffer;
            desc.sourceWidth = 70;
            desc.sourceHeight = 41;
            const std::uint32_t wide = CountBlocks(static_cast<std::uint32_t>(part.width));
            desc.destinationRows = {6, 2 * wide + 4};
            const auto pass = MakeBlockCompressionPass(desc);
            REQUIRE(pass.has_value());
            const auto expected = EncodeRect(desc, texels);
            const auto words = RunPass(*context, *pass, texels, isHlsl);
            std::vector<std::uint32_t> wanted(words.size(), kBlockGuard);
            for (std::uint32_t y = 0; y < pass->blocksHigh; ++y)
                std::copy_n(&expected[std::size_t{2} * wide * y], 2 * wide, &wanted[6 + (2 * wide + 4) * y]);
            CHECK(words == wanted);
        }
    }
}

TEST_CASE("block compression pass: what is asked for wrongly is named") {
    BlockCompressionDesc good;
    good.width = good.sourceWidth = 64;
    good.height = good.sourceHeight = 64;
    REQUIRE(MakeBlockCompressionPass(good).has_value());
    const auto fails = [&](auto change, const char* text) {
        BlockCompressionDesc desc = good;
        change(desc);
        const auto pass = MakeBlockCompressionPass(desc);
        REQUIRE(!pass.has_value());
        CHECK(pass.error().GetStatus() == Status::OutOfRange);
        CHECK_MESSAGE(std::string(pass.error().GetText()).find(text) != std::string::npos,
                      std::string(pass.error().GetText()));
    };
    using Desc = BlockCompressionDesc;
    fails([](Desc& d) { d.format = static_cast<BlockFormat>(10); }, "format: 10: 0 ... 9");
    fails([](Desc& d) { d.quality = static_cast<BlockQuality>(3); }, "quality: 3");
    fails([](Desc& d) { d.width = 0; }, "rectangle: 0 x 64");
    fails([](Desc& d) { d.height = -1; }, "rectangle: 64 x -1");
    fails([](Desc& d) { d.left = -1; }, "at (-1, 0)");
    fails([](Desc& d) { d.left = 1; }, "not within the source, 64 x 64");
    fails([](Desc& d) { d.top = 0x7FFFFFFF; }, "not within the source");
    fails([](Desc& d) { d.destinationTop = -4; }, "destination: block (0, -4)");
    fails([](Desc& d) { d.sourceMip = -1; }, "sourceMip: -1");
    fails([](Desc& d) { d.alphaThreshold = 256; }, "alphaThreshold: 256");
    fails([](Desc& d) { d.allowedModes = 0x700; }, "allowedModes: 0x700");
    fails([](Desc& d) { d.destinationRows.rowWords = 63; }, "destination: 63 words a row: 64 are needed");
    fails([](Desc& d) { d.destinationRows.firstWord = 0xFFFFFFFF; }, "shaders reach 4 GiB");
    fails(
        [](Desc& d) {
            d.source = PassMemory::Buffer;
            d.sourceRows.rowWords = 63;
        },
        "source: 63 words a row: 64 are needed");
    fails([](Desc& d) { d.width = d.sourceWidth = 0x7FFFFFFF; }, "in one dispatch");
}
