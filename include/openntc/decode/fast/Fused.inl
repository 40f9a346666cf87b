// SPDX-License-Identifier: MIT
// The activation with fused multiply-adds (FusedActivation.h), for kernels that have them; behind Inputs.inl.

OPENNTC_FAST_INLINE Quantized Requantize(Fused, Int sum, const PreparedLayer& layer, int row) noexcept {
    const FusedRow& constants = layer.fused[row];
    const Float value = ToFloat(sum);
    const Float open = MultiplyAdd(value, SetFloat(constants.slope), SetFloat(constants.offset));
    const Float gate = Min(Max(open, SetFloat(0.0f)), SetFloat(constants.limit));
    return RoundToInteger(MultiplyAdd(value, gate, SetFloat(constants.base)));
}

// Integers are limited to 127 when there are two in a lane.
OPENNTC_FAST_INLINE void StoreAs(Fused activation, const Int (&sums)[4], const PreparedLayer& layer, int row,
                                 std::int32_t* outputs) noexcept {
    Quantized quantized[4];
    OPENNTC_FAST_UNROLL
    for (int r = 0; r < 4; ++r)
        quantized[r] = Requantize(activation, sums[r], layer, row + r);
    const Int limit = SetInt16(127 + static_cast<int>(kQuantizedZero));
    StorePairs(outputs, kBatchTexels, Min16(JoinPairs(quantized[0], quantized[2]), limit),
               Min16(JoinPairs(quantized[1], quantized[3]), limit));
}
