// SPDX-License-Identifier: MIT
// Stability: internal
// Forward and backward pass of a block of texels with AMX bfloat16 tiles and AVX-512.
//
// Every integer that the decoder's network handles (inputs, activations 0 ... 255, weights -127 ... 127) is
// exact in bfloat16 and every sum is below 2^24, so that the forward pass computes the decoder's integers
// exactly.
//
// Three arrangements of a matrix [channel][texel] are used, each in tiles of 1 KiB:
//   P  rows = pairs of channels, columns = 16 texels, element = (channel 2j, channel 2j + 1): right operand
//      of W x X
//   A  rows = 16 channels, columns = 32 texels: left operand of X x dZ^T
//   B  rows = pairs of texels, columns = 16 channels: right operand of X x dZ^T; the transpose of A in 32-bit
//      units
#pragma once

#include "openntc/encode/detail/AmxLatents.h"

#if defined(OPENNTC_ENCODE_AMX)

#if !defined(__clang__)
// g++ 12 warns about its own headers: they initialise "undefined" vectors with themselves (GCC bug 105593).
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wuninitialized"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif

#include "openntc/core/HideMacros.h"

namespace openntc::encode::detail {

class AmxKernel : public Avx512Rows {
public:
    static constexpr int kTiles = AmxLatents::kTiles;
    static constexpr int kTexels = AmxLatents::kTexels;

    explicit AmxKernel(const NetworkShape& shape) : shape_(shape), latents_(shape) {
        const auto inputs = static_cast<std::size_t>(shape.PaddedInputs());
        constexpr std::size_t kBytes = std::size_t{kTexels} * 2;
        xp_[0].Resize(inputs * kBytes);
        xa_[0].Resize(inputs * kBytes);
        for (int l = 1; l < kLayers; ++l) {
            xp_[l].Resize(kHidden * kBytes);
            xa_[l].Resize(kHidden * kBytes);
        }
        for (auto& d : derivative_)
            d.Resize(kHidden * kBytes);
        zp_.Resize(kHidden * kBytes);
        zp2_.Resize(kHidden * kBytes);
        zb_.Resize(kHidden * kBytes);
        zpOut_.Resize(32 * kBytes);
        inputGradient_.Resize(inputs * kTexels);
        staging_.Resize(2 * 4 * 256);
        outputs_.Resize(kOutputs * kTexels);
    }

    OPENNTC_AMX_TARGET void Begin() {
        struct Configuration {
            std::uint8_t palette, start, reserved[14];
            std::uint16_t bytesPerRow[16];
            std::uint8_t rows[16];
        } configuration = {};
        configuration.palette = 1;
        for (int i = 0; i < 8; ++i) {
            configuration.bytesPerRow[i] = 64;
            configuration.rows[i] = 16;
        }
        // The compiler's header does not say that the instruction reads all of the structure.
        __asm__ volatile("" : : "r"(&configuration) : "memory");
        _tile_loadconfig(&configuration);
    }
    OPENNTC_AMX_TARGET void End() { _tile_release(); }

    /// Adds the gradients and the loss of up to kTiles tiles; writes the tiles' latent gradients.
    OPENNTC_AMX_TARGET void Train(const KernelContext& context, TileTask* tiles, int count,
                                  GradientSums& sums) {
        Forward<true>(context, tiles, count);
        Loss(context, tiles, count, sums);
        Backward(context, sums);
        for (int i = 0; i < count; ++i)
            latents_.Scatter(tiles[i], i, inputGradient_.data());
    }

    /// Network outputs [16][kTexels] of up to kTiles tiles, texel = tile * 128 + row * 16 + column.
    OPENNTC_AMX_TARGET const float* Infer(const KernelContext& context, TileTask* tiles, int count) {
        Forward<false>(context, tiles, count);
        return outputs_.data();
    }

private:
    static constexpr int kColumns = kTexels / 16; ///< 16-texel columns of a block
    static constexpr int kGroups = kTexels / 32;
    using Byte = std::uint8_t;

