// SPDX-License-Identifier: MIT
// Third part: the output layer, and the tile.

// One group of a batch: up to kLanes neighbouring texels of a row.
struct BatchGroup {
    float* outputs = nullptr; ///< 16 values per texel
    int texels = 0;
};

// The last layer computes texel by texel, the 16 outputs in lanes, which is the order of the result.
template <Epilogue kEpilogue>
OPENNTC_FAST_NOINLINE void RunOutputLayer(const std::int32_t* inputs, const PreparedLayer& layer,
                                          const BatchGroup& group, int firstTexel) noexcept {
    constexpr int kVectors = kOutputRows / kLanes;
    constexpr int kTexels = kLanes == 16 ? 16 : kLanes == 8 ? 4 : 2;
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
                    if constexpr (kEpilogue == Epilogue::Binary16)
                        z = RoundToHalf(z);
                    StoreFloat(group.outputs + (lane + t) * kOutputRows + v * kLanes, z);
                }
            }
        }
    }
}

template <Epilogue kEpilogue>
inline void RunBatch(const PreparedNetwork& network, Scratch& scratch, const BatchGroup* groups,
                     int groupCount) noexcept {
    RunHiddenLayer<kEpilogue>(scratch.inputs, network.layers[0], scratch.hidden[0]);
    RunHiddenLayer<kEpilogue>(scratch.hidden[0], network.layers[1], scratch.hidden[1]);
    RunHiddenLayer<kEpilogue>(scratch.hidden[1], network.layers[2], scratch.hidden[0]);
    for (int g = 0; g < groupCount; ++g)
        RunOutputLayer<kEpilogue>(scratch.hidden[0], network.layers[3], groups[g], g * kLanes);
}

template <Epilogue kEpilogue>
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
                RunBatch<kEpilogue>(*job.network, scratch, groups, groupCount);
                groupCount = 0;
            }
        }
    }
    if (groupCount > 0)
        RunBatch<kEpilogue>(*job.network, scratch, groups, groupCount);
}

inline void DecodeTile(const TileJob& job, void* scratchMemory) noexcept {
    // The memory is plain storage of the right size and alignment; every field is written before it is read.
    Scratch& scratch = *::new (scratchMemory) Scratch;
    [[maybe_unused]] const TileState state;
    switch (job.epilogue) {
    case Epilogue::Binary32:
        return DecodeTileAs<Epilogue::Binary32>(job, scratch);
    case Epilogue::Binary16:
        return DecodeTileAs<Epilogue::Binary16>(job, scratch);
    case Epilogue::Generation3:
        return DecodeTileAs<Epilogue::Generation3>(job, scratch);
    }
}

inline constexpr TileKernel kTileKernel = {&DecodeTile, sizeof(Scratch), kLayout, kFuses};
