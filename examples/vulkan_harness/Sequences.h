// SPDX-License-Identifier: MIT
// Many dispatches of few passes, submitted without waiting for them.
#pragma once

#include "vulkan_harness/Pipelines.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

namespace openntc::harness {

/// A pipeline and what is bound to it.
struct SequencePass {
    const ComputePipeline* pipeline = nullptr;
    std::span<const BoundBuffer> buffers;
};

struct SequenceDispatch {
    std::uint32_t pass = 0; ///< of those that the sequence was made of
    std::span<const std::byte> pushConstants;
    std::uint32_t groups = 1; ///< along x
};

/// Passes of a Context with their descriptors, and command buffers of their own. The context, pipelines and buffers must
/// outlive it; it waits for what is under way before it goes.
class Sequence {
public:
    struct Impl;
    Sequence() noexcept;
    explicit Sequence(std::unique_ptr<Impl> impl) noexcept;
    Sequence(Sequence&&) noexcept;
    Sequence& operator=(Sequence&&) noexcept;
    ~Sequence();
    Impl* GetImpl() const noexcept { return impl_.get(); }

private:
    std::unique_ptr<Impl> impl_;
};

inline constexpr std::uint32_t kSequenceSubmissions = 2; ///< under way at once

} // namespace openntc::harness
