// SPDX-License-Identifier: MIT
#include "report/Device.h"

#include "Failure.h"
#include "Interrupt.h"
#include "Output.h"
#include "TextureSet.h"
#include "report/ShaderSource.h"
#include "report/SharedDevice.h"

#include "openntc/MathModes.h"
#include "openntc/inference/LatentTextures.h"

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>

namespace openntc::report {

using tool::ExitCode;

namespace {

constexpr std::size_t kMaxSets = 8; // REPORT_MAX_SETS
constexpr std::size_t kSetAlignment = 256;
constexpr std::uint32_t kBinary32 = 0x80000000u;

/// As declared in ReportDecode.comp.
struct ReportConstants {
    NtcTextureSetConstants desc[kMaxSets];
    std::uint32_t offsets[kMaxSets][4];
    std::uint32_t extent[4];
};
static_assert(sizeof(NtcTextureSetConstants) % 16 == 0);

bool UsesVectors(int math) {
    return math == NTC_MATH_COOPVEC_INT8 || math == NTC_MATH_COOPVEC_FP8;
}

constexpr harness::BufferSlot kSlots[] = {{0, harness::BufferKind::Uniform},
                                          {1, harness::BufferKind::Storage},
                                          {2, harness::BufferKind::Storage},
                                          {3, harness::BufferKind::Storage}};

class VulkanCase final : public PreparedCase {
public:
    VulkanCase(SharedDevice& shared, const Case& c, const Encoding& encoding,
               std::span<const std::uint32_t> spirv)
        : shared_(shared), width_(static_cast<std::uint32_t>(encoding.record.width)),
          texels_(c.weights == WeightsForm::WideTwoTexels ? 2 : 1) {
        std::vector<harness::BufferSlot> slots(std::begin(kSlots), std::end(kSlots));
        if (c.latentTexture) {
            slots[1].kind = harness::BufferKind::FilteredTexture;
            texture_ = MakeTexture(encoding);
        }
        kernel_ = RequireDevice(
            shared_.context->CreateComputePipeline(spirv, slots, sizeof(std::uint32_t), {.isKept = false}),
            shared_.GetInfo().name + ": " + c.GetId());
        Upload(c, encoding);
    }

    std::vector<float> Decode(int rows) override {
        const auto height = static_cast<std::uint32_t>(rows);
        std::vector<float> outputs(std::size_t{16} * width_ * height);
        shared_.MakeResults(outputs.size() * sizeof(float));
        // The first dispatch of drivers that compile late, so that Ctrl-C is seen after it.
        Run(width_ | kBinary32, 1, 1, 1);
        Run(width_ | kBinary32, width_ / (8 * texels_), height / 8, 1);
        RequireDevice(shared_.context->Read(shared_.results, 0, std::as_writable_bytes(std::span(outputs))));
        return outputs;
    }

    std::vector<double> Time(int repeats) override {
        shared_.MakeResults(std::uint64_t{kMaxSide} * kMaxSide * 32);
        if (side_ == 0)
            PickSide();
        std::vector<double> times =
            shared_.TimeWarm([this](int count) { return RunSquare(side_, count); }, repeats);
        for (double& time : times)
            time /= static_cast<double>(GetTexelsPerDispatch());
        return times;
    }

    std::uint64_t GetTexelsPerDispatch() const override { return std::uint64_t{side_} * side_; }

private:
    static constexpr std::uint32_t kMaxSide = 2048;
    static constexpr std::uint32_t kSmallestSide = 64;

    /// A GPU needs many texels to be busy, a driver on the CPU few to be done soon.
    void PickSide() {
        const bool isCpu = shared_.GetInfo().isCpu;
        const double wanted = isCpu ? 4e7 : 2e6; // ns
        side_ = isCpu ? kSmallestSide : 1024;
        const double first = RunSquare(side_, 2).back() / static_cast<double>(GetTexelsPerDispatch());
        const std::uint32_t most = isCpu ? 512 : kMaxSide;
        while (side_ < most && first * 4.0 * static_cast<double>(GetTexelsPerDispatch()) <= wanted)
            side_ *= 2;
    }

