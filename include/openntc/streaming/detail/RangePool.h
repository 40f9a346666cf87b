// SPDX-License-Identifier: MIT
// Stability: internal
// Ranges of numbers that are taken and returned: first fit, neighbours joined. No memory after Reset.
#pragma once

#include "openntc/core/Allocator.h"
#include "openntc/core/Expected.h"

#include <cstddef>
#include <cstdint>

#include "openntc/core/HideMacros.h"

namespace openntc::detail {

class RangePool {
public:
    explicit RangePool(Allocator& allocator) noexcept : free_(allocator) {}

    /// Numbers 0 … size - 1, all free, of which at most `maxRanges` ranges will be taken at a time.
    Expected<void> Reset(std::uint32_t size, std::uint32_t maxRanges) noexcept {
        size_ = size;
        used_ = 0;
        free_.clear();
        OPENNTC_CHECK(free_.Reserve(std::size_t{maxRanges} + 1)); // n ranges leave n + 1 gaps at most
        return size > 0 ? free_.PushBack({0, size}) : Expected<void>{};
    }

    /// The first number of `count` in a row; 0 for none. Errors: OutOfMemory, naming `limit`.
    Expected<std::uint32_t> Take(std::uint32_t count, const char* limit) noexcept {
        if (count == 0)
            return 0;
        for (std::size_t i = 0; i < free_.size(); ++i) {
            Range& range = free_[i];
            if (range.count < count)
                continue;
            const std::uint32_t first = range.first;
            range.first += count;
            range.count -= count;
            used_ += count;
            if (range.count == 0)
                RemoveAt(i);
            return first;
        }
        return Fail(Status::OutOfMemory, "%s: %u more in a row: %u of %u are taken", limit, count, used_,
                    size_);
    }

    /// `first` and `count` are those of a Take.
    void Return(std::uint32_t first, std::uint32_t count) noexcept {
        if (count == 0)
            return;
        used_ -= count;
        std::size_t at = 0; // the first gap behind
        for (std::size_t end = free_.size(); at < end;) {
            const std::size_t middle = at + (end - at) / 2;
            if (free_[middle].first < first)
                at = middle + 1;
            else
                end = middle;
        }
        const bool joinsLeft = at > 0 && free_[at - 1].first + free_[at - 1].count == first;
        const bool joinsRight = at < free_.size() && first + count == free_[at].first;
        if (joinsLeft) {
            free_[at - 1].count += count;
            if (joinsRight) {
                free_[at - 1].count += free_[at].count;
                RemoveAt(at);
            }
        } else if (joinsRight) {
            free_[at].first = first;
            free_[at].count += count;
        } else if (free_.PushBack({0, 0})) { // has room since Reset
            for (std::size_t i = free_.size() - 1; i > at; --i)
                free_[i] = free_[i - 1];
            free_[at] = {first, count};
        }
    }

    std::uint32_t GetUsed() const noexcept { return used_; }

private:
    struct Range {
        std::uint32_t first;
        std::uint32_t count;
    };

    void RemoveAt(std::size_t at) noexcept {
        for (std::size_t i = at; i + 1 < free_.size(); ++i)
            free_[i] = free_[i + 1];
        static_cast<void>(free_.Resize(free_.size() - 1)); // shrinking takes no memory
    }

    std::uint32_t size_ = 0;
    std::uint32_t used_ = 0;
    Array<Range> free_; // rising
};

} // namespace openntc::detail

#include "openntc/core/RestoreMacros.h"
