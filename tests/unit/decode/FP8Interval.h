// SPDX-License-Identifier: MIT
// What FP8 hardware may return. E4M3 products are exact, but hardware adds them up in an order and precision of its own,
// and a compiler may fuse the multiplications and additions of the activation. This computes, per texel, an interval
// around every result that is possible under:
//   1. inputs are rounded to E4M3 to nearest even, saturating; or, with `halfInputs`, the hidden layers take the
//      activation's halves as they are;
//   2. a row's n products and bias are added in any order, each addition with an error of at most u times the power of
//      two below its result (2^-24: binary32 accumulators) and none where its exact result has no more significant bits
//      than 1 / u, and the sum is rounded once to nearest half; or, with `block`, as tensor cores do that multiply E4M3 as
//      binary16: bias and products of the first `block` inputs are added and rounded to nearest half, to which the
//      products of the next ones are added, and so on;
//   3. the activation is binary16 arithmetic; z h3 + 1/2 and 80 y - 113 are fused or not, in every row anew, unless the
//      shader forbids contraction (ours do: all of it is `precise`);
//   4. layer 3 is exact int32 arithmetic with nearest-even conversion of its inputs.
//
// Row. Terms t_i: products and bias. In any order every exact partial sum is a sum of some of the terms, so its magnitude
// is at most M, the larger of the sum of the positive and of the negative terms. m terms that are not zero take m - 1
// additions; with a total error of E no partial sum exceeds M + E, so E <= (m - 1) u 2^floor(log2(M + E)). Where all terms
// are multiples of a power of two p and M <= p / u, every partial sum in every order is a multiple of p that needs no more
// bits than 1 / u: all additions are exact. With binary32 accumulators that is the usual case. With inputs in [a_i, b_i]
// the real sum lies between the sums of the smaller and of the larger of w_i a_i, w_i b_i. Rounding to half is monotone:
// rounding both ends encloses it. With `block`, terms are cut off `cut` bits below the exponent of the largest (a product's:
// the sum of its factors' exponents), as published models of tensor cores have it (P. Xie and others, MMA-Sim, arXiv
// 2511.10909); exact where the inputs are single numbers, else at most one unit a term.
// Activation. A function of one half, evaluated in its variants for all 63 488 finite halves; the image of an interval is
// the least and the greatest value in it (tables of ranges of 2^k neighbours). No bound is lost here.
// Networks. After layers 0 and 1 most numbers are one E4M3 code. Where some are one of few, every combination is followed
// through the layers behind on its own, if there are at most `branches` in all, and the outputs' hull is taken at the end;
// otherwise they stay intervals. The hull is exact where no interval was left: hardware may make every combination.
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

/// What is assumed of hardware and compiler.
struct FP8Assumptions {
    double unit = 0x1p-24;     ///< error of an addition, see above
    bool halfInputs = false;   ///< the hidden layers' inputs are not rounded to E4M3
    std::size_t block = 0;     ///< 0: any order; else inputs between roundings to half, in order
    int cut = 25;              ///< bits below the largest term's exponent that terms of a block keep
    bool contraction = true;   ///< the activation's multiplications and additions may be fused
    std::size_t branches = 64; ///< networks followed; 1: intervals only
};

class FP8Interval {
public:
    explicit FP8Interval(FP8Assumptions assumptions = {}) : assumptions_(assumptions) {
        for (int index = 0; index < static_cast<int>(kHalves); ++index) {
            const double z = GetHalf(index);
            Interval y = {1e9, -1e9};
            Interval byte = {1e9, -1e9};
            const double h3 = HalfValue(0x3555);
            for (int fused = 0; fused <= (assumptions.contraction ? 1 : 0); ++fused) {
                const double gate = ToHalf((fused != 0 ? h3 * z : ToHalf(h3 * z)) + 0.5);
                const double value = ToHalf(std::min(z, 3.0) * std::clamp(gate, 0.0, 1.0));
                Extend(y, assumptions.halfInputs ? value : ToE4M3(value));
                Extend(byte, std::clamp(std::nearbyint(ToHalf(ToHalf(value * 80) - 113)), -128.0, 127.0));
                if (assumptions.contraction)
                    Extend(byte, std::clamp(std::nearbyint(ToHalf(value * 80 - 113)), -128.0, 127.0));
            }
            activation_[0].push_back(y);
            bytes_[0].push_back(byte);
        }
        FillRanges(activation_);
        FillRanges(bytes_);
        for (std::size_t code = 0; code < 256; ++code)
            weights_[code] =
                MakeTerm({E4M3Value(static_cast<std::byte>(code)), E4M3Value(static_cast<std::byte>(code))});
    }