    /// Tile loads do not tell the compiler what memory they read: what was stored before must really be
    /// stored.
    OPENNTC_AMX_TARGET static inline void PublishStores() { __asm__ volatile("" : : : "memory"); }

    OPENNTC_AMX_TARGET static inline void Multiply2x2(const Byte* a0, const Byte* a1, const Byte* b0,
                                                      const Byte* b1, int steps, std::size_t stepA,
                                                      std::size_t stepB) {
        for (int k = 0; k < steps; ++k) {
            _tile_loadd(4, a0, 64);
            _tile_loadd(6, b0, 64);
            _tile_loadd(7, b1, 64);
            _tile_loadd(5, a1, 64);
            _tile_dpbf16ps(0, 4, 6);
            _tile_dpbf16ps(1, 4, 7);
            _tile_dpbf16ps(2, 5, 6);
            _tile_dpbf16ps(3, 5, 7);
            a0 += stepA;
            a1 += stepA;
            b0 += stepB;
            b1 += stepB;
        }
    }
    OPENNTC_AMX_TARGET static inline void ZeroAccumulators() {
        PublishStores();
        _tile_zero(0);
        _tile_zero(1);
        _tile_zero(2);
        _tile_zero(3);
    }
    OPENNTC_AMX_TARGET static inline void StoreAccumulators(float* to) {
        _tile_stored(0, to, 64);
        _tile_stored(1, to + 256, 64);
        _tile_stored(2, to + 512, 64);
        _tile_stored(3, to + 768, 64);
    }
    // ---- forward
    // ----------------------------------------------------------------------------------------------

    /// kTraining: also keeps what the backward pass needs.
    template <bool kTraining>
    OPENNTC_AMX_TARGET void Forward(const KernelContext& context, TileTask* tiles, int count) {
        for (int i = 0; i < count; ++i)
            latents_.Gather<kTraining>(tiles[i], i, xp_[0].data(), xa_[0].data());
        if (count < kTiles)
            ClearInputs(count);
        const Byte* weights = reinterpret_cast<const Byte*>(context.packed->forward.data());
        for (int l = 0; l < 3; ++l)
            HiddenLayer<kTraining>(context, l, weights + 2 * PackedNetwork::ForwardOffset(shape_, l));
        OutputLayer(context, weights + 2 * PackedNetwork::ForwardOffset(shape_, 3));
    }

    OPENNTC_AMX_TARGET void ClearInputs(int from) {
        const int slots = shape_.PaddedInputs() / 32;
        for (int k = 0; k < slots; ++k)
            std::memset(xp_[0].data() + (k * kColumns + from * 8) * 1024, 0,
                        std::size_t(kTiles - from) * 8 * 1024);
        for (int k = 0; k < 2 * slots; ++k)
            std::memset(xa_[0].data() + (k * kGroups + from * 4) * 1024, 0,
                        std::size_t(kTiles - from) * 4 * 1024);
    }

    template <bool kTraining>
    OPENNTC_AMX_TARGET void HiddenLayer(const KernelContext& context, int layer, const Byte* weights) {
        const int steps = shape_.LayerInputs(layer) / 32;
        const std::size_t rowStep = static_cast<std::size_t>(steps) * 1024;
        const float* scale = context.packed->scale + NetworkShape::BiasOffset(layer);
        const float* bias = context.packed->bias + NetworkShape::BiasOffset(layer);
        const Byte* inputs = xp_[layer].data();
        // The tile unit works on the next block while the vector units finish the previous one.
        int pending = -1;
        for (int block = 0; block <= 2 * kGroups; ++block) {
            if (block < 2 * kGroups) {
                const int half = block / kGroups, group = block % kGroups;
                const Byte* a = weights + static_cast<std::size_t>(2 * half) * rowStep;
                const Byte* b = inputs + group * 2048;
                ZeroAccumulators();
                Multiply2x2(a, a + rowStep, b, b + 1024, steps, 1024, kColumns * 1024);
            }
            if (pending >= 0) {
                const int half = pending / kGroups, group = pending % kGroups;
                Activate<kTraining>(staging_.data(), scale + half * 32, bias + half * 32,
                                    xp_[layer + 1].data() + (half * kColumns + group * 2) * 1024,
                                    xa_[layer + 1].data() + (half * 2 * kGroups + group) * 1024,
                                    derivative_[layer].data() + (half * kGroups + group) * 2048);
            }
            if (block < 2 * kGroups)
                StoreAccumulators(staging_.data());
            pending = block;
        }
    }