    /// Copies of the set with latents and weights of their own, so that sets differ in what they load.
    void Upload(const Case& c, const Encoding& encoding) {
        const tool::DecodeData& data = encoding.GetData(c.math);
        NtcTextureSetConstants constants = data.constants;
        std::vector<std::byte> weights = data.weights;
        if (UsesVectors(c.math)) {
            CoopVecWeights converted = tool::Require(
                MakeCoopVecWeights(c.math == NTC_MATH_COOPVEC_FP8 ? InferenceWeightType::CoopVecFP8
                                                                  : InferenceWeightType::CoopVecInt8,
                                   c.network, weights),
                ExitCode::Failed, encoding.record.name);
            weights = RequireDevice(shared_.context->ConvertWeights(converted));
            SetCoopVecOffsets(converted, constants);
        }
        const std::size_t copies = std::max<std::size_t>(1, static_cast<std::size_t>(c.sets));
        const auto align = [](std::size_t n) {
            return (n + kSetAlignment - 1) / kSetAlignment * kSetAlignment;
        };
        const std::size_t latentStride = align(data.latents.size()), weightStride = align(weights.size());
        std::vector<std::byte> allLatents(latentStride * copies), allWeights(weightStride * copies);
        ReportConstants block = {};
        for (std::size_t i = 0; i < copies; ++i) {
            std::copy(data.latents.begin(), data.latents.end(),
                      allLatents.begin() + static_cast<std::ptrdiff_t>(i * latentStride));
            std::copy(weights.begin(), weights.end(),
                      allWeights.begin() + static_cast<std::ptrdiff_t>(i * weightStride));
            block.desc[i] = constants;
            block.offsets[i][0] = static_cast<std::uint32_t>(i * latentStride);
            block.offsets[i][1] = static_cast<std::uint32_t>(i * weightStride);
        }
        block.extent[0] = static_cast<std::uint32_t>(encoding.record.width);
        block.extent[1] = static_cast<std::uint32_t>(encoding.record.height);
        block.extent[2] = static_cast<std::uint32_t>(copies);
        const std::span<const std::byte> contents[] = {std::as_bytes(std::span(&block, 1)), allLatents,
                                                       allWeights};
        for (std::size_t i = 0; i < buffers_.size(); ++i)
            buffers_[i] = RequireDevice(shared_.context->CreateBuffer(contents[i], kSlots[i].kind,
                                                                      harness::BufferMemory::DeviceLocal));
    }

    harness::Image MakeTexture(const Encoding& encoding) const {
        const tool::TextureSet set = tool::LoadTextureSet(encoding.path);
        const LatentTextureSize size =
            tool::Require(GetLatentTextureSize(set.metadata), ExitCode::Failed, encoding.path);
        harness::Image image = RequireDevice(shared_.context->CreateImageArray(
            harness::ImageFormat::BGRA4, size.width, size.height, size.layers, size.levels));
        for (const LatentTextureCopy& copy :
             tool::Require(GetLatentTextureCopies(set.metadata, 0, encoding.record.mips), ExitCode::Failed,
                           encoding.path))
            RequireDevice(shared_.context->Write(
                image, std::span(encoding.int8.latents).subspan(copy.offset, image.GetBytes(copy.level)),
                copy.level));
        return image;
    }

