// SPDX-License-Identifier: MIT
// Stability: internal
// A set of small numbers that knows its smallest and its largest: bits, with a bit above every 64 that says
// whether one of them is set, and so on up.
#pragma once

#include "openntc/core/Allocator.h"

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "openntc/core/HideMacros.h"

namespace openntc::detail {

class BitTree {
public:
    static constexpr std::uint32_t kNone = 0xFFFFFFFF;

    explicit BitTree(Allocator& allocator) noexcept
        : levels_{Array<std::uint64_t>(allocator), Array<std::uint64_t>(allocator),
                  Array<std::uint64_t>(allocator), Array<std::uint64_t>(allocator)} {}

    /// Makes room for numbers below `size` (at most 2^24); those added are not in the set. Errors:
    /// OutOfMemory.
    Expected<void> Grow(std::size_t size) noexcept {
        std::size_t words = size;
        for (Array<std::uint64_t>& level : levels_) {
            words = words / 64 + 1;
            if (words > level.size()) {
                if (words > 1) // steps that keep the cost linear
                    OPENNTC_CHECK(level.Reserve(words + words / 2));
                OPENNTC_CHECK(level.Resize(words));
            }
        }
        return {};
    }

    void Set(std::uint32_t number) noexcept {
        for (Array<std::uint64_t>& level : levels_) {
            std::uint64_t& word = level[number / 64];
            const bool wasEmpty = word == 0;
            word |= std::uint64_t{1} << (number % 64);
            if (!wasEmpty)
                return;
            number /= 64;
        }
    }

    void Clear(std::uint32_t number) noexcept {
        for (Array<std::uint64_t>& level : levels_) {
            std::uint64_t& word = level[number / 64];
            word &= ~(std::uint64_t{1} << (number % 64));
            if (word != 0)
                return;
            number /= 64;
        }
    }

    bool Has(std::uint32_t number) const noexcept {
        return number / 64 < levels_[0].size() && ((levels_[0][number / 64] >> (number % 64)) & 1) != 0;
    }

    void ClearAll() noexcept {
        for (Array<std::uint64_t>& level : levels_) {
            for (std::uint64_t& word : level)
                word = 0;
        }
    }

    /// The smallest number in the set; kNone if it is empty.
    std::uint32_t First() const noexcept {
        return Find([](std::uint64_t word) { return static_cast<std::uint32_t>(std::countr_zero(word)); });
    }

    /// The largest; kNone if it is empty.
    std::uint32_t Last() const noexcept {
        return Find(
            [](std::uint64_t word) { return 63 - static_cast<std::uint32_t>(std::countl_zero(word)); });
    }

private:
    template <typename PickBit>
    std::uint32_t Find(PickBit pickBit) const noexcept {
        if (levels_[3].empty() || levels_[3][0] == 0)
            return kNone;
        std::uint32_t number = 0;
        for (std::size_t level = levels_.size(); level-- > 0;)
            number = number * 64 + pickBit(levels_[level][number]);
        return number;
    }

    std::array<Array<std::uint64_t>, 4> levels_; // 64^4 = 2^24 numbers
};

} // namespace openntc::detail

#include "openntc/core/RestoreMacros.h"
