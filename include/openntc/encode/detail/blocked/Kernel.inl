// SPDX-License-Identifier: MIT
// Forward and backward pass of a tile, over Matrix.inl. Texels are rows and channels are columns of every
// product, so that nothing is transposed between layers:
//   forward   sums[texel][output]     = inputs[texel][input] x weights[input][output]
//   backward  gradients[texel][input] = gradients[texel][output] x weights^T[output][input]
//   weights   sums[input][output]    += inputs^T[input][texel] x gradients[texel][output]
// Integers that the decoder's network handles are exact in what an operand keeps, and their sums are below
// 2^24: the forward pass computes the decoder's integers.

/// kEightBits: of an FP8 network, whose latents are given and stay, whose numbers of E4M3 are exact in an
/// operand too, and whose sums are rounded to binary16.
template <bool kEightBits>
class NetworkKernel : public std::conditional_t<kEightBits, EightBitRows, Rows> {
public:
    static constexpr int kTiles = 1;
    static constexpr int kTexels = kTileTexels;

    explicit NetworkKernel(const NetworkShape& shape)
        : shape_(shape), latents_(shape), inputGradients_(std::size_t{kTexels} * kMostChannels),
          rows_(std::size_t{kTexels} * kOutputs), outputs_(std::size_t{kTexels} * kOutputs) {
        for (auto& slopes : slopes_)
            slopes.Resize(std::size_t{kTexels} * kHidden);
    }

    void Begin() {}
    void End() {}

    /// Adds the gradients and the loss of a tile; writes the tile's latent gradients where those are trained.
    void Train(const KernelContext& context, TileTask* tiles, int, GradientSums& sums) {
        Forward<true>(context, tiles[0]);
        Loss::Apply(context, tiles[0], outputs_.data(), sums);
        Backward(*context.packed, sums);
        if constexpr (!kEightBits)
            latents_.Scatter(tiles[0], inputGradients_.data(), kMostChannels);
    }
    /// Network outputs [16][kTexels] of a tile.
    const float* Infer(const KernelContext& context, TileTask* tiles, int) {
        Forward<false>(context, tiles[0]);
        return outputs_.data();
    }

    /// Working weights of inputs `input`, which is even, and `input` + 1 to the outputs of a column: integers
    /// q[2][16], real[o] of them in real units.
    static void PackRows(PackedNetwork& packed, const NetworkShape& shape, int layer, int column, int input,
                         const float (&q)[2][16], const float* real) {
        const int outputs = shape.LayerOutputs(layer), inputs = shape.LayerInputs(layer);
        const Float even = Load(q[0]), odd = Load(q[1]), scale = Load(real);
        PackWeights(packed.columns.data() + (shape.WeightOffset(layer) + input * outputs) / kTerms +
                        column * 16,
                    outputs, even, odd);
        PackTransposed(packed.rows.data() + (shape.WeightOffset(layer) + column * 16 * inputs) / kTerms +
                           input,
                       inputs, Multiply(even, scale), Multiply(odd, scale));
    }

private:
    /// How a hidden layer's sums become the next one's inputs.
    enum class Hidden { Integers, BlendedIntegers, EightBits, LastEightBits };

    /// Activation and requantisation (format specification: HGELU-clamp, step 0.0125): generation 1's in
    /// units of the step; generation 3's (BlendedIntegers) in real units, in the order of its operations.
    template <bool kTraining, Hidden kHiddenLayer>
    struct Activation {
        Operand& to;
        float* slopes; ///< [texel][channel]
        const float* scale;
        const float* bias;

