// SPDX-License-Identifier: MIT
#include "report/Device.h"

#include "Failure.h"
#include "Interrupt.h"
#include "Output.h"
#include "report/ShaderSource.h"

#include "bench_gpu/Device.h"

#include "openntc/MathModes.h"

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>

namespace openntc::report {

using tool::CommandError;
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

double GetSeconds() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

bool UsesVectors(int math) {
    return math == NTC_MATH_COOPVEC_INT8 || math == NTC_MATH_COOPVEC_FP8;
}

class VulkanDevice final : public MeasuredDevice {
public:
    explicit VulkanDevice(const VulkanSettings& settings) : settings_(settings), device_(settings.device) {
        const bench::DeviceFacts& facts = device_.GetFacts();
        record_.name = facts.name;
        record_.driver = facts.driver;
        record_.kind = facts.isCpu ? "vulkan on a CPU" : "gpu";
        record_.clock = "timestamps around the dispatch";
        record_.features = std::string("integer dot product: ") +
                           (facts.hasIntegerDotProduct ? "yes" : "no") +
                           ", cooperative vectors: " + DescribeVectors() +
                           tool::Format(", subgroups of %u", facts.subgroupSize);
    }
    ~VulkanDevice() override { Release(); }

    const DeviceRecord& GetRecord() const override { return record_; }

    std::string Prepare(const Case& c, const Encoding& encoding) override {
        Release();
        const CoopVecDevice& vectors = device_.GetFacts().cooperativeVectors;
        const bool needsVectors = UsesVectors(c.math);
        if (needsVectors && !(vectors.hasCooperativeVectors &&
                              (c.math == NTC_MATH_COOPVEC_INT8 ? vectors.hasInt8 : vectors.hasE4M3)))
            return "device or feature absent: cooperative vectors";
        if (c.weights != WeightsForm::Default && needsVectors)
            return "cooperative vectors fetch their own weights";
        if (c.weights == GetDefaultForm())
            return "the device's default";
        if (device_.GetFacts().isCpu &&
            (c.weights == WeightsForm::Wide || c.weights == WeightsForm::WideTwoTexels))
            return "wide loads gain nothing on drivers that compile to the CPU";
        if (!std::has_single_bit(static_cast<unsigned>(encoding.record.width)) ||
            !std::has_single_bit(static_cast<unsigned>(encoding.record.height)) ||
            encoding.record.width < 16 || encoding.record.height < 8)
            return "the pass repeats a texture by powers of two";
        ShaderRequest request{settings_.sources, settings_.glslang, ListDefines(c, encoding), needsVectors};
        ShaderResult shader = CompileReportShader(request);
        if (!shader.missing.empty())
            return "GL_NV_cooperative_vector: " + shader.missing;
        kernel_ = device_.CreateKernel(shader.words, false);
        hasKernel_ = true;
        if (!kernel_.error.empty())
            throw CommandError(ExitCode::Failed, record_.name, c.GetId() + ": " + kernel_.error);
        encoding_ = &encoding;
        texels_ = c.weights == WeightsForm::WideTwoTexels ? 2 : 1;
        Upload(c, encoding);
        return {};
    }

    bool IsSlow() const override { return device_.GetFacts().isCpu; }

    std::vector<float> Decode(int rows) override {
        const auto width = static_cast<std::uint32_t>(encoding_->record.width);
        const auto height = static_cast<std::uint32_t>(rows);
        MakeResults(std::uint64_t{width} * height * 64);
        // The first dispatch of drivers that compile late, so that this time is not mistaken for decoding.
        Run(width | kBinary32, 1, 1, 1);
        tool::ThrowIfInterrupted();
        Run(width | kBinary32, width / (8 * texels_), height / 8, 1);
        const std::vector<std::byte> bytes = device_.Read(buffers_[3], std::uint64_t{width} * height * 64);
        std::vector<float> outputs(bytes.size() / sizeof(float));
        std::memcpy(outputs.data(), bytes.data(), bytes.size());
        return outputs;
    }

    Timing Measure() override {
        const bool isCpu = device_.GetFacts().isCpu;
        // A GPU needs many texels to be busy, a driver on the CPU few to be done soon.
        const double wantedNs = isCpu ? (settings_.quick ? 2e7 : 4e7) : 2e6;
        std::uint32_t side = 64;
        MakeResults(std::uint64_t{kMaxSide} * kMaxSide * 32);
        const double first = RunSquare(side, 2).back() / (64.0 * 64.0);
        const std::uint32_t most = isCpu ? 512 : kMaxSide;
        while (side < most && first * 4.0 * side * side <= wantedNs)
            side *= 2;
        if (!isCpu)
            side = std::max(side, 1024u);
        const double texels = static_cast<double>(side) * side;
        if (!isCpu) { // clocks rise first
            const double start = GetSeconds();
            while (GetSeconds() - start < (settings_.quick ? 0.1 : 0.25))
                RunSquare(side, 8);
        }
        const int repeats = isCpu ? (settings_.quick ? 5 : 7) : 64;
        std::vector<double> times = RunSquare(side, repeats);
        for (double& time : times)
            time /= texels;
        return {Summarise(times), std::uint64_t{side} * side};
    }

private:
    static constexpr std::uint32_t kMaxSide = 2048;