    /// Activation and requantisation (format specification: HGELU-clamp, step 0.0125) of 32 outputs x 32
    /// texels, in units of the step; `d` receives the derivative.
    template <bool kTraining>
    OPENNTC_AMX_TARGET static inline void Activate(const float* sums, const float* scale, const float* bias,
                                                   Byte* p, Byte* a, Byte* d) {
        const __m512 third = _mm512_set1_ps(1.0f / 240.0f), half = _mm512_set1_ps(0.5f),
                     one = _mm512_set1_ps(1.0f), zero = _mm512_setzero_ps(), top = _mm512_set1_ps(240.0f),
                     magic = _mm512_set1_ps(12582912.0f), two = _mm512_set1_ps(2.0f),
                     oneAndHalf = _mm512_set1_ps(1.5f);
        for (int pair = 0; pair < 16; ++pair) {
            __m512 q[2][2], slope[2][2];
            for (int r = 0; r < 2; ++r) {
                const int row = 2 * pair + r;
                const float* source = sums + (row / 16) * 512 + (row % 16) * 16;
                const __m512 b = _mm512_set1_ps(bias[row]), s = _mm512_set1_ps(scale[row]);
                for (int t = 0; t < 2; ++t) {
                    const __m512 u = _mm512_mul_ps(_mm512_add_ps(_mm512_load_ps(source + t * 256), b), s);
                    const __m512 open = _mm512_fmadd_ps(u, third, half);
                    const __m512 gate = _mm512_min_ps(_mm512_max_ps(open, zero), one);
                    q[r][t] = _mm512_sub_ps(_mm512_fmadd_ps(_mm512_min_ps(u, top), gate, magic), magic);
                    if constexpr (!kTraining)
                        continue;
                    const __mmask16 upper = _mm512_cmp_ps_mask(open, one, _CMP_GE_OQ);
                    const __mmask16 inside = _mm512_mask_cmp_ps_mask(
                        _mm512_cmp_ps_mask(open, zero, _CMP_GT_OQ), open, oneAndHalf, _CMP_LE_OQ);
                    slope[r][t] = _mm512_maskz_mov_ps(
                        inside, _mm512_mask_mov_ps(_mm512_fmsub_ps(open, two, half), upper, one));
                }
            }
            for (int t = 0; t < 2; ++t) {
                _mm512_store_si512(p + t * 1024 + pair * 64, PackPair(q[0][t], q[1][t]));
                if constexpr (kTraining)
                    _mm512_store_si512(d + pair * 128 + t * 64, PackPair(slope[0][t], slope[1][t]));
            }
            for (int r = 0; kTraining && r < 2; ++r) {
                const int row = 2 * pair + r;
                _mm512_store_si512(a + (row / 16) * kGroups * 1024 + (row % 16) * 64,
                                   PackTexels(q[r][0], q[r][1]));
            }
        }
    }

