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

#include <array>
#include <cstddef>
#include <vector>

namespace openntc::models {

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

/// Immutable after construction; Decode may be called from any thread. The tables take some megabytes.
class FP8Interval {
public:
    explicit FP8Interval(FP8Assumptions assumptions = {});

    /// The interval of each of the 16 outputs of a texel inside the mip. Some tens of microseconds.
    std::array<Interval, 16> Decode(const ModelSource& source, int mip, int x, int y) const;

private:
    /// A number of several possible ones, a power of two that all of them are multiples of, and the exponent of the
    /// largest.
    struct Term {
        double low, high, step;
        int exponent;
    };

    using Tables = std::array<std::vector<Interval>, 16>;

    /// One layer and all behind it; extends `outputs` by what they may give. `branches`: networks that may be followed.
    void Follow(const ModelSource& source, std::size_t l, const std::vector<Interval>& inputs,
                std::size_t branches, std::array<Interval, 16>& outputs) const;
    /// The numbers of an interval that a layer may be given; none if there are more than `limit`.
    std::vector<double> ListNumbers(Interval interval, std::size_t limit) const;
    /// Between the numbers of a magnitude that a layer may be given: E4M3 numbers or halves.
    double GetSpacing(double x) const;
    /// Subnormal halves count with the exponent of the least normal one.
    Term MakeTerm(Interval x) const;
    /// A power of two that every number of the interval is a multiple of: a single number's lowest bit, else the spacing at
    /// the end that is nearer to zero.
    double GetStep(Interval x) const;
    Interval GetRow(const ModelSource& source, const ModelLayer& layer, std::size_t row, double bias,
                    const std::vector<Term>& inputs) const;
    Interval GetBlocks(const std::byte* codes, double bias, const std::vector<Term>& inputs) const;

    FP8Assumptions assumptions_;
    std::array<Term, 256> weights_; ///< by code
    Tables activation_;
    Tables bytes_;
};

} // namespace openntc::models
