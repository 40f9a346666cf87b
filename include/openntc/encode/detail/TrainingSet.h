// SPDX-License-Identifier: MIT
// Stability: internal
// The texels to reproduce: every mip cut into tiles, 16 bits per channel over the channel's range.
#pragma once

#include "openntc/encode/detail/TrainNetwork.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <functional>
#include <limits>
#include <span>
#include <vector>

#include "openntc/core/HideMacros.h"

namespace openntc::encode::detail {

/// Shape of what is trained.
struct TrainerShape {
    NetworkShape network;
    int gridScale = 4, highBits = 2, lowBits = 4;
};

inline TrainerShape MakeTrainerShape(const LatentShape& latents, int networkVersion) {
    TrainerShape shape;
    shape.network.highFeatures = latents.highResFeatures;
    shape.network.lowFeatures = latents.lowResFeatures;
    shape.network.blended = GetGeneration(networkVersion) == 3;
    shape.network.highSlots =
        shape.network.blended ? kMaxFeatures : GetNetworkDescription(networkVersion).highResSlots;
    shape.gridScale = latents.gridSizeScale;
    shape.highBits = latents.highResQuantBits;
    shape.lowBits = latents.lowResQuantBits;
    return shape;
}

struct LossSums;

struct TileRecord {
    int mip = 0, x = 0, y = 0;
};

/// How a channel is trained.
struct ChannelPlan {
    bool declared = false; ///< covered by a texture
    bool constant = false; ///< one value everywhere: made exact by the bias, not trained
    bool mask = false;     ///< alpha mask: exact 0 and 1 are trained beyond the range
    float minimum = 0.0f;  ///< stored value of a network output of 0
    float range = 0.0f;    ///< stored value of output 1, minus minimum
    float lossScale = 1.0f;
};

class TrainingSet {
public:
    /// `mips` planes: texels of channel c of mip m, row by row.
    using Planes = std::function<std::span<const float>(int mip, int channel)>;

    static TrainingSet Make(int width, int height, int mips, const Planes& planes,
                            std::uint32_t declaredChannels, int maskChannel, bool discardMasked,
                            std::span<const float> lossScales) {
        TrainingSet set;
        set.width_ = width;
        set.height_ = height;
        set.mips_ = mips;
        set.discardMasked_ = discardMasked && maskChannel >= 0;
        for (int c = 0; c < kMaxChannels; ++c) {
            if ((declaredChannels >> c & 1u) == 0)
                continue;
            ChannelPlan& plan = set.channels_[static_cast<std::size_t>(c)];
            plan = PlanChannel(planes, mips, c, c == maskChannel);
            if (static_cast<std::size_t>(c) < lossScales.size())
                plan.lossScale = lossScales[static_cast<std::size_t>(c)];
            if (!plan.constant && plan.lossScale > 0.0f)
                set.trained_.push_back(c);
        }
        set.CutTiles(planes);
        set.MakeFingerprint();
        return set;
    }

    int GetWidth() const { return width_; }
    int GetHeight() const { return height_; }
    int GetMipCount() const { return mips_; }
    int GetFirstTile(int mip) const { return firstTile_[static_cast<std::size_t>(mip)]; }
    const TileRecord& GetTile(int tile) const { return tiles_[static_cast<std::size_t>(tile)]; }
    const ChannelPlan& GetChannel(int channel) const { return channels_[static_cast<std::size_t>(channel)]; }
    const std::uint16_t* GetReference(int tile) const {
        return references_.data() + static_cast<std::size_t>(tile) * trained_.size() * kTileTexels;
    }
    /// Of all tiles: [tile][trained channel][128].
    std::span<const std::uint16_t> GetReferences() const { return references_; }
    std::span<const int> GetTrainedChannels() const { return trained_; }
    /// Differs, for all practical purposes, between sets with other texels or other trained channels.
    std::uint64_t GetFingerprint() const { return fingerprint_; }
    int GetDeclaredCount() const {
        int count = 0;
        for (const ChannelPlan& plan : channels_)
            count += plan.declared ? 1 : 0;
        return count;
    }

