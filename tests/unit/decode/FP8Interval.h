// SPDX-License-Identifier: MIT
// What FP8 hardware may return. E4M3 products are exact, but hardware adds them up in an order and precision of its own,
// and a compiler may fuse the multiplications and additions of the activation. This computes, per texel, an interval
// around every result that is possible under:
//   1. inputs are rounded to E4M3 to nearest even, saturating;
//   2. a row's n products and bias are added in any order, each addition with relative error at most u (2^-24 for
//      binary32 accumulators) and none where its exact result has no more significant bits than 1 / u, and the sum is
//      rounded once to nearest half;
//   3. the activation is binary16 arithmetic, z h3 + 1/2 and 80 y - 113 fused or not;
//   4. layer 3 is exact int32 arithmetic with nearest-even conversion of its inputs.
//
// Row. With n additions in any order the computed sum is sum_i t_i (1 + d_i), |d_i| <= g = n u / (1 - n u), over the
// terms t_i (products and bias), because every term passes at most n additions: so it lies within g sum |t_i| of the real
// sum. With inputs in [a_i, b_i] the real sum lies between the sums of the smaller and of the larger of w_i a_i, w_i b_i,
// and |t_i| <= |w_i| max(|a_i|, |b_i|). Rounding to half is monotone: rounding both ends encloses it.
// Where all terms are multiples of a power of two p and sum |t_i| <= p / u, every partial sum in every order is a multiple
// of p that needs no more bits than 1 / u: all additions are exact. With binary32 accumulators that is the usual case.
// Activation. A function of one half, evaluated in its four variants for all 63 488 finite halves; the image of an
// interval is the least and the greatest value in it (tables of ranges of 2^k neighbours). No bound is lost here.
// Layer 3. Integers in [a_i, b_i]: exact ends; the float of the sum and the product with S are monotone.
#pragma once

#include "ModeModel.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

namespace test {

struct Interval {
    double low, high;
};

class FP8Interval {
public:
    explicit FP8Interval(double unit) : unit_(unit) {
        for (int index = 0; index < static_cast<int>(kHalves); ++index) {
            const double z = GetHalf(index);
            Interval y = {1e9, -1e9};
            Interval byte = {1e9, -1e9};
            const double h3 = HalfValue(0x3555);
            for (const double gate : {ToHalf(ToHalf(h3 * z) + 0.5), ToHalf(h3 * z + 0.5)}) {
                const double value = ToHalf(std::min(z, 3.0) * std::clamp(gate, 0.0, 1.0));
                Extend(y, ToE4M3(value));
                for (const double t : {ToHalf(ToHalf(value * 80) - 113), ToHalf(value * 80 - 113)})
                    Extend(byte, std::clamp(std::nearbyint(t), -128.0, 127.0));
            }
            activation_[0].push_back(y);
            bytes_[0].push_back(byte);
        }
        for (std::size_t k = 1; (std::size_t{1} << k) <= kHalves; ++k) {
            for (auto* table : {&activation_, &bytes_}) {
                const std::vector<Interval>& half = (*table)[k - 1];
                const std::size_t step = std::size_t{1} << (k - 1);
                for (std::size_t i = 0; i + 2 * step <= kHalves; ++i)
                    (*table)[k].push_back({std::min(half[i].low, half[i + step].low),
                                           std::max(half[i].high, half[i + step].high)});
            }
        }
    }

    std::array<Interval, 16> Decode(const ModelSource& source, int mip, int x, int y) const {
        std::vector<Interval> inputs;
        for (const double input : GetFP8ModelInputs(source, mip, x, y))
            inputs.push_back({ToE4M3(input), ToE4M3(input)});
        std::size_t biases = static_cast<std::size_t>(source.constants->networkScaleBiasOffset);
        for (std::size_t l = 0; l < 3; ++l) {
            const ModelLayer layer = GetModelLayers(source)[l];
            std::vector<Interval> next;
            for (std::size_t row = 0; row < 64; ++row) {
                const double bias = HalfValue(LoadAt<std::uint16_t>(source.weights, biases + 2 * row));
                const Interval z = GetRow(source, layer, row, bias, inputs);
                next.push_back(GetImage(l == 2 ? bytes_ : activation_, z));
            }
            inputs = next;
            biases += 128;
        }
        return GetOutputs(source, inputs, biases);
    }

private:
    static constexpr std::size_t kHalves = 2 * 0x7C00;
    using Tables = std::array<std::vector<Interval>, 16>;

    static void Extend(Interval& interval, double value) {
        interval = {std::min(interval.low, value), std::max(interval.high, value)};
    }