    std::string DescribeVectors() const {
        const CoopVecDevice& vectors = device_.GetFacts().cooperativeVectors;
        if (!vectors.hasCooperativeVectors)
            return "no";
        return vectors.hasInt8 && vectors.hasE4M3 ? "int8 and e4m3" : vectors.hasInt8 ? "int8" : "e4m3";
    }

    /// As inference/PermutationKey.h chooses for material shaders, whose neighbours may decode different sets.
    WeightsForm GetDefaultForm() const {
        return device_.GetFacts().isCpu ? WeightsForm::Direct : WeightsForm::Wide;
    }

    std::vector<std::string> ListDefines(const Case& c, const Encoding& encoding) const {
        const bench::DeviceFacts& facts = device_.GetFacts();
        std::vector<std::string> defines = {
            "NETWORK_VERSION=" + std::to_string(c.network), "NTC_MATH=" + std::to_string(c.math),
            tool::Format("NTC_OUTPUT_MASK=0x%X", encoding.GetOutputMask(c.outputs))};
        if (c.linear)
            defines.push_back("REPORT_LINEAR=true");
        if (c.sets > 0)
            defines.push_back("REPORT_BY_INDEX=1");
        if (c.math != NTC_MATH_INT8 && c.math != NTC_MATH_INT8_HALF)
            return defines;
        const WeightsForm form = c.weights != WeightsForm::Default ? c.weights : GetDefaultForm();
        if (form == WeightsForm::SubgroupFloat) {
            defines.insert(defines.end(),
                           {"NTC_WEIGHT_FETCH=3", "NTC_SUBGROUP_DECODES_ONE_SET=1", "NTC_FLOAT_DOT=1"});
            return defines;
        }
        if (facts.hasIntegerDotProduct)
            defines.push_back("NTC_DOT4_SPIRV=1");
        if (form == WeightsForm::Wide || form == WeightsForm::WideTwoTexels)
            defines.push_back("NTC_WIDE_WEIGHT_LOADS=1");
        if (form == WeightsForm::WideTwoTexels)
            defines.push_back("NTC_TEXELS_PER_INVOCATION=2");
        return defines;
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
            weights = device_.ConvertWeights(converted);
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
        Replace(0, std::as_bytes(std::span(&block, 1)));
        Replace(1, allLatents);
        Replace(2, allWeights);
    }

    void Replace(std::size_t index, std::span<const std::byte> contents) {
        if (buffers_[index].handle != 0)
            device_.DestroyBuffer(buffers_[index]);
        buffers_[index] = device_.CreateBuffer(contents.size(), contents);
    }

    void MakeResults(std::uint64_t size) {
        if (buffers_[3].size >= size)
            return;
        if (buffers_[3].handle != 0)
            device_.DestroyBuffer(buffers_[3]);
        buffers_[3] = device_.CreateBuffer(size, {});
    }

    /// Nanoseconds of each dispatch.
    std::vector<double> Run(std::uint32_t widthAndForm, std::uint32_t groupsX, std::uint32_t groupsY,
                            int repeats) {
        std::vector<double> times;
        // One submission on a GPU, whose clocks fall between submissions; one by one where a dispatch takes long.
        const int batch = device_.GetFacts().isCpu ? 1 : repeats;
        for (int done = 0; done < repeats; done += batch) {
            tool::ThrowIfInterrupted();
            for (const double ms : device_.Run(kernel_, buffers_, widthAndForm, groupsX, groupsY, batch))
                times.push_back(1e6 * ms);
        }
        return times;
    }
    std::vector<double> RunSquare(std::uint32_t side, int repeats) {
        return Run(side, side / (8 * texels_), side / 8, repeats);
    }

    void Release() {
        if (hasKernel_)
            device_.DestroyKernel(kernel_);
        hasKernel_ = false;
    }

    VulkanSettings settings_;
    bench::Device device_;
    DeviceRecord record_;
    bench::Kernel kernel_;
    bool hasKernel_ = false;
    std::array<bench::DeviceBuffer, 4> buffers_ = {};
    std::uint32_t texels_ = 1; // per invocation
    const Encoding* encoding_ = nullptr;
};

/// Turns the bench's failures into the command's.
class GuardedDevice final : public MeasuredDevice {
public:
    explicit GuardedDevice(const VulkanSettings& settings) {
        Guard([&] { device_ = std::make_unique<VulkanDevice>(settings); });
    }
    const DeviceRecord& GetRecord() const override { return device_->GetRecord(); }
    std::string Prepare(const Case& c, const Encoding& encoding) override {
        return Guard([&] { return device_->Prepare(c, encoding); });
    }
    std::vector<float> Decode(int rows) override {
        return Guard([&] { return device_->Decode(rows); });
    }
    bool IsSlow() const override { return device_->IsSlow(); }
    Timing Measure() override {
        return Guard([&] { return device_->Measure(); });
    }

private:
    template <typename F>
    auto Guard(F&& work) -> decltype(work()) {
        try {
            return work();
        } catch (const bench::DeviceFailure& failure) {
            const bool absent = std::string_view(failure.what()).starts_with("device or feature absent");
            throw CommandError(absent ? ExitCode::NoDevice : ExitCode::Failed, "vulkan", failure.what());
        }
    }

    std::unique_ptr<VulkanDevice> device_;
};

} // namespace

std::unique_ptr<MeasuredDevice> MakeVulkanDevice(const VulkanSettings& settings) {
    return std::make_unique<GuardedDevice>(settings);
}

} // namespace openntc::report
