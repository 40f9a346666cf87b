// SPDX-License-Identifier: MIT
// Pipelines that draw and that trace rays, for shaders that must run there too. They write buffers only.
#include "VulkanObjects.h"

#include <algorithm>
#include <array>
#include <cstring>

namespace openntc::harness {

namespace {

Expected<void> CheckSize(const PictureRequest& request, std::uint32_t limit) {
    if (request.width < 1 || request.height < 1 || request.width > limit || request.height > limit)
        return Fail(Status::OutOfRange, "picture: %u x %u: 1 ... %u", request.width, request.height, limit);
    return {};
}

DispatchRequest ToDispatch(const PictureRequest& request) {
    DispatchRequest dispatch;
    dispatch.pipeline = request.pipeline;
    dispatch.buffers = request.buffers;
    dispatch.pushConstants = request.pushConstants;
    return dispatch;
}

void RecordWrites(const vk::raii::CommandBuffer& target, vk::PipelineStageFlagBits stage) {
    const vk::MemoryBarrier after(vk::AccessFlagBits::eShaderWrite,
                                  vk::AccessFlagBits::eHostRead | vk::AccessFlagBits::eMemoryRead);
    target.pipelineBarrier(stage, vk::PipelineStageFlagBits::eAllCommands | vk::PipelineStageFlagBits::eHost,
                           {}, after, {}, {});
}

} // namespace

Expected<ComputePipeline> Context::CreateDrawPipeline(std::span<const std::uint32_t> vertexSpirv,
                                                      std::span<const std::uint32_t> fragmentSpirv,
                                                      std::span<const BufferSlot> slots,
                                                      std::uint32_t pushConstantBytes) {
    if (!impl_->info.features.Has(Feature::FragmentStores))
        return Fail(Status::Unsupported, "device or feature absent: %s: %s",
                    GetFeatureName(Feature::FragmentStores),
                    impl_->info.features.GetAbsence(Feature::FragmentStores).c_str());
    const auto families = impl_->physicalDevice.getQueueFamilyProperties();
    if (!(families[impl_->queueFamily].queueFlags & vk::QueueFlagBits::eGraphics))
        return Fail(Status::Unsupported, "device or feature absent: a queue that draws: %s",
                    impl_->info.name.c_str());
    std::vector<std::uint32_t> code(vertexSpirv.begin(), vertexSpirv.end());
    code.insert(code.end(), fragmentSpirv.begin(), fragmentSpirv.end());
    if (auto known = impl_->FindPipeline(vk::PipelineBindPoint::eGraphics, code, slots, pushConstantBytes))
        return ComputePipeline(std::move(known));
    return Guard("pipeline", [&]() -> Expected<ComputePipeline> {
        auto pipeline = std::make_shared<ComputePipeline::Impl>();
        pipeline->bindPoint = vk::PipelineBindPoint::eGraphics;
        pipeline->stages = vk::ShaderStageFlagBits::eVertex | vk::ShaderStageFlagBits::eFragment;
        OPENNTC_CHECK(impl_->FillLayout(*pipeline, code, slots, pushConstantBytes));
        const vk::SubpassDescription subpass({}, vk::PipelineBindPoint::eGraphics);
        pipeline->renderPass =
            vk::raii::RenderPass(impl_->device, vk::RenderPassCreateInfo({}, {}, subpass, {}));
        const vk::raii::ShaderModule vertex = impl_->MakeModule(vertexSpirv);
        const vk::raii::ShaderModule fragment = impl_->MakeModule(fragmentSpirv);
        const std::array stages = {
            vk::PipelineShaderStageCreateInfo({}, vk::ShaderStageFlagBits::eVertex, *vertex, "main"),
            vk::PipelineShaderStageCreateInfo({}, vk::ShaderStageFlagBits::eFragment, *fragment, "main")};
        const vk::PipelineVertexInputStateCreateInfo input;
        const vk::PipelineInputAssemblyStateCreateInfo assembly({}, vk::PrimitiveTopology::eTriangleList);
        vk::PipelineViewportStateCreateInfo viewport;
        viewport.viewportCount = 1;
        viewport.scissorCount = 1;
        vk::PipelineRasterizationStateCreateInfo raster;
        raster.lineWidth = 1;
        const vk::PipelineMultisampleStateCreateInfo samples({}, vk::SampleCountFlagBits::e1);
        const vk::PipelineColorBlendStateCreateInfo blend;
        const std::array dynamic = {vk::DynamicState::eViewport, vk::DynamicState::eScissor};
        const vk::PipelineDynamicStateCreateInfo dynamicInfo({}, dynamic);
        vk::GraphicsPipelineCreateInfo info;
        info.setStages(stages);
        info.pVertexInputState = &input;
        info.pInputAssemblyState = &assembly;
        info.pViewportState = &viewport;
        info.pRasterizationState = &raster;
        info.pMultisampleState = &samples;
        info.pColorBlendState = &blend;
        info.pDynamicState = &dynamicInfo;
        info.layout = *pipeline->layout;
        info.renderPass = *pipeline->renderPass;
        pipeline->pipeline = vk::raii::Pipeline(impl_->device, nullptr, info);
        impl_->pipelines.push_back(pipeline);
        return ComputePipeline(std::move(pipeline));
    });
}

Expected<ComputePipeline> Context::CreateRayPipeline(std::span<const std::uint32_t> spirv,
                                                     std::span<const BufferSlot> slots,
                                                     std::uint32_t pushConstantBytes) {
    if (!impl_->info.features.Has(Feature::RayTracing))
        return Fail(Status::Unsupported, "device or feature absent: %s: %s",
                    GetFeatureName(Feature::RayTracing),
                    impl_->info.features.GetAbsence(Feature::RayTracing).c_str());
    if (auto known =
            impl_->FindPipeline(vk::PipelineBindPoint::eRayTracingKHR, spirv, slots, pushConstantBytes))
        return ComputePipeline(std::move(known));
    return Guard("pipeline", [&]() -> Expected<ComputePipeline> {
        auto pipeline = std::make_shared<ComputePipeline::Impl>();
        pipeline->bindPoint = vk::PipelineBindPoint::eRayTracingKHR;
        pipeline->stages = vk::ShaderStageFlagBits::eRaygenKHR;
        OPENNTC_CHECK(impl_->FillLayout(*pipeline, spirv, slots, pushConstantBytes));
        const vk::raii::ShaderModule module = impl_->MakeModule(spirv);
        const vk::PipelineShaderStageCreateInfo stage({}, vk::ShaderStageFlagBits::eRaygenKHR, *module,
                                                      "main");
        vk::RayTracingShaderGroupCreateInfoKHR group;
        group.type = vk::RayTracingShaderGroupTypeKHR::eGeneral;
        group.generalShader = 0;
        group.closestHitShader = group.anyHitShader = group.intersectionShader = VK_SHADER_UNUSED_KHR;
        vk::RayTracingPipelineCreateInfoKHR info;
        info.setStages(stage);
        info.setGroups(group);
        info.maxPipelineRayRecursionDepth = 1;
        info.layout = *pipeline->layout;
        pipeline->pipeline = vk::raii::Pipeline(impl_->device, nullptr, nullptr, info);

        const auto properties = impl_->physicalDevice
                                    .getProperties2<vk::PhysicalDeviceProperties2,
                                                    vk::PhysicalDeviceRayTracingPipelinePropertiesKHR>()
                                    .get<vk::PhysicalDeviceRayTracingPipelinePropertiesKHR>();
        const std::uint32_t size = properties.shaderGroupHandleSize;
        const std::uint64_t alignment = properties.shaderGroupBaseAlignment;
        const std::vector<std::byte> handle =
            pipeline->pipeline.getRayTracingShaderGroupHandlesKHR<std::byte>(0, 1, size);
        pipeline->shaderTable = impl_->MakeBuffer(
            size + alignment, BufferKind::Storage,
            vk::BufferUsageFlagBits::eShaderBindingTableKHR | vk::BufferUsageFlagBits::eShaderDeviceAddress,
            vk::MemoryPropertyFlagBits::eHostVisible | vk::MemoryPropertyFlagBits::eHostCoherent);
        const std::uint64_t address = pipeline->shaderTable->address;
        const std::uint64_t aligned = (address + alignment - 1) / alignment * alignment;
        std::memcpy(pipeline->shaderTable->mapped + (aligned - address), handle.data(), handle.size());
        pipeline->rayGeneration = vk::StridedDeviceAddressRegionKHR(aligned, size, size);
        impl_->pipelines.push_back(pipeline);
        return ComputePipeline(std::move(pipeline));
    });
}

Expected<void> Context::Draw(const PictureRequest& request) {
    const DispatchRequest dispatch = ToDispatch(request);
    OPENNTC_CHECK(impl_->CheckRequest(dispatch));
    const ComputePipeline::Impl& pipeline = *request.pipeline->GetImpl();
    if (pipeline.bindPoint != vk::PipelineBindPoint::eGraphics)
        return Fail(Status::InvalidArgument, "draw: pipeline: must be one of CreateDrawPipeline");
    const vk::PhysicalDeviceLimits limits = impl_->physicalDevice.getProperties().limits;
    OPENNTC_CHECK(CheckSize(request, std::min(limits.maxFramebufferWidth, limits.maxFramebufferHeight)));
    return Guard("draw", [&]() -> Expected<void> {
        const std::vector<vk::raii::DescriptorSet> sets = impl_->Bind(dispatch, *impl_->descriptorPool);
        const vk::raii::Framebuffer framebuffer(
            impl_->device,
            vk::FramebufferCreateInfo({}, *pipeline.renderPass, {}, request.width, request.height, 1));
        const vk::Rect2D area({0, 0}, {request.width, request.height});
        impl_->Submit([&](const vk::raii::CommandBuffer& target) {
            target.beginRenderPass(vk::RenderPassBeginInfo(*pipeline.renderPass, *framebuffer, area),
                                   vk::SubpassContents::eInline);
            impl_->RecordState(target, dispatch, sets);
            target.setViewport(0, vk::Viewport(0, 0, static_cast<float>(request.width),
                                               static_cast<float>(request.height), 0, 1));
            target.setScissor(0, area);
            target.draw(request.vertices, 1, 0, 0);
            target.endRenderPass();
            RecordWrites(target, vk::PipelineStageFlagBits::eFragmentShader);
        });
        return {};
    });
}

Expected<void> Context::TraceRays(const PictureRequest& request) {
    const DispatchRequest dispatch = ToDispatch(request);
    OPENNTC_CHECK(impl_->CheckRequest(dispatch));
    const ComputePipeline::Impl& pipeline = *request.pipeline->GetImpl();
    if (pipeline.bindPoint != vk::PipelineBindPoint::eRayTracingKHR)
        return Fail(Status::InvalidArgument, "rays: pipeline: must be one of CreateRayPipeline");
    OPENNTC_CHECK(CheckSize(request, 1u << 15)); // 2^30 rays are what every device launches
    return Guard("rays", [&]() -> Expected<void> {
        const std::vector<vk::raii::DescriptorSet> sets = impl_->Bind(dispatch, *impl_->descriptorPool);
        impl_->Submit([&](const vk::raii::CommandBuffer& target) {
            impl_->RecordState(target, dispatch, sets);
            target.traceRaysKHR(pipeline.rayGeneration, {}, {}, {}, request.width, request.height, 1);
            RecordWrites(target, vk::PipelineStageFlagBits::eRayTracingShaderKHR);
        });
        return {};
    });
}

} // namespace openntc::harness