    /// Nanoseconds of each dispatch.
    std::vector<double> Run(std::uint32_t widthAndForm, std::uint32_t groupsX, std::uint32_t groupsY,
                            int repeats) {
        const harness::BoundBuffer bound[] = {
            {0, &buffers_[0]}, {1, &buffers_[1]}, {2, &buffers_[2]}, {3, &shared_.results}};
        harness::DispatchRequest request;
        request.pipeline = &kernel_;
        request.buffers = bound;
        const harness::BoundImage images[] = {{1, &texture_}};
        if (texture_.GetImpl() != nullptr)
            request.images = images;
        request.pushConstants = std::as_bytes(std::span(&widthAndForm, 1));
        request.groups[0] = groupsX;
        request.groups[1] = groupsY;
        return shared_.Time(request, repeats);
    }
    std::vector<double> RunSquare(std::uint32_t side, int repeats) {
        return Run(side, side / (8 * texels_), side / 8, repeats);
    }

    SharedDevice& shared_;
    std::uint32_t width_;
    std::uint32_t texels_; // per invocation
    std::uint32_t side_ = 0;
    harness::ComputePipeline kernel_;
    std::array<harness::Buffer, 3> buffers_;
    harness::Image texture_; ///< of latents that are one
};

class VulkanDevice final : public MeasuredDevice {
public:
    explicit VulkanDevice(const VulkanSettings& settings)
        : settings_(settings), shared_{OpenDevice(settings.device), {}, settings.quick} {
        const harness::DeviceInfo& facts = shared_.GetInfo();
        record_.name = facts.name;
        record_.driver = facts.driver;
        record_.kind = facts.isCpu ? "vulkan on a CPU" : "gpu";
        record_.clock = "timestamps around the dispatch";
        record_.hasCoopVec = facts.cooperativeVectors.hasCooperativeVectors;
        record_.features = std::string("integer dot product: ") +
                           (facts.features.Has(harness::Feature::IntegerDotProduct) ? "yes" : "no") +
                           ", cooperative vectors: " + DescribeVectors() +
                           ", cooperative matrices: " + (facts.hasByteMatrices ? "int8" : "no") +
                           tool::Format(", subgroups of %u", facts.subgroupSize);
    }

    const DeviceRecord& GetRecord() const override { return record_; }
    bool IsSlow() const override { return shared_.GetInfo().isCpu; }
    Repeats GetRepeats() const override {
        if (!IsSlow())
            return {2, 32};
        return settings_.quick ? Repeats{5, 1} : Repeats{7, 1};
    }

    std::unique_ptr<PreparedCase> Prepare(const Case& c, const Encoding& encoding,
                                          std::string& skipped) override {
        if (c.instructions > 0)
            skipped = "instructions of the processor: for the C++ decoder";
        else if (UsesMatrices(c.math))
            return PrepareOnMatrices(shared_, c, encoding, skipped);
        else
            skipped = FindObstacle(c, encoding);
        if (!skipped.empty())
            return nullptr;
        const ShaderRequest request{settings_.sources, "examples/ntc/report/ReportDecode.comp",
                                    settings_.glslang, ListDefines(c, encoding), UsesVectors(c.math)};
        const ShaderResult shader = CompileReportShader(request);
        if (!shader.missing.empty()) {
            skipped = "GL_NV_cooperative_vector: " + shader.missing;
            return nullptr;
        }
        return std::make_unique<VulkanCase>(shared_, c, encoding, shader.words);
    }

    std::vector<std::unique_ptr<PreparedBlocks>>
    PrepareBlocks(const BlockCase& c, const BlockTexture& texture, std::string& skipped) override {
        return PrepareBlocksOnVulkan(shared_, settings_, c, texture, skipped);
    }

private:
    static std::unique_ptr<harness::Context> OpenDevice(const std::string& name) {
        harness::ContextOptions options;
        options.device = name;
        return RequireDevice(harness::Context::Create(options));
    }