    OPENNTC_AMX_TARGET void OutputLayer(const KernelContext& context, const Byte* weights) {
        const float* scale = context.packed->scale + NetworkShape::BiasOffset(3);
        const float* bias = context.packed->bias + NetworkShape::BiasOffset(3);
        const Byte* inputs = xp_[3].data();
        for (int column = 0; column < kColumns; column += 4) {
            ZeroAccumulators();
            for (int k = 0; k < 2; ++k) {
                const Byte* b = inputs + (k * kColumns + column) * 1024;
                _tile_loadd(4, weights + k * 1024, 64);
                _tile_loadd(5, b, 64);
                _tile_dpbf16ps(0, 4, 5);
                _tile_loadd(6, b + 1024, 64);
                _tile_dpbf16ps(1, 4, 6);
                _tile_loadd(7, b + 2048, 64);
                _tile_dpbf16ps(2, 4, 7);
                _tile_loadd(5, b + 3072, 64);
                _tile_dpbf16ps(3, 4, 5);
            }
            float* to = outputs_.data() + column * 16;
            _tile_stored(0, to, kTexels * 4);
            _tile_stored(1, to + 16, kTexels * 4);
            _tile_stored(2, to + 32, kTexels * 4);
            _tile_stored(3, to + 48, kTexels * 4);
        }
        for (int o = 0; o < kOutputs; ++o) {
            const __m512 b = _mm512_set1_ps(bias[o]), s = _mm512_set1_ps(scale[o]);
            float* row = outputs_.data() + o * kTexels;
            for (int t = 0; t < kTexels; t += 16)
                _mm512_store_ps(row + t, _mm512_mul_ps(_mm512_add_ps(_mm512_load_ps(row + t), b), s));
        }
    }

    // ---- loss
    // -------------------------------------------------------------------------------------------------

