// SPDX-License-Identifier: MIT
// Activations for kernels that have fused multiply-adds; behind Inputs.inl. That of networks in binary32 is
// FusedActivation.h's.

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

// Rounds to binary16 by adding and taking away 1.5 · 2^13 times the power of two in a number, whose last bit
// is the one that stays: less than a conversion there and back takes. Numbers below 2^-14 keep more bits,
// which what follows loses: 0.5 or 113 is added.
OPENNTC_FAST_INLINE Float RoundToNormalHalf(Float v) noexcept {
    const Int power = And(AsInt(v), SetInt(0x7F800000));
    const Float raise = AsFloat(AddInt(power, SetInt((13 << 23) + 0x400000)));
    return Subtract(Add(v, raise), raise);
}

// HalfGate says why this is exact.
OPENNTC_FAST_INLINE Quantized Requantize(FusedHalf, Int sum, const PreparedLayer& layer, int row) noexcept {
    const Float z = Multiply(ToFloat(sum), SetFloat(layer.scales[row]));
    const Float limited = RoundToNormalHalf(Min(Max(z, SetFloat(-1.5f)), SetFloat(3.0f)));
    const Float fine = SetFloat(HalfGate::kThirdBase), half = SetFloat(0.5f);
    const Float base = SelectNegative(limited, SetFloat(HalfGate::kNegativeBase), SetFloat(HalfGate::kBase));
    const Float open = Subtract(MultiplyAdd(limited, SetFloat(HalfGate::kThird), Add(fine, half)), fine);
    const Float gate = Min(Subtract(Add(open, base), base), SetFloat(1.0f));
    const Float y = RoundToNormalHalf(Multiply(limited, gate));
    const Float steps = RoundToNormalHalf(Multiply(y, SetFloat(80.0f)));
    return RoundToInteger(RoundToNormalHalf(Add(steps, SetFloat(-113.0f))));
}
