// SPDX-License-Identifier: MIT
// Latents of a tile to network inputs, and gradients of inputs back to latents.

class Latents {
public:
    explicit Latents(const NetworkShape& shape)
        : shape_(shape), slots_(std::size_t{kMostChannels} * 16), block_(256),
          gradients_(static_cast<std::size_t>(GetLatentColumns(shape) * 16) * kTileTexels) {}

    /// Columns of sixteen that hold a network's inputs, and those that hold its latents.
    static int GetInputColumns(const NetworkShape& shape) { return (shape.Inputs() + 15) / 16; }
    static int GetLatentColumns(const NetworkShape& shape) { return (shape.LatentInputs() + 15) / 16; }

    /// Network inputs of a tile, integers or numbers of E4M3 (kEightBits).
    template <bool kEightBits>
    void Gather(const TileTask& tile, Operand& inputs) {
        const MipGeometry& mip = *tile.mip;
        constexpr auto kFractions = kEightBits ? &GetExactFractions : &GetFractions;
        const Taps high = LoadTaps(mip.highX, kFractions(mip.highX), tile, tile.high.originX),
                   low = LoadTaps(mip.lowX, kFractions(mip.lowX), tile, tile.low.originX);
        PutWaves<kEightBits>(mip, tile.x);
        for (int row = 0; row < kTileHeight; ++row) {
            const int y = tile.y + std::min(row, tile.height - 1);
            const auto at = static_cast<std::size_t>(y);
            const float highY = kFractions(mip.highY)[at], lowY = kFractions(mip.lowY)[at];
            if (shape_.blended) {
                Blend<true, kEightBits>(PlaceRows(mip.highY, highY, tile.high, y), high, shape_.highFeatures,
                                        slots_.data());
                Blend<true, kEightBits>(PlaceRows(mip.lowY, lowY, tile.low, y), low, shape_.lowFeatures,
                                        GetLowSlots());
            } else {
                GatherHigh<kEightBits>(PlaceRows(mip.highY, highY, tile.high, y), high);
                Blend<false, kEightBits>(PlaceRows(mip.lowY, lowY, tile.low, y), low, shape_.lowFeatures,
                                         GetLowSlots());
            }
            float* waves = slots_.data() + shape_.LatentInputs() * 16;
            for (int wave = 0; wave < 3; ++wave) {
                for (int phase = 0; phase < 2; ++phase)
                    Store(waves + (wave * 4 + phase * 2 + 1) * 16,
                          Set(*GetWaves<kEightBits>(mip, mip.wavesY, wave, phase, tile.y + row)));
            }
            for (int column = 0; column < GetInputColumns(shape_); ++column) {
                Transpose(slots_.data() + column * 256, 16, block_.data(), 16);
                for (int t = 0; t < 16; t += 2)
                    inputs.Put(row * 16 + t, column * 16, Load(block_.data() + t * 16),
                               Load(block_.data() + t * 16 + 16));
            }
        }
    }

