// SPDX-License-Identifier: MIT
// Latents and activations of FP8 networks, over Lanes.inl (format specification: "FP8 (E4M3) path").

/// Activation of a layer's sums, with the derivative where training wants it. kLast: to the integers that
/// the last layer takes, 0 ... 240; otherwise to E4M3. Bits that binary16 does not have below 2^-14 are lost
/// in what follows: in 0.5 and -113 that are added, and to E4M3, whose smallest number is 2^-9.
template <bool kTraining, bool kLast>
OPENNTC_FAST_INLINE Float ActivateEightBits(const Float& sum, float* slope) {
    const Float zero = Set(0.0f), one = Set(1.0f), half = Set(0.5f), three = Set(3.0f);
    const Float z = RoundToNormalHalf(Min(Max(sum, Set(-65504.0f)), Set(65504.0f)));
    const Float open = RoundToNormalHalf(Add(RoundToNormalHalf(Multiply(z, Set(kHalfThird))), half));
    const Float gate = Min(Max(open, zero), one);
    if constexpr (kTraining) {
        const Float middle = MultiplyAdd(open, Set(2.0f), Set(-0.5f));
        const Float inner = Select(Less(open, one), middle, one);
        const Float lower = Select(Less(zero, open), inner, zero);
        Store(slope, Select(Less(Set(1.5f), open), zero, lower));
    }
    const Float value = RoundToNormalHalf(Multiply(Min(z, three), gate)); // -0.1875 ... 3
    if constexpr (!kLast)
        return RoundToSmallE4M3(value);
    const Float magic = Set(12582912.0f), offset = Set(113.0f);
    const Float steps = RoundToNormalHalf(Multiply(value, Set(kHiddenSteps)));
    const Float raised = Add(RoundToNormalHalf(Subtract(steps, offset)), magic);
    return Add(Min(Subtract(raised, magic), Set(127.0f)), offset);
}

/// Fp8Kernel's rows.
struct EightBitRows : Rows {
    static void RoundRow(const float* from, float* to, int count, const LatentQuantiser& quantiser) {
        const HalfLevels levels(quantiser);
        const Float scale = Set(quantiser.scale), half = Set(0.5f), step = Set(levels.step),
                    bias = Set(levels.bias), low = Set(static_cast<float>(quantiser.lowestLevel)),
                    high = Set(static_cast<float>(quantiser.highestLevel));
        for (int i = 0; i < count; i += 16) {
            const Float level = Floor(MultiplyAdd(LoadPartial(from + i, count - i), scale, half));
            const Float code = Subtract(Min(Max(level, low), high), low);
            Store(to + i,
                  quantiser.blended ? code : RoundToHalf(Add(RoundToHalf(Multiply(code, step)), bias)));
        }
    }
    static void NoiseRow(const float* from, float* to, int count, const LatentQuantiser& quantiser,
                         std::uint32_t) {
        RoundRow(from, to, count, quantiser);
    }
};
