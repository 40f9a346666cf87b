// SPDX-License-Identifier: MIT
// A training device behind which another works.
#pragma once

#include "openntc/encode/TrainingDevice.h"

namespace openntc::harness {

/// Hands everything on; what differs is overridden. `device` outlives it.
class ForwardingDevice : public encode::TrainingDevice {
public:
    explicit ForwardingDevice(encode::TrainingDevice& device) : device_(device) {}
    const char* GetKernelName() const override { return device_.GetKernelName(); }
    std::uint64_t GetLargestBuffer() const override { return device_.GetLargestBuffer(); }
    Expected<void> Create(const encode::TrainingPlan& wanted) override {
        plan = wanted;
        return device_.Create(wanted);
    }
    Expected<void> Write(encode::TrainingBuffer buffer, std::uint64_t offset,
                         std::span<const std::byte> bytes) override {
        return device_.Write(buffer, offset, bytes);
    }
    Expected<void> Read(encode::TrainingBuffer buffer, std::uint64_t offset,
                        std::span<std::byte> bytes) override {
        return device_.Read(buffer, offset, bytes);
    }
    Expected<void> Submit(std::span<const std::uint32_t> batch, std::span<const std::uint16_t> references,
                          std::span<const encode::TrainingDispatch> dispatches) override {
        return device_.Submit(batch, references, dispatches);
    }
    Expected<void> Wait(std::uint64_t submissions) override { return device_.Wait(submissions); }

    encode::TrainingPlan plan; ///< that was asked for last

private:
    encode::TrainingDevice& device_;
};

} // namespace openntc::harness
