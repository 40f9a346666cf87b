// SPDX-License-Identifier: MIT
// Operands of Matrix.inl in binary32: a unit is a number, and rows of texels serve both directions.

inline constexpr int kTerms = 1; ///< numbers in a unit

using Sum = Float;

OPENNTC_FAST_INLINE void AddDot(Sum& sum, const NativeFloat& a, const Float& b) {
    OPENNTC_FAST_UNROLL
    for (int k = 0; k < kParts; ++k)
        sum.part[k] = MultiplyAdd(a, b.part[k], sum.part[k]);
}

/// Numbers [texel][channel] of a tile.
struct Operand {
    /// Odd numbers of cache lines between texels: columns of texels then lie in all sets of a cache.
    static constexpr int kRowPitch = kMostChannels + 16, kColumnPitch = kRowPitch;

    AlignedBuffer<float> rows;

    Operand() : rows(std::size_t{kTileTexels} * kRowPitch) {}
    const float* GetRow(int texel) const { return rows.data() + texel * kRowPitch; }
    const float* GetColumns() const { return rows.data(); }
    /// Sixteen channels of texels `texel`, which is even, and `texel` + 1.
    OPENNTC_FAST_INLINE void Put(int texel, int channel, const Float& even, const Float& odd) {
        float* to = rows.data() + texel * kRowPitch + channel;
        Store(to, even);
        Store(to + kRowPitch, odd);
    }
};

/// Weights of inputs `input`, which is even, and `input` + 1 to sixteen outputs: those of the forward pass to
/// units [input][output] of `pitch`, those of the backward pass to units [output][input].
OPENNTC_FAST_INLINE void PackWeights(float* forward, int pitch, const Float& even, const Float& odd) {
    Store(forward, even);
    Store(forward + pitch, odd);
}
OPENNTC_FAST_INLINE void PackTransposed(float* backward, int pitch, const Float& even, const Float& odd) {
    alignas(64) float values[2][16];
    Store(values[0], even);
    Store(values[1], odd);
    for (int o = 0; o < 16; ++o) {
        backward[o * pitch] = values[0][o];
        backward[o * pitch + 1] = values[1][o];
    }
}
