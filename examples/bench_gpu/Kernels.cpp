// SPDX-License-Identifier: MIT
// Pipelines and timed dispatches.
#include "DeviceObjects.h"

#include <algorithm>
#include <chrono>

namespace openntc::bench {

Kernel Device::CreateKernel(std::span<const std::uint32_t> spirv, bool uniformWeights) {
    Kernel kernel;
    kernel.uniformWeights = uniformWeights;
    VkDescriptorSetLayoutBinding bindings[4] = {};
    for (std::uint32_t i = 0; i < 4; ++i) {
        const bool uniform = i == 0 || (i == 2 && uniformWeights);
        bindings[i].binding = i;
        bindings[i].descriptorType =
            uniform ? VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER : VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
        bindings[i].descriptorCount = 1;
        bindings[i].stageFlags = VK_SHADER_STAGE_COMPUTE_BIT;
    }
    VkDescriptorSetLayoutCreateInfo setInfo = {};
    setInfo.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO;
    setInfo.bindingCount = 4;
    setInfo.pBindings = bindings;
    VkDescriptorSetLayout setLayout = VK_NULL_HANDLE;
    Check(impl_->vkCreateDescriptorSetLayout(impl_->device, &setInfo, nullptr, &setLayout), "set layout");
    const VkPushConstantRange range = {VK_SHADER_STAGE_COMPUTE_BIT, 0, 4};
    VkPipelineLayoutCreateInfo layoutInfo = {};
    layoutInfo.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO;
    layoutInfo.setLayoutCount = 1;
    layoutInfo.pSetLayouts = &setLayout;
    layoutInfo.pushConstantRangeCount = 1;
    layoutInfo.pPushConstantRanges = &range;
    VkPipelineLayout layout = VK_NULL_HANDLE;
    Check(impl_->vkCreatePipelineLayout(impl_->device, &layoutInfo, nullptr, &layout), "pipeline layout");
    VkShaderModuleCreateInfo moduleInfo = {};
    moduleInfo.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO;
    moduleInfo.codeSize = spirv.size_bytes();
    moduleInfo.pCode = spirv.data();
    VkShaderModule module = VK_NULL_HANDLE;
    Check(impl_->vkCreateShaderModule(impl_->device, &moduleInfo, nullptr, &module), "shader module");
    VkComputePipelineCreateInfo info = {};
    info.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO;
    if (impl_->hasStatistics)
        info.flags = VK_PIPELINE_CREATE_CAPTURE_STATISTICS_BIT_KHR;
    info.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
    info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
    info.stage.module = module;
    info.stage.pName = "main";
    info.layout = layout;
    VkPipeline pipeline = VK_NULL_HANDLE;
    const auto start = std::chrono::steady_clock::now();
    const VkResult result =
        impl_->vkCreateComputePipelines(impl_->device, VK_NULL_HANDLE, 1, &info, nullptr, &pipeline);
    kernel.creationSeconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    impl_->vkDestroyShaderModule(impl_->device, module, nullptr);
    kernel.layout = ToNumber(layout);
    kernel.setLayout = ToNumber(setLayout);
    if (result != VK_SUCCESS) {
        kernel.error = "vkCreateComputePipelines: " + std::to_string(result);
        return kernel;
    }
    kernel.pipeline = ToNumber(pipeline);
    if (impl_->hasStatistics) {
        VkPipelineExecutableInfoKHR executable = {};
        executable.sType = VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_INFO_KHR;
        executable.pipeline = pipeline;
        VkPipelineExecutableStatisticKHR empty = {};
        empty.sType = VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_STATISTIC_KHR;
        std::vector<VkPipelineExecutableStatisticKHR> list(32, empty);
        std::uint32_t count = 32;
        if (impl_->getStatistics(impl_->device, &executable, &count, list.data()) >= 0) {
            for (std::uint32_t i = 0; i < count; ++i)
                kernel.statistics +=
                    (i > 0 ? ", " : "") + std::string(list[i].name) + " " +
                    std::to_string(list[i].value.u64 & 0xFFFFFFFFu); // NVIDIA's driver sets bits above
        }
    }
    return kernel;
}

void Device::DestroyKernel(Kernel& kernel) {
    impl_->vkDestroyPipeline(impl_->device, FromNumber<VkPipeline>(kernel.pipeline), nullptr);
    impl_->vkDestroyPipelineLayout(impl_->device, FromNumber<VkPipelineLayout>(kernel.layout), nullptr);
    impl_->vkDestroyDescriptorSetLayout(impl_->device, FromNumber<VkDescriptorSetLayout>(kernel.setLayout),
                                        nullptr);
    kernel = {};
}

std::vector<double> Device::Run(const Kernel& kernel, std::span<const DeviceBuffer> buffers,
                                std::uint32_t width, std::uint32_t groupsX, std::uint32_t groupsY,
                                int repetitions) {
    Check(impl_->vkResetDescriptorPool(impl_->device, impl_->descriptors, 0), "vkResetDescriptorPool");
    VkDescriptorSetLayout setLayout = FromNumber<VkDescriptorSetLayout>(kernel.setLayout);
    VkDescriptorSetAllocateInfo allocation = {};
    allocation.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO;
    allocation.descriptorPool = impl_->descriptors;
    allocation.descriptorSetCount = 1;
    allocation.pSetLayouts = &setLayout;
    VkDescriptorSet set = VK_NULL_HANDLE;
    Check(impl_->vkAllocateDescriptorSets(impl_->device, &allocation, &set), "vkAllocateDescriptorSets");
    for (std::uint32_t i = 0; i < buffers.size(); ++i) {
        const VkDescriptorBufferInfo bound = {FromNumber<VkBuffer>(buffers[i].handle), 0, VK_WHOLE_SIZE};
        VkWriteDescriptorSet write = {};
        write.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET;
        write.dstSet = set;
        write.dstBinding = i;
        write.descriptorCount = 1;
        const bool uniform = i == 0 || (i == 2 && kernel.uniformWeights);
        write.descriptorType =
            uniform ? VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER : VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
        write.pBufferInfo = &bound;
        impl_->vkUpdateDescriptorSets(impl_->device, 1, &write, 0, nullptr);
    }
    std::vector<double> milliseconds;
    // A batch is one submission, so that the device does not idle and lower its clocks between dispatches.
    while (milliseconds.size() < static_cast<std::size_t>(repetitions)) {
        const std::uint32_t batch = static_cast<std::uint32_t>(
            std::min<std::size_t>(kBatch, static_cast<std::size_t>(repetitions) - milliseconds.size()));
        impl_->Begin();
        impl_->vkCmdResetQueryPool(impl_->commands, impl_->queries, 0, 2 * kBatch);
        impl_->vkCmdBindPipeline(impl_->commands, VK_PIPELINE_BIND_POINT_COMPUTE,
                                 FromNumber<VkPipeline>(kernel.pipeline));
        VkPipelineLayout layout = FromNumber<VkPipelineLayout>(kernel.layout);
        impl_->vkCmdBindDescriptorSets(impl_->commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout, 0, 1, &set, 0,
                                       nullptr);
        impl_->vkCmdPushConstants(impl_->commands, layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, 4, &width);
        VkMemoryBarrier barrier = {};
        barrier.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER;
        barrier.srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT;
        barrier.dstAccessMask = VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_SHADER_READ_BIT;
        for (std::uint32_t i = 0; i < batch; ++i) {
            impl_->vkCmdPipelineBarrier(impl_->commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                                        VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 1, &barrier, 0, nullptr, 0,
                                        nullptr);
            impl_->vkCmdWriteTimestamp(impl_->commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, impl_->queries,
                                       2 * i);
            impl_->vkCmdDispatch(impl_->commands, groupsX, groupsY, 1);
            impl_->vkCmdWriteTimestamp(impl_->commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, impl_->queries,
                                       2 * i + 1);
        }
        impl_->EndAndWait();
        std::uint64_t ticks[2 * kBatch] = {};
        Check(impl_->vkGetQueryPoolResults(impl_->device, impl_->queries, 0, 2 * batch, sizeof ticks, ticks,
                                           8, VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT),
              "vkGetQueryPoolResults");
        for (std::uint32_t i = 0; i < batch; ++i)
            milliseconds.push_back(static_cast<double>(ticks[2 * i + 1] - ticks[2 * i]) *
                                   impl_->nanosecondsPerTick * 1e-6);
    }
    return milliseconds;
}

} // namespace openntc::bench