    /// Gradients of a tile's inputs ([texel][`pitch`]) to those of its latents.
    void Scatter(const TileTask& tile, const float* inputGradients, int pitch) {
        const int columns = GetLatentColumns(shape_);
        for (int row = 0; row < kTileHeight; ++row) {
            for (int column = 0; column < columns; ++column)
                Transpose(inputGradients + row * 16 * pitch + column * 16, pitch,
                          gradients_.data() + column * 16 * kTileTexels + row * 16, kTileTexels);
        }
        const MipGeometry& mip = *tile.mip;
        const int hf = shape_.highFeatures, lf = shape_.lowFeatures;
        FillMatrix(matrices_[0], mip.highX, tile, tile.high, true, shape_.blended);
        if (!shape_.blended)
            FillMatrix(matrices_[1], mip.highX, tile, tile.high, false, true);
        FillMatrix(matrices_[2], mip.lowX, tile, tile.low, true, true);
        const auto rows = static_cast<std::size_t>(std::max(tile.high.rows, tile.low.rows)) * 16;
        if (rowSums_.size() < rows)
            rowSums_.Resize(rows);
        std::memset(tile.high.gradients, 0,
                    sizeof(float) * static_cast<std::size_t>(hf * tile.high.rows * tile.high.pitch));
        std::memset(tile.low.gradients, 0,
                    sizeof(float) * static_cast<std::size_t>(lf * tile.low.rows * tile.low.pitch));
        for (int f = 0; f < hf; ++f) {
            if (shape_.blended) {
                AddSlots(tile, mip.highY, tile.high, f, f, f, matrices_[0]);
                continue;
            }
            for (int cx = 0; cx < 2; ++cx)
                AddSlots(tile, mip.highY, tile.high, f, cx * hf + f, (2 + cx) * hf + f, matrices_[cx]);
        }
        const int firstLow = shape_.HighInputs();
        for (int f = 0; f < lf; ++f)
            AddSlots(tile, mip.lowY, tile.low, f, firstLow + f, firstLow + f, matrices_[2]);
    }

private:
    struct Taps {
        Bits first, second;
        Float fraction;
    };
    /// Rows of latents of a feature that a row of texels lies between.
    struct RowTaps {
        const float* above;
        const float* below;
        int plane, pitch; ///< numbers of a feature and of a row
        float fraction;   ///< weight of the row below
    };
    static const std::vector<float>& GetFractions(const AxisTaps& taps) { return taps.fraction; }
    static const std::vector<float>& GetExactFractions(const AxisTaps& taps) {
        return taps.exactFraction.empty() ? taps.fraction : taps.exactFraction;
    }
    /// Of a row of texels; those beyond the image read the first latent.
    static OPENNTC_FAST_INLINE Taps LoadTaps(const AxisTaps& taps, const std::vector<float>& fractions,
                                             const TileTask& tile, int origin) {
        alignas(64) std::int32_t first[16] = {}, second[16] = {};
        for (int t = 0; t < tile.width; ++t) {
            first[t] = taps.first[static_cast<std::size_t>(tile.x + t)] - origin;
            second[t] = taps.second[static_cast<std::size_t>(tile.x + t)] - origin;
        }
        return {LoadBits(first), LoadBits(second), LoadPartial(fractions.data() + tile.x, tile.width)};
    }
    static RowTaps PlaceRows(const AxisTaps& taps, float fraction, const LocalGrid& grid, int texelY) {
        const auto y = static_cast<std::size_t>(texelY);
        return {grid.values + (taps.first[y] - grid.originY) * grid.pitch,
                grid.values + (taps.second[y] - grid.originY) * grid.pitch, grid.rows * grid.pitch,
                grid.pitch, fraction};
    }
    /// Bilinear weights of a row of texels, corners in the format's order.
    static OPENNTC_FAST_INLINE void MakeProducts(const Float& fx, float fy, Float (&weights)[4]) {
        const Float fractions[2] = {Subtract(Set(1.0f), fx), fx}, sides[2] = {Set(1.0f - fy), Set(fy)};
        for (int c = 0; c < 4; ++c)
            weights[c] = Multiply(fractions[c & 1], sides[c >> 1]);
    }
    /// The same, truncated to 1/256 or rounded to binary16.
    template <bool kEightBits>
    static OPENNTC_FAST_INLINE void MakeWeights(const Float& fx, float fy, Float (&weights)[4]) {
        MakeProducts(fx, fy, weights);
        for (Float& weight : weights)
            weight = kEightBits ? RoundToHalf(weight)
                                : Multiply(Truncate(Multiply(weight, Set(256.0f))), Set(1.0f / 256.0f));
    }

    float* GetLowSlots() { return slots_.data() + shape_.HighInputs() * 16; }
    template <bool kEightBits>
    static const float* GetWaves(const MipGeometry& mip, const AxisWaves& axis, int wave, int phase,
                                 int texel) {
        return kEightBits ? mip.GetEightBitWaves(axis, wave, phase, texel)
                          : mip.GetWaves(axis, wave, phase, texel);
    }
    template <bool kEightBits>
    void PutWaves(const MipGeometry& mip, int x) {
        float* waves = slots_.data() + shape_.LatentInputs() * 16;
        for (int wave = 0; wave < 3; ++wave) {
            for (int phase = 0; phase < 2; ++phase)
                Store(waves + (wave * 4 + phase * 2) * 16,
                      Load(GetWaves<kEightBits>(mip, mip.wavesX, wave, phase, x)));
        }
        const Float lod = Set(kEightBits ? mip.eightBitLod : mip.lodInput);
        Store(waves + 12 * 16, lod);
        Store(waves + 13 * 16, lod);
    }
    template <bool kEightBits>
    void GatherHigh(RowTaps rows, const Taps& taps) {
        Float weights[4];
        MakeWeights<kEightBits>(taps.fraction, rows.fraction, weights);
        const auto weigh = [&](int corner, const Float& value) {
            const Float product = Multiply(weights[corner], value);
            return kEightBits ? RoundToInput(product) : Floor(product);
        };
        const int hf = shape_.highFeatures;
        for (int f = 0; f < hf; ++f, rows.above += rows.plane, rows.below += rows.plane) {
            float* to = slots_.data() + f * 16;
            Store(to, weigh(0, Pick(rows.above, rows.pitch, taps.first)));
            Store(to + hf * 16, weigh(1, Pick(rows.above, rows.pitch, taps.second)));
            Store(to + hf * 32, weigh(2, Pick(rows.below, rows.pitch, taps.first)));
            Store(to + hf * 48, weigh(3, Pick(rows.below, rows.pitch, taps.second)));
        }
    }
    /// Features of a grid whose four taps make one input each.
    template <bool kBlended, bool kEightBits>
    void Blend(RowTaps rows, const Taps& taps, int features, float* to) {
        Float weights[4];
        if constexpr (kBlended)
            MakeProducts(taps.fraction, rows.fraction, weights);
        else
            MakeWeights<kEightBits>(taps.fraction, rows.fraction, weights);
        for (int f = 0; f < features; ++f, rows.above += rows.plane, rows.below += rows.plane, to += 16) {
            const Float values[4] = {
                Pick(rows.above, rows.pitch, taps.first), Pick(rows.above, rows.pitch, taps.second),
                Pick(rows.below, rows.pitch, taps.first), Pick(rows.below, rows.pitch, taps.second)};
            if constexpr (kEightBits && !kBlended)
                Store(to, RoundToE4M3(AddHalves(weights, values)));
            else
                Store(to, FinishBlend<kBlended, kEightBits>(AddProducts(weights, values)));
        }
    }
    static OPENNTC_FAST_INLINE Float AddProducts(const Float (&weights)[4], const Float (&values)[4]) {
        Float sum = Multiply(weights[0], values[0]);
        for (int c = 1; c < 4; ++c)
            sum = MultiplyAdd(weights[c], values[c], sum);
        return sum;
    }
    /// With products and sums rounded to binary16.
    static OPENNTC_FAST_INLINE Float AddHalves(const Float (&weights)[4], const Float (&values)[4]) {
        Float sum = RoundToHalf(Multiply(weights[0], values[0]));
        for (int c = 1; c < 4; ++c)
            sum = RoundToHalf(Add(sum, RoundToHalf(Multiply(weights[c], values[c]))));
        return sum;
    }
    template <bool kBlended, bool kEightBits>
    static OPENNTC_FAST_INLINE Float FinishBlend(const Float& sum) {
        if constexpr (kEightBits)
            return RoundToInput(Subtract(Multiply(sum, Set(2.0f / 15.0f)), Set(1.0f)));
        return kBlended ? Subtract(Floor(sum), Set(kBlendedOffset)) : Floor(sum);
    }

