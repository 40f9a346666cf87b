// SPDX-License-Identifier: MIT
// Second part: a hidden layer by vector instructions, four outputs at a time.

template <bool kHalf>
inline void RunHiddenLayer(const std::int32_t* inputs, const PreparedLayer& layer,
                           std::int32_t* outputs) noexcept {
    const int units = layer.units;
    for (int row = 0; row < kHiddenRows; row += 4) {
        Int accumulators[4][kGroups];
        OPENNTC_FAST_UNROLL
        for (int r = 0; r < 4; ++r) {
            OPENNTC_FAST_UNROLL
            for (int g = 0; g < kGroups; ++g)
                accumulators[r][g] = SetInt(layer.biases[row + r]);
        }
        const std::int32_t* weights = layer.weights + row * units;
        const std::int32_t* operands = inputs;
        for (int unit = 0; unit < units; ++unit, weights += 4, operands += kBatchTexels) {
            Int x[kGroups];
            OPENNTC_FAST_UNROLL
            for (int g = 0; g < kGroups; ++g)
                x[g] = LoadInt(operands + g * kLanes);
            OPENNTC_FAST_UNROLL
            for (int r = 0; r < 4; ++r) {
                const Int w = SetInt(weights[r]);
                OPENNTC_FAST_UNROLL
                for (int g = 0; g < kGroups; ++g)
                    AddDot(accumulators[r][g], x[g], w);
            }
        }
        OPENNTC_FAST_UNROLL
        for (int g = 0; g < kGroups; ++g) {
            Quantized quantized[4];
            OPENNTC_FAST_UNROLL
            for (int r = 0; r < 4; ++r)
                quantized[r] = Requantize<kHalf>(accumulators[r][g], SetFloat(layer.scales[row + r]));
            StoreQuantized(outputs + (row / 4 * UnitsPerWord(kLayout) * kGroups + g) * kLanes, kBatchTexels,
                           quantized);
        }
    }
}

// Nothing to prepare for the instructions used here.
struct TileState {};