    /// Why the case cannot run here, or nothing.
    std::string FindObstacle(const Case& c, const Encoding& encoding) const {
        const harness::DeviceInfo& facts = shared_.GetInfo();
        const CoopVecDevice& vectors = facts.cooperativeVectors;
        const bool hasVectors = vectors.hasCooperativeVectors &&
                                (c.math == NTC_MATH_COOPVEC_FP8 ? vectors.hasE4M3 : vectors.hasInt8);
        if (UsesVectors(c.math) && !hasVectors)
            return "device or feature absent: cooperative vectors";
        if (c.weights != WeightsForm::Default && UsesVectors(c.math))
            return "cooperative vectors fetch their own weights";
        if (c.weights == WeightsForm::SubgroupFloat && !HasWideSubgroups())
            return "subgroups of fewer than 8 lanes";
        if (c.weights == GetDefaultForm(c))
            return "the device's default";
        if (facts.isCpu && (c.weights == WeightsForm::Wide || c.weights == WeightsForm::WideTwoTexels))
            return "wide loads gain nothing on drivers that compile to the CPU";
        const auto width = static_cast<unsigned>(encoding.record.width);
        const auto height = static_cast<unsigned>(encoding.record.height);
        if (!std::has_single_bit(width) || !std::has_single_bit(height) || width < 16 || height < 8)
            return "the pass repeats a texture by powers of two";
        return {};
    }

    std::string DescribeVectors() const {
        const CoopVecDevice& vectors = shared_.GetInfo().cooperativeVectors;
        if (!vectors.hasCooperativeVectors)
            return "no";
        return vectors.hasInt8 && vectors.hasE4M3 ? "int8 and e4m3" : vectors.hasInt8 ? "int8" : "e4m3";
    }

    /// NTC_FETCH_SUBGROUP passes words between 8 lanes.
    bool HasWideSubgroups() const { return shared_.GetInfo().subgroupSize >= 8; }

    /// As permutation/PermutationKey.h chooses for one texel per invocation.
    WeightsForm GetDefaultForm(const Case& c) const {
        if (!shared_.GetInfo().isCpu)
            return WeightsForm::Wide;
        return c.sets == 0 && HasWideSubgroups() ? WeightsForm::SubgroupFloat : WeightsForm::Direct;
    }

    std::vector<std::string> ListDefines(const Case& c, const Encoding& encoding) const {
        const harness::DeviceInfo& facts = shared_.GetInfo();
        std::vector<std::string> defines = {
            "NETWORK_VERSION=" + std::to_string(c.network), "NTC_MATH=" + std::to_string(c.math),
            tool::Format("NTC_OUTPUT_MASK=0x%X", encoding.GetOutputMask(c.outputs))};
        if (c.linear)
            defines.push_back("REPORT_LINEAR=true");
        if (c.latentTexture)
            defines.push_back("NTC_LATENT_FETCH=2");
        if (c.sets > 0)
            defines.push_back("REPORT_BY_INDEX=1");
        if (c.math != NTC_MATH_INT8 && c.math != NTC_MATH_INT8_HALF)
            return defines;
        const WeightsForm form = c.weights != WeightsForm::Default ? c.weights : GetDefaultForm(c);
        if (form == WeightsForm::SubgroupFloat) {
            defines.insert(defines.end(), {"NTC_WEIGHT_FETCH=3", "NTC_SUBGROUP_DECODES_ONE_SET=1",
                                           "NTC_FLOAT_DOT=1", "NTC_WIDE_WEIGHT_LOADS=1"});
            return defines;
        }
        if (facts.features.Has(harness::Feature::IntegerDotProduct))
            defines.push_back("NTC_DOT4_SPIRV=1");
        if (form == WeightsForm::Wide || form == WeightsForm::WideTwoTexels)
            defines.push_back("NTC_WIDE_WEIGHT_LOADS=1");
        if (form == WeightsForm::WideTwoTexels)
            defines.push_back("NTC_TEXELS_PER_INVOCATION=2");
        return defines;
    }

    VulkanSettings settings_;
    SharedDevice shared_;
    DeviceRecord record_;
};

} // namespace

std::unique_ptr<MeasuredDevice> MakeVulkanDevice(const VulkanSettings& settings) {
    return std::make_unique<VulkanDevice>(settings);
}

} // namespace openntc::report