    std::array<Interval, 16> Decode(const ModelSource& source, int mip, int x, int y) const {
        std::vector<Interval> inputs;
        for (const double input : GetFP8ModelInputs(source, mip, x, y))
            inputs.push_back({ToE4M3(input), ToE4M3(input)});
        std::array<Interval, 16> outputs;
        outputs.fill({1e300, -1e300});
        Follow(source, 0, inputs, assumptions_.branches, outputs);
        return outputs;
    }

private:
    /// A number of several possible ones, a power of two that all of them are multiples of, and the exponent of the
    /// largest.
    struct Term {
        double low, high, step;
        int exponent;
    };

    /// One layer and all behind it; extends `outputs` by what they may give. `branches`: networks that may be followed.
    void Follow(const ModelSource& source, std::size_t l, const std::vector<Interval>& inputs,
                std::size_t branches, std::array<Interval, 16>& outputs) const {
        const std::size_t biases =
            static_cast<std::size_t>(source.constants->networkScaleBiasOffset) + 128 * l;
        const ModelLayer layer = GetModelLayers(source)[l];
        std::vector<Term> terms;
        for (const Interval& input : inputs)
            terms.push_back(MakeTerm(input));
        std::vector<Interval> next;
        for (std::size_t row = 0; row < 64; ++row) {
            const double bias = HalfValue(LoadAt<std::uint16_t>(source.weights, biases + 2 * row));
            next.push_back(GetImage(l == 2 ? bytes_ : activation_, GetRow(source, layer, row, bias, terms)));
        }
        if (l == 2)
            return ExtendByOutputs(source, next, biases + 128, outputs);
        // The numbers to branch on, and the numbers that each may be: all between its ends.
        std::vector<std::pair<std::size_t, std::vector<double>>> open;
        std::size_t combinations = 1;
        for (std::size_t row = 0; row < 64; ++row) {
            if (next[row].low == next[row].high)
                continue;
            open.emplace_back(row, ListNumbers(next[row], branches / combinations));
            combinations *= open.back().second.size();
            if (combinations == 0) { // too many
                open.clear();
                combinations = 1;
                break;
            }
        }
        for (std::size_t index = 0; index < combinations; ++index) {
            std::size_t rest = index;
            for (const auto& [row, numbers] : open) {
                const double number = numbers[rest % numbers.size()];
                next[row] = {number, number};
                rest /= numbers.size();
            }
            Follow(source, l + 1, next, branches / combinations, outputs);
        }
    }

    /// The numbers of an interval that a layer may be given; none if there are more than `limit`.
    std::vector<double> ListNumbers(Interval interval, std::size_t limit) const {
        std::vector<double> numbers;
        for (double number = interval.low; number <= interval.high;) {
            if (numbers.size() == limit)
                return {};
            numbers.push_back(number);
            // Out of a power of two the spacing toward zero is half of what it is away from it.
            const double spacing = GetSpacing(number);
            number += number < 0 ? GetSpacing(number + spacing / 2) : spacing;
        }
        return numbers;
    }

    /// Between the numbers of a magnitude that a layer may be given: E4M3 numbers or halves.
    double GetSpacing(double x) const {
        const double least = assumptions_.halfInputs ? 0x1p-24 : 0x1p-9;
        int exponent = 0;
        std::frexp(x, &exponent);
        return x == 0 ? least : std::max(least, std::ldexp(1, exponent - (assumptions_.halfInputs ? 11 : 4)));
    }

    /// Subnormal halves count with the exponent of the least normal one.
    Term MakeTerm(Interval x) const {
        const double largest = std::max(std::fabs(x.low), std::fabs(x.high));
        return {x.low, x.high, GetStep(x), std::max(-14, GetExponent(largest))};
    }

    static constexpr std::size_t kHalves = 2 * 0x7C00;
    using Tables = std::array<std::vector<Interval>, 16>;

    /// tables[k][i]: what 2^k neighbours from the i-th on have.
    static void FillRanges(Tables& tables) {
        for (std::size_t k = 1; (std::size_t{1} << k) <= kHalves; ++k) {
            const std::vector<Interval>& half = tables[k - 1];
            const std::size_t step = std::size_t{1} << (k - 1);
            for (std::size_t i = 0; i + 2 * step <= kHalves; ++i)
                tables[k].push_back(
                    {std::min(half[i].low, half[i + step].low), std::max(half[i].high, half[i + step].high)});
        }
    }

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

    /// A power of two that every number of the interval is a multiple of: a single number's lowest bit, else the spacing at
    /// the end that is nearer to zero.
    double GetStep(Interval x) const {
        if (x.low == 0 && x.high == 0)
            return 0x1p40;
        if (x.low == x.high) {
            // Halves and E4M3 numbers are multiples of 2^-24.
            const auto units = static_cast<std::uint64_t>(std::fabs(x.low) * 0x1p24);
            return static_cast<double>(units & (0 - units)) * 0x1p-24;
        }
        return GetSpacing(x.low <= 0 && x.high >= 0 ? 0 : std::min(std::fabs(x.low), std::fabs(x.high)));
    }

