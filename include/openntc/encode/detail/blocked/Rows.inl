// SPDX-License-Identifier: MIT
// Row loops of the optimiser, the latents and the losses, over Lanes.inl.

struct Rows {
    /// PlainWeightRows::SumRow.
    static void SumRow(std::span<const GradientSums> slices, std::size_t at, float unit, float* to) {
        Float sum = Set(0.0f);
        for (const GradientSums& slice : slices)
            sum = Add(sum, Load(slice.weights.data() + at));
        Store(to, Multiply(sum, Set(unit)));
    }
    /// PlainWeightRows::SumBiases.
    static void SumBiases(std::span<const GradientSums> slices, int row, float* to) {
        alignas(64) float lanes[16][16], outputs[16][16];
        for (int o = 0; o < 16; ++o) {
            Float sum = Set(0.0f);
            for (const GradientSums& slice : slices)
                sum = Add(sum, Load(slice.biases[row + o]));
            Store(lanes[o], sum);
        }
        Transpose(lanes[0], 16, outputs[0], 16);
        Float total = Set(0.0f);
        for (const auto& lane : outputs)
            total = Add(total, Load(lane));
        Store(to, total);
    }
    /// PlainWeightRows::RaiseLimits.
    static void RaiseLimits(const float* from, float* limit) {
        const Float v = Load(from);
        Store(limit, Max(Load(limit), Max(v, Subtract(Set(0.0f), v))));
    }
    /// PlainWeightRows::QuantiseRow.
    static void QuantiseRow(const float* from, const float* inverse, bool quantise, float* q) {
        const Float scaled = Multiply(Load(from), Load(inverse));
        if (!quantise)
            return Store(q, scaled);
        const Float half = Select(Less(scaled, Set(0.0f)), Set(-0.5f), Set(0.5f));
        Store(q, Truncate(Min(Max(Add(scaled, half), Set(-127.0f)), Set(127.0f))));
    }
    /// PlainWeightRows::RoundEightBitRow.
    static void RoundEightBitRow(const float* from, float* q) { Store(q, RoundToE4M3(Load(from))); }
    /// Adam on `count` parameters; those whose gradient is exactly 0 keep value and moments. Values that are
    /// not finite become 0.
    static void AdamRow(float* values, float* first, float* second, const float* gradients, int count,
                        const AdamStep& step, float lowest, float highest) {
        const Float b1 = Set(1.0f - step.beta1), b2 = Set(1.0f - step.beta2), rate = Set(step.rate),
                    correction = Set(step.secondCorrection), epsilon = Set(AdamStep::kEpsilon),
                    low = Set(lowest), high = Set(highest), zero = Set(0.0f);
        for (int i = 0; i < count; i += 16) {
            const int lanes = count - i;
            const Float g = LoadPartial(gradients + i, lanes), w = LoadPartial(values + i, lanes),
                        m = LoadPartial(first + i, lanes), v = LoadPartial(second + i, lanes);
            const Mask untouched = Equal(g, zero);
            const Float newM = MultiplyAdd(b1, Subtract(g, m), m);
            const Float newV = MultiplyAdd(b2, Subtract(Multiply(g, g), v), v);
            const Float change =
                Divide(Multiply(rate, newM), Add(SquareRoot(Multiply(newV, correction)), epsilon));
            Float updated = Min(Max(Subtract(w, change), low), high);
            updated = Select(Equal(change, change), updated, zero);
            StorePartial(values + i, Select(untouched, w, updated), lanes);
            StorePartial(first + i, Select(untouched, m, newM), lanes);
            StorePartial(second + i, Select(untouched, v, newV), lanes);
        }
    }
    /// Latents rounded to their levels (format specification: "Encode"), as integer network inputs. `to` has
    /// room for a multiple of 16.
    static void RoundRow(const float* from, float* to, int count, const LatentQuantiser& quantiser) {
        const Float scale = Set(quantiser.scale), input = Set(quantiser.levelInput), half = Set(0.5f),
                    low = Set(static_cast<float>(quantiser.lowestLevel)),
                    high = Set(static_cast<float>(quantiser.highestLevel));
        for (int i = 0; i < count; i += 16) {
            const Float level = Floor(MultiplyAdd(LoadPartial(from + i, count - i), scale, half));
            Store(to + i, Multiply(Min(Max(level, low), high), input));
        }
    }
    /// Latents with uniform noise of one level's width, as real-valued network inputs. `to` has room for a
    /// multiple of 16.
    static void NoiseRow(const float* from, float* to, int count, const LatentQuantiser& quantiser,
                         std::uint32_t seed) {
        const Float scale = Set(quantiser.scale), input = Set(quantiser.levelInput),
                    unit = Set(1.0f / 16777216.0f), half = Set(-0.5f);
        for (int i = 0; i < count; i += 16) {
            const Bits bits = HashLanes(seed + static_cast<std::uint32_t>(i));
            const Float noise = MultiplyAdd(ToFloat(ShiftRight<8>(bits)), unit, half);
            const Float level = MultiplyAdd(LoadPartial(from + i, count - i), scale, noise);
            Store(to + i, Multiply(level, input));
        }
    }

    /// The references of a row of texels, 0 ... 1.
    static OPENNTC_FAST_INLINE Float LoadReference(const std::uint16_t* from) {
        return Multiply(LoadShorts(from), Set(1.0f / 65535.0f));
    }
    /// MaskLoss::Clip.
    static OPENNTC_FAST_INLINE Float ClipMask(const Float& error, const Mask& low, const Mask& high) {
        const Float zero = Set(0.0f);
        return Select(high, Min(error, zero), Select(low, Max(error, zero), error));
    }
    /// WriteTexelLosses.
    static void TexelLosses(const KernelContext& context, const TileTask& tile, const float* outputs,
                            int stride, float* to, std::size_t pitch) {
        const Float zero = Set(0.0f), knee = Set(MaskLoss::kKnee);
        for (int y = 0; y < kTileHeight; ++y, to += pitch) {
            Float sum = zero, masked = zero;
            for (int c = 0; c < context.channels; ++c) {
                const Float wanted = LoadReference(tile.reference + c * kTileTexels + y * 16);
                Float error = Subtract(Load(outputs + context.outputOf[c] * stride + y * 16), wanted);
                const Float gain = Set(context.gain[c]);
                if (c != context.oneSided) {
                    sum = MultiplyAdd(Multiply(error, error), gain, sum);
                    continue;
                }
                const Mask low = Less(wanted, Set(MaskLoss::kLow)), high = Less(Set(MaskLoss::kHigh), wanted);
                error = ClipMask(error, low, high);
                const Float size = Max(error, Subtract(zero, error)),
                            excess = Max(Subtract(size, knee), zero);
                const Float push = Set(context.maskPush);
                const Float pushed = Select(high, push, Select(low, push, zero));
                masked =
                    Multiply(MultiplyAdd(pushed, Multiply(excess, excess), Multiply(error, error)), gain);
            }
            if (context.maskIndex >= 0) { // masked texels are discarded
                const Float mask = LoadReference(tile.reference + context.maskIndex * kTileTexels + y * 16);
                sum = Select(Less(Set(context.maskZero), mask), sum, zero);
            }
            Store(to, Add(sum, masked));
        }
    }
};
