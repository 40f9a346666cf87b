// SPDX-License-Identifier: MIT
// Products of matrices in blocks that stay in registers: kBlockRows rows by kBlockColumns columns of sixteen
// numbers.

/// Sums of kRows rows and kColumns columns of sixteen.
template <int kRows, int kColumns>
using Sums = Sum[static_cast<std::size_t>(kRows)][static_cast<std::size_t>(kColumns)];

/// sums[r][c] = start[16 c ...], or 0 without `start`, and the sum over `units` k of a[r * kRowStep + k *
/// kUnitStep] times b[k * pitch + 16 c ...], in the order of k.
template <int kRows, int kColumns, int kRowStep, int kUnitStep>
OPENNTC_FAST_INLINE void MultiplyBlock(const float* a, const float* b, const float* start, int pitch,
                                       int units, Sums<kRows, kColumns>& sums) {
    OPENNTC_FAST_UNROLL
    for (int c = 0; c < kColumns; ++c) {
        const Float first = start == nullptr ? Set(0.0f) : Load(start + 16 * c);
        OPENNTC_FAST_UNROLL
        for (int r = 0; r < kRows; ++r)
            sums[r][c] = first;
    }
    for (int k = 0; k < units; ++k) {
        Float right[static_cast<std::size_t>(kColumns)];
        OPENNTC_FAST_UNROLL
        for (int c = 0; c < kColumns; ++c)
            right[c] = Load(b + 16 * c);
        OPENNTC_FAST_UNROLL
        for (int r = 0; r < kRows; ++r) {
            const NativeFloat left = SetNative(a[r * kRowStep]);
            OPENNTC_FAST_UNROLL
            for (int c = 0; c < kColumns; ++c)
                AddDot(sums[r][c], left, right[c]);
        }
        a += kUnitStep;
        b += pitch;
    }
}

/// Factors of a product: rows of `a` times columns of `b` (units [k][column] of `pitch`).
struct Factors {
    const float* a;
    const float* b;
    int pitch, units;
    const float* start = nullptr; ///< [column]: what sums begin with, if not 0

    const float* GetStart(int column) const { return start == nullptr ? nullptr : start + 16 * column; }
};

template <int kRows, int kColumns, int kRowStep, int kUnitStep, typename Finish>
OPENNTC_FAST_INLINE void MultiplyRows(const Factors& f, int row, int columns, const Finish& finish) {
    int c = 0;
    for (; c + kColumns <= columns; c += kColumns) {
        Sums<kRows, kColumns> sums;
        MultiplyBlock<kRows, kColumns, kRowStep, kUnitStep>(f.a + row * kRowStep, f.b + 16 * c, f.GetStart(c),
                                                            f.pitch, f.units, sums);
        finish.template Do<kRows, kColumns>(row, c, sums);
    }
    if constexpr (kColumns > 1) {
        for (; c < columns; ++c) {
            Sums<kRows, 1> sums;
            MultiplyBlock<kRows, 1, kRowStep, kUnitStep>(f.a + row * kRowStep, f.b + 16 * c, f.GetStart(c),
                                                         f.pitch, f.units, sums);
            finish.template Do<kRows, 1>(row, c, sums);
        }
    }
}

/// Calls finish.Do<R, C>(row, column, sums) for blocks of R rows and C columns of sixteen that cover `rows`
/// (a multiple of 16) by `columns`.
template <int kRowStep, int kUnitStep, typename Finish>
OPENNTC_FAST_INLINE void MultiplyAll(const Factors& f, int rows, int columns, const Finish& finish) {
    int row = 0;
    for (; row + kBlockRows <= rows; row += kBlockRows)
        MultiplyRows<kBlockRows, kBlockColumns, kRowStep, kUnitStep>(f, row, columns, finish);
    if constexpr (16 % kBlockRows != 0) {
        for (; row + 4 <= rows; row += 4)
            MultiplyRows<4, kBlockColumns, kRowStep, kUnitStep>(f, row, columns, finish);
        for (; row < rows; row += 2)
            MultiplyRows<2, kBlockColumns, kRowStep, kUnitStep>(f, row, columns, finish);
    }
}
