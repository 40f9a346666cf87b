// SPDX-License-Identifier: MIT
// `bench_blocks [--device NAME] [--size TEXELS] [--frames N] [--json]`: Mtexel/s of the block-compression
// passes, for every format and quality that this program has shaders of, buffer to buffer; of BC7 also with
// the device's dot product where it has one.
//
// The image is made here: smooth gradients, edges, noise and flat areas in squares of 64 texels, because
// encoders take as long as their hardest blocks. Its blocks in the middle are compared with the CPU encoder's.
// Times are between timestamps round the dispatch, on devices without them the host's, on devices that are
// processors the process's time on them. All kinds follow each other in turns; a first round is not counted.
#include "bench_blocks_shaders.h"

#include "openntc/bc/BlockEncoder.h"
#include "openntc/bc/CompressionPass.h"
#include "vulkan_harness/FrameBench.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <string>
#include <utility>
#include <vector>

namespace {

using namespace openntc;
using namespace openntc::bc;
using namespace openntc::harness;

constexpr FrameBench kBench = {"bench_blocks", 128};

template <typename T>
T Require(Expected<T> result) {
    return RequireOrExit(kBench, std::move(result));
}

TexelType GetTexelType(BlockFormat format) {
    if (format == BlockFormat::Bc6Unsigned || format == BlockFormat::Bc6Signed)
        return TexelType::Half;
    return format == BlockFormat::Bc4Signed || format == BlockFormat::Bc5Signed ? TexelType::Signed8
                                                                                : TexelType::Unsigned8;
}

/// Four channels a texel; halves lie between 2^-8 and 2^8.
std::vector<std::byte> MakeImage(std::uint32_t size, TexelType type) {
    const std::size_t texelBytes = type == TexelType::Half ? 8 : 4;
    std::vector<std::byte> bytes(texelBytes * size * size);
    std::uint32_t random = 1;
    for (std::uint32_t y = 0; y < size; ++y) {
        for (std::uint32_t x = 0; x < size; ++x) {
            const std::uint32_t kind = (x / 64 + 3 * (y / 64)) % 4;
            for (std::uint32_t c = 0; c < 4; ++c) {
                random = random * 1664525u + 1013904223u;
                std::uint32_t value = (x * (c + 1) + y * (3 - c % 3)) / 2 % 512;
                value = value < 256 ? value : 511 - value;
                if (kind == 1)
                    value = (x * 5 + y * 3 + c * 40) % 97 < 48 ? 40 + 30 * c : 180 - 20 * c;
                else if (kind == 2)
                    value = random >> 24;
                else if (kind == 3)
                    value = 90 + 25 * c + (random >> 30);
                if (c == 3 && kind != 2)
                    value = 255;
                const std::size_t at = (std::size_t{y} * size + x) * 4 + c;
                if (type == TexelType::Half) {
                    const auto half = static_cast<std::uint16_t>(0x1C00 + value * 64);
                    std::memcpy(&bytes[2 * at], &half, 2);
                } else {
                    bytes[at] = static_cast<std::byte>(value);
                }
            }
        }
    }
    return bytes;
}

/// One format at one quality.
struct Kind {
    BlockFormat format;
    BlockQuality quality;
    bool hasDot;
    BlockCompressionPass pass;
    ComputePipeline pipeline;
    Buffer blocks;
    std::vector<double> seconds;
};

constexpr const char* kQualities[] = {"fast", "normal", "best"};

std::vector<Kind> MakeKinds(Context& context, const FrameOptions& options) {
    std::vector<Kind> kinds;
    const auto side = static_cast<std::int32_t>(options.size);
    const bool deviceHasDot = context.GetDevice().features.Has(Feature::IntegerDotProduct);
    for (int number = 0; number < 3 * (kBlockFormatCount + 1); ++number) {
        BlockCompressionDesc desc;
        desc.integerDotProduct = number / 3 == kBlockFormatCount;
        if (desc.integerDotProduct && !deviceHasDot)
            continue;
        if (!desc.integerDotProduct)
            desc.format = static_cast<BlockFormat>(number / 3);
        desc.quality = static_cast<BlockQuality>(number % 3);
        desc.width = desc.height = desc.sourceWidth = desc.sourceHeight = side;
        desc.source = desc.destination = PassMemory::Buffer;
        const BlockCompressionPass pass = Require(MakeBlockCompressionPass(desc));
        const auto spirv = bench_blocks_shaders::FindShader("CompressBlocks.comp", pass.defines.View());
        if (!spirv)
            continue; // a format that has no encoder
        const BufferSlot slots[] = {{0, BufferKind::Storage}, {1, BufferKind::Storage}};
        kinds.push_back({desc.format,
                         desc.quality,
                         desc.integerDotProduct,
                         pass,
                         Require(context.CreateComputePipeline(*spirv, slots, sizeof(pass.constants))),
                         Require(context.CreateBuffer(pass.destinationWords * 4, BufferKind::Storage,
                                                      BufferMemory::DeviceLocal)),
                         {}});
    }
    return kinds;
}

/// Ends the program where blocks of the image's middle differ from the CPU encoder's.
void CheckBlocks(Context& context, const Kind& kind, std::span<const std::byte> image,
                 const FrameOptions& options) {
    const std::uint32_t columns = options.size / 4;
    const BlockRect rect = {columns / 2 - 8, columns / 2 - 8, 16, 16};
    const std::size_t blockBytes = GetBytesPerBlock(kind.format);
    std::vector<std::byte> expected(blockBytes * rect.width * rect.height);
    BlockOptions request;
    request.quality = kind.quality;
    Require(EncodeBlocks(kind.format, {image, options.size, options.size, 0, 4, GetTexelType(kind.format)},
                         rect, request, expected));
    std::vector<std::byte> blocks(static_cast<std::size_t>(kind.pass.destinationWords) * 4);
    Require(context.Read(kind.blocks, 0, blocks));
    for (std::uint32_t y = 0; y < rect.height; ++y) {
        const std::byte* row = &blocks[blockBytes * (std::size_t{rect.top + y} * columns + rect.left)];
        if (std::memcmp(row, &expected[blockBytes * rect.width * y], blockBytes * rect.width) == 0)
            continue;
        std::fprintf(stderr, "bench_blocks: %s %s: row %u of blocks differs from the CPU's\n",
                     BlockFormatToString(kind.format), kQualities[static_cast<int>(kind.quality)],
                     rect.top + y);
        std::exit(1);
    }
}

} // namespace

