// SPDX-License-Identifier: MIT
// Submissions that nobody waits for at once.
#include "VulkanObjects.h"

#include <algorithm>
#include <cstring>

namespace openntc::harness {

struct Sequence::Impl {
    struct Slot {
        vk::raii::CommandBuffer commands = nullptr;
        vk::raii::Fence fence = nullptr;
        std::unique_ptr<Buffer::Impl> staging; ///< of large writes
    };
    const vk::raii::Device* device = nullptr;
    vk::raii::DescriptorPool pool = nullptr;
    std::vector<std::vector<vk::raii::DescriptorSet>> sets; ///< of each pass
    std::vector<const ComputePipeline::Impl*> pipelines;
    Slot slots[kSequenceSubmissions];
    std::uint64_t submitted = 0;
    std::uint64_t ended = 0; ///< submissions that were waited for

    /// Throws what Vulkan throws.
    void Wait(std::uint64_t submissions) {
        for (; ended < std::min(submissions, submitted); ++ended) {
            const vk::raii::Fence& fence = slots[ended % kSequenceSubmissions].fence;
            while (device->waitForFences(*fence, VK_TRUE, 1'000'000'000) == vk::Result::eTimeout) {
            }
            device->resetFences(*fence);
        }
    }
};

Sequence::Sequence() noexcept = default;
Sequence::Sequence(std::unique_ptr<Impl> impl) noexcept : impl_(std::move(impl)) {}
Sequence::Sequence(Sequence&&) noexcept = default;
Sequence& Sequence::operator=(Sequence&& other) noexcept {
    Sequence old(std::move(impl_));
    impl_ = std::move(other.impl_);
    return *this;
}
Sequence::~Sequence() {
    try {
        if (impl_)
            impl_->Wait(impl_->submitted);
    } catch (const std::exception&) { // the device is lost: nothing is under way
    }
}

Expected<Sequence> Context::CreateSequence(std::span<const SequencePass> passes) {
    std::vector<DispatchRequest> requests;
    for (const SequencePass& pass : passes) {
        DispatchRequest& request = requests.emplace_back();
        request.pipeline = pass.pipeline;
        request.buffers = pass.buffers;
    }
    return Guard("sequence", [&]() -> Expected<Sequence> {
        auto sequence = std::make_unique<Sequence::Impl>();
        sequence->device = &impl_->device;
        sequence->pool = impl_->MakePool(requests);
        for (const DispatchRequest& request : requests) {
            OPENNTC_CHECK(impl_->CheckBindings(request));
            sequence->sets.push_back(impl_->Bind(request, *sequence->pool));
            sequence->pipelines.push_back(request.pipeline->GetImpl());
        }
        for (Sequence::Impl::Slot& slot : sequence->slots) {
            vk::raii::CommandBuffers commands(
                impl_->device,
                vk::CommandBufferAllocateInfo(*impl_->commandPool, vk::CommandBufferLevel::ePrimary, 1));
            slot.commands = std::move(commands.front());
            slot.fence = vk::raii::Fence(impl_->device, vk::FenceCreateInfo());
        }
        return Sequence(std::move(sequence));
    });
}

namespace {

/// All that was written before is seen by what comes.
void RecordBarrier(const vk::raii::CommandBuffer& target, vk::PipelineStageFlags from,
                   vk::PipelineStageFlags to) {
    const vk::MemoryBarrier barrier(vk::AccessFlagBits::eMemoryWrite,
                                    vk::AccessFlagBits::eMemoryRead | vk::AccessFlagBits::eMemoryWrite);
    target.pipelineBarrier(from, to, {}, barrier, {}, {});
}

constexpr std::size_t kLargestUpdate = 65536; ///< of vkCmdUpdateBuffer

/// Through `staging`, from `at` on, what is too large for the command buffer.
void RecordWrite(const vk::raii::CommandBuffer& target, const BufferWrite& write, const Buffer::Impl* staging,
                 std::uint64_t at) {
    const vk::Buffer to = *write.buffer->GetImpl()->buffer;
    if (write.bytes.size() > kLargestUpdate) {
        std::memcpy(staging->mapped + at, write.bytes.data(), write.bytes.size());
        target.copyBuffer(*staging->buffer, to, vk::BufferCopy(at, write.offset, write.bytes.size()));
    } else if (!write.bytes.empty()) {
        target.updateBuffer<std::byte>(
            to, write.offset,
            vk::ArrayProxy<const std::byte>(static_cast<std::uint32_t>(write.bytes.size()),
                                            write.bytes.data()));
    }
}

} // namespace

Expected<void> Context::Submit(const Sequence& sequence, std::span<const BufferWrite> writes,
                               std::span<const SequenceDispatch> dispatches) {
    Sequence::Impl& impl = *sequence.GetImpl();
    for (const SequenceDispatch& dispatch : dispatches) {
        if (dispatch.pass >= impl.pipelines.size())
            return Fail(Status::OutOfRange, "sequence: pass %u: %zu passes", dispatch.pass,
                        impl.pipelines.size());
        if (dispatch.pushConstants.size() != impl.pipelines[dispatch.pass]->pushConstantBytes)
            return Fail(Status::InvalidArgument, "sequence: %zu bytes of push constants: the pipeline has %u",
                        dispatch.pushConstants.size(), impl.pipelines[dispatch.pass]->pushConstantBytes);
        if (dispatch.groups == 0 || dispatch.groups > impl_->info.maxWorkgroupCount[0])
            return Fail(Status::OutOfRange, "sequence: %u groups: 1 ... %u", dispatch.groups,
                        impl_->info.maxWorkgroupCount[0]);
    }
    std::uint64_t staged = 0;
    for (const BufferWrite& write : writes)
        staged += write.bytes.size() > kLargestUpdate ? write.bytes.size() : 0;
    return Guard("sequence", [&]() -> Expected<void> {
        if (impl_->submissions++ >= impl_->faults.submissions)
            throw vk::DeviceLostError("as was asked for");
        if (impl.submitted >= kSequenceSubmissions)
            impl.Wait(impl.submitted - kSequenceSubmissions + 1);
        Sequence::Impl::Slot& slot = impl.slots[impl.submitted % kSequenceSubmissions];
        if (staged > 0 && (!slot.staging || slot.staging->size < staged)) {
            slot.staging.reset();
            slot.staging = impl_->MakeBuffer(
                staged, BufferKind::Storage, vk::BufferUsageFlagBits::eTransferSrc,
                vk::MemoryPropertyFlagBits::eHostVisible | vk::MemoryPropertyFlagBits::eHostCoherent);
        }
        const vk::raii::CommandBuffer& target = slot.commands;
        target.reset();
        target.begin(vk::CommandBufferBeginInfo(vk::CommandBufferUsageFlagBits::eOneTimeSubmit));
        const auto compute = vk::PipelineStageFlagBits::eComputeShader;
        RecordBarrier(target, vk::PipelineStageFlagBits::eAllCommands,
                      vk::PipelineStageFlagBits::eAllCommands);
        std::uint64_t at = 0;
        for (const BufferWrite& write : writes) {
            RecordWrite(target, write, slot.staging.get(), at);
            at += write.bytes.size() > kLargestUpdate ? write.bytes.size() : 0;
        }
        RecordBarrier(target, vk::PipelineStageFlagBits::eTransfer, compute);
        for (std::size_t i = 0; i < dispatches.size(); ++i) {
            const SequenceDispatch& dispatch = dispatches[i];
            const ComputePipeline::Impl& pipeline = *impl.pipelines[dispatch.pass];
            if (i > 0)
                RecordBarrier(target, compute, compute);
            target.bindPipeline(vk::PipelineBindPoint::eCompute, *pipeline.pipeline);
            std::vector<vk::DescriptorSet> handles;
            for (const vk::raii::DescriptorSet& set : impl.sets[dispatch.pass])
                handles.push_back(*set);
            target.bindDescriptorSets(vk::PipelineBindPoint::eCompute, *pipeline.layout, 0, handles, {});
            target.pushConstants<std::byte>(
                *pipeline.layout, pipeline.stages, 0,
                vk::ArrayProxy<const std::byte>(static_cast<std::uint32_t>(dispatch.pushConstants.size()),
                                                dispatch.pushConstants.data()));
            target.dispatch(dispatch.groups, 1, 1);
        }
        const vk::MemoryBarrier after(vk::AccessFlagBits::eShaderWrite,
                                      vk::AccessFlagBits::eHostRead | vk::AccessFlagBits::eMemoryRead);
        target.pipelineBarrier(compute,
                               vk::PipelineStageFlagBits::eAllCommands | vk::PipelineStageFlagBits::eHost, {},
                               after, {}, {});
        target.end();
        const vk::CommandBuffer handle = *target;
        impl_->queue.submit(vk::SubmitInfo({}, {}, handle), *slot.fence);
        ++impl.submitted;
        return {};
    });
}

Expected<void> Context::Wait(const Sequence& sequence, std::uint64_t submissions) {
    return Guard("sequence", [&]() -> Expected<void> {
        sequence.GetImpl()->Wait(submissions);
        return {};
    });
}

} // namespace openntc::harness
