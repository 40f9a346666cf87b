// SPDX-License-Identifier: MIT
// Pipelines that draw into a colour and a depth image, by dynamic rendering. Images stay in the general layout.
#include "VulkanObjects.h"

#include <algorithm>
#include <array>

namespace openntc::harness {

namespace {

vk::CullModeFlags GetCullMode(Culling culling) {
    switch (culling) {
    case Culling::Front:
        return vk::CullModeFlagBits::eFront;
    case Culling::Back:
        return vk::CullModeFlagBits::eBack;
    case Culling::None:
        break;
    }
    return vk::CullModeFlagBits::eNone;
}

DispatchRequest ToDispatch(const RasterDraw& draw) {
    DispatchRequest dispatch;
    dispatch.pipeline = draw.pipeline;
    dispatch.buffers = draw.buffers;
    dispatch.images = draw.images;
    dispatch.pushConstants = draw.pushConstants;
    return dispatch;
}

vk::PipelineColorBlendAttachmentState MakeBlending(const RasterState& state) {
    vk::PipelineColorBlendAttachmentState blending;
    if (state.writesColor)
        blending.colorWriteMask = vk::ColorComponentFlagBits::eR | vk::ColorComponentFlagBits::eG |
                                  vk::ColorComponentFlagBits::eB | vk::ColorComponentFlagBits::eA;
    if (state.blends) {
        blending.blendEnable = VK_TRUE;
        blending.srcColorBlendFactor = vk::BlendFactor::eSrcAlpha;
        blending.dstColorBlendFactor = vk::BlendFactor::eOneMinusSrcAlpha;
        blending.srcAlphaBlendFactor = vk::BlendFactor::eOne;
        blending.dstAlphaBlendFactor = vk::BlendFactor::eOneMinusSrcAlpha;
    }
    return blending;
}

bool AreSame(const RasterState& a, const RasterState& b) {
    return a.color == b.color && a.culling == b.culling && a.writesDepth == b.writesDepth &&
           a.passesEqual == b.passesEqual && a.writesColor == b.writesColor && a.blends == b.blends;
}

} // namespace

vk::raii::Pipeline Context::Impl::MakeRasterPipeline(const ComputePipeline::Impl& pipeline,
                                                     vk::ShaderModule vertex,
                                                     vk::ShaderModule fragment) const {
    const RasterState& state = pipeline.raster;
    const std::array stages = {
        vk::PipelineShaderStageCreateInfo({}, vk::ShaderStageFlagBits::eVertex, vertex, "main"),
        vk::PipelineShaderStageCreateInfo({}, vk::ShaderStageFlagBits::eFragment, fragment, "main")};
    const vk::PipelineVertexInputStateCreateInfo input;
    const vk::PipelineInputAssemblyStateCreateInfo assembly({}, vk::PrimitiveTopology::eTriangleList);
    vk::PipelineViewportStateCreateInfo viewport;
    viewport.viewportCount = 1;
    viewport.scissorCount = 1;
    vk::PipelineRasterizationStateCreateInfo raster;
    raster.lineWidth = 1;
    raster.cullMode = GetCullMode(state.culling);
    raster.frontFace = vk::FrontFace::eCounterClockwise;
    const vk::PipelineMultisampleStateCreateInfo samples({}, vk::SampleCountFlagBits::e1);
    const vk::PipelineDepthStencilStateCreateInfo depth({}, VK_TRUE, state.writesDepth ? VK_TRUE : VK_FALSE,
                                                        state.passesEqual ? vk::CompareOp::eGreaterOrEqual
                                                                          : vk::CompareOp::eGreater);
    const vk::PipelineColorBlendAttachmentState blending = MakeBlending(state);
    const vk::PipelineColorBlendStateCreateInfo blend({}, VK_FALSE, vk::LogicOp::eClear, blending);
    const std::array dynamic = {vk::DynamicState::eViewport, vk::DynamicState::eScissor};
    const vk::PipelineDynamicStateCreateInfo dynamicInfo({}, dynamic);
    const vk::Format color = GetVulkanFormat(state.color);
    const vk::PipelineRenderingCreateInfo rendering(0, color, vk::Format::eD32Sfloat);
    vk::GraphicsPipelineCreateInfo create;
    create.pNext = &rendering;
    create.setStages(stages);
    create.pVertexInputState = &input;
    create.pInputAssemblyState = &assembly;
    create.pViewportState = &viewport;
    create.pRasterizationState = &raster;
    create.pMultisampleState = &samples;
    create.pDepthStencilState = &depth;
    create.pColorBlendState = &blend;
    create.pDynamicState = &dynamicInfo;
    create.layout = *pipeline.layout;
    return {device, nullptr, create};
}

Expected<void> Context::Impl::CheckRaster(const RasterState& state) const {
    if (!info.features.Has(Feature::DynamicRendering))
        return Fail(Status::Unsupported, "device or feature absent: %s: %s",
                    GetFeatureName(Feature::DynamicRendering),
                    info.features.GetAbsence(Feature::DynamicRendering).c_str());
    const auto families = physicalDevice.getQueueFamilyProperties();
    if (!(families[queueFamily].queueFlags & vk::QueueFlagBits::eGraphics))
        return Fail(Status::Unsupported, "device or feature absent: a queue that draws: %s",
                    info.name.c_str());
    const vk::FormatFeatureFlagBits needed = state.blends ? vk::FormatFeatureFlagBits::eColorAttachmentBlend
                                                          : vk::FormatFeatureFlagBits::eColorAttachment;
    const vk::Format format = GetVulkanFormat(state.color);
    if (!(physicalDevice.getFormatProperties(format).optimalTilingFeatures & needed))
        return Fail(Status::Unsupported, "device or feature absent: %s images of format %d: %s",
                    state.blends ? "blending into" : "drawing into", static_cast<int>(format),
                    info.name.c_str());
    return {};
}

Expected<ComputePipeline> Context::CreateRasterPipeline(std::span<const std::uint32_t> vertexSpirv,
                                                        std::span<const std::uint32_t> fragmentSpirv,
                                                        std::span<const BufferSlot> slots,
                                                        std::uint32_t pushConstantBytes,
                                                        const RasterState& state) {
    OPENNTC_CHECK(impl_->CheckRaster(state));
    std::vector<std::uint32_t> code(vertexSpirv.begin(), vertexSpirv.end());
    code.insert(code.end(), fragmentSpirv.begin(), fragmentSpirv.end());
    for (const auto& known : impl_->pipelines) {
        if (known->isRaster && AreSame(known->raster, state) &&
            known->pushConstantBytes == pushConstantBytes && std::ranges::equal(known->slots, slots) &&
            known->code == code)
            return ComputePipeline(known);
    }
    return Guard("pipeline", [&]() -> Expected<ComputePipeline> {
        auto pipeline = std::make_shared<ComputePipeline::Impl>();
        pipeline->bindPoint = vk::PipelineBindPoint::eGraphics;
        pipeline->stages = vk::ShaderStageFlagBits::eVertex | vk::ShaderStageFlagBits::eFragment;
        pipeline->isRaster = true;
        pipeline->raster = state;
        OPENNTC_CHECK(impl_->FillLayout(*pipeline, code, slots, pushConstantBytes));
        const vk::raii::ShaderModule vertex = impl_->MakeModule(vertexSpirv);
        const vk::raii::ShaderModule fragment = impl_->MakeModule(fragmentSpirv);
        pipeline->pipeline = impl_->MakeRasterPipeline(*pipeline, *vertex, *fragment);
        impl_->pipelines.push_back(pipeline);
        return ComputePipeline(std::move(pipeline));
    });
}

Expected<void> Context::Impl::CheckRequest(const RasterRequest& request) const {
    const auto hasSize = [&](const harness::Image* image) {
        return image != nullptr && image->GetImpl() != nullptr &&
               image->GetWidth() == request.color->GetWidth() &&
               image->GetHeight() == request.color->GetHeight();
    };
    if (request.color == nullptr || !hasSize(request.color) || !hasSize(request.depth) ||
        request.depth->GetImpl()->format != ImageFormat::D32)
        return Fail(Status::InvalidArgument, "draw: images: a colour and a D32 one of the same size");
    for (const RasterDraw& draw : request.draws) {
        OPENNTC_CHECK(CheckRequest(ToDispatch(draw)));
        const ComputePipeline::Impl& pipeline = *draw.pipeline->GetImpl();
        if (!pipeline.isRaster || pipeline.raster.color != request.color->GetImpl()->format)
            return Fail(Status::InvalidArgument,
                        "draw: pipeline: must be of CreateRasterPipeline and for the image's format");
    }
    return {};
}

Expected<DispatchTiming> Context::Draw(const RasterRequest& request) {
    OPENNTC_CHECK(impl_->CheckRequest(request));
    return Guard("draw", [&]() -> Expected<DispatchTiming> {
        std::vector<DispatchRequest> dispatches;
        for (const RasterDraw& draw : request.draws)
            dispatches.push_back(ToDispatch(draw));
        const vk::raii::DescriptorPool pool = impl_->MakePool(dispatches);
        std::vector<std::vector<vk::raii::DescriptorSet>> sets;
        for (const DispatchRequest& dispatch : dispatches)
            sets.push_back(impl_->Bind(dispatch, *pool));
        const vk::Rect2D area({0, 0}, {request.color->GetWidth(), request.color->GetHeight()});
        const auto attach = [&](const Image& image, bool clears) {
            vk::RenderingAttachmentInfo info;
            info.imageView = *image.GetImpl()->mipViews.front();
            info.imageLayout = vk::ImageLayout::eGeneral;
            info.loadOp = clears ? vk::AttachmentLoadOp::eClear : vk::AttachmentLoadOp::eLoad;
            info.storeOp = vk::AttachmentStoreOp::eStore;
            return info;
        };
        const vk::RenderingAttachmentInfo color = attach(*request.color, request.clearsColor),
                                          depth = attach(*request.depth, request.clearsDepth);
        const vk::RenderingInfo rendering({}, area, 1, 0, color, &depth);
        const bool isTimed = impl_->info.hasTimestamps;
        DispatchTiming timing;
        timing.wallSeconds = impl_->Submit([&](const vk::raii::CommandBuffer& target) {
            const vk::MemoryBarrier order(vk::AccessFlagBits::eMemoryWrite,
                                          vk::AccessFlagBits::eMemoryRead | vk::AccessFlagBits::eMemoryWrite);
            if (isTimed)
                target.resetQueryPool(*impl_->queries, 0, 2);
            target.pipelineBarrier(vk::PipelineStageFlagBits::eAllCommands,
                                   vk::PipelineStageFlagBits::eAllCommands, {}, order, {}, {});
            if (isTimed)
                target.writeTimestamp(vk::PipelineStageFlagBits::eBottomOfPipe, *impl_->queries, 0);
            target.beginRendering(rendering);
            target.setViewport(0, vk::Viewport(0, 0, static_cast<float>(area.extent.width),
                                               static_cast<float>(area.extent.height), 0, 1));
            target.setScissor(0, area);
            for (std::size_t i = 0; i < dispatches.size(); ++i) {
                impl_->RecordState(target, dispatches[i], sets[i]);
                target.draw(request.draws[i].vertices, 1, request.draws[i].firstVertex,
                            request.draws[i].instance);
            }
            target.endRendering();
            if (isTimed)
                target.writeTimestamp(vk::PipelineStageFlagBits::eBottomOfPipe, *impl_->queries, 1);
            target.pipelineBarrier(vk::PipelineStageFlagBits::eAllCommands,
                                   vk::PipelineStageFlagBits::eAllCommands, {}, order, {}, {});
        });
        timing.gpuSeconds = impl_->GetGpuSeconds();
        return timing;
    });
}

} // namespace openntc::harness
