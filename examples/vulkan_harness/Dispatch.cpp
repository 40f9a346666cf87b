// SPDX-License-Identifier: MIT
// Descriptors, dispatches and their timing.
#include "VulkanObjects.h"

#include <algorithm>
#include <map>

namespace openntc::harness {

vk::DescriptorType GetDescriptorType(BufferKind kind) {
    switch (kind) {
    case BufferKind::Uniform:
        return vk::DescriptorType::eUniformBuffer;
    case BufferKind::Image:
        return vk::DescriptorType::eStorageImage;
    case BufferKind::Texture:
        return vk::DescriptorType::eSampledImage;
    case BufferKind::FilteredTexture:
        return vk::DescriptorType::eCombinedImageSampler;
    case BufferKind::Storage:
        break;
    }
    return vk::DescriptorType::eStorageBuffer;
}

namespace {

const Buffer* FindBound(const DispatchRequest& request, const BufferSlot& slot, std::uint32_t element) {
    for (const BoundBuffer& bound : request.buffers) {
        if (bound.binding == slot.binding && bound.set == slot.set && bound.element == element)
            return bound.buffer;
    }
    return nullptr;
}

const BoundImage* FindBoundImage(const DispatchRequest& request, const BufferSlot& slot,
                                 std::uint32_t element) {
    for (const BoundImage& bound : request.images) {
        if (bound.binding == slot.binding && bound.set == slot.set && bound.element == element)
            return &bound;
    }
    return nullptr;
}

bool IsOfImages(const BufferSlot& slot) {
    return slot.kind == BufferKind::Image || slot.kind == BufferKind::Texture ||
           slot.kind == BufferKind::FilteredTexture;
}

bool IsBound(const DispatchRequest& request, const BufferSlot& slot, std::uint32_t element) {
    if (IsOfImages(slot)) {
        const BoundImage* const bound = FindBoundImage(request, slot, element);
        return bound != nullptr && bound->mip < bound->image->GetMips() &&
               (slot.kind != BufferKind::Image || bound->image->GetLayers() == 0);
    }
    const Buffer* const bound = FindBound(request, slot, element);
    return bound != nullptr && bound->GetImpl() != nullptr && bound->GetImpl()->kind == slot.kind;
}

} // namespace

Expected<void> Context::Impl::CheckRequest(const DispatchRequest& request) const {
    const ComputePipeline::Impl* pipeline =
        request.pipeline != nullptr ? request.pipeline->GetImpl() : nullptr;
    if (pipeline == nullptr)
        return Fail(Status::InvalidArgument, "dispatch: pipeline: must not be null");
    if (request.pushConstants.size() != pipeline->pushConstantBytes) {
        return Fail(Status::InvalidArgument, "dispatch: %zu bytes of push constants: the pipeline has %u",
                    request.pushConstants.size(), pipeline->pushConstantBytes);
    }
    for (int axis = 0; axis < 3; ++axis) {
        if (request.groups[axis] == 0 || request.groups[axis] > info.maxWorkgroupCount[axis]) {
            return Fail(Status::OutOfRange, "dispatch: %u groups: 1 ... %u", request.groups[axis],
                        info.maxWorkgroupCount[axis]);
        }
    }
    return CheckBindings(request);
}

Expected<void> Context::Impl::CheckBindings(const DispatchRequest& request) const {
    if (request.pipeline == nullptr || request.pipeline->GetImpl() == nullptr)
        return Fail(Status::InvalidArgument, "dispatch: pipeline: must not be null");
    for (const BufferSlot& slot : request.pipeline->GetImpl()->slots) {
        for (std::uint32_t element = 0; element < slot.count; ++element) {
            if (!IsBound(request, slot, element))
                return Fail(Status::InvalidArgument,
                            "dispatch: set %u, binding %u, element %u: nothing of its kind given", slot.set,
                            slot.binding, element);
        }
    }
    return {};
}

std::vector<vk::raii::DescriptorSet> Context::Impl::Bind(const DispatchRequest& request,
                                                         vk::DescriptorPool pool) {
    const ComputePipeline::Impl& pipeline = *request.pipeline->GetImpl();
    std::vector<vk::DescriptorSetLayout> setLayouts;
    for (const vk::raii::DescriptorSetLayout& setLayout : pipeline.setLayouts)
        setLayouts.push_back(*setLayout);
    std::vector<vk::raii::DescriptorSet> sets; // none, if everything is found by address
    if (!setLayouts.empty())
        sets = vk::raii::DescriptorSets(device, vk::DescriptorSetAllocateInfo(pool, setLayouts));
    std::vector<vk::DescriptorBufferInfo> buffers;
    std::vector<vk::DescriptorImageInfo> images;
    for (const BufferSlot& slot : pipeline.slots) {
        for (std::uint32_t element = 0; element < slot.count; ++element) {
            if (IsOfImages(slot)) {
                const BoundImage& bound = *FindBoundImage(request, slot, element);
                const Image::Impl& image = *bound.image->GetImpl();
                images.emplace_back(slot.kind == BufferKind::FilteredTexture ? *sampler : vk::Sampler(),
                                    slot.kind == BufferKind::Image ? *image.mipViews[bound.mip] : *image.view,
                                    vk::ImageLayout::eGeneral);
            } else
                buffers.emplace_back(*FindBound(request, slot, element)->GetImpl()->buffer, 0, VK_WHOLE_SIZE);
        }
    }
    std::vector<vk::WriteDescriptorSet> writes;
    const vk::DescriptorBufferInfo* next = buffers.data();
    const vk::DescriptorImageInfo* nextImage = images.data();
    for (const BufferSlot& slot : pipeline.slots) {
        const bool isImage = IsOfImages(slot);
        writes.emplace_back(*sets[slot.set], slot.binding, 0u, slot.count, GetDescriptorType(slot.kind),
                            isImage ? nextImage : nullptr, isImage ? nullptr : next);
        if (isImage)
            nextImage += slot.count;
        else
            next += slot.count;
    }
    device.updateDescriptorSets(writes, {});
    return sets;
}

void Context::Impl::RecordState(const vk::raii::CommandBuffer& target, const DispatchRequest& request,
                                const std::vector<vk::raii::DescriptorSet>& sets) const {
    const ComputePipeline::Impl& pipeline = *request.pipeline->GetImpl();
    target.bindPipeline(pipeline.bindPoint, *pipeline.pipeline);
    std::vector<vk::DescriptorSet> handles;
    for (const vk::raii::DescriptorSet& set : sets)
        handles.push_back(*set);
    if (!handles.empty())
        target.bindDescriptorSets(pipeline.bindPoint, *pipeline.layout, 0, handles, {});
    if (!request.pushConstants.empty()) {
        target.pushConstants<std::byte>(
            *pipeline.layout, pipeline.stages, 0,
            vk::ArrayProxy<const std::byte>(static_cast<std::uint32_t>(request.pushConstants.size()),
                                            request.pushConstants.data()));
    }
}

std::vector<double> Context::Impl::GetSeconds(const vk::raii::QueryPool& pool, std::uint32_t pairs) const {
    const auto [result, ticks] =
        pool.getResults<std::uint64_t>(0, 2 * pairs, 2 * pairs * sizeof(std::uint64_t), sizeof(std::uint64_t),
                                       vk::QueryResultFlagBits::e64 | vk::QueryResultFlagBits::eWait);
    std::vector<double> seconds;
    if (result != vk::Result::eSuccess)
        return seconds;
    // The difference modulo 2^bits survives one wrap of the counter.
    const std::uint32_t bits = info.timestampValidBits;
    const std::uint64_t mask = bits >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << bits) - 1;
    for (std::uint32_t i = 0; i < pairs; ++i)
        seconds.push_back(static_cast<double>((ticks[2 * i + 1] - ticks[2 * i]) & mask) *
                          info.timestampPeriodNanoseconds * 1e-9);
    return seconds;
}