    /// What each texel of a row gives to each latent of a row: [16 texels][pitch].
    static void FillMatrix(AlignedBuffer<float>& matrix, const AxisTaps& taps, const TileTask& tile,
                           const LocalGrid& grid, bool first, bool second) {
        const auto size = static_cast<std::size_t>(16 * grid.pitch);
        if (matrix.size() < size)
            matrix.Resize(size);
        std::memset(matrix.data(), 0, size * sizeof(float));
        for (int t = 0; t < tile.width; ++t) {
            const auto x = static_cast<std::size_t>(tile.x + t);
            float* row = matrix.data() + t * grid.pitch - grid.originX;
            if (first)
                row[taps.first[x]] += 1.0f - taps.fraction[x];
            if (second)
                row[taps.second[x]] += taps.fraction[x];
        }
    }
    /// Adds the gradients of two inputs, which read a feature's upper and lower taps, along y and then along
    /// x.
    void AddSlots(const TileTask& tile, const AxisTaps& tapsY, const LocalGrid& grid, int feature, int upper,
                  int lower, const AlignedBuffer<float>& matrix) {
        float* rows = rowSums_.data();
        std::memset(rows, 0, sizeof(float) * 16 * static_cast<std::size_t>(grid.rows));
        for (int y = 0; y < tile.height; ++y) {
            const auto at = static_cast<std::size_t>(tile.y + y);
            const float fy = tapsY.fraction[at];
            float* first = rows + (tapsY.first[at] - grid.originY) * 16;
            float* second = rows + (tapsY.second[at] - grid.originY) * 16;
            Store(first, MultiplyAdd(Set(1.0f - fy), Load(gradients_.data() + upper * kTileTexels + y * 16),
                                     Load(first)));
            Store(second,
                  MultiplyAdd(Set(fy), Load(gradients_.data() + lower * kTileTexels + y * 16), Load(second)));
        }
        float* to = grid.gradients + feature * grid.rows * grid.pitch;
        for (int r = 0; r < grid.rows; ++r)
            AddRow(rows + r * 16, matrix.data(), grid.pitch, to + r * grid.pitch);
    }
    static OPENNTC_FAST_INLINE void AddRow(const float* texels, const float* matrix, int pitch,
                                           float* latents) {
        for (int j = 0; j < pitch; j += 16) {
            Float even = Load(latents + j), odd = Set(0.0f);
            for (int t = 0; t < 16; t += 2) {
                even = MultiplyAdd(Set(texels[t]), Load(matrix + t * pitch + j), even);
                odd = MultiplyAdd(Set(texels[t + 1]), Load(matrix + (t + 1) * pitch + j), odd);
            }
            Store(latents + j, Add(even, odd));
        }
    }

    NetworkShape shape_;
    AlignedBuffer<float> slots_, block_; ///< inputs of a row of texels, and their transpose
    AlignedBuffer<float> gradients_;     ///< [input][texel]
    AlignedBuffer<float> matrices_[3], rowSums_;
};
