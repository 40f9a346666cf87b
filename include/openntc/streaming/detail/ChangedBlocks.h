// SPDX-License-Identifier: MIT
// Stability: internal
// Which bytes of a buffer have changed: a bit per block of 64, and a bit per 64 of those blocks, so that
// looking for changes among few costs little. No memory after Reset.
#pragma once

#include "openntc/core/Allocator.h"
#include "openntc/core/Expected.h"

#include <bit>
#include <cstddef>
#include <cstdint>

#include "openntc/core/HideMacros.h"

namespace openntc::detail {

class ChangedBlocks {
public:
    struct ByteRange {
        std::size_t offset = 0;
        std::size_t size = 0;
    };

    explicit ChangedBlocks(Allocator& allocator) noexcept : blocks_(allocator), groups_(allocator) {}

    Expected<void> Reset(std::size_t bytes) noexcept {
        bytes_ = bytes;
        const std::size_t count = (bytes + kBlock - 1) / kBlock;
        OPENNTC_CHECK(blocks_.Resize((count + 63) / 64));
        return groups_.Resize((blocks_.size() + 63) / 64);
    }

    void Mark(std::size_t offset, std::size_t size) noexcept {
        if (size == 0)
            return;
        for (std::size_t block = offset / kBlock; block <= (offset + size - 1) / kBlock; ++block) {
            blocks_[block / 64] |= std::uint64_t{1} << (block % 64);
            groups_[block / 4096] |= std::uint64_t{1} << (block / 64 % 64);
        }
    }

    void MarkAll() noexcept { Mark(0, bytes_); }

    /// Takes the first run of changed blocks. False: nothing has changed.
    bool Take(ByteRange& range) noexcept {
        const std::size_t first = FindFirst();
        if (first == kNone)
            return false;
        std::size_t end = first;
        for (; end / 64 < blocks_.size() && (blocks_[end / 64] >> (end % 64) & 1u) != 0; ++end) {
            blocks_[end / 64] &= ~(std::uint64_t{1} << (end % 64));
            if (blocks_[end / 64] == 0)
                groups_[end / 4096] &= ~(std::uint64_t{1} << (end / 64 % 64));
        }
        range.offset = first * kBlock;
        range.size = (end * kBlock < bytes_ ? end * kBlock : bytes_) - range.offset;
        return true;
    }

private:
    static constexpr std::size_t kBlock = 64;
    static constexpr std::size_t kNone = ~std::size_t{0};

    std::size_t FindFirst() const noexcept {
        for (std::size_t group = 0; group < groups_.size(); ++group) {
            if (groups_[group] != 0) {
                const std::size_t word =
                    group * 64 + static_cast<std::size_t>(std::countr_zero(groups_[group]));
                return word * 64 + static_cast<std::size_t>(std::countr_zero(blocks_[word]));
            }
        }
        return kNone;
    }

    std::size_t bytes_ = 0;
    Array<std::uint64_t> blocks_;
    Array<std::uint64_t> groups_;
};

} // namespace openntc::detail

#include "openntc/core/RestoreMacros.h"