int main(int argc, char** argv) {
    const FrameOptions options = ReadFrameOptions(kBench, argc, argv);
    ContextOptions contextOptions;
    contextOptions.device = options.device;
    const auto context = Require(Context::Create(contextOptions));
    std::vector<std::byte> images[3];
    std::vector<Buffer> sources;
    for (const TexelType type : {TexelType::Unsigned8, TexelType::Signed8, TexelType::Half}) {
        images[static_cast<int>(type)] = MakeImage(options.size, type);
        sources.push_back(Require(context->CreateBuffer(images[static_cast<int>(type)], BufferKind::Storage,
                                                        BufferMemory::DeviceLocal)));
    }
    std::vector<Kind> kinds = MakeKinds(*context, options);
    for (std::uint32_t frame = 0; frame <= options.frames; ++frame) {
        for (Kind& kind : kinds) {
            const BoundBuffer bound[] = {{0, &sources[static_cast<std::size_t>(GetTexelType(kind.format))]},
                                         {1, &kind.blocks}};
            DispatchRequest request;
            request.pipeline = &kind.pipeline;
            request.buffers = bound;
            request.pushConstants = std::as_bytes(std::span(&kind.pass.constants, 1));
            std::copy_n(kind.pass.groups, 3, request.groups);
            const std::clock_t start = std::clock();
            const DispatchTiming timing = Require(context->Dispatch(request));
            const double processor = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
            if (frame > 0)
                kind.seconds.push_back(
                    context->GetDevice().isCpu ? processor : timing.gpuSeconds.value_or(timing.wallSeconds));
        }
    }
    const double texels = static_cast<double>(options.size) * options.size;
    std::printf(options.json
                    ? "{\"device\":\"%s\",\"texels\":%.0f,\"frames\":%u,\"rows\":["
                    : "%s, %.0f texels, %u frames\n\nformat quality  Mtexel/s median  slowest  fastest\n",
                context->GetDevice().name.c_str(), texels, options.frames);
    const char* separator = "\n";
    for (Kind& kind : kinds) {
        CheckBlocks(*context, kind, images[static_cast<std::size_t>(GetTexelType(kind.format))], options);
        std::sort(kind.seconds.begin(), kind.seconds.end());
        const auto rate = [&](double seconds) { return texels / seconds * 1e-6; };
        const double median = rate(kind.seconds[kind.seconds.size() / 2]);
        if (options.json)
            std::printf("%s", std::exchange(separator, ",\n"));
        const char* dot = options.json ? (kind.hasDot ? "true" : "false") : kind.hasDot ? "dot" : "";
        std::printf(options.json ? "{\"format\":\"%s\",\"quality\":\"%s\",\"dotProduct\":%s,\"median\":%.2f,"
                                   "\"slowest\":%.2f,\"fastest\":%.2f}"
                                 : "%-6s %-6s %3s %13.2f %8.2f %8.2f\n",
                    BlockFormatToString(kind.format), kQualities[static_cast<int>(kind.quality)], dot, median,
                    rate(kind.seconds.back()), rate(kind.seconds.front()));
    }
    if (options.json)
        std::printf("\n]}\n");
    return 0;
}
