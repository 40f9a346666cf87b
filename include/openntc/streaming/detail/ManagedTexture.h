// SPDX-License-Identifier: MIT
// Stability: internal
// What a tile manager keeps of a texture.
#pragma once

#include "openntc/core/Allocator.h"
#include "openntc/streaming/TileManagerTypes.h"
#include "openntc/streaming/detail/HeapPool.h"
#include "openntc/streaming/detail/TileShape.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <utility>

#include "openntc/core/HideMacros.h"

namespace openntc::detail {

/// One word per tile: how many regions want it, and what it is.
namespace tile_word {
inline constexpr std::uint32_t kState = 7;         ///< ManagedTileState
inline constexpr std::uint32_t kWanted = 1u << 3;  ///< by the last finished update
inline constexpr std::uint32_t kTouched = 1u << 4; ///< in the list of tiles whose count reached or left zero
inline constexpr std::uint32_t kPinned = 1u << 5;  ///< always wanted
inline constexpr std::uint32_t kIdle = 1u << 6;    ///< in the texture's idle list: not wanted, has a slot
inline constexpr std::uint32_t kOverdue = 1u << 7; ///< not wanted for the timeout, but not confirmed yet
inline constexpr std::uint32_t kOne = 1u << 8;     ///< the count's unit; 24 bits: kMaxTileCount regions
} // namespace tile_word

inline ManagedTileState GetState(std::uint32_t word) noexcept {
    return static_cast<ManagedTileState>(word & tile_word::kState);
}
inline bool IsVisible(std::uint32_t word) noexcept {
    return GetState(word) >= ManagedTileState::Mapped; // or standby
}
inline void SetState(std::uint32_t& word, ManagedTileState state) noexcept {
    word = (word & ~tile_word::kState) | static_cast<std::uint32_t>(state);
}

struct ManagedTexture {
    // What an update without changes reads comes first.
    TileShape* shape = nullptr;                                  ///< null: the index is free
    std::uint8_t* feedback = nullptr;                            ///< as it was last given
    double oldestIdle = std::numeric_limits<double>::infinity(); ///< when the first of `idle` was last wanted
    double lastTime = 0;                                         ///< of the last update
    std::uint64_t lastSequence = 0; ///< number of the last update of this texture alone
    std::uint32_t generation = 0;
    int bias = 0; ///< of the last update
    int streamedMips = 0;
    bool isFollowing = false; ///< the wanted set comes from another texture

    std::uint32_t* words = nullptr;
    /// Slot of a tile that has one; place in the request queue of a requested one; of a free one, the round
    /// of
    /// allocation in which it was evicted.
    std::uint32_t* places = nullptr;
    std::uint8_t* residency = nullptr;
    std::uint8_t* sent = nullptr; ///< residency as the caller knows it
    SlotList idle;                ///< slots of tiles not wanted, by the time they last were
    std::uint32_t wanted = 0;     ///< tiles, tail included
    std::uint32_t pinnedMissing = 0;
    std::uint32_t wantedVersion = 0; ///< counts changes of the wanted set
    ManagedTextureId primary;        ///< that the wanted set was made from
    std::uint32_t primaryVersion = 0;
    std::uint32_t idleIndex = kNoIndex;  ///< in the list of textures with idle tiles
    std::uint32_t dirtyIndex = kNoIndex; ///< in the list of textures whose residency changed
    TileRect dirty;                      ///< entries of the residency map, while in that list
    Array<std::uint64_t> block;          ///< holds all the arrays

    explicit ManagedTexture(Allocator& allocator) noexcept : block(allocator) {}

    std::uint32_t GetTileCount() const noexcept {
        return static_cast<std::uint32_t>(shape->layout.GetTileCount());
    }
    std::uint32_t GetRegionCount() const noexcept {
        return static_cast<std::uint32_t>(shape->layout.GetRegionCount());
    }
    std::uint32_t GetResidencyBytes() const noexcept {
        return static_cast<std::uint32_t>(shape->layout.GetResidencyWidth() *
                                          shape->layout.GetResidencyHeight());
    }

    /// All arrays lie in one block. Errors: OutOfMemory.
    Expected<void> AllocateArrays() noexcept {
        const std::size_t regions = (std::size_t{GetRegionCount()} + 7) / 8 * 8;
        const std::size_t wordBytes = std::size_t{GetTileCount()} * sizeof(std::uint32_t);
        const std::size_t bytes = GetResidencyBytes();
        Array<std::uint64_t> taken(block.GetAllocator());
        OPENNTC_CHECK(taken.Resize((regions + 2 * wordBytes + 2 * bytes + 7) / 8));
        block = std::move(taken);
        feedback = reinterpret_cast<std::uint8_t*>(block.data());
        words = reinterpret_cast<std::uint32_t*>(feedback + regions);
        places = words + GetTileCount();
        residency = reinterpret_cast<std::uint8_t*>(places + GetTileCount());
        sent = residency + bytes;
        std::memset(feedback, kNoTilesFeedback, regions);
        std::memset(residency, kNoTilesFeedback, 2 * bytes);
        return {};
    }

    /// The level that a byte of feedback asks for; the number of levels if it is the tail or nothing.
    int GetLevel(std::uint8_t value, int withBias, int withStreamedMips) const noexcept {
        if (value == kNoTilesFeedback)
            return shape->levels;
        const int mips = shape->layout.GetMips();
        int mip = std::clamp(value + std::clamp(withBias, -256, 256), 0, 255);
        if (withStreamedMips > 0)
            mip = std::max(mip, mips - withStreamedMips);
        return shape->levelOfMip[static_cast<std::size_t>(mip)];
    }
};

} // namespace openntc::detail

#include "openntc/core/RestoreMacros.h"
