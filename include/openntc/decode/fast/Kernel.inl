// SPDX-License-Identifier: MIT
// The decoding of a tile, written once for every instruction set. A Simd*.h header includes this text inside
// its own namespace and function target, after it has defined the vector types and operations used here.
//
// A batch is kGroups vectors of kLanes texels. Between layers, a batch lies in memory unit by unit:
// activations[(unit * kGroups + group) * kLanes + lane].

inline constexpr int kBatchTexels = kLanes * kGroups;
inline constexpr int kMaxUnits = kMaxInputWords * UnitsPerWord(kLayout);

struct alignas(64) Scratch {
    TileColumns columns;
    RowPair<HighResRow> highRes;
    RowPair<LowResRow> lowRes;
    alignas(64) std::int32_t inputs[kMaxUnits * kBatchTexels];
    alignas(64) std::int32_t hidden[2][kHiddenWords * UnitsPerWord(kLayout) * kBatchTexels];
};

// Weights of the four corners for one group: 0 … 256, corners in the order of the format.
struct CornerWeights {
    Int corners[4];
};

inline CornerWeights MakeCornerWeights(const float* columnFractions, float rowFraction) noexcept {
    // The factor of 256 is exact, so it may be applied before the product is rounded.
    const Float dx = LoadFloat(columnFractions);
    const Float dxRest = Subtract(SetFloat(1.0f), dx);
    const Float dy = SetFloat(rowFraction * 256.0f);
    const Float dyRest = SetFloat((1.0f - rowFraction) * 256.0f);
    return {{Truncate(Multiply(dxRest, dyRest)), Truncate(Multiply(dx, dyRest)),
             Truncate(Multiply(dxRest, dy)), Truncate(Multiply(dx, dy))}};
}

// Stores one word of four signed bytes per lane as layer input.
inline void StoreInputWord(std::int32_t* inputs, int word, int group, Int bytes) noexcept {
    if constexpr (kLayout == OperandLayout::UnsignedBytes) {
        StoreInt(inputs + (word * kGroups + group) * kLanes,
                 Xor(bytes, SetInt(static_cast<int>(0x80808080u))));
    } else {
        std::int32_t* units = inputs + (2 * word * kGroups + group) * kLanes;
        StoreInt(units, ShiftRight16<8>(ShiftLeft16<8>(bytes)));
        StoreInt(units + kGroups * kLanes, ShiftRight16<8>(bytes));
    }
}

// Groups that a small tile leaves unused hold zeros; the lod word is the same for all samples of a mip.
inline void ClearInputs(std::int32_t* inputs, const PreparedNetwork& network, const MipView& mip) noexcept {
    std::memset(inputs, 0, sizeof(std::int32_t) * kMaxUnits * kBatchTexels);
    for (int group = 0; group < kGroups; ++group)
        StoreInputWord(inputs, network.inputWords - 1, group, SetInt(static_cast<int>(mip.lodWord)));
}

inline void BuildHighResInputs(std::int32_t* inputs, int group, const MipView& mip, const Scratch& scratch,
                               int column, float rowFraction) noexcept {
    const GridColumns& columns = scratch.columns.highRes;
    const CornerWeights weights = MakeCornerWeights(columns.fraction + column, rowFraction);
    const std::int32_t base = columns.entry[column];
    const Int index = SubtractInt(LoadInt(columns.entry + column), SetInt(base));
    for (int corner = 0; corner < 4; ++corner) {
        const HighResRow& row = corner < 2 ? *scratch.highRes.top : *scratch.highRes.bottom;
        const Int weight = weights.corners[corner];
        const Int weightPair = Or(ShiftLeft32<4>(weight), ShiftLeft32<20>(weight));
        for (int k = 0; k < mip.highRes.features; k += 4) {
            const auto& pairs = row.pairs[corner & 1];
            const Int even = MultiplyHigh16(Lookup(pairs[k / 2] + base, index), weightPair);
            const Int odd = MultiplyHigh16(Lookup(pairs[k / 2 + 1] + base, index), weightPair);
            const Int word = Or(And(even, SetInt(0x00FF00FF)), ShiftLeft16<8>(odd));
            StoreInputWord(inputs, (corner * mip.highRes.features + k) / 4, group, word);
        }
    }
}

