// SPDX-License-Identifier: MIT
#include "report/ShaderSource.h"
#include "report/SharedDevice.h"

#include "openntc/bc/CompressionPass.h"

#include <algorithm>

namespace openntc::report {

namespace {

constexpr harness::BufferSlot kBlockSlots[] = {
    {0, harness::BufferKind::Storage}, {1, harness::BufferKind::Storage}, {2, harness::BufferKind::Storage}};
constexpr int kGpuTexels = 1 << 22; // fewer do not fill a GPU

/// Four numbers a texel, which is what the pass reads; the third and fourth as the C++ encoder has them.
std::vector<std::byte> MakePassTexels(const BlockTexture& texture) {
    const tool::TextureFormat& format = texture.decoded.GetFormat();
    const std::span<const std::byte> texels = texture.decoded.GetTexels();
    const auto bytes = static_cast<std::size_t>(tool::GetNumberBytes(format.number));
    const std::size_t from = bytes * static_cast<std::size_t>(format.channels), to = 4 * bytes;
    std::vector<std::byte> words(texels.size() / from * to);
    for (std::size_t i = 0; i < texels.size() / from; ++i)
        std::copy_n(texels.begin() + static_cast<std::ptrdiff_t>(i * from), from,
                    words.begin() + static_cast<std::ptrdiff_t>(i * to));
    return words;
}

class VulkanBlocks final : public PreparedBlocks {
public:
    VulkanBlocks(SharedDevice& shared, const BlockCase& c, const BlockTexture& texture,
                 const bc::BlockCompressionDesc& desc, std::span<const std::uint32_t> spirv)
        : shared_(shared) {
        bc::BlockCompressionDesc one = desc;
        one.height = one.sourceHeight = texture.height;
        onePass_ = tool::Require(bc::MakeBlockCompressionPass(one), tool::ExitCode::Failed, c.GetId());
        allPass_ = tool::Require(bc::MakeBlockCompressionPass(desc), tool::ExitCode::Failed, c.GetId());
        texels_ = static_cast<double>(desc.width) * desc.height;
        kernel_ = RequireDevice(
            shared_.context->CreateComputePipeline(spirv, std::span(kBlockSlots).first(desc.hasHints ? 3 : 2),
                                                   sizeof allPass_.constants, {.isKept = false}),
            shared_.GetInfo().name + ": " + c.GetId());
        const std::vector<std::byte> words = MakePassTexels(texture);
        std::vector<std::byte> all;
        for (std::int32_t row = 0; row < desc.height; row += texture.height)
            all.insert(all.end(), words.begin(), words.end());
        source_ = RequireDevice(shared_.context->CreateBuffer(all, harness::BufferKind::Storage,
                                                              harness::BufferMemory::DeviceLocal));
        hasHints_ = desc.hasHints;
        if (!hasHints_)
            return;
        const std::vector<std::int32_t> hints = GatherBlockHints(c, texture);
        std::vector<std::int32_t> allHints;
        for (std::int32_t row = 0; row < desc.height; row += texture.height)
            allHints.insert(allHints.end(), hints.begin(), hints.end());
        hints_ = RequireDevice(shared_.context->CreateBuffer(std::as_bytes(std::span(allHints)),
                                                             harness::BufferKind::Storage,
                                                             harness::BufferMemory::DeviceLocal));
    }

    int GetThreads() const override { return 0; }

    std::vector<std::byte> Encode() override {
        Run(onePass_, 1);
        std::vector<std::byte> blocks(static_cast<std::size_t>(onePass_.destinationWords) * 4);
        RequireDevice(shared_.context->Read(shared_.results, 0, blocks));
        return blocks;
    }

    std::vector<double> Time(int repeats) override {
        std::vector<double> times =
            shared_.TimeWarm([this](int count) { return Run(allPass_, count); }, repeats);
        for (double& time : times)
            time /= texels_;
        return times;
    }

private:
    std::vector<double> Run(const bc::BlockCompressionPass& pass, int repeats) {
        shared_.MakeResults(pass.destinationWords * 4);
        const harness::BoundBuffer bound[] = {{0, &source_}, {1, &shared_.results}, {2, &hints_}};
        harness::DispatchRequest request;
        request.pipeline = &kernel_;
        request.buffers = std::span(bound).first(hasHints_ ? 3 : 2);
        request.pushConstants = std::as_bytes(std::span(&pass.constants, 1));
        std::copy(std::begin(pass.groups), std::end(pass.groups), std::begin(request.groups));
        return shared_.Time(request, repeats);
    }

    SharedDevice& shared_;
    bc::BlockCompressionPass onePass_, allPass_;
    double texels_ = 1;
    harness::ComputePipeline kernel_;
    bool hasHints_ = false;
    harness::Buffer source_, hints_;
};

} // namespace

std::vector<std::unique_ptr<PreparedBlocks>>
PrepareBlocksOnVulkan(SharedDevice& shared, const VulkanSettings& settings, const BlockCase& c,
                      const BlockTexture& texture, std::string& skipped) {
    bc::BlockCompressionDesc desc;
    desc.format = c.format;
    desc.quality = tool::ToBlockQuality(c.effort);
    const int copies =
        shared.GetInfo().isCpu ? 1 : std::max(1, kGpuTexels / std::max(1, texture.width * texture.height));
    desc.width = desc.sourceWidth = texture.width;
    desc.height = desc.sourceHeight = texture.height * copies;
    desc.source = desc.destination = bc::PassMemory::Buffer;
    desc.hasHints = c.isHinted;
    // Drivers on the CPU have it too, and gain nothing.
    desc.integerDotProduct =
        !shared.GetInfo().isCpu && shared.GetInfo().features.Has(harness::Feature::IntegerDotProduct);
    const bc::BlockCompressionPass pass =
        tool::Require(bc::MakeBlockCompressionPass(desc), tool::ExitCode::Failed, c.GetId());
    ShaderRequest request{
        settings.sources, "shaders/openntc/passes/CompressBlocks.comp", settings.glslang, {}, false};
    for (std::string_view rest = pass.defines.View(); !rest.empty();) {
        const std::size_t end = std::min(rest.find(' '), rest.size());
        request.defines.emplace_back(rest.substr(0, end));
        rest.remove_prefix(std::min(end + 1, rest.size()));
    }
    const ShaderResult shader = CompileReportShader(request);
    std::vector<std::unique_ptr<PreparedBlocks>> ways;
    if (!shader.missing.empty())
        skipped = shader.missing;
    else
        ways.push_back(std::make_unique<VulkanBlocks>(shared, c, texture, desc, shader.words));
    return ways;
}

} // namespace openntc::report