    /// Finite halves in ascending order; both zeros occur.
    static double GetHalf(int index) {
        return index < 0x7C00 ? HalfValue(static_cast<std::uint16_t>(0xFBFF - index))
                              : HalfValue(static_cast<std::uint16_t>(index - 0x7C00));
    }

    /// Index of a half; for zero the first or the last of both.
    static std::size_t GetIndex(double half, bool last) {
        int exponent = 0;
        const double magnitude = std::min(std::fabs(half), 65504.0);
        std::frexp(magnitude, &exponent);
        // Normal: the bits count up with the value within a binade of 2^10 halves.
        const double code = magnitude < 0x1p-14
                                ? magnitude * 0x1p24
                                : std::ldexp(magnitude, 11 - exponent) - 1024 + 1024 * (exponent + 14);
        const int index = static_cast<int>(code);
        const bool negative = half < 0 || (half == 0 && !last);
        return static_cast<std::size_t>(negative ? 0x7BFF - index : 0x7C00 + index);
    }

    static Interval GetImage(const Tables& tables, Interval z) {
        const std::size_t first = GetIndex(z.low, false);
        const std::size_t count = GetIndex(z.high, true) - first + 1;
        const std::size_t k = static_cast<std::size_t>(std::bit_width(count)) - 1;
        const Interval a = tables[k][first];
        const Interval b = tables[k][first + count - (std::size_t{1} << k)];
        return {std::min(a.low, b.low), std::max(a.high, b.high)};
    }

    /// A power of two that every number of the interval is a multiple of: a single number's lowest bit, else the spacing of
    /// E4M3 numbers at the end that is nearer to zero.
    static double GetStep(Interval x) {
        if (x.low == x.high) {
            // Halves and E4M3 numbers are multiples of 2^-24.
            const auto units = static_cast<std::uint64_t>(std::fabs(x.low) * 0x1p24);
            return static_cast<double>(units & (0 - units)) * 0x1p-24;
        }
        if (x.low <= 0 && x.high >= 0)
            return 0x1p-9;
        int exponent = 0;
        std::frexp(std::min(std::fabs(x.low), std::fabs(x.high)), &exponent);
        return std::max(0x1p-9, std::ldexp(1, exponent - 4));
    }

    Interval GetRow(const ModelSource& source, const ModelLayer& layer, std::size_t row, double bias,
                    const std::vector<Interval>& inputs) const {
        Interval sum = {bias, bias};
        double magnitude = std::fabs(bias);
        double step = bias == 0 ? 0x1p40 : GetStep({bias, bias});
        for (std::size_t i = 0; i < layer.inputs; ++i) {
            const double w = E4M3Value(source.weights[layer.weights + row * layer.inputs + i]);
            sum.low += std::min(w * inputs[i].low, w * inputs[i].high);
            sum.high += std::max(w * inputs[i].low, w * inputs[i].high);
            magnitude += std::fabs(w) * std::max(std::fabs(inputs[i].low), std::fabs(inputs[i].high));
            if (w != 0 && (inputs[i].low != 0 || inputs[i].high != 0))
                step = std::min(step, GetStep({w, w}) * GetStep(inputs[i]));
        }
        if (magnitude * unit_ <= step)
            return {ToHalf(sum.low), ToHalf(sum.high)};
        const double n = static_cast<double>(layer.inputs);
        // The sums above are exact in double: products are multiples of 2^-18 below 2^18, and n < 100.
        const double margin = n * unit_ / (1 - n * unit_) * magnitude;
        return {ToHalf(sum.low - margin), ToHalf(sum.high + margin)};
    }

    static std::array<Interval, 16> GetOutputs(const ModelSource& source, const std::vector<Interval>& bytes,
                                               std::size_t scales) {
        const ModelLayer layer = GetModelLayers(source)[3];
        std::array<Interval, 16> outputs{};
        for (std::size_t row = 0; row < 16; ++row) {
            Interval sum{};
            sum.low = sum.high = LoadAt<std::int32_t>(source.weights, scales + 64 + 4 * row);
            for (std::size_t i = 0; i < 64; ++i) {
                const double q = ModelInt8Weight(source, layer, row, i);
                sum.low += std::min(q * bytes[i].low, q * bytes[i].high);
                sum.high += std::max(q * bytes[i].low, q * bytes[i].high);
            }
            const double scale = static_cast<double>(LoadAt<float>(source.weights, scales + 4 * row));
            const double a = ToBinary32(ToBinary32(sum.low) * scale);
            const double b = ToBinary32(ToBinary32(sum.high) * scale);
            outputs[row] = {std::min(a, b), std::max(a, b)};
        }
        return outputs;
    }

    double unit_;
    Tables activation_;
    Tables bytes_;
};

} // namespace test
