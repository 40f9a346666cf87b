// SPDX-License-Identifier: MIT
// Pipelines and dispatches.
#include "VulkanObjects.h"

#include <algorithm>
#include <chrono>

namespace openntc::harness {

namespace {

vk::DescriptorType GetDescriptorType(BufferKind kind) {
    return kind == BufferKind::Uniform ? vk::DescriptorType::eUniformBuffer
                                       : vk::DescriptorType::eStorageBuffer;
}

} // namespace

ComputePipeline::ComputePipeline() noexcept = default;
ComputePipeline::ComputePipeline(std::shared_ptr<const Impl> impl) noexcept : impl_(std::move(impl)) {}
double ComputePipeline::GetCreationSeconds() const noexcept {
    return impl_ ? impl_->creationSeconds : 0;
}

Expected<ComputePipeline> Context::CreateComputePipeline(std::span<const std::uint32_t> spirv,
                                                         std::span<const BufferSlot> slots,
                                                         std::uint32_t pushConstantBytes) {
    if (pushConstantBytes > impl_->info.maxPushConstantBytes) {
        return Fail(Status::Unsupported, "device or feature absent: %u bytes of push constants: %u",
                    pushConstantBytes, impl_->info.maxPushConstantBytes);
    }
    std::uint32_t setCount = 0;
    for (const BufferSlot& slot : slots) {
        if (slot.set >= kMaxDescriptorSets || slot.count < 1)
            return Fail(Status::OutOfRange, "pipeline: set %u, %u buffers: sets 0 ... %u, 1 buffer or more",
                        slot.set, slot.count, kMaxDescriptorSets - 1);
        setCount = std::max(setCount, slot.set + 1);
    }
    for (const std::shared_ptr<const ComputePipeline::Impl>& known : impl_->pipelines) {
        if (known->pushConstantBytes == pushConstantBytes && std::ranges::equal(known->slots, slots) &&
            std::ranges::equal(known->code, spirv))
            return ComputePipeline(known);
    }
    return Guard("pipeline", [&]() -> Expected<ComputePipeline> {
        auto pipeline = std::make_shared<ComputePipeline::Impl>();
        pipeline->code.assign(spirv.begin(), spirv.end());
        pipeline->slots.assign(slots.begin(), slots.end());
        pipeline->pushConstantBytes = pushConstantBytes;
        std::vector<vk::DescriptorSetLayout> setLayouts;
        for (std::uint32_t set = 0; set < setCount; ++set) {
            std::vector<vk::DescriptorSetLayoutBinding> bindings;
            for (const BufferSlot& slot : slots) {
                if (slot.set == set)
                    bindings.emplace_back(slot.binding, GetDescriptorType(slot.kind), slot.count,
                                          vk::ShaderStageFlagBits::eCompute);
            }
            pipeline->setLayouts.emplace_back(impl_->device, vk::DescriptorSetLayoutCreateInfo({}, bindings));
            setLayouts.push_back(*pipeline->setLayouts.back());
        }
        const vk::PushConstantRange range(vk::ShaderStageFlagBits::eCompute, 0, pushConstantBytes);
        vk::PipelineLayoutCreateInfo layoutInfo({}, setLayouts);
        if (pushConstantBytes > 0)
            layoutInfo.setPushConstantRanges(range);
        pipeline->layout = vk::raii::PipelineLayout(impl_->device, layoutInfo);

        vk::ShaderModuleCreateInfo moduleInfo;
        moduleInfo.codeSize = spirv.size_bytes();
        moduleInfo.pCode = spirv.data();
        const vk::raii::ShaderModule module(impl_->device, moduleInfo);
        const vk::PipelineShaderStageCreateInfo stage({}, vk::ShaderStageFlagBits::eCompute, *module, "main");
        const auto start = std::chrono::steady_clock::now();
        pipeline->pipeline = vk::raii::Pipeline(impl_->device, nullptr,
                                                vk::ComputePipelineCreateInfo({}, stage, *pipeline->layout));
        pipeline->creationSeconds =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        impl_->pipelines.push_back(pipeline);
        return ComputePipeline(std::move(pipeline));
    });
}

Expected<DispatchTiming> Context::Dispatch(const DispatchRequest& request) {
    const ComputePipeline::Impl* pipeline =
        request.pipeline != nullptr ? request.pipeline->GetImpl() : nullptr;
    if (pipeline == nullptr)
        return Fail(Status::InvalidArgument, "dispatch: pipeline: must not be null");
    if (request.pushConstants.size() != pipeline->pushConstantBytes) {
        return Fail(Status::InvalidArgument, "dispatch: %zu bytes of push constants: the pipeline has %u",
                    request.pushConstants.size(), pipeline->pushConstantBytes);
    }
    for (int axis = 0; axis < 3; ++axis) {
        if (request.groups[axis] == 0 || request.groups[axis] > impl_->info.maxWorkgroupCount[axis]) {
            return Fail(Status::OutOfRange, "dispatch: %u groups: 1 ... %u", request.groups[axis],
                        impl_->info.maxWorkgroupCount[axis]);
        }
    }
    std::vector<vk::DescriptorBufferInfo> buffers;
    for (const BufferSlot& slot : pipeline->slots) {
        for (std::uint32_t element = 0; element < slot.count; ++element) {
            const auto bound = std::find_if(
                request.buffers.begin(), request.buffers.end(), [&](const BoundBuffer& candidate) {
                    return candidate.binding == slot.binding && candidate.set == slot.set &&
                           candidate.element == element;
                });
            if (bound == request.buffers.end() || bound->buffer == nullptr ||
                bound->buffer->GetImpl() == nullptr || bound->buffer->GetImpl()->kind != slot.kind)
                return Fail(Status::InvalidArgument,
                            "dispatch: set %u, binding %u, element %u: no buffer of its kind given", slot.set,
                            slot.binding, element);
            buffers.emplace_back(*bound->buffer->GetImpl()->buffer, 0, VK_WHOLE_SIZE);
        }
    }

    return Guard("dispatch", [&]() -> Expected<DispatchTiming> {
        std::vector<vk::DescriptorSetLayout> setLayouts;
        for (const vk::raii::DescriptorSetLayout& setLayout : pipeline->setLayouts)
            setLayouts.push_back(*setLayout);
        std::vector<vk::raii::DescriptorSet> sets; // none, if everything is found by address
        if (!setLayouts.empty())
            sets = vk::raii::DescriptorSets(
                impl_->device, vk::DescriptorSetAllocateInfo(*impl_->descriptorPool, setLayouts));
        std::vector<vk::DescriptorSet> handles;
        for (const vk::raii::DescriptorSet& set : sets)
            handles.push_back(*set);
        std::vector<vk::WriteDescriptorSet> writes;
        const vk::DescriptorBufferInfo* next = buffers.data();
        for (const BufferSlot& slot : pipeline->slots) {
            writes.emplace_back(handles[slot.set], slot.binding, 0u, slot.count, GetDescriptorType(slot.kind),
                                nullptr, next);
            next += slot.count;
        }
        impl_->device.updateDescriptorSets(writes, {});

        DispatchTiming timing;
        timing.wallSeconds = impl_->Submit([&](const vk::raii::CommandBuffer& target) {
            target.bindPipeline(vk::PipelineBindPoint::eCompute, *pipeline->pipeline);
            if (!handles.empty())
                target.bindDescriptorSets(vk::PipelineBindPoint::eCompute, *pipeline->layout, 0, handles, {});
            if (!request.pushConstants.empty()) {
                target.pushConstants<std::byte>(
                    *pipeline->layout, vk::ShaderStageFlagBits::eCompute, 0,
                    vk::ArrayProxy<const std::byte>(static_cast<std::uint32_t>(request.pushConstants.size()),
                                                    request.pushConstants.data()));
            }
            if (impl_->info.hasTimestamps) {
                target.resetQueryPool(*impl_->queries, 0, 2);
                target.writeTimestamp(vk::PipelineStageFlagBits::eTopOfPipe, *impl_->queries, 0);
            }
            target.dispatch(request.groups[0], request.groups[1], request.groups[2]);
            if (impl_->info.hasTimestamps)
                target.writeTimestamp(vk::PipelineStageFlagBits::eComputeShader, *impl_->queries, 1);
            const vk::MemoryBarrier after(vk::AccessFlagBits::eShaderWrite,
                                          vk::AccessFlagBits::eHostRead | vk::AccessFlagBits::eMemoryRead);
            target.pipelineBarrier(vk::PipelineStageFlagBits::eComputeShader,
                                   vk::PipelineStageFlagBits::eAllCommands | vk::PipelineStageFlagBits::eHost,
                                   {}, after, {}, {});
        });
        if (impl_->info.hasTimestamps) {
            const auto [result, ticks] = impl_->queries.getResults<std::uint64_t>(
                0, 2, 2 * sizeof(std::uint64_t), sizeof(std::uint64_t), vk::QueryResultFlagBits::e64);
            if (result == vk::Result::eSuccess) {
                // Only the valid bits count; the difference modulo 2^bits survives one wrap of the counter.
                const std::uint32_t bits = impl_->info.timestampValidBits;
                const std::uint64_t mask = bits >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << bits) - 1;
                const std::uint64_t elapsed = (ticks[1] - ticks[0]) & mask;
                timing.gpuSeconds =
                    static_cast<double>(elapsed) * impl_->info.timestampPeriodNanoseconds * 1e-9;
            }
        }
        return timing;
    });
}

} // namespace openntc::harness