inline void BuildLowResInputs(std::int32_t* inputs, int group, const MipView& mip, const Scratch& scratch,
                              int column, float rowFraction) noexcept {
    const GridColumns& columns = scratch.columns.lowRes;
    const CornerWeights weights = MakeCornerWeights(columns.fraction + column, rowFraction);
    const std::int32_t base = columns.entry[column];
    const Int index = SubtractInt(LoadInt(columns.entry + column), SetInt(base));
    const Int topWeights = Or(weights.corners[0], ShiftLeft32<16>(weights.corners[1]));
    const Int bottomWeights = Or(weights.corners[2], ShiftLeft32<16>(weights.corners[3]));
    for (int k = 0; k < mip.lowRes.features; k += 4) {
        Int sums[4];
        OPENNTC_FAST_UNROLL
        for (int i = 0; i < 4; ++i) {
            const Int top = MultiplyAdd16(Lookup(scratch.lowRes.top->pairs[k + i] + base, index), topWeights);
            const Int bottom =
                MultiplyAdd16(Lookup(scratch.lowRes.bottom->pairs[k + i] + base, index), bottomWeights);
            sums[i] = AddInt(top, bottom);
        }
        // Byte 1 of every sum is the input.
        const Int low = Or(And(ShiftRight32<8>(sums[0]), SetInt(0xFF)), And(sums[1], SetInt(0xFF00)));
        const Int high = Or(And(ShiftRight32<8>(sums[2]), SetInt(0xFF)), And(sums[3], SetInt(0xFF00)));
        const Int word = Or(low, ShiftLeft32<16>(high));
        StoreInputWord(inputs, mip.highRes.features + k / 4, group, word);
    }
}

inline void BuildInputs(std::int32_t* inputs, int group, const MipView& mip, const Scratch& scratch,
                        int column, const TileRow& row) noexcept {
    BuildHighResInputs(inputs, group, mip, scratch, column, row.highRes.fraction);
    BuildLowResInputs(inputs, group, mip, scratch, column, row.lowRes.fraction);
    const int firstWave = mip.highRes.features + mip.lowRes.features / 4;
    for (int wave = 0; wave < 3; ++wave) {
        const Int word = Or(LoadInt(scratch.columns.waves[wave] + column),
                            SetInt(static_cast<std::int32_t>(row.waves[wave])));
        StoreInputWord(inputs, firstWave + wave, group, word);
    }
}

// Activation and requantisation to -128 … 127, as integers in vectors. Limiting z to -1.5 … 3 first gives the
// same integers (z <= -1.5 yields -113, z >= 3 yields 127), needs no lower limit on the gate, and keeps
// infinities out.
template <bool kHalf>
OPENNTC_FAST_INLINE Quantized Requantize(Int accumulator, Float scale) noexcept {
    const Float z = Multiply(ToFloat(accumulator), scale);
    if constexpr (kHalf) {
        const Float limited = Min(Max(RoundToHalf(z), SetFloat(-1.5f)), SetFloat(3.0f));
        const Float third = RoundToHalf(Multiply(limited, SetFloat(0.333251953125f)));
        const Float gate = Min(RoundToHalf(Add(third, SetFloat(0.5f))), SetFloat(1.0f));
        const Float y = RoundToHalf(Multiply(limited, gate));
        const Float steps = RoundToHalf(Multiply(y, SetFloat(80.0f)));
        return RoundToInteger(RoundToHalf(Add(steps, SetFloat(-113.0f))));
    } else {
        const Float limited = Min(Max(z, SetFloat(-1.5f)), SetFloat(3.0f));
        const Float third = Multiply(limited, SetFloat(0x1.555556p-2f));
        const Float gate = Min(Add(third, SetFloat(0.5f)), SetFloat(1.0f));
        const Float y = Multiply(limited, gate);
        return RoundToInteger(Add(Multiply(y, SetFloat(80.0f)), SetFloat(-113.0f)));
    }
}

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

// One group of a batch: up to kLanes neighbouring texels of a row.
struct BatchGroup {
    float* outputs = nullptr; ///< 16 values per texel
    int texels = 0;
};

