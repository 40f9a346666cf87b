// SPDX-License-Identifier: MIT
// Second part: a hidden layer by vector instructions, four outputs at a time.

// Sums of four outputs for all groups of a batch.
struct FourOutputs {
    Int sums[4][kGroups];

    OPENNTC_FAST_INLINE void SetBiases(const std::int32_t* biases) noexcept {
        OPENNTC_FAST_UNROLL
        for (int r = 0; r < 4; ++r) {
            OPENNTC_FAST_UNROLL
            for (int g = 0; g < kGroups; ++g)
                sums[r][g] = SetInt(biases[r]);
        }
    }

    OPENNTC_FAST_INLINE void AddProducts(const std::int32_t*& operands, const std::int32_t*& weights,
                                         const std::int32_t* weightsEnd) noexcept {
        for (; weights != weightsEnd; weights += 4, operands += kBatchTexels) {
            Int x[kGroups];
            OPENNTC_FAST_UNROLL
            for (int g = 0; g < kGroups; ++g)
                x[g] = LoadInt(operands + g * kLanes);
            OPENNTC_FAST_UNROLL
            for (int r = 0; r < 4; ++r) {
                const Int w = SetInt(weights[r]);
                OPENNTC_FAST_UNROLL
                for (int g = 0; g < kGroups; ++g)
                    AddDot(sums[r][g], x[g], w);
            }
        }
    }
};

// The sums of four outputs are requantised between the products of the next four, a group at a time:
// processors do both at once, but do not look ahead far enough to find that by themselves. Not in binary16
// with 16 lanes, where conversions take most of the time anyway.
template <Epilogue kEpilogue>
OPENNTC_FAST_NOINLINE void RunHiddenLayer(const std::int32_t* inputs, const PreparedLayer& layer,
                                          std::int32_t* outputs) noexcept {
    const int units = layer.units;
    Int done[kGroups][4] = {};
    const auto store = [&](int row, int group) {
        StoreOutputs<kEpilogue>(done[group], layer, row,
                                outputs + (row / 4 * UnitsPerWord(kLayout) * kGroups + group) * kLanes);
    };
    constexpr bool kInterleaves = kEpilogue != Epilogue::Binary16 || kLanes < 16;
    for (int row = 0; row < layer.rows; row += 4) {
        FourOutputs four;
        four.SetBiases(layer.biases + row);
        const std::int32_t* const first = layer.weights + row * units;
        const std::int32_t* weights = first;
        const std::int32_t* operands = inputs;
        if constexpr (!kInterleaves) {
            four.AddProducts(operands, weights, first + units * 4);
            OPENNTC_FAST_UNROLL
            for (int g = 0; g < kGroups; ++g) {
                OPENNTC_FAST_UNROLL
                for (int r = 0; r < 4; ++r)
                    done[g][r] = four.sums[r][g];
                store(row, g);
            }
            continue;
        }
        for (int group = 0; group < kGroups; ++group) {
            four.AddProducts(operands, weights, first + units * (group + 1) / kGroups * 4);
            if (row > 0)
                store(row - 4, group);
        }
        OPENNTC_FAST_UNROLL
        for (int r = 0; r < 4; ++r) {
            OPENNTC_FAST_UNROLL
            for (int g = 0; g < kGroups; ++g)
                done[g][r] = four.sums[r][g];
        }
    }
    for (int group = 0; kInterleaves && group < kGroups; ++group)
        store(layer.rows - 4, group);
}

// Nothing to prepare for the instructions used here.
struct TileState {};
