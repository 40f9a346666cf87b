// SPDX-License-Identifier: MIT
// Stability: internal
// The activation with fused multiply-adds, for the rows of a network where it gives the same integers.
//
// The contract rounds after every step: z = sum · scale, limited to -1.5 … 3; gate = min(z / 3 + 0.5, 1);
// 80 · (z · gate) - 113, rounded to an integer. FusedRow has two multiply-adds instead, which round less, and
// therefore otherwise. Both stay within kMargin of what real numbers give, and differ only where that lies
// within kMargin of the middle between two integers. A row has few sums of that kind, and all of them are
// tried: the constants may be off by some units in the last place, so there is a choice.
#pragma once

#include "openntc/core/FloatBits.h"
#include "openntc/decode/fast/Platform.h"

#include <cmath>
#include <cstdint>
#include <cstring>

#include "openntc/core/HideMacros.h"

namespace openntc::fast {

/// sum · clamp(sum · slope + offset, 0, limit) + base, each product and addition rounded once, is what is
/// rounded to an integer and limited to 127.
struct FusedRow {
    float slope = 0;
    float offset = 0;
    float limit = 0;
    float base = 0;
};

/// a · b + c rounded to binary32 once, without the processor's help; a · b must fit 53 bits (a sum below 2^24
/// and a binary32 do). Rounds the sum to odd as a binary64, whose rounding to binary32 is then that of the
/// real number (Boldo and Melquiond, "Emulation of FMA and correctly rounded sums", 2008).
inline float FuseMultiplyAdd(float a, float b, float c) noexcept {
    const double product = static_cast<double>(a) * static_cast<double>(b); // exact
    const double addend = static_cast<double>(c);
    const double sum = product + addend;
    const double part = sum - product;
    const double error = (product - (sum - part)) + (addend - part); // sum + error is exact (Knuth)
    std::uint64_t bits;
    std::memcpy(&bits, &sum, sizeof bits);
    if (error != 0.0 && (bits & 1u) == 0)
        bits += (error > 0.0) == (sum > 0.0) ? 1u : ~std::uint64_t{0};
    double odd;
    std::memcpy(&odd, &bits, sizeof odd);
    return static_cast<float>(odd);
}

/// Adding this rounds to an integer, ties to even, and leaves it in the low bits: 1.5 · 2^23.
inline constexpr float kRoundingBase = 12582912.0f;

/// The activation of a contract in binary32: its constant for 1/3, and whether -113 is added behind rounding
/// to an integer or before.
struct ActivationForm {
    float third = 0x1.555556p-2f;
    bool roundsFirst = false;
};
inline constexpr float kThirdOfGeneration3 = 0x1.55553ep-2f; ///< 0.333333
inline constexpr ActivationForm kGeneration3Form = {kThirdOfGeneration3, true};

/// The integer that the contract gives a sum of a row, -128 … 127.
inline int RequantizeExactly(std::int32_t sum, float scale, const ActivationForm& form = {}) noexcept {
    const float z = MultiplyRounded(static_cast<float>(sum), scale);
    const float limited = z > 3.0f ? 3.0f : z < -1.5f ? -1.5f : z;
    const float third = MultiplyRounded(limited, form.third);
    const float gate = third + 0.5f < 1.0f ? third + 0.5f : 1.0f;
    const float y = MultiplyRounded(limited, gate);
    const float steps = MultiplyRounded(y, 80.0f) - (form.roundsFirst ? 0.0f : 113.0f);
    const auto integer = static_cast<int>(steps + kRoundingBase - kRoundingBase);
    return form.roundsFirst ? integer - 113 : integer;
}

/// The same by a FusedRow.
inline int RequantizeFused(std::int32_t sum, const FusedRow& row) noexcept {
    const auto value = static_cast<float>(sum);
    const float open = FuseMultiplyAdd(value, row.slope, row.offset);
    const float gate = open > row.limit ? row.limit : open > 0.0f ? open : 0.0f;
    const float steps = FuseMultiplyAdd(value, gate, row.base);
    const auto integer = static_cast<int>(steps + kRoundingBase - kRoundingBase);
    return integer < 127 ? integer : 127;
}

/// The gate of the activation in binary16, min(z / 3 + 0.5, 1), for kernels that round by adding a base and
/// taking it away: the third to multiples of 2^-14, the sum to 2^-11, or to 2^-12 where z is negative. With
/// this constant for 1/3 the integer that follows is the contract's for every z of binary16 from -1.5 to 3.
struct HalfGate {
    static constexpr float kThird = 0.333251953125f - 19 * 0x1p-21f;
    static constexpr float kThirdBase = kRoundingBase * 0x1p-14f;
    static constexpr float kBase = kRoundingBase * 0x1p-11f;
    static constexpr float kNegativeBase = kRoundingBase * 0x1p-12f;
};

/// Finds the constants of rows.
class ActivationFuser {
public:
    /// Scales below have too many sums near the middle between two integers.
    static constexpr float kMinScale = 0x1p-18f;
    static constexpr int kSlopeSteps = 4; ///< units in the last place that slope and offset may be off
    static constexpr int kLimitSteps = 6; ///< and the limit
    static constexpr int kBaseSteps = 3;  ///< and the base

    explicit ActivationFuser(const ActivationForm& form = {}) noexcept : form_(form) {
        int count = 0;
        // 80 z (z / 3 + 0.5) - 113 falls from -113 at z = -1.5 to -128 at -0.75 and rises to 7 at 1.5, from
        // where on 80 z - 113 goes on.
        for (int step = 0; step < 15; ++step)
            AddCurve(count++, -113.5 - step, -1.0);
        for (int step = 0; step < 135; ++step)
            AddCurve(count++, -127.5 + step, 1.0);
        for (int step = 0; step < 120; ++step)
            middles_[count++] = {(120.5 + step) / 80.0, kMargin / 80.0};
    }