    OPENNTC_AMX_TARGET void Loss(const KernelContext& context, TileTask* tiles, int count,
                                 GradientSums& sums) {
        // Output errors become gradients in place; outputs nobody trains get none.
        bool trained[kOutputs] = {};
        for (int c = 0; c < context.channels; ++c)
            trained[context.outputOf[c]] = true;
        for (int o = 0; o < kOutputs; ++o) {
            if (!trained[o])
                std::memset(outputs_.data() + o * kTexels, 0, kTexels * sizeof(float));
        }
        const __m512 unit = _mm512_set1_ps(1.0f / 65535.0f);
        for (int i = 0; i < kTiles; ++i) {
            if (i >= count) {
                for (int o = 0; o < kOutputs; ++o)
                    std::memset(outputs_.data() + o * kTexels + i * kTileTexels, 0,
                                kTileTexels * sizeof(float));
                continue;
            }
            const TileTask& tile = tiles[i];
            const auto columns = static_cast<__mmask16>((1u << tile.width) - 1u);
            __mmask16 keep[kTileHeight];
            for (int y = 0; y < kTileHeight; ++y) {
                keep[y] = y < tile.height ? columns : __mmask16(0);
                if (context.maskIndex >= 0) {
                    const __m512 mask =
                        LoadReference(tile.reference + context.maskIndex * kTileTexels + y * 16, unit);
                    keep[y] =
                        _mm512_mask_cmp_ps_mask(keep[y], mask, _mm512_set1_ps(context.maskZero), _CMP_GT_OQ);
                }
            }
            for (int c = 0; c < context.channels; ++c) {
                const int o = context.outputOf[c];
                float* row = outputs_.data() + o * kTexels + i * kTileTexels;
                const std::uint16_t* reference = tile.reference + c * kTileTexels;
                const __m512 gain = _mm512_set1_ps(context.gain[c]);
                __m512 squares = _mm512_setzero_ps(), total = _mm512_setzero_ps();
                for (int y = 0; y < kTileHeight; ++y) {
                    const __mmask16 texels =
                        c == context.maskIndex ? (y < tile.height ? columns : __mmask16(0)) : keep[y];
                    const __m512 wanted = LoadReference(reference + y * 16, unit);
                    __m512 error = _mm512_maskz_sub_ps(texels, _mm512_load_ps(row + y * 16), wanted);
                    __m512 weighed = error;
                    if (c == context.oneSided)
                        WeighMask(context.maskPush, wanted, error, weighed);
                    const __m512 gradient = _mm512_mul_ps(weighed, gain);
                    squares = _mm512_fmadd_ps(error, error, squares);
                    total = _mm512_add_ps(total, gradient);
                    _mm512_store_ps(row + y * 16, gradient);
                }
                float* loss = sums.loss[o];
                _mm512_store_ps(loss, _mm512_fmadd_ps(squares, _mm512_set1_ps(context.squaredRange[c]),
                                                      _mm512_load_ps(loss)));
                float* bias = sums.biases[NetworkShape::BiasOffset(3) + o];
                _mm512_store_ps(bias, _mm512_add_ps(_mm512_load_ps(bias), total));
            }
        }
        for (int group = 0; group < kGroups; ++group) {
            alignas(64) Byte rows[1024];
            for (int o = 0; o < kOutputs; o += 2) {
                const float* even = outputs_.data() + o * kTexels + group * 32;
                const float* odd = even + kTexels;
                const __m512 e0 = _mm512_load_ps(even), e1 = _mm512_load_ps(even + 16),
                             o0 = _mm512_load_ps(odd), o1 = _mm512_load_ps(odd + 16);
                _mm512_store_si512(zpOut_.data() + group * 2048 + o * 32, PackPair(e0, o0));
                _mm512_store_si512(zpOut_.data() + group * 2048 + 1024 + o * 32, PackPair(e1, o1));
                _mm512_store_si512(rows + o * 64, PackTexels(e0, e1));
                _mm512_store_si512(rows + o * 64 + 64, PackTexels(o0, o1));
            }
            Transpose(rows, zb_.data() + group * 1024);
        }
    }
    /// MaskLoss::Clip and Weigh.
    OPENNTC_AMX_TARGET static inline void WeighMask(float maskPush, __m512 wanted, __m512& error,
                                                    __m512& weighed) {
        const __m512 none = _mm512_setzero_ps(), push = _mm512_set1_ps(maskPush),
                     knee = _mm512_set1_ps(MaskLoss::kKnee);
        const __mmask16 low = _mm512_cmp_ps_mask(wanted, _mm512_set1_ps(MaskLoss::kLow), _CMP_LT_OQ),
                        high = _mm512_cmp_ps_mask(wanted, _mm512_set1_ps(MaskLoss::kHigh), _CMP_GT_OQ);
        error = _mm512_mask_max_ps(error, low, error, none);
        error = _mm512_mask_min_ps(error, high, error, none);
        const __m512 above = _mm512_max_ps(_mm512_sub_ps(error, knee), none),
                     below = _mm512_min_ps(_mm512_add_ps(error, knee), none);
        weighed = _mm512_mask_add_ps(error, low, error, _mm512_mul_ps(push, above));
        weighed = _mm512_mask_add_ps(weighed, high, error, _mm512_mul_ps(push, below));
    }
    OPENNTC_AMX_TARGET static inline __m512 LoadReference(const std::uint16_t* from, __m512 unit) {
        const __m256i raw = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(from));
        return _mm512_mul_ps(_mm512_cvtepi32_ps(_mm512_cvtepu16_epi32(raw)), unit);
    }

    // ---- backward
    // ---------------------------------------------------------------------------------------------