        template <int kRows, int kColumns>
        OPENNTC_FAST_INLINE void Do(int texel, int column, const Sums<kRows, kColumns>& sums) const {
            OPENNTC_FAST_UNROLL
            for (int c = 0; c < kColumns; ++c) {
                const int channel = (column + c) * 16;
                const Float s = Load(scale + channel), b = Load(bias + channel);
                OPENNTC_FAST_UNROLL
                for (int r = 0; r < kRows; r += 2) {
                    float* slope = slopes + (texel + r) * kHidden + channel;
                    const Float even = Apply(sums[r][c], s, b, slope);
                    const Float odd = Apply(sums[r + 1][c], s, b, slope + kHidden);
                    to.Put(texel + r, channel, even, odd);
                }
            }
        }
        static OPENNTC_FAST_INLINE Float Apply(const Float& sum, const Float& scale, const Float& bias,
                                               float* slope) {
            constexpr bool kBlended = kHiddenLayer == Hidden::BlendedIntegers;
            if constexpr (kHiddenLayer == Hidden::EightBits || kHiddenLayer == Hidden::LastEightBits)
                return ActivateEightBits<kTraining, kHiddenLayer == Hidden::LastEightBits>(sum, slope);
            const Float zero = Set(0.0f), one = Set(1.0f), half = Set(0.5f), magic = Set(12582912.0f);
            const Float u = Multiply(Add(sum, bias), scale);
            const Float open = kBlended ? Add(Multiply(u, Set(kBlendedThird)), half)
                                        : MultiplyAdd(u, Set(1.0f / 240.0f), half);
            const Float gate = Min(Max(open, zero), one);
            if constexpr (kTraining) {
                const Float middle = MultiplyAdd(open, Set(2.0f), Set(-0.5f));
                const Float inner = Select(Less(open, one), middle, one);
                const Float lower = Select(Less(zero, open), inner, zero);
                Store(slope, Select(Less(Set(1.5f), open), zero, lower));
            }
            if constexpr (kBlended) {
                const Float y = Multiply(Multiply(Min(u, Set(3.0f)), gate), Set(kHiddenSteps));
                return Subtract(Add(y, magic), magic);
            }
            return Subtract(MultiplyAdd(Min(u, Set(240.0f)), gate, magic), magic);
        }
    };
    struct Outputs {
        float* to; ///< [texel][output]
        const float* scale;
        const float* bias;

        template <int kRows, int kColumns>
        OPENNTC_FAST_INLINE void Do(int texel, int, const Sums<kRows, kColumns>& sums) const {
            const Float s = Load(scale), b = Load(bias);
            OPENNTC_FAST_UNROLL
            for (int r = 0; r < kRows; ++r)
                Store(to + (texel + r) * kOutputs, Multiply(Add(sums[r][0], b), s));
        }
    };
    /// Gradients of sums from those of activations.
    struct Derivative {
        Operand& to;
        const float* slopes;
        float* bias; ///< [channel]: what their sum over texels is added to

        template <int kRows, int kColumns>
        OPENNTC_FAST_INLINE void Do(int texel, int column, const Sums<kRows, kColumns>& sums) const {
            OPENNTC_FAST_UNROLL
            for (int c = 0; c < kColumns; ++c) {
                const int channel = (column + c) * 16;
                Float total = Load(bias + channel);
                OPENNTC_FAST_UNROLL
                for (int r = 0; r < kRows; r += 2) {
                    const float* slope = slopes + (texel + r) * kHidden + channel;
                    const Float even = Multiply(sums[r][c], Load(slope)),
                                odd = Multiply(sums[r + 1][c], Load(slope + kHidden));
                    total = Add(total, Add(even, odd));
                    to.Put(texel + r, channel, even, odd);
                }
                Store(bias + channel, total);
            }
        }
    };
    struct InputGradients {
        float* to; ///< [texel][kMostChannels]

        template <int kRows, int kColumns>
        OPENNTC_FAST_INLINE void Do(int texel, int column, const Sums<kRows, kColumns>& sums) const {
            OPENNTC_FAST_UNROLL
            for (int r = 0; r < kRows; ++r) {
                OPENNTC_FAST_UNROLL
                for (int c = 0; c < kColumns; ++c)
                    Store(to + (texel + r) * kMostChannels + (column + c) * 16, sums[r][c]);
            }
        }
    };
    struct WeightGradients {
        float* to; ///< WeightIndex order
        int outputColumns;

        template <int kRows, int kColumns>
        OPENNTC_FAST_INLINE void Do(int input, int column, const Sums<kRows, kColumns>& sums) const {
            OPENNTC_FAST_UNROLL
            for (int r = 0; r < kRows; ++r) {
                const int i = input + r;
                OPENNTC_FAST_UNROLL
                for (int c = 0; c < kColumns; ++c) {
                    float* sum = to + ((i / 16) * outputColumns + column + c) * 256 + (i % 16) * 16;
                    Store(sum, Add(Load(sum), sums[r][c]));
                }
            }
        }
    };

