// SPDX-License-Identifier: MIT
// An allocator that counts, remembers the peak and can fail on request. For tests of memory behaviour; one
// thread.
#pragma once

#include "openntc/core/Allocator.h"

#include <cstddef>
#include <cstdlib>
#include <limits>

namespace openntc::test {

class CountingAllocator final : public Allocator {
public:
    void* Allocate(std::size_t bytes) noexcept override {
        if (allocationCount_++ == failAt_ || used_ > limit_ || bytes > limit_ - used_)
            return nullptr;
        used_ += bytes;
        peak_ = used_ > peak_ ? used_ : peak_;
        return std::malloc(bytes);
    }
    void Deallocate(void* block, std::size_t bytes) noexcept override {
        used_ -= bytes;
        std::free(block);
    }

    /// The allocation of this number, counted from 0 since construction, returns null.
    void FailAt(std::size_t number) noexcept { failAt_ = number; }
    /// More than this many bytes at a time are refused.
    void SetLimit(std::size_t bytes) noexcept { limit_ = bytes; }

    std::size_t GetAllocationCount() const noexcept { return allocationCount_; }
    std::size_t GetUsedBytes() const noexcept { return used_; }
    std::size_t GetPeakBytes() const noexcept { return peak_; }

private:
    std::size_t allocationCount_ = 0;
    std::size_t failAt_ = std::numeric_limits<std::size_t>::max();
    std::size_t limit_ = std::numeric_limits<std::size_t>::max();
    std::size_t used_ = 0;
    std::size_t peak_ = 0;
};

} // namespace openntc::test
