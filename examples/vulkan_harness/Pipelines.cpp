// SPDX-License-Identifier: MIT
// Making compute pipelines.
#include "VulkanObjects.h"

#include <algorithm>
#include <chrono>

namespace openntc::harness {

namespace {

std::string DescribeStatistics(const vk::raii::Device& device, vk::Pipeline pipeline) {
    std::string text;
    for (const vk::PipelineExecutableStatisticKHR& statistic :
         device.getPipelineExecutableStatisticsKHR(vk::PipelineExecutableInfoKHR(pipeline, 0))) {
        // NVIDIA's driver sets bits above.
        text += (text.empty() ? "" : ", ") + std::string(statistic.name.data()) + " " +
                std::to_string(statistic.value.u64 & 0xFFFFFFFFu);
    }
    return text;
}

} // namespace

ComputePipeline::ComputePipeline() noexcept = default;
ComputePipeline::ComputePipeline(std::shared_ptr<const Impl> impl) noexcept : impl_(std::move(impl)) {}
double ComputePipeline::GetCreationSeconds() const noexcept {
    return impl_ ? impl_->creationSeconds : 0;
}

const std::string& ComputePipeline::GetStatistics() const noexcept {
    static const std::string kNone;
    return impl_ ? impl_->statistics : kNone;
}

std::shared_ptr<const ComputePipeline::Impl>
Context::Impl::FindPipeline(vk::PipelineBindPoint bindPoint, std::span<const std::uint32_t> code,
                            std::span<const BufferSlot> slots, std::uint32_t pushConstantBytes) const {
    for (const std::shared_ptr<const ComputePipeline::Impl>& known : pipelines) {
        if (known->bindPoint == bindPoint && known->pushConstantBytes == pushConstantBytes &&
            std::ranges::equal(known->slots, slots) && std::ranges::equal(known->code, code))
            return known;
    }
    return nullptr;
}

Expected<void> Context::Impl::FillLayout(ComputePipeline::Impl& pipeline,
                                         std::span<const std::uint32_t> spirv,
                                         std::span<const BufferSlot> slots,
                                         std::uint32_t pushConstantBytes) const {
    if (pushConstantBytes > info.maxPushConstantBytes) {
        return Fail(Status::Unsupported, "device or feature absent: %u bytes of push constants: %u",
                    pushConstantBytes, info.maxPushConstantBytes);
    }
    std::uint32_t setCount = 0;
    for (const BufferSlot& slot : slots) {
        if (slot.set >= kMaxDescriptorSets || slot.count < 1)
            return Fail(Status::OutOfRange, "pipeline: set %u, %u buffers: sets 0 ... %u, 1 buffer or more",
                        slot.set, slot.count, kMaxDescriptorSets - 1);
        setCount = std::max(setCount, slot.set + 1);
    }
    pipeline.code.assign(spirv.begin(), spirv.end());
    pipeline.slots.assign(slots.begin(), slots.end());
    pipeline.pushConstantBytes = pushConstantBytes;
    std::vector<vk::DescriptorSetLayout> setLayouts;
    for (std::uint32_t set = 0; set < setCount; ++set) {
        std::vector<vk::DescriptorSetLayoutBinding> bindings;
        for (const BufferSlot& slot : slots) {
            if (slot.set == set)
                bindings.emplace_back(slot.binding, GetDescriptorType(slot.kind), slot.count,
                                      pipeline.stages);
        }
        pipeline.setLayouts.emplace_back(device, vk::DescriptorSetLayoutCreateInfo({}, bindings));
        setLayouts.push_back(*pipeline.setLayouts.back());
    }
    const vk::PushConstantRange range(pipeline.stages, 0, pushConstantBytes);
    vk::PipelineLayoutCreateInfo layoutInfo({}, setLayouts);
    if (pushConstantBytes > 0)
        layoutInfo.setPushConstantRanges(range);
    pipeline.layout = vk::raii::PipelineLayout(device, layoutInfo);
    return {};
}

vk::raii::ShaderModule Context::Impl::MakeModule(std::span<const std::uint32_t> spirv) const {
    vk::ShaderModuleCreateInfo moduleInfo;
    moduleInfo.codeSize = spirv.size_bytes();
    moduleInfo.pCode = spirv.data();
    return vk::raii::ShaderModule(device, moduleInfo);
}

Expected<ComputePipeline> Context::CreateComputePipeline(std::span<const std::uint32_t> spirv,
                                                         std::span<const BufferSlot> slots,
                                                         std::uint32_t pushConstantBytes,
                                                         const PipelineOptions& options) {
    if (options.isKept) {
        if (auto known =
                impl_->FindPipeline(vk::PipelineBindPoint::eCompute, spirv, slots, pushConstantBytes))
            return ComputePipeline(std::move(known));
    }
    return Guard("pipeline", [&]() -> Expected<ComputePipeline> {
        auto pipeline = std::make_shared<ComputePipeline::Impl>();
        OPENNTC_CHECK(impl_->FillLayout(*pipeline, spirv, slots, pushConstantBytes));
        const vk::raii::ShaderModule module = impl_->MakeModule(spirv);
        const vk::PipelineShaderStageCreateInfo stage({}, vk::ShaderStageFlagBits::eCompute, *module, "main");
        const auto start = std::chrono::steady_clock::now();
        const bool hasStatistics =
            options.wantsStatistics && impl_->info.features.Has(Feature::PipelineStatistics);
        const vk::PipelineCreateFlags flags =
            hasStatistics ? vk::PipelineCreateFlagBits::eCaptureStatisticsKHR : vk::PipelineCreateFlags();
        pipeline->pipeline = vk::raii::Pipeline(
            impl_->device, nullptr, vk::ComputePipelineCreateInfo(flags, stage, *pipeline->layout));
        pipeline->creationSeconds =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        if (hasStatistics)
            pipeline->statistics = DescribeStatistics(impl_->device, *pipeline->pipeline);
        if (options.isKept)
            impl_->pipelines.push_back(pipeline);
        return ComputePipeline(std::move(pipeline));
    });
}

} // namespace openntc::harness