    OPENNTC_AMX_TARGET void Backward(const KernelContext& context, GradientSums& sums) {
        const Byte* weights = reinterpret_cast<const Byte*>(context.packed->backward.data());
        // Layer 3: one tile of outputs.
        PublishStores();
        {
            float* to = sums.weights.data() + shape_.WeightOffset(3);
            for (int i = 0; i < 4; ++i) {
                _tile_loadd(0, to + i * 256, 64);
                for (int g = 0; g < kGroups; ++g) {
                    _tile_loadd(4, xa_[3].data() + (i * kGroups + g) * 1024, 64);
                    _tile_loadd(6, zb_.data() + g * 1024, 64);
                    _tile_dpbf16ps(0, 4, 6);
                }
                _tile_stored(0, to + i * 256, 64);
            }
        }
        HiddenGradients(weights + 2 * PackedNetwork::BackwardOffset(shape_, 3), zpOut_.data(), 1, 2,
                        zp_.data(), sums);
        WeightGradients(2, sums);
        HiddenGradients(weights + 2 * PackedNetwork::BackwardOffset(shape_, 2), zp_.data(), 2, 1, zp2_.data(),
                        sums);
        WeightGradients(1, sums);
        HiddenGradients(weights + 2 * PackedNetwork::BackwardOffset(shape_, 1), zp2_.data(), 2, 0, zp_.data(),
                        sums);
        WeightGradients(0, sums);
        const Byte* first = weights + 2 * PackedNetwork::BackwardOffset(shape_, 0);
        const int blocks = (shape_.LatentInputs() + 31) / 32;
        for (int half = 0; half < blocks; ++half) {
            const Byte* a = first + half * 2 * 2048;
            for (int group = 0; group < kGroups; ++group) {
                const Byte* b = zp_.data() + group * 2048;
                ZeroAccumulators();
                Multiply2x2(a, a + 2048, b, b + 1024, 2, 1024, kColumns * 1024);
                float* to = inputGradient_.data() + half * 32 * kTexels + group * 32;
                _tile_stored(0, to, kTexels * 4);
                _tile_stored(1, to + 16, kTexels * 4);
                _tile_stored(2, to + 16 * kTexels, kTexels * 4);
                _tile_stored(3, to + 16 * kTexels + 16, kTexels * 4);
            }
        }
    }

    /// Gradients before the activation of hidden layer `layer` from those after the next layer's matrix.
    OPENNTC_AMX_TARGET void HiddenGradients(const Byte* weights, const Byte* next, int steps, int layer,
                                            Byte* p, GradientSums& sums) {
        const std::size_t rowStep = static_cast<std::size_t>(steps) * 1024;
        int pending = -1;
        for (int block = 0; block <= 2 * kGroups; ++block) {
            if (block < 2 * kGroups) {
                const int half = block / kGroups, group = block % kGroups;
                const Byte* a = weights + static_cast<std::size_t>(2 * half) * rowStep;
                const Byte* b = next + group * 2048;
                ZeroAccumulators();
                Multiply2x2(a, a + rowStep, b, b + 1024, steps, 1024, kColumns * 1024);
            }
            if (pending >= 0) {
                const int half = pending / kGroups, group = pending % kGroups;
                Differentiate(staging_.data(), derivative_[layer].data() + (half * kGroups + group) * 2048,
                              p + (half * kColumns + group * 2) * 1024,
                              zb_.data() + (half * 2 * kGroups + group) * 1024,
                              sums.biases[NetworkShape::BiasOffset(layer) + half * 32]);
            }
            if (block < 2 * kGroups)
                StoreAccumulators(staging_.data());
            pending = block;
        }
    }

    OPENNTC_AMX_TARGET static inline void Differentiate(const float* sums, const Byte* d, Byte* p, Byte* b,
                                                        float* bias) {
        const __m512i high = _mm512_set1_epi32(static_cast<int>(0xffff0000u));
        alignas(64) Byte rows[2048];
        for (int pair = 0; pair < 16; ++pair) {
            __m512 z[2][2];
            const float* source = sums + (pair / 8) * 512 + (pair % 8) * 32;
            for (int t = 0; t < 2; ++t) {
                const __m512i slopes = _mm512_load_si512(d + pair * 128 + t * 64);
                z[0][t] = _mm512_mul_ps(_mm512_load_ps(source + t * 256),
                                        _mm512_castsi512_ps(_mm512_slli_epi32(slopes, 16)));
                z[1][t] = _mm512_mul_ps(_mm512_load_ps(source + t * 256 + 16),
                                        _mm512_castsi512_ps(_mm512_and_si512(slopes, high)));
                _mm512_store_si512(p + t * 1024 + pair * 64, PackPair(z[0][t], z[1][t]));
            }
            for (int r = 0; r < 2; ++r) {
                float* total = bias + (2 * pair + r) * 16;
                _mm512_store_ps(total, _mm512_add_ps(_mm512_load_ps(total), _mm512_add_ps(z[r][0], z[r][1])));
                _mm512_store_si512(rows + (2 * pair + r) * 64, PackTexels(z[r][0], z[r][1]));
            }
        }
        Transpose(rows, b);
        Transpose(rows + 1024, b + kGroups * 1024);
    }

