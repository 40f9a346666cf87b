// SPDX-License-Identifier: MIT
#include "FP8Interval.h"

#include "ModelInputs.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <utility>

namespace openntc::models {

namespace {

constexpr std::size_t kHalves = 2 * 0x7C00;
using Tables = std::array<std::vector<Interval>, 16>;

/// tables[k][i]: what 2^k neighbours from the i-th on have.
void FillRanges(Tables& tables) {
    for (std::size_t k = 1; (std::size_t{1} << k) <= kHalves; ++k) {
        const std::vector<Interval>& half = tables[k - 1];
        const std::size_t step = std::size_t{1} << (k - 1);
        for (std::size_t i = 0; i + 2 * step <= kHalves; ++i)
            tables[k].push_back(
                {std::min(half[i].low, half[i + step].low), std::max(half[i].high, half[i + step].high)});
    }
}

void Extend(Interval& interval, double value) {
    interval = {std::min(interval.low, value), std::max(interval.high, value)};
}

/// Finite halves in ascending order; both zeros occur.
double GetHalf(int index) {
    return index < 0x7C00 ? HalfValue(static_cast<std::uint16_t>(0xFBFF - index))
                          : HalfValue(static_cast<std::uint16_t>(index - 0x7C00));
}

/// Index of a half; for zero the first or the last of both.
std::size_t GetIndex(double half, bool last) {
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

Interval GetImage(const Tables& tables, Interval z) {
    const std::size_t first = GetIndex(z.low, false);
    const std::size_t count = GetIndex(z.high, true) - first + 1;
    const std::size_t k = static_cast<std::size_t>(std::bit_width(count)) - 1;
    const Interval a = tables[k][first];
    const Interval b = tables[k][first + count - (std::size_t{1} << k)];
    return {std::min(a.low, b.low), std::max(a.high, b.high)};
}

int GetExponent(double x) {
    int exponent = 0;
    std::frexp(x, &exponent);
    return exponent - 1;
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

double GetMargin(const Sum& sum, double unit) {
    const double largest = std::max(sum.positive, sum.negative);
    if (largest * unit <= sum.step)
        return 0;
    const double error = (sum.terms - 1) * unit;
    return std::ldexp(error, GetExponent(largest + error * largest / (1 - error)));
}

void ExtendByOutputs(const ModelSource& source, const std::vector<Interval>& bytes, std::size_t scales,
                     std::array<Interval, 16>& outputs) {
    const ModelLayer layer = GetModelLayers(source)[3];
    for (std::size_t row = 0; row < 16; ++row) {
        Interval sum{};
        sum.low = sum.high = LoadAt<std::int32_t>(source.weights, scales + 64 + 4 * row);
        for (std::size_t i = 0; i < layer.inputs; ++i) {
            const double q = ModelInt8Weight(source, layer, row, i);
            sum.low += std::min(q * bytes[i].low, q * bytes[i].high);
            sum.high += std::max(q * bytes[i].low, q * bytes[i].high);
        }
        const double scale = static_cast<double>(LoadAt<float>(source.weights, scales + 4 * row));
        Extend(outputs[row], ToBinary32(ToBinary32(sum.low) * scale));
        Extend(outputs[row], ToBinary32(ToBinary32(sum.high) * scale));
    }
}

} // namespace

FP8Interval::FP8Interval(FP8Assumptions assumptions) : assumptions_(assumptions) {
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

std::array<Interval, 16> FP8Interval::Decode(const ModelSource& source, int mip, int x, int y) const {
    std::vector<Interval> inputs;
    for (const double input : GetFP8ModelInputs(source, mip, x, y))
        inputs.push_back({ToE4M3(input), ToE4M3(input)});
    std::array<Interval, 16> outputs;
    outputs.fill({1e300, -1e300});
    Follow(source, 0, inputs, assumptions_.branches, outputs);
    return outputs;
}

void FP8Interval::Follow(const ModelSource& source, std::size_t l, const std::vector<Interval>& inputs,
                         std::size_t branches, std::array<Interval, 16>& outputs) const {
    const ModelLayer layer = GetModelLayers(source)[l];
    const std::size_t biases =
        static_cast<std::size_t>(source.constants->networkScaleBiasOffset) + 2 * layer.firstRow;
    std::vector<Term> terms;
    terms.reserve(inputs.size());
    for (const Interval& input : inputs)
        terms.push_back(MakeTerm(input));
    std::vector<Interval> next;
    for (std::size_t row = 0; row < layer.rows; ++row) {
        const double bias = HalfValue(LoadAt<std::uint16_t>(source.weights, biases + 2 * row));
        next.push_back(GetImage(l == 2 ? bytes_ : activation_, GetRow(source, layer, row, bias, terms)));
    }
    if (l == 2)
        return ExtendByOutputs(source, next, biases + 2 * layer.rows, outputs);
    // The numbers to branch on, and the numbers that each may be: all between its ends.
    std::vector<std::pair<std::size_t, std::vector<double>>> open;
    std::size_t combinations = 1;
    for (std::size_t row = 0; row < layer.rows; ++row) {
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

std::vector<double> FP8Interval::ListNumbers(Interval interval, std::size_t limit) const {
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

double FP8Interval::GetSpacing(double x) const {
    const double least = assumptions_.halfInputs ? 0x1p-24 : 0x1p-9;
    int exponent = 0;
    std::frexp(x, &exponent);
    return x == 0 ? least : std::max(least, std::ldexp(1, exponent - (assumptions_.halfInputs ? 11 : 4)));
}

FP8Interval::Term FP8Interval::MakeTerm(Interval x) const {
    const double largest = std::max(std::fabs(x.low), std::fabs(x.high));
    return {x.low, x.high, GetStep(x), std::max(-14, GetExponent(largest))};
}

double FP8Interval::GetStep(Interval x) const {
    if (x.low == 0 && x.high == 0)
        return 0x1p40;
    if (x.low == x.high) {
        // Halves and E4M3 numbers are multiples of 2^-24.
        const auto units = static_cast<std::uint64_t>(std::fabs(x.low) * 0x1p24);
        return static_cast<double>(units & (0 - units)) * 0x1p-24;
    }
    return GetSpacing(x.low <= 0 && x.high >= 0 ? 0 : std::min(std::fabs(x.low), std::fabs(x.high)));
}

Interval FP8Interval::GetRow(const ModelSource& source, const ModelLayer& layer, std::size_t row, double bias,
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
    const double margin = GetMargin(sum, assumptions_.unit);
    return {ToHalf(sum.low - margin), ToHalf(sum.high + margin)};
}

Interval FP8Interval::GetBlocks(const std::byte* codes, double bias, const std::vector<Term>& inputs) const {
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
            sum.high += single ? std::trunc(term.high / unit) * unit : term.high + (term.high < 0 ? unit : 0);
        }
        z = {ToHalf(sum.low), ToHalf(sum.high)};
    }
    return z;
}

} // namespace openntc::models