// The last layer computes texel by texel, the 16 outputs in lanes, which is the order of the result.
template <bool kHalf>
inline void RunOutputLayer(const std::int32_t* inputs, const PreparedLayer& layer, const BatchGroup& group,
                           int firstTexel) noexcept {
    constexpr int kVectors = kOutputRows / kLanes;
    constexpr int kTexels = kLanes == 16 ? 8 : kLanes == 8 ? 4 : 2;
    for (int lane = 0; lane < group.texels; lane += kTexels) {
        Int accumulators[kTexels][kVectors];
        OPENNTC_FAST_UNROLL
        for (int v = 0; v < kVectors; ++v) {
            OPENNTC_FAST_UNROLL
            for (int t = 0; t < kTexels; ++t)
                accumulators[t][v] = LoadInt(layer.biases + v * kLanes);
        }
        const std::int32_t* operands = inputs + firstTexel + lane;
        const std::int32_t* weights = layer.weights;
        for (int unit = 0; unit < layer.units; ++unit, operands += kBatchTexels, weights += kOutputRows) {
            OPENNTC_FAST_UNROLL
            for (int v = 0; v < kVectors; ++v) {
                const Int w = LoadInt(weights + v * kLanes);
                OPENNTC_FAST_UNROLL
                for (int t = 0; t < kTexels; ++t)
                    AddDot(accumulators[t][v], SetInt(operands[t]), w);
            }
        }
        OPENNTC_FAST_UNROLL
        for (int t = 0; t < kTexels; ++t) {
            if (lane + t < group.texels) {
                OPENNTC_FAST_UNROLL
                for (int v = 0; v < kVectors; ++v) {
                    Float z = Multiply(ToFloat(accumulators[t][v]), LoadFloat(layer.scales + v * kLanes));
                    if constexpr (kHalf)
                        z = RoundToHalf(z);
                    StoreFloat(group.outputs + (lane + t) * kOutputRows + v * kLanes, z);
                }
            }
        }
    }
}

template <bool kHalf>
inline void RunBatch(const PreparedNetwork& network, Scratch& scratch, const BatchGroup* groups,
                     int groupCount) noexcept {
    RunHiddenLayer<kHalf>(scratch.inputs, network.layers[0], scratch.hidden[0]);
    RunHiddenLayer<kHalf>(scratch.hidden[0], network.layers[1], scratch.hidden[1]);
    RunHiddenLayer<kHalf>(scratch.hidden[1], network.layers[2], scratch.hidden[0]);
    for (int g = 0; g < groupCount; ++g)
        RunOutputLayer<kHalf>(scratch.hidden[0], network.layers[3], groups[g], g * kLanes);
}

template <bool kHalf>
inline void DecodeTileAs(const TileJob& job, Scratch& scratch) noexcept {
    const MipView& mip = *job.mip;
    PlanTileColumns(scratch.columns, mip, job.left, job.width);
    scratch.highRes.Clear();
    scratch.lowRes.Clear();
    ClearInputs(scratch.inputs, *job.network, mip);
    BatchGroup groups[kGroups];
    int groupCount = 0;
    for (int i = 0; i < job.height; ++i) {
        const TileRow row = PlanTileRow(mip, job.top + i);
        scratch.highRes.Select(mip.highRes, scratch.columns.highRes, row.highRes.cell);
        scratch.lowRes.Select(mip.lowRes, scratch.columns.lowRes, row.lowRes.cell);
        float* rowOutputs = job.outputs + static_cast<std::size_t>(i) * job.outputRowStride;
        for (int column = 0; column < job.width; column += kLanes) {
            BuildInputs(scratch.inputs, groupCount, mip, scratch, column, row);
            const int rest = job.width - column;
            groups[groupCount++] = {rowOutputs + column * kOutputRows, rest < kLanes ? rest : kLanes};
            if (groupCount == kGroups) {
                RunBatch<kHalf>(*job.network, scratch, groups, groupCount);
                groupCount = 0;
            }
        }
    }
    if (groupCount > 0)
        RunBatch<kHalf>(*job.network, scratch, groups, groupCount);
}

inline void DecodeTile(const TileJob& job, void* scratchMemory) noexcept {
    // The memory is plain storage of the right size and alignment; every field is written before it is read.
    Scratch& scratch = *::new (scratchMemory) Scratch;
    if (job.half)
        DecodeTileAs<true>(job, scratch);
    else
        DecodeTileAs<false>(job, scratch);
}

inline constexpr TileKernel kTileKernel = {&DecodeTile, sizeof(Scratch), kLayout};