    OPENNTC_AMX_TARGET void WeightGradients(int layer, GradientSums& sums) {
        float* to = sums.weights.data() + shape_.WeightOffset(layer);
        const int inputTiles = shape_.LayerInputs(layer) / 16;
        for (int i = 0; i < inputTiles; i += 2) {
            const Byte* a = xa_[layer].data() + i * kGroups * 1024;
            for (int o = 0; o < 4; o += 2) {
                float* c = to + (i * 4 + o) * 256;
                const Byte* b = zb_.data() + o * kGroups * 1024;
                PublishStores();
                _tile_loadd(0, c, 64);
                _tile_loadd(1, c + 256, 64);
                _tile_loadd(2, c + 1024, 64);
                _tile_loadd(3, c + 1280, 64);
                Multiply2x2(a, a + kGroups * 1024, b, b + kGroups * 1024, kGroups, 1024, 1024);
                _tile_stored(0, c, 64);
                _tile_stored(1, c + 256, 64);
                _tile_stored(2, c + 1024, 64);
                _tile_stored(3, c + 1280, 64);
            }
        }
    }

    /// 16 x 16 transpose of 32-bit units.
    OPENNTC_AMX_TARGET static inline void Transpose(const Byte* from, Byte* to) {
        // Four rows whose 128-bit lanes come from rows r, r+4, r+8, r+12: half of the shuffles become loads.
        __m512i lane[16];
        for (int r = 0; r < 4; ++r) {
            for (int quarter = 0; quarter < 4; ++quarter) {
                const Byte* source = from + r * 64 + quarter * 16;
                __m512i v = _mm512_castsi128_si512(_mm_load_si128(reinterpret_cast<const __m128i*>(source)));
                v = _mm512_mask_broadcast_i32x4(
                    v, 0x00f0, _mm_load_si128(reinterpret_cast<const __m128i*>(source + 256)));
                v = _mm512_mask_broadcast_i32x4(
                    v, 0x0f00, _mm_load_si128(reinterpret_cast<const __m128i*>(source + 512)));
                v = _mm512_mask_broadcast_i32x4(
                    v, 0xf000, _mm_load_si128(reinterpret_cast<const __m128i*>(source + 768)));
                lane[quarter * 4 + r] = v;
            }
        }
        for (int quarter = 0; quarter < 4; ++quarter) {
            const __m512i* v = lane + quarter * 4;
            const __m512i a = _mm512_unpacklo_epi32(v[0], v[1]), b = _mm512_unpackhi_epi32(v[0], v[1]),
                          c = _mm512_unpacklo_epi32(v[2], v[3]), d = _mm512_unpackhi_epi32(v[2], v[3]);
            Byte* target = to + quarter * 256;
            _mm512_store_si512(target, _mm512_unpacklo_epi64(a, c));
            _mm512_store_si512(target + 64, _mm512_unpackhi_epi64(a, c));
            _mm512_store_si512(target + 128, _mm512_unpacklo_epi64(b, d));
            _mm512_store_si512(target + 192, _mm512_unpackhi_epi64(b, d));
        }
    }

    NetworkShape shape_;
    AmxLatents latents_;
    AlignedBuffer<Byte> xp_[kLayers], xa_[kLayers], derivative_[3], zp_, zp2_, zb_, zpOut_;
    AlignedBuffer<float> inputGradient_, staging_, outputs_;
};

} // namespace openntc::encode::detail

#if !defined(__clang__)
#pragma GCC diagnostic pop
#endif

#include "openntc/core/RestoreMacros.h"
#endif