    template <bool kTraining>
    void Forward(const KernelContext& context, const TileTask& tile) {
        latents_.template Gather<kEightBits>(tile, inputs_[0]);
        const PackedNetwork& packed = *context.packed;
        if constexpr (kEightBits) {
            HiddenLayer<kTraining, Hidden::EightBits>(packed, 0);
            HiddenLayer<kTraining, Hidden::EightBits>(packed, 1);
            HiddenLayer<kTraining, Hidden::LastEightBits>(packed, 2);
        } else {
            for (int l = 0; l < 3; ++l) {
                if (shape_.blended)
                    HiddenLayer<kTraining, Hidden::BlendedIntegers>(packed, l);
                else
                    HiddenLayer<kTraining, Hidden::Integers>(packed, l);
            }
        }
        const Factors factors{inputs_[3].GetRow(0), packed.columns.data() + shape_.WeightOffset(3) / kTerms,
                              kOutputs, shape_.LayerInputs(3) / kTerms};
        MultiplyAll<Operand::kRowPitch, 1>(factors, kTexels, 1,
                                           Outputs{rows_.data(), packed.scale + NetworkShape::BiasOffset(3),
                                                   packed.bias + NetworkShape::BiasOffset(3)});
        for (int t = 0; t < kTexels; t += 16)
            Transpose(rows_.data() + t * kOutputs, kOutputs, outputs_.data() + t, kTexels);
    }

    template <bool kTraining, Hidden kHiddenLayer>
    void HiddenLayer(const PackedNetwork& packed, int layer) {
        const int outputs = shape_.LayerOutputs(layer);
        // Sums of an FP8 network begin with the bias, as a decoder's that emulates E4M3 do.
        const Factors factors{inputs_[layer].GetRow(0),
                              packed.columns.data() + shape_.WeightOffset(layer) / kTerms, outputs,
                              GetUsedInputs(layer) / kTerms,
                              kEightBits ? packed.bias + NetworkShape::BiasOffset(layer) : nullptr};
        const Activation<kTraining, kHiddenLayer> finish{inputs_[layer + 1], slopes_[layer].data(),
                                                         packed.scale + NetworkShape::BiasOffset(layer),
                                                         packed.bias + NetworkShape::BiasOffset(layer)};
        MultiplyAll<Operand::kRowPitch, 1>(factors, kTexels, outputs / 16, finish);
    }
    /// Whole columns of sixteen.
    int GetUsedInputs(int layer) const {
        return layer == 0 ? Latents::GetInputColumns(shape_) * 16 : shape_.LayerInputs(layer);
    }

    void Backward(const PackedNetwork& packed, GradientSums& sums) {
        for (int t = 0; t < kTexels; t += 16)
            Transpose(outputs_.data() + t, kTexels, rows_.data() + t * kOutputs, kOutputs);
        for (int t = 0; t < kTexels; t += 2)
            gradients_[1].Put(t, 0, Load(rows_.data() + t * kOutputs),
                              Load(rows_.data() + t * kOutputs + kOutputs));
        AddWeightGradients(3, gradients_[1], sums);
        for (int l = 3; l > 0; --l) {
            const Operand& from = gradients_[l & 1];
            Operand& to = gradients_[(l & 1) ^ 1];
            alignas(64) float bias[kHidden] = {};
            const int inputs = shape_.LayerInputs(l);
            const Factors factors{from.GetRow(0), packed.rows.data() + shape_.WeightOffset(l) / kTerms,
                                  inputs, shape_.LayerOutputs(l) / kTerms};
            MultiplyAll<Operand::kRowPitch, 1>(factors, kTexels, inputs / 16,
                                               Derivative{to, slopes_[l - 1].data(), bias});
            for (int o = 0; o < inputs; ++o)
                sums.biases[NetworkShape::BiasOffset(l - 1) + o][0] += bias[o];
            AddWeightGradients(l - 1, to, sums);
        }
        if constexpr (kEightBits)
            return;
        const Factors factors{gradients_[0].GetRow(0), packed.rows.data(), shape_.PaddedInputs(),
                              kHidden / kTerms};
        MultiplyAll<Operand::kRowPitch, 1>(factors, kTexels, Latents::GetLatentColumns(shape_),
                                           InputGradients{inputGradients_.data()});
    }
    void AddWeightGradients(int layer, const Operand& gradients, GradientSums& sums) {
        const int inputs = GetUsedInputs(layer);
        const int columns = shape_.LayerOutputs(layer) / 16;
        const Factors factors{inputs_[layer].GetColumns(), gradients.GetColumns(), Operand::kColumnPitch,
                              kTexels / kTerms};
        MultiplyAll<1, Operand::kColumnPitch>(
            factors, inputs, columns,
            WeightGradients{sums.weights.data() + shape_.WeightOffset(layer), columns});
    }

    NetworkShape shape_;
    Latents latents_;
    Operand inputs_[kLayers], gradients_[2];
    AlignedBuffer<float> slopes_[3], inputGradients_; ///< [texel][channel]
    AlignedBuffer<float> rows_, outputs_;             ///< [texel][output], [output][texel]
};

using Kernel = NetworkKernel<false>;
using HeadKernel = NetworkKernel<true>; ///< of FP8 networks