    /// What a number of terms adds up to, and what their magnitudes say about rounding.
    struct Sum {
        double low = 0, high = 0;          ///< of the exact sum
        double positive = 0, negative = 0; ///< magnitudes of the terms of either sign
        double step = 0x1p40;              ///< all terms are multiples of it
        double terms = 0;                  ///< that are not zero

        void Add(double low1, double high1, double step1) {
            low += low1;
            high += high1;
            positive += std::max(high1, 0.0);
            negative += std::max(-low1, 0.0);
            step = std::min(step, step1);
            terms += low1 == 0 && high1 == 0 ? 0 : 1;
        }
    };

    Interval GetRow(const ModelSource& source, const ModelLayer& layer, std::size_t row, double bias,
                    const std::vector<Term>& inputs) const {
        const std::byte* const codes = &source.weights[layer.weights + row * layer.inputs];
        if (assumptions_.block != 0)
            return GetBlocks(codes, bias, inputs);
        Sum sum;
        sum.Add(bias, bias, GetStep({bias, bias}));
        for (std::size_t i = 0; i < inputs.size(); ++i) {
            const Term& w = weights_[std::to_integer<std::size_t>(codes[i])];
            const Term& x = inputs[i];
            sum.Add(std::min(w.low * x.low, w.low * x.high), std::max(w.low * x.low, w.low * x.high),
                    w.step * x.step);
        }
        // The sums above are exact in double: products are multiples of 2^-33, all of them together below 2^19.
        const double margin = GetMargin(sum);
        return {ToHalf(sum.low - margin), ToHalf(sum.high + margin)};
    }

    double GetMargin(const Sum& sum) const {
        const double largest = std::max(sum.positive, sum.negative);
        if (largest * assumptions_.unit <= sum.step)
            return 0;
        const double error = (sum.terms - 1) * assumptions_.unit;
        return std::ldexp(error, GetExponent(largest + error * largest / (1 - error)));
    }

    Interval GetBlocks(const std::byte* codes, double bias, const std::vector<Term>& inputs) const {
        Interval z = {bias, bias};
        for (std::size_t first = 0; first < inputs.size(); first += assumptions_.block) {
            const std::size_t last = std::min(first + assumptions_.block, inputs.size());
            std::vector<Interval> terms = {z};
            int exponent = z.low == 0 && z.high == 0
                               ? -99
                               : std::max(-14, GetExponent(std::max(std::fabs(z.low), std::fabs(z.high))));
            bool single = z.low == z.high;
            for (std::size_t i = first; i < last; ++i) {
                const Term& w = weights_[std::to_integer<std::size_t>(codes[i])];
                const Term& x = inputs[i];
                terms.push_back(
                    {std::min(w.low * x.low, w.low * x.high), std::max(w.low * x.low, w.low * x.high)});
                single = single && x.low == x.high;
                if (w.low != 0 && (x.low != 0 || x.high != 0))
                    exponent = std::max(exponent, std::max(-6, GetExponent(w.low)) + x.exponent);
            }
            const double unit = std::ldexp(1, exponent - assumptions_.cut);
            Interval sum = {0, 0};
            for (const Interval& term : terms) {
                // Toward zero: monotone for a given unit. The unit of an interval is at most this one.
                sum.low += single ? std::trunc(term.low / unit) * unit : term.low - (term.low > 0 ? unit : 0);
                sum.high +=
                    single ? std::trunc(term.high / unit) * unit : term.high + (term.high < 0 ? unit : 0);
            }
            z = {ToHalf(sum.low), ToHalf(sum.high)};
        }
        return z;
    }

    static int GetExponent(double x) {
        int exponent = 0;
        std::frexp(x, &exponent);
        return exponent - 1;
    }

    static void ExtendByOutputs(const ModelSource& source, const std::vector<Interval>& bytes,
                                std::size_t scales, std::array<Interval, 16>& outputs) {
        const ModelLayer layer = GetModelLayers(source)[3];
        for (std::size_t row = 0; row < 16; ++row) {
            Interval sum{};
            sum.low = sum.high = LoadAt<std::int32_t>(source.weights, scales + 64 + 4 * row);
            for (std::size_t i = 0; i < 64; ++i) {
                const double q = ModelInt8Weight(source, layer, row, i);
                sum.low += std::min(q * bytes[i].low, q * bytes[i].high);
                sum.high += std::max(q * bytes[i].low, q * bytes[i].high);
            }
            const double scale = static_cast<double>(LoadAt<float>(source.weights, scales + 4 * row));
            Extend(outputs[row], ToBinary32(ToBinary32(sum.low) * scale));
            Extend(outputs[row], ToBinary32(ToBinary32(sum.high) * scale));
        }
    }

    FP8Assumptions assumptions_;
    std::array<Term, 256> weights_; ///< by code
    Tables activation_;
    Tables bytes_;
};

} // namespace test