    /// True, and the constants, if the row gives the same integers as the contract for all sums from `low` to
    /// `high`.
    bool Fuse(float scale, std::int64_t low, std::int64_t high, FusedRow& row) noexcept {
        // Sums are exact as binary32; the integer before its limit stays within 16 bits.
        if (!(scale >= kMinScale && scale <= 1.0f) || low < -(1 << 24) || high > 1 << 24 ||
            static_cast<double>(high) * static_cast<double>(scale) > 256.0)
            return false;
        int curved = 0;
        int count = 0;
        for (int i = 0; i < kMiddles; ++i) {
            if (i == kCurvedMiddles)
                curved = count;
            const double center = middles_[i].z / static_cast<double>(scale);
            const double reach = middles_[i].reach / static_cast<double>(scale);
            const std::int64_t last = Floor(center + reach);
            for (std::int64_t sum = Floor(center - reach) + 1; sum <= last; ++sum) {
                if (sum < low || sum > high)
                    continue;
                if (count == kMaxCandidates)
                    return false;
                const auto candidate = static_cast<std::int32_t>(sum);
                candidates_[count++] = {candidate, RequantizeExactly(candidate, scale, form_)};
            }
        }
        // Beyond z = 1.5 the limit alone decides, below it does not matter: the middles next to it are 0.004
        // away, a hundred times as far as the constants' errors move it.
        const auto wide = static_cast<double>(scale);
        const auto slope = static_cast<float>(GetSlope() * wide * wide);
        const auto offset = static_cast<float>(40.0 * wide);
        const auto limit = static_cast<float>(80.0 * wide);
        for (int i = 0; i <= 2 * kBaseSteps; ++i) {
            row = {slope, offset, limit, Step(-113.0f, i)};
            if (FindLimit(row, limit, curved, count) && FindSlope(row, slope, offset, curved))
                return true;
        }
        return false;
    }

private:
    /// In units u = 2^-24 of relative rounding: the contract's steps are off by at most 1058 u (240 u by
    /// rounding z, 210 by the gate's two roundings and its constant, 240 by y, 240 by 80 y, 128 by the
    /// difference), FusedRow below z = 1.5 by 1200 u (9 u of slope and of offset on at most 60 each, 120 by
    /// the gate's rounding), above by 240 (1 + 2 kLimitSteps) u = 3120 u, and everywhere by
    /// 128 (1 + 2 kBaseSteps) u = 896 u more. 0.333333 for 1/3 moves both by 120 (0.5 · 17.6 u) = 1056 u at
    /// z = 1.5, the most. All that is less than 2^-12 = 4096 u.
    static constexpr double kMargin = 0x1p-12;
    static constexpr int kCurvedMiddles = 15 + 135;
    static constexpr int kMiddles = kCurvedMiddles + 120;
    static constexpr int kMaxCandidates = 512;

    /// Where the real number lies in the middle between two integers, and how far around that it lies within
    /// kMargin of it.
    struct Middle {
        double z = 0;
        double reach = 0;
    };
    struct Candidate {
        std::int32_t sum = 0;
        int integer = 0;
    };

    double GetSlope() const noexcept {
        return form_.third == ActivationForm{}.third ? 80.0 / 3.0 : 80.0 * static_cast<double>(form_.third);
    }

    void AddCurve(int index, double value, double side) noexcept {
        const double z = -0.75 + side * std::sqrt(0.5625 + 3.0 * (value + 113.0) / 80.0);
        const double rise =
            std::fabs(160.0 / 3.0 * z + 40.0);        // at least 7.3: a step of 0.5 from the extremum
        middles_[index] = {z, 1.01 * kMargin / rise}; // it changes by less than 0.1 % within reach
    }

    /// Of numbers below 2^26, without the library's function, which is a call on older processors.
    static std::int64_t Floor(double value) noexcept {
        return static_cast<std::int64_t>(value + 0x1p26) - (std::int64_t{1} << 26);
    }

    /// 0, 1, -1, 2, -2, … units in the last place away.
    static float Step(float value, int index) noexcept {
        const int step = (index + 1) / 2 * (index % 2 != 0 ? 1 : -1);
        return BitCast<float>(BitCast<std::int32_t>(value) + step);
    }

    bool FindLimit(FusedRow& row, float limit, int first, int last) const noexcept {
        for (int i = 0; i <= 2 * kLimitSteps; ++i) {
            row.limit = Step(limit, i);
            if (Agrees(row, first, last))
                return true;
        }
        return false;
    }

    bool FindSlope(FusedRow& row, float slope, float offset, int last) const noexcept {
        for (int i = 0; i < (2 * kSlopeSteps + 1) * (2 * kSlopeSteps + 1); ++i) {
            row.slope = Step(slope, i / (2 * kSlopeSteps + 1));
            row.offset = Step(offset, i % (2 * kSlopeSteps + 1));
            if (Agrees(row, 0, last))
                return true;
        }
        return false;
    }

    bool Agrees(const FusedRow& row, int first, int last) const noexcept {
        for (int i = first; i < last; ++i) {
            if (RequantizeFused(candidates_[i].sum, row) != candidates_[i].integer)
                return false;
        }
        return true;
    }

    ActivationForm form_;
    Middle middles_[kMiddles];
    Candidate candidates_[kMaxCandidates];
};

} // namespace openntc::fast

#include "openntc/core/RestoreMacros.h"
