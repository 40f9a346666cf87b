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
#include <new>

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

/// A tile of a texture.
struct ManagedTile {
    std::uint32_t word = 0;
    /// Slot of a tile that has one; place in the request queue of a requested one; of a free one, the round
    /// of allocation in which it was evicted.
    std::uint32_t place = 0;
};

/// What only an update that changes something reads. It lies in front of the texture's feedback.
struct TextureState {
    SlotList idle;            ///< slots of tiles not wanted, by the time they last were
    std::uint32_t wanted = 0; ///< tiles, tail included
    std::uint32_t pinnedMissing = 0;
    std::uint32_t wantedVersion = 0;     ///< counts changes of the wanted set
    std::uint32_t idleIndex = kNoIndex;  ///< in the list of textures with idle tiles
    std::uint32_t dirtyIndex = kNoIndex; ///< in the list of textures whose residency changed
    TileRect dirty;                      ///< entries of the residency map, while in that list
    ManagedTextureId primary;            ///< that the wanted set was made from
    std::uint32_t primaryVersion = 0;
};

/// What an update without changes reads: one cache line a texture, one behind the other. The arrays lie in a
/// block of memory of the texture's own, each from a multiple of kLine on: what is touched together (a row of
/// eight tiles, 64 regions) is a line.
struct ManagedTexture {
    static constexpr std::size_t kLine = 64;
    static_assert(sizeof(TextureState) <= kLine);

    TileShape* shape = nullptr;    ///< null: the index is free
    TextureState* state = nullptr; ///< the start of the block; a line behind it is the feedback
    ManagedTile* tiles = nullptr;
    std::uint8_t* residency = nullptr; ///< behind it: the same as the caller knows it
    double oldestIdle = std::numeric_limits<double>::infinity(); ///< when the first of `idle` was last wanted
    double lastTime = 0;                                         ///< of the last update
    std::uint64_t lastSequence = 0; ///< number of the last update of this texture alone
    std::uint32_t generation = 0;
    std::int16_t bias = 0; ///< of the last update, as LimitBias gives it
    std::uint8_t streamedMips = 0;
    bool isFollowing = false; ///< the wanted set comes from another texture

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
    /// As it was last given.
    std::uint8_t* GetFeedback() const noexcept { return reinterpret_cast<std::uint8_t*>(state) + kLine; }
    std::uint8_t* GetSent() const noexcept { return residency + GetResidencyBytes(); }

    /// All arrays lie in one block. Errors: OutOfMemory.
    Expected<void> AllocateArrays(Array<std::uint64_t>& block) noexcept {
        const auto roundUp = [](std::size_t bytes) { return (bytes + kLine - 1) / kLine * kLine; };
        const std::size_t regions = roundUp(GetRegionCount());
        const std::size_t tileBytes = roundUp(std::size_t{GetTileCount()} * sizeof(ManagedTile));
        const std::size_t bytes = GetResidencyBytes();
        OPENNTC_CHECK(block.Resize((kLine + regions + tileBytes + roundUp(2 * bytes) + kLine) / 8));
        const auto address = reinterpret_cast<std::uintptr_t>(block.data());
        auto* first = reinterpret_cast<std::uint8_t*>(block.data()) + (kLine - address % kLine) % kLine;
        state = ::new (static_cast<void*>(first)) TextureState();
        tiles = reinterpret_cast<ManagedTile*>(first + kLine + regions);
        residency = first + kLine + regions + tileBytes;
        std::memset(GetFeedback(), kNoTilesFeedback, regions);
        std::memset(residency, kNoTilesFeedback, 2 * bytes);
        return {};
    }

    /// All mips are below 256: more bias, or more streamed mips, makes no difference.
    static std::int16_t LimitBias(int bias) noexcept {
        return static_cast<std::int16_t>(std::clamp(bias, -256, 256));
    }
    static std::uint8_t LimitStreamedMips(int count) noexcept {
        return static_cast<std::uint8_t>(std::min(count, 255));
    }

    /// The level that a byte of feedback asks for; the number of levels if it is the tail or nothing.
    int GetLevel(std::uint8_t value, int withBias, int withStreamedMips) const noexcept {
        if (value == kNoTilesFeedback)
            return shape->levels;
        const int mips = shape->layout.GetMips();
        int mip = std::clamp(value + withBias, 0, 255);
        if (withStreamedMips > 0)
            mip = std::max(mip, mips - withStreamedMips);
        return shape->levelOfMip[static_cast<std::size_t>(mip)];
    }
};

} // namespace openntc::detail

#include "openntc/core/RestoreMacros.h"