std::optional<double> Context::Impl::GetGpuSeconds() const {
    if (!info.hasTimestamps)
        return std::nullopt;
    const std::vector<double> seconds = GetSeconds(queries, 1);
    return seconds.empty() ? std::nullopt : std::optional(seconds.front());
}

Expected<DispatchTiming> Context::Dispatch(const DispatchRequest& request) {
    OPENNTC_CHECK(impl_->CheckRequest(request));
    if (request.pipeline->GetImpl()->bindPoint != vk::PipelineBindPoint::eCompute)
        return Fail(Status::InvalidArgument, "dispatch: pipeline: must be a compute pipeline");
    return Guard("dispatch", [&]() -> Expected<DispatchTiming> {
        const std::vector<vk::raii::DescriptorSet> sets = impl_->Bind(request, *impl_->descriptorPool);
        DispatchTiming timing;
        timing.wallSeconds = impl_->Submit([&](const vk::raii::CommandBuffer& target) {
            impl_->RecordState(target, request, sets);
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
        timing.gpuSeconds = impl_->GetGpuSeconds();
        return timing;
    });
}

vk::raii::DescriptorPool Context::Impl::MakePool(std::span<const DispatchRequest> requests) const {
    std::map<vk::DescriptorType, std::uint32_t> counts;
    std::uint32_t sets = 0;
    for (const DispatchRequest& request : requests) {
        sets += static_cast<std::uint32_t>(request.pipeline->GetImpl()->setLayouts.size());
        for (const BufferSlot& slot : request.pipeline->GetImpl()->slots)
            counts[GetDescriptorType(slot.kind)] += slot.count;
    }
    std::vector<vk::DescriptorPoolSize> sizes;
    for (const auto& [type, count] : counts)
        sizes.emplace_back(type, count);
    return {device, vk::DescriptorPoolCreateInfo(vk::DescriptorPoolCreateFlagBits::eFreeDescriptorSet,
                                                 std::max(sets, 1u), sizes)};
}

Expected<BatchTiming> Context::DispatchBatch(std::span<const DispatchRequest> requests) {
    for (const DispatchRequest& request : requests) {
        OPENNTC_CHECK(impl_->CheckRequest(request));
        if (request.pipeline->GetImpl()->bindPoint != vk::PipelineBindPoint::eCompute)
            return Fail(Status::InvalidArgument, "dispatch: pipeline: must be a compute pipeline");
    }
    if (requests.empty())
        return BatchTiming{};
    return Guard("dispatch", [&]() -> Expected<BatchTiming> {
        const vk::raii::DescriptorPool pool = impl_->MakePool(requests);
        std::vector<std::vector<vk::raii::DescriptorSet>> sets;
        for (const DispatchRequest& request : requests)
            sets.push_back(impl_->Bind(request, *pool));
        const auto count = static_cast<std::uint32_t>(requests.size());
        const auto begins = [&](std::uint32_t i) { return i == 0 || !requests[i].overlapsPrevious; };
        std::uint32_t groups = 0;
        for (std::uint32_t i = 0; i < count; ++i)
            groups += begins(i) ? 1 : 0;
        const bool isTimed = impl_->info.hasTimestamps;
        vk::raii::QueryPool queries = nullptr;
        if (isTimed)
            queries = vk::raii::QueryPool(impl_->device,
                                          vk::QueryPoolCreateInfo({}, vk::QueryType::eTimestamp, 2 * groups));
        BatchTiming timing;
        timing.wallSeconds = impl_->Submit([&](const vk::raii::CommandBuffer& target) {
            if (isTimed)
                target.resetQueryPool(*queries, 0, 2 * groups);
            const vk::MemoryBarrier between(vk::AccessFlagBits::eShaderWrite,
                                            vk::AccessFlagBits::eShaderWrite |
                                                vk::AccessFlagBits::eShaderRead |
                                                vk::AccessFlagBits::eMemoryRead);
            std::uint32_t query = 0;
            for (std::uint32_t i = 0; i < count; ++i) {
                const DispatchRequest& request = requests[i];
                impl_->RecordState(target, request, sets[i]);
                if (begins(i)) {
                    target.pipelineBarrier(vk::PipelineStageFlagBits::eAllCommands,
                                           vk::PipelineStageFlagBits::eAllCommands, {}, between, {}, {});
                    if (isTimed)
                        target.writeTimestamp(vk::PipelineStageFlagBits::eBottomOfPipe, *queries, query++);
                }
                target.dispatch(request.groups[0], request.groups[1], request.groups[2]);
                if (isTimed && (i + 1 == count || begins(i + 1)))
                    target.writeTimestamp(vk::PipelineStageFlagBits::eBottomOfPipe, *queries, query++);
            }
            target.pipelineBarrier(vk::PipelineStageFlagBits::eComputeShader,
                                   vk::PipelineStageFlagBits::eAllCommands | vk::PipelineStageFlagBits::eHost,
                                   {}, between, {}, {});
        });
        if (isTimed)
            timing.gpuSeconds = impl_->GetSeconds(queries, groups);
        return timing;
    });
}

Expected<std::vector<double>> Context::TimeDispatches(const DispatchRequest& request,
                                                      std::uint32_t repetitions) {
    if (!impl_->info.hasTimestamps)
        return Fail(Status::Unsupported, "device or feature absent: timestamps: %s",
                    impl_->info.name.c_str());
    OPENNTC_CHECK(impl_->CheckRequest(request));
    return Guard("dispatch", [&]() -> Expected<std::vector<double>> {
        const std::vector<vk::raii::DescriptorSet> sets = impl_->Bind(request, *impl_->descriptorPool);
        std::vector<double> seconds;
        while (seconds.size() < repetitions) {
            const std::uint32_t batch =
                std::min(kTimedBatch, repetitions - static_cast<std::uint32_t>(seconds.size()));
            impl_->Submit([&](const vk::raii::CommandBuffer& target) {
                target.resetQueryPool(*impl_->queries, 0, 2 * batch);
                impl_->RecordState(target, request, sets);
                const vk::MemoryBarrier between(vk::AccessFlagBits::eShaderWrite,
                                                vk::AccessFlagBits::eShaderWrite |
                                                    vk::AccessFlagBits::eShaderRead |
                                                    vk::AccessFlagBits::eMemoryRead);
                for (std::uint32_t i = 0; i < batch; ++i) {
                    target.pipelineBarrier(vk::PipelineStageFlagBits::eAllCommands,
                                           vk::PipelineStageFlagBits::eAllCommands, {}, between, {}, {});
                    target.writeTimestamp(vk::PipelineStageFlagBits::eBottomOfPipe, *impl_->queries, 2 * i);
                    target.dispatch(request.groups[0], request.groups[1], request.groups[2]);
                    target.writeTimestamp(vk::PipelineStageFlagBits::eBottomOfPipe, *impl_->queries,
                                          2 * i + 1);
                }
                target.pipelineBarrier(vk::PipelineStageFlagBits::eComputeShader,
                                       vk::PipelineStageFlagBits::eAllCommands |
                                           vk::PipelineStageFlagBits::eHost,
                                       {}, between, {}, {});
            });
            const std::vector<double> part = impl_->GetSeconds(impl_->queries, batch);
            if (part.size() != batch)
                return Fail(Status::UnknownError, "dispatch: timestamps: not available");
            seconds.insert(seconds.end(), part.begin(), part.end());
        }
        return seconds;
    });
}

} // namespace openntc::harness
