// SPDX-License-Identifier: MIT
// Errors of a tile's outputs ([output][texel]) to gradients, in their place.

struct Loss {
    static void Apply(const KernelContext& context, const TileTask& tile, float* outputs,
                      GradientSums& sums) {
        bool trained[kOutputs] = {};
        for (int c = 0; c < context.channels; ++c)
            trained[context.outputOf[c]] = true;
        for (int o = 0; o < kOutputs; ++o) { // outputs nobody trains get no gradient
            if (!trained[o])
                std::memset(outputs + o * kTileTexels, 0, kTileTexels * sizeof(float));
        }
        Float inside[kTileHeight], kept[kTileHeight]; // 1 or 0
        for (int y = 0; y < kTileHeight; ++y) {
            inside[y] = LoadPartial(kOnes, y < tile.height ? tile.width : 0);
            kept[y] = inside[y];
            if (context.maskIndex >= 0) {
                const Float mask =
                    Rows::LoadReference(tile.reference + context.maskIndex * kTileTexels + y * 16);
                kept[y] = Select(Less(Set(context.maskZero), mask), inside[y], Set(0.0f));
            }
        }
        for (int c = 0; c < context.channels; ++c) {
            float* row = outputs + context.outputOf[c] * kTileTexels;
            const Float(&texels)[kTileHeight] = c == context.maskIndex ? inside : kept;
            if (c == context.oneSided)
                ApplyChannel<true>(context, tile, c, row, texels, sums);
            else
                ApplyChannel<false>(context, tile, c, row, texels, sums);
        }
    }

private:
    alignas(64) static constexpr float kOnes[16] = {1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1};

    template <bool kOneSided>
    static OPENNTC_FAST_INLINE void ApplyChannel(const KernelContext& context, const TileTask& tile, int c,
                                                 float* row, const Float (&texels)[kTileHeight],
                                                 GradientSums& sums) {
        const Float zero = Set(0.0f), half = Set(0.5f), gain = Set(context.gain[c]);
        Float squares = zero, total = zero;
        for (int y = 0; y < kTileHeight; ++y) {
            const Float wanted = Rows::LoadReference(tile.reference + c * kTileTexels + y * 16);
            Float error = Select(Less(half, texels[y]), Subtract(Load(row + y * 16), wanted), zero);
            Float weighed = error;
            if constexpr (kOneSided)
                WeighMask(context.maskPush, wanted, error, weighed);
            const Float gradient = Multiply(weighed, gain);
            squares = MultiplyAdd(error, error, squares);
            total = Add(total, gradient);
            Store(row + y * 16, gradient);
        }
        const int output = context.outputOf[c];
        float* loss = sums.loss[output];
        Store(loss, MultiplyAdd(squares, Set(context.squaredRange[c]), Load(loss)));
        float* bias = sums.biases[NetworkShape::BiasOffset(3) + output];
        Store(bias, Add(Load(bias), total));
    }
    /// MaskLoss::Clip and Weigh.
    static OPENNTC_FAST_INLINE void WeighMask(float maskPush, const Float& wanted, Float& error,
                                              Float& weighed) {
        const Float zero = Set(0.0f), push = Set(maskPush), knee = Set(MaskLoss::kKnee);
        const Mask low = Less(wanted, Set(MaskLoss::kLow)), high = Less(Set(MaskLoss::kHigh), wanted);
        error = Rows::ClipMask(error, low, high);
        const Float above = Max(Subtract(error, knee), zero), below = Min(Add(error, knee), zero);
        const Float excess = Select(high, below, Select(low, above, zero));
        weighed = MultiplyAdd(push, excess, error);
    }
};
