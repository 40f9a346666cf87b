// SPDX-License-Identifier: MIT
#include "vulkan_harness/TrainingQueue.h"

#include "matrix_shaders.h"
#include "train_shaders.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <string>
#include <vector>

namespace openntc::harness {

namespace {

using encode::kTrainingBindings;
using encode::kTrainingBuffers;
using encode::kTrainingPasses;
using encode::TrainingBuffer;
using encode::TrainingDispatch;
using encode::TrainingPass;

Expected<std::span<const std::uint32_t>> FindTrainingShader(TrainingPass pass, int generation, int inputs,
                                                            bool onMatrices) {
    const std::string name =
        std::string(encode::kTrainingPassNames[static_cast<std::size_t>(pass)]) + ".comp";
    std::string defines;
    if (pass != TrainingPass::TrainMoves)
        defines =
            "NTC_TRAIN_INPUTS=" + std::to_string(inputs) + (generation == 3 ? " NTC_TRAIN_GENERATION=3" : "");
    if (pass == TrainingPass::TryMoves)
        defines += " NTC_TRAIN_TRIES=1";
    if (onMatrices && (pass == TrainingPass::TrainTexels || pass == TrainingPass::TryMoves))
        return matrix_shaders::FindShader(name, defines + " NTC_MATH=8");
    return train_shaders::FindShader(name, defines);
}

class TrainingQueue final : public encode::TrainingDevice {
public:
    TrainingQueue(Context& context, bool onMatrices) : context_(context), onMatrices_(onMatrices) {}

    const char* GetKernelName() const override { return onMatrices_ ? "vulkan-fp16" : "vulkan"; }

    std::uint64_t GetLargestBuffer() const override { return context_.GetDevice().maxStorageBufferBytes; }

    Expected<void> Create(const encode::TrainingPlan& plan) override {
        sequence_ = {};
        submitted_ = 0;
        for (std::size_t i = 0; i < kTrainingBuffers; ++i) {
            const bool isRead = i == static_cast<std::size_t>(TrainingBuffer::Losses);
            buffers_[i] = {};
            OPENNTC_ASSIGN(buffers_[i], context_.CreateBuffer(plan.bytes[i], BufferKind::Storage,
                                                              isRead ? BufferMemory::HostVisible
                                                                     : BufferMemory::DeviceLocal));
        }
        std::array<ComputePipeline, kTrainingPasses> pipelines;
        std::array<std::vector<BoundBuffer>, kTrainingPasses> bound;
        std::array<SequencePass, kTrainingPasses> passes;
        for (std::size_t pass = 0; pass < kTrainingPasses; ++pass) {
            std::vector<BufferSlot> slots;
            for (std::uint32_t binding = 0; binding < kTrainingBuffers; ++binding) {
                if ((kTrainingBindings[pass] >> binding & 1u) == 0)
                    continue;
                slots.push_back({binding, BufferKind::Storage});
                bound[pass].push_back({binding, &buffers_[binding]});
            }
            OPENNTC_ASSIGN(const std::span<const std::uint32_t> words,
                           FindTrainingShader(static_cast<TrainingPass>(pass), plan.generation, plan.inputs,
                                              onMatrices_));
            OPENNTC_ASSIGN(pipelines_[pass],
                           context_.CreateComputePipeline(words, slots, sizeof(NtcTrainStep)));
            passes[pass] = {&pipelines_[pass], bound[pass]};
        }
        OPENNTC_ASSIGN(sequence_, context_.CreateSequence(passes));
        return {};
    }

    Expected<void> Write(TrainingBuffer buffer, std::uint64_t offset,
                         std::span<const std::byte> bytes) override {
        OPENNTC_CHECK(context_.Wait(sequence_, submitted_));
        for (std::size_t at = 0; at < bytes.size(); at += kPart) {
            OPENNTC_CHECK(context_.Write(Get(buffer), offset + at,
                                         bytes.subspan(at, std::min(kPart, bytes.size() - at))));
        }
        return {};
    }
    Expected<void> Read(TrainingBuffer buffer, std::uint64_t offset, std::span<std::byte> bytes) override {
        if (buffer != TrainingBuffer::Losses)
            OPENNTC_CHECK(context_.Wait(sequence_, submitted_));
        for (std::size_t at = 0; at < bytes.size(); at += kPart) {
            OPENNTC_CHECK(context_.Read(Get(buffer), offset + at,
                                        bytes.subspan(at, std::min(kPart, bytes.size() - at))));
        }
        return {};
    }

    Expected<void> Submit(std::span<const std::uint32_t> batch, std::span<const std::uint16_t> references,
                          std::span<const TrainingDispatch> dispatches) override {
        std::vector<SequenceDispatch> list;
        for (const TrainingDispatch& dispatch : dispatches)
            list.push_back({static_cast<std::uint32_t>(dispatch.pass),
                            std::as_bytes(std::span(&dispatch.step, 1)), dispatch.groups});
        ++submitted_;
        const BufferWrite writes[] = {{&Get(TrainingBuffer::Batch), 0, std::as_bytes(batch)},
                                      {&Get(TrainingBuffer::References), 0, std::as_bytes(references)}};
        return context_.Submit(sequence_, writes, list);
    }
    Expected<void> Wait(std::uint64_t submissions) override { return context_.Wait(sequence_, submissions); }

private:
    static constexpr std::size_t kPart = std::size_t{64} << 20; ///< bytes of staging memory

    const Buffer& Get(TrainingBuffer buffer) const { return buffers_[static_cast<std::size_t>(buffer)]; }

    Context& context_;
    bool onMatrices_;
    std::array<Buffer, kTrainingBuffers> buffers_;
    std::array<ComputePipeline, kTrainingPasses> pipelines_;
    Sequence sequence_; // before the buffers go
    std::uint64_t submitted_ = 0;
};

/// Why the device cannot; empty if it can.
std::string FindObstacle(const DeviceInfo& device) {
    constexpr std::uint32_t kSharedBytes = 32 << 10;
    if (device.maxSharedBytes < kSharedBytes)
        return "32 KiB of shared memory";
    if (device.maxWorkgroupInvocations < NTC_TRAIN_GROUP)
        return "workgroups of 256";
    return {};
}

} // namespace

Expected<std::unique_ptr<encode::TrainingDevice>> MakeTrainingQueue(Context& context, TrainingForm form) {
    const DeviceInfo& device = context.GetDevice();
    const std::string obstacle = FindObstacle(device);
    if (!obstacle.empty())
        return Fail(Status::Unsupported, "device or feature absent: %s: %s", obstacle.c_str(),
                    device.name.c_str());
    constexpr std::uint32_t kMatrixBytes = 48 << 10;
    const bool can = device.hasHalfMatrices && device.maxSharedBytes >= kMatrixBytes;
    const Expected<std::span<const std::uint32_t>> shader =
        FindTrainingShader(TrainingPass::TrainTexels, 1, 64, true);
    if (form == TrainingForm::Matrices) {
        if (!can)
            return Fail(Status::Unsupported,
                        "device or feature absent: cooperative matrices of binary16, 16 x 16 x 16: %s",
                        device.name.c_str());
        OPENNTC_CHECK(shader);
    }
    const bool onMatrices = form != TrainingForm::Plain && can && shader;
    return std::make_unique<TrainingQueue>(context, onMatrices);
}

} // namespace openntc::harness