    /// How often tiles of a mip are visited for each visit of the largest mip's: small mips a little more,
    /// they depend on few latents but on all of the network.
    int GetTileRepeats(int mip) const {
        return mip == 0 || GetFirstTile(mip + 1) - GetFirstTile(mip) > 4 ? 1 : 2;
    }

    void FillContext(KernelContext& context, int batchTexels) const {
        context.channels = static_cast<int>(trained_.size());
        for (std::size_t i = 0; i < trained_.size(); ++i) {
            const ChannelPlan& plan = GetChannel(trained_[i]);
            context.outputOf[i] = trained_[i];
            context.squaredRange[i] = plan.range * plan.range;
            context.gain[i] = 2.0f * kLossScale * plan.range * plan.range * plan.lossScale /
                              static_cast<float>(batchTexels);
            if (plan.mask)
                context.oneSided = static_cast<int>(i);
            if (plan.mask && discardMasked_) {
                context.maskIndex = static_cast<int>(i);
                context.maskZero = 0.0f;
            }
        }
    }

    /// Adds the squared errors of a tile's outputs ([16][stride]) to `sums`, after the clamping that a mask
    /// gets and without what discarded texels hold in other channels.
    template <typename Sums>
    void AddErrors(const TileTask& tile, const float* outputs, int stride, Sums& sums) const {
        const std::uint16_t* mask = FindDiscardingMask(tile, sums);
        for (std::size_t i = 0; i < trained_.size(); ++i) {
            const int c = trained_[i];
            const ChannelPlan& plan = GetChannel(c);
            const float* row = outputs + c * stride;
            const std::uint16_t* reference = tile.reference + i * kTileTexels;
            double total = 0.0;
            for (int y = 0; y < tile.height; ++y) {
                for (int x = 0; x < tile.width; ++x) {
                    if (mask != nullptr && !plan.mask && mask[y * kTileWidth + x] == 0)
                        continue;
                    const float value = row[y * kTileWidth + x];
                    const float wanted =
                        static_cast<float>(reference[y * kTileWidth + x]) * (1.0f / 65535.0f);
                    float error = (value - wanted) * plan.range;
                    if (plan.mask) {
                        const std::uint16_t raw = reference[y * kTileWidth + x];
                        const float decoded = plan.minimum + value * plan.range;
                        if ((raw == 0 && decoded >= 0.5f / 255.0f) ||
                            (raw == 65535 && decoded < 254.5f / 255.0f))
                            ++sums.maskViolations;
                        error = std::clamp(decoded, 0.0f, 1.0f) -
                                std::clamp(plan.minimum + wanted * plan.range, 0.0f, 1.0f);
                    }
                    total += static_cast<double>(error * error);
                }
            }
            sums.perOutput[static_cast<std::size_t>(c)] += total;
        }
        sums.texels += tile.width * tile.height;
    }

    /// The tile's mask when texels are discarded by it, which are counted; or null.
    template <typename Sums>
    const std::uint16_t* FindDiscardingMask(const TileTask& tile, Sums& sums) const {
        for (std::size_t i = 0; discardMasked_ && i < trained_.size(); ++i) {
            if (!GetChannel(trained_[i]).mask)
                continue;
            const std::uint16_t* mask = tile.reference + i * kTileTexels;
            for (int y = 0; y < tile.height; ++y)
                sums.discarded += static_cast<double>(
                    std::count(mask + y * kTileWidth, mask + y * kTileWidth + tile.width, std::uint16_t{0}));
            sums.mask = trained_[i];
            return mask;
        }
        return nullptr;
    }

private:
    static constexpr float kLossScale = 1024.0f; ///< keeps gradients far from the smallest floats
    static constexpr float kMaskMargin =
        0.125f; ///< format specification: exact 0 and 1 are trained to -1/8 and 9/8

