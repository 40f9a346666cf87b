// SPDX-License-Identifier: MIT
// The decoding of a tile, written once for every instruction set, first part: the inputs of the network and
// the activation. A Simd*.h header includes this text inside its own namespace and function target, after it
// has defined the vector types and operations used here; then VectorLayer.inl, or a hidden layer of its own;
// then Tile.inl.
//
// A batch is kGroups vectors of kLanes texels. Between layers, a batch lies in memory unit by unit:
// activations[(unit * kGroups + group) * kLanes + lane].

inline constexpr int kBatchTexels = kLanes * kGroups;
inline constexpr int kMaxUnits = PadWords(kLayout, kMaxInputWords) * UnitsPerWord(kLayout);

struct alignas(64) Scratch {
    TileColumns columns;
    RowPair highRes;
    RowPair lowRes;
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
    if constexpr (kLayout != OperandLayout::SignedPairs) {
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
        const LatentRow& row = corner < 2 ? *scratch.highRes.top : *scratch.highRes.bottom;
        const Int weight = weights.corners[corner];
        const Int weightPair = Or(ShiftLeft32<4>(weight), ShiftLeft32<20>(weight));
        for (int k = 0; k < mip.highRes.features; k += 4) {
            const auto* pairs = row.pairs + (corner & 1) * LatentRow::kSidePairs + k / 2;
            const Int even = MultiplyHigh16(Lookup(pairs[0] + base, index), weightPair);
            const Int odd = MultiplyHigh16(Lookup(pairs[1] + base, index), weightPair);
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

// Four latents weighted by 17 · 2^16 as bytes of a word: floor(sum) - 128, or trunc(sum - 127.5).
OPENNTC_FAST_INLINE Int PackLatentSums(const Int (&sums)[4], bool truncates) noexcept {
    if (!truncates) {
        const Int low = Or(ShiftRight32<16>(sums[0]), And(ShiftRight32<8>(sums[1]), SetInt(0xFF00)));
        const Int high = Or(And(sums[2], SetInt(0xFF0000)),
                            And(ShiftLeft32<8>(sums[3]), SetInt(static_cast<std::int32_t>(0xFF000000u))));
        return Xor(Or(low, high), SetInt(static_cast<std::int32_t>(0x80808080u)));
    }
    Int bytes[4];
    OPENNTC_FAST_UNROLL
    for (int i = 0; i < 4; ++i) {
        const Int centered = SubtractInt(sums[i], SetInt(8355840)); // 127.5 · 2^16
        const Int upward = And(ShiftRight32<31>(centered), SetInt(65535));
        bytes[i] = And(ShiftRight32<16>(AddInt(centered, upward)), SetInt(0xFF));
    }
    return Or(Or(bytes[0], ShiftLeft32<8>(bytes[1])),
              Or(ShiftLeft32<16>(bytes[2]), ShiftLeft32<24>(bytes[3])));
}

// The features of one latent mip, from word `firstWord` on.
inline void BuildLatentMipInputs(std::int32_t* inputs, int group, const GridView& grid, bool truncates,
                                 const GridColumns& columns, const RowPair& rows, int column,
                                 float rowFraction, int firstWord) noexcept {
    const std::int32_t base = columns.entry[column];
    const Int index = SubtractInt(LoadInt(columns.entry + column), SetInt(base));
    const Int right =
        Truncate(Add(Multiply(LoadFloat(columns.fraction + column), SetFloat(256.0f)), SetFloat(0.5f)));
    const Int columnWeights = Or(SubtractInt(SetInt(256), right), ShiftLeft32<16>(right));
    const float shifted = rowFraction * 256.0f + 0.5f; // in binary32, as the columns' above: not lround
    const int lower = static_cast<int>(shifted);
    const Int rowWeights = SetInt(17 * (256 - lower) | 17 * lower << 16);
    for (int k = 0; k < grid.features; k += 4) {
        Int sums[4];
        OPENNTC_FAST_UNROLL
        for (int i = 0; i < 4; ++i) { // along x at most 15 · 256 each
            const Int top = MultiplyAdd16(Lookup(rows.top->pairs[k + i] + base, index), columnWeights);
            const Int bottom = MultiplyAdd16(Lookup(rows.bottom->pairs[k + i] + base, index), columnWeights);
            sums[i] = MultiplyAdd16(Or(top, ShiftLeft32<16>(bottom)), rowWeights);
        }
        StoreInputWord(inputs, firstWord + k / 4, group, PackLatentSums(sums, truncates));
    }
}

inline void BuildInputs(std::int32_t* inputs, int group, const MipView& mip, const Scratch& scratch,
                        int column, const TileRow& row) noexcept {
    int firstWave = mip.highRes.features + mip.lowRes.features / 4;
    if (mip.highRes.isLatentMip) {
        const int words = mip.highRes.features / 4;
        firstWave = 2 * words;
        BuildLatentMipInputs(inputs, group, mip.highRes, mip.truncates, scratch.columns.highRes,
                             scratch.highRes, column, row.highRes.fraction, 0);
        BuildLatentMipInputs(inputs, group, mip.lowRes, mip.truncates, scratch.columns.lowRes, scratch.lowRes,
                             column, row.lowRes.fraction, words);
    } else {
        BuildHighResInputs(inputs, group, mip, scratch, column, row.highRes.fraction);
        BuildLowResInputs(inputs, group, mip, scratch, column, row.lowRes.fraction);
    }
    for (int wave = 0; wave < 3; ++wave) {
        const Int word = Or(LoadInt(scratch.columns.waves[wave] + column),
                            SetInt(static_cast<std::int32_t>(row.waves[wave])));
        StoreInputWord(inputs, firstWave + wave, group, word);
    }
}

// What turns the sums of a layer into the inputs of the next.
struct Exact {}; // rounded after every step
struct ExactOfGeneration3 {};
struct Half {}; // the same in binary16
struct FusedHalf {};
struct Fused {}; // with fused multiply-adds: Fused.inl

// Activation and requantisation to -128 … 127, as integers in vectors. Limiting z to -1.5 … 3 first gives the
// same integers (z <= -1.5 yields -113, z >= 3 yields 127), needs no lower limit on the gate, and keeps
// infinities out.
OPENNTC_FAST_INLINE Quantized Requantize(Exact, Int sum, const PreparedLayer& layer, int row) noexcept {
    const Float z = Multiply(ToFloat(sum), SetFloat(layer.scales[row]));
    const Float limited = Min(Max(z, SetFloat(-1.5f)), SetFloat(3.0f));
    const Float third = Multiply(limited, SetFloat(0x1.555556p-2f));
    const Float gate = Min(Add(third, SetFloat(0.5f)), SetFloat(1.0f));
    const Float y = Multiply(limited, gate);
    return RoundToInteger(Add(Multiply(y, SetFloat(80.0f)), SetFloat(-113.0f)));
}

OPENNTC_FAST_INLINE Quantized Requantize(ExactOfGeneration3, Int sum, const PreparedLayer& layer,
                                         int row) noexcept {
    const Float z = Multiply(ToFloat(sum), SetFloat(layer.scales[row]));
    const Float limited = Min(Max(z, SetFloat(-1.5f)), SetFloat(3.0f));
    const Float third = Multiply(limited, SetFloat(kThirdOfGeneration3));
    const Float gate = Min(Add(third, SetFloat(0.5f)), SetFloat(1.0f));
    const Float y = Multiply(limited, gate);
    return SubtractInt(RoundToInteger(Multiply(y, SetFloat(80.0f))), SetInt(113));
}

OPENNTC_FAST_INLINE Quantized Requantize(Half, Int sum, const PreparedLayer& layer, int row) noexcept {
    const Float z = Multiply(ToFloat(sum), SetFloat(layer.scales[row]));
    const Float limited = Min(Max(RoundToHalf(z), SetFloat(-1.5f)), SetFloat(3.0f));
    const Float third = RoundToHalf(Multiply(limited, SetFloat(0.333251953125f)));
    const Float gate = Min(RoundToHalf(Add(third, SetFloat(0.5f))), SetFloat(1.0f));
    const Float y = RoundToHalf(Multiply(limited, gate));
    const Float steps = RoundToHalf(Multiply(y, SetFloat(80.0f)));
    return RoundToInteger(RoundToHalf(Add(steps, SetFloat(-113.0f))));
}

// Requantises four outputs of one group of texels and stores them.
template <typename Activation>
OPENNTC_FAST_INLINE void StoreAs(Activation activation, const Int (&sums)[4], const PreparedLayer& layer,
                                 int row, std::int32_t* outputs) noexcept {
    Quantized quantized[4];
    OPENNTC_FAST_UNROLL
    for (int r = 0; r < 4; ++r)
        quantized[r] = Requantize(activation, sums[r], layer, row + r);
    StoreQuantized(outputs, kBatchTexels, quantized);
}

inline void StoreAs(Fused activation, const Int (&sums)[4], const PreparedLayer& layer, int row,
                    std::int32_t* outputs) noexcept;

template <Epilogue kEpilogue>
OPENNTC_FAST_INLINE void StoreOutputs(const Int (&sums)[4], const PreparedLayer& layer, int row,
                                      std::int32_t* outputs) noexcept {
    if constexpr (kEpilogue == Epilogue::Binary16) {
        if constexpr (kFuses)
            StoreAs(FusedHalf{}, sums, layer, row, outputs);
        else
            StoreAs(Half{}, sums, layer, row, outputs);
    } else {
        if constexpr (kFuses) {
            if (row >= layer.exactRows)
                return StoreAs(Fused{}, sums, layer, row, outputs);
        }
        if constexpr (kEpilogue == Epilogue::Generation3)
            StoreAs(ExactOfGeneration3{}, sums, layer, row, outputs);
        else
            StoreAs(Exact{}, sums, layer, row, outputs);
    }
}
