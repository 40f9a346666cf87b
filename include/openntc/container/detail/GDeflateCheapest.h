// SPDX-License-Identifier: MIT
// Stability: internal
// The cheapest way through all repetitions of a tile, in bits of a code that follows from the last way.
#pragma once

#include "openntc/container/detail/GDeflateWriter.h"

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc::container::detail {

class GDeflateCheapestParser {
public:
    explicit GDeflateCheapestParser(Allocator& allocator) noexcept : steps_(allocator) {}

    /// Replaces `tokens`, a way through the tile, by one that is cheaper in the code that fits them.
    Expected<void> Improve(GDeflateMatchFinder& finder, std::span<const std::byte> tile,
                           const GDeflateEffort& effort, Array<GDeflateToken>& tokens) noexcept {
        SetCosts(std::as_const(tokens).AsSpan());
        OPENNTC_CHECK(finder.Start(tile));
        steps_.clear();
        OPENNTC_CHECK(steps_.Resize(tile.size() + 1));
        steps_[0].cost = 0;
        for (std::size_t at = 0; at < tile.size();) {
            const std::uint32_t cost = steps_[at].cost;
            Offer(at + 1, cost + literalCosts_[static_cast<std::size_t>(tile[at])], 1, 0);
            std::size_t length = kMinMatch;
            finder.Find(at, kMinMatch - 1, effort, [&](std::size_t found, std::size_t distance) {
                const ExtraSymbol symbol = GetDistanceSymbol(static_cast<std::uint32_t>(distance));
                const std::uint32_t costOfDistance = cost + distanceCosts_[symbol.symbol] + symbol.extraBits;
                // Parts of a long repetition are no better than the whole.
                for (length = found >= effort.nice ? found : length; length <= found; ++length)
                    Offer(at + length, costOfDistance + GetLengthCost(static_cast<std::uint32_t>(length)),
                          length, distance);
            });
            const std::size_t end = at + (length > effort.nice ? length - 1 : 1);
            for (; at < end; ++at)
                finder.Insert(at);
        }
        return Collect(tile, tokens);
    }

private:
    struct Step { // the last token of the cheapest way to a position
        std::uint32_t cost = std::numeric_limits<std::uint32_t>::max();
        std::uint32_t length = 0;
        std::uint16_t distance = 0;
    };

    void SetCosts(std::span<const GDeflateToken> tokens) noexcept {
        const GDeflateCounts counts(tokens);
        LengthCode lengths;
        DistanceCode distances;
        lengths.Make(counts.lengths, kMaxCodeBits);
        distances.Make(counts.distances, kMaxCodeBits);
        const auto getCost = [](std::uint8_t length, std::uint32_t unused) {
            return length > 0 ? std::uint32_t{length} : unused;
        };
        for (std::size_t i = 0; i < kLengthSymbols; ++i)
            literalCosts_[i] = getCost(lengths.lengths[i], 13);
        for (std::size_t i = 0; i < kDistanceSymbols; ++i)
            distanceCosts_[i] = getCost(distances.lengths[i], 10);
    }

    std::uint32_t GetLengthCost(std::uint32_t length) const noexcept {
        const ExtraSymbol symbol = GetLengthSymbol(length);
        return literalCosts_[symbol.symbol] + symbol.extraBits;
    }

    void Offer(std::size_t to, std::uint32_t cost, std::size_t length, std::size_t distance) noexcept {
        Step& step = steps_[to];
        if (cost < step.cost)
            step = {cost, static_cast<std::uint32_t>(length), static_cast<std::uint16_t>(distance)};
    }

    /// The way, which is known from its end.
    Expected<void> Collect(std::span<const std::byte> tile, Array<GDeflateToken>& tokens) noexcept {
        tokens.clear();
        for (std::size_t at = tile.size(); at > 0; at -= steps_[at].length) {
            const Step& step = steps_[at];
            const std::uint8_t literal = step.distance == 0 ? static_cast<std::uint8_t>(tile[at - 1]) : 0;
            OPENNTC_CHECK(tokens.PushBack({step.length, step.distance, literal}));
        }
        std::reverse(tokens.begin(), tokens.end());
        return {};
    }

    Array<Step> steps_;
    std::array<std::uint32_t, kLengthSymbols> literalCosts_{};
    std::array<std::uint32_t, kDistanceSymbols> distanceCosts_{};
};

} // namespace openntc::container::detail

#include "openntc/core/RestoreMacros.h"