    static ChannelPlan PlanChannel(const Planes& planes, int mips, int channel, bool mask) {
        ChannelPlan plan;
        plan.declared = true;
        float lowest = std::numeric_limits<float>::max(), highest = std::numeric_limits<float>::lowest();
        for (int m = 0; m < mips; ++m) {
            for (float value : planes(m, channel)) {
                lowest = std::min(lowest, value);
                highest = std::max(highest, value);
            }
        }
        plan.minimum = lowest;
        plan.range = highest - lowest;
        // A range this small has no meaning in half precision, and its row scale would overflow the integer
        // bias.
        const float magnitude = std::max(std::fabs(lowest), std::fabs(highest));
        if (plan.range <= magnitude * (1.0f / 16384.0f)) {
            plan.constant = true;
            plan.minimum = lowest + 0.5f * plan.range;
            plan.range = 0.0f;
        } else if (mask) {
            plan.mask = true;
            plan.minimum = -kMaskMargin;
            plan.range = 1.0f + 2.0f * kMaskMargin;
        }
        return plan;
    }

    /// Fowler, Noll and Vo's FNV-1a over words in place of bytes.
    void MakeFingerprint() {
        fingerprint_ = 0xcbf29ce484222325u;
        const auto add = [&](std::uint64_t word) { fingerprint_ = (fingerprint_ ^ word) * 0x100000001b3u; };
        add(static_cast<std::uint64_t>(width_) << 32 | static_cast<std::uint64_t>(height_));
        for (int channel : trained_)
            add(static_cast<std::uint64_t>(channel));
        for (std::size_t i = 0; i < references_.size(); i += 4) { // whole tiles: a multiple of 128
            std::uint64_t word = 0;
            std::memcpy(&word, references_.data() + i, sizeof(word));
            add(word);
        }
    }

    void CutTiles(const Planes& planes) {
        for (int m = 0; m < mips_; ++m) {
            firstTile_.push_back(static_cast<int>(tiles_.size()));
            const int w = std::max(width_ >> m, 1), h = std::max(height_ >> m, 1);
            for (int y = 0; y < h; y += kTileHeight) {
                for (int x = 0; x < w; x += kTileWidth)
                    tiles_.push_back({m, x, y});
            }
        }
        firstTile_.push_back(static_cast<int>(tiles_.size()));
        references_.resize(tiles_.size() * trained_.size() * kTileTexels);
        for (std::size_t t = 0; t < tiles_.size(); ++t) {
            const TileRecord& tile = tiles_[t];
            const int w = std::max(width_ >> tile.mip, 1), h = std::max(height_ >> tile.mip, 1);
            for (std::size_t i = 0; i < trained_.size(); ++i) {
                const ChannelPlan& plan = GetChannel(trained_[i]);
                const std::span<const float> plane = planes(tile.mip, trained_[i]);
                std::uint16_t* to = references_.data() + (t * trained_.size() + i) * kTileTexels;
                for (int y = 0; y < kTileHeight && tile.y + y < h; ++y) {
                    for (int x = 0; x < kTileWidth && tile.x + x < w; ++x) {
                        float value =
                            plane[static_cast<std::size_t>(tile.y + y) * static_cast<std::size_t>(w) +
                                  static_cast<std::size_t>(tile.x + x)];
                        if (plan.mask)
                            value = value <= 0.0f ? -kMaskMargin : value >= 1.0f ? 1.0f + kMaskMargin : value;
                        const float unit = (value - plan.minimum) / plan.range;
                        const float raised = std::clamp(unit, 0.0f, 1.0f) * 65535.0f + 0.5f;
                        to[y * kTileWidth + x] = static_cast<std::uint16_t>(raised);
                    }
                }
            }
        }
    }

    int width_ = 0, height_ = 0, mips_ = 0;
    bool discardMasked_ = false;
    std::array<ChannelPlan, kMaxChannels> channels_{};
    std::vector<int> trained_;
    std::vector<TileRecord> tiles_;
    std::vector<int> firstTile_;
    std::vector<std::uint16_t> references_;
    std::uint64_t fingerprint_ = 0;
};

} // namespace openntc::encode::detail

#include "openntc/core/RestoreMacros.h"
