// SPDX-License-Identifier: MIT
// Stability: internal
// Latents of a tile to network inputs, and gradients of inputs back to latents, with AVX-512.
#pragma once

#include "openntc/encode/detail/Avx512Rows.h"

#if defined(OPENNTC_ENCODE_AMX)

#if !defined(__clang__)
// g++ 12 warns about its own headers: they initialise "undefined" vectors with themselves (GCC bug 105593).
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wuninitialized"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#pragma GCC diagnostic ignored "-Wsign-conversion" // intrinsics are macros without optimisation
#endif

#include "openntc/core/HideMacros.h"

namespace openntc::encode::detail {

class AmxLatents {
public:
    using Byte = std::uint8_t;
    static constexpr int kTiles = 2; ///< tiles of texels per block
    static constexpr int kTexels = kTiles * kTileTexels;
    static constexpr int kColumns = kTexels / 16; ///< 16-texel columns of a block
    static constexpr int kGroups = kTexels / 32;

    explicit AmxLatents(const NetworkShape& shape) : shape_(shape) {}

    struct TapVectors {
        __m512i first, second;
        __m512 fraction;
    };
    OPENNTC_AMX_TARGET static inline TapVectors LoadTaps(const AxisTaps& taps, int x, int width, int origin) {
        const auto lanes = static_cast<__mmask16>((1u << width) - 1u);
        const __m512i base = _mm512_set1_epi32(origin);
        TapVectors v;
        v.first = _mm512_maskz_sub_epi32(lanes, _mm512_maskz_loadu_epi32(lanes, taps.first.data() + x), base);
        v.second =
            _mm512_maskz_sub_epi32(lanes, _mm512_maskz_loadu_epi32(lanes, taps.second.data() + x), base);
        v.fraction = _mm512_maskz_loadu_ps(lanes, taps.fraction.data() + x);
        return v;
    }
    OPENNTC_AMX_TARGET static inline __m512 Pick(const float* row, int pitch, __m512i index) {
        if (pitch == 16)
            return _mm512_permutexvar_ps(index, _mm512_load_ps(row));
        if (pitch == 32)
            return _mm512_permutex2var_ps(_mm512_load_ps(row), index, _mm512_load_ps(row + 16));
        return _mm512_i32gather_ps(index, row, 4);
    }
    /// Integer bilinear weights 0 ... 256 of a row of texels, as floats, corners in the format's order.
    OPENNTC_AMX_TARGET static inline void CornerWeights(__m512 fx, float fy, __m512* weights) {
        const __m512 one = _mm512_set1_ps(1.0f), scale = _mm512_set1_ps(256.0f);
        const __m512 gx = _mm512_sub_ps(one, fx), y1 = _mm512_set1_ps(fy), y0 = _mm512_set1_ps(1.0f - fy);
        const __m512 products[4] = {_mm512_mul_ps(gx, y0), _mm512_mul_ps(fx, y0), _mm512_mul_ps(gx, y1),
                                    _mm512_mul_ps(fx, y1)};
        const __m512 inverse = _mm512_set1_ps(1.0f / 256.0f);
        for (int c = 0; c < 4; ++c) {
            const __m512 integer = _mm512_roundscale_ps(_mm512_mul_ps(products[c], scale),
                                                        _MM_FROUND_TO_ZERO | _MM_FROUND_NO_EXC);
            weights[c] = _mm512_mul_ps(integer, inverse);
        }
    }

    /// kTraining: also to `xa`, which the backward pass needs.
    template <bool kTraining>
    OPENNTC_AMX_TARGET void Gather(const TileTask& tile, int index, Byte* xp, Byte* xa) const {
        const MipGeometry& mip = *tile.mip;
        const TapVectors hx = LoadTaps(mip.highX, tile.x, tile.width, tile.high.originX);
        const TapVectors lx = LoadTaps(mip.lowX, tile.x, tile.width, tile.low.originX);
        const int hf = shape_.highFeatures, lf = shape_.lowFeatures;
        const int hp = tile.high.pitch, lp = tile.low.pitch;
        for (int rowPair = 0; rowPair < 4; ++rowPair) {
            const int column = index * 8 + rowPair * 2, group = index * 4 + rowPair;
            __m512 hw[2][4], lw[2][4];
            const float* h0[2];
            const float* h1[2];
            const float* l0[2];
            const float* l1[2];
            for (int r = 0; r < 2; ++r) {
                const auto y = static_cast<std::size_t>(tile.y + std::min(rowPair * 2 + r, tile.height - 1));
                CornerWeights(hx.fraction, mip.highY.fraction[y], hw[r]);
                CornerWeights(lx.fraction, mip.lowY.fraction[y], lw[r]);
                h0[r] = tile.high.values + (mip.highY.first[y] - tile.high.originY) * hp;
                h1[r] = tile.high.values + (mip.highY.second[y] - tile.high.originY) * hp;
                l0[r] = tile.low.values + (mip.lowY.first[y] - tile.low.originY) * lp;
                l1[r] = tile.low.values + (mip.lowY.second[y] - tile.low.originY) * lp;
            }
            for (int f = 0; f < hf; f += 2) {
                __m512 v[4][2][2]; // corner, feature, row
                for (int k = 0; k < 2; ++k) {
                    const int plane = (f + k) * tile.high.rows * hp;
                    for (int r = 0; r < 2; ++r) {
                        v[0][k][r] = Floor(_mm512_mul_ps(hw[r][0], Pick(h0[r] + plane, hp, hx.first)));
                        v[1][k][r] = Floor(_mm512_mul_ps(hw[r][1], Pick(h0[r] + plane, hp, hx.second)));
                        v[2][k][r] = Floor(_mm512_mul_ps(hw[r][2], Pick(h1[r] + plane, hp, hx.first)));
                        v[3][k][r] = Floor(_mm512_mul_ps(hw[r][3], Pick(h1[r] + plane, hp, hx.second)));
                    }
                }
                for (int c = 0; c < 4; ++c)
                    PutInputs<kTraining>(xp, xa, c * hf + f, column, group, v[c][0][0], v[c][0][1],
                                         v[c][1][0], v[c][1][1]);
            }
            for (int f = 0; f < lf; f += 2) {
                __m512 v[2][2];
                for (int k = 0; k < 2; ++k) {
                    const int plane = (f + k) * tile.low.rows * lp;
                    for (int r = 0; r < 2; ++r) {
                        __m512 s = _mm512_mul_ps(lw[r][0], Pick(l0[r] + plane, lp, lx.first));
                        s = _mm512_fmadd_ps(lw[r][1], Pick(l0[r] + plane, lp, lx.second), s);
                        s = _mm512_fmadd_ps(lw[r][2], Pick(l1[r] + plane, lp, lx.first), s);
                        s = _mm512_fmadd_ps(lw[r][3], Pick(l1[r] + plane, lp, lx.second), s);
                        v[k][r] = Floor(s);
                    }
                }
                PutInputs<kTraining>(xp, xa, 4 * hf + f, column, group, v[0][0], v[0][1], v[1][0], v[1][1]);
            }
            const int base = shape_.LatentInputs();
            for (int wave = 0; wave < 3; ++wave) {
                for (int phase = 0; phase < 2; ++phase) {
                    const __m512 x = _mm512_loadu_ps(mip.waves[wave][phase]);
                    const int y = tile.y + rowPair * 2;
                    const __m512 y0 = _mm512_set1_ps(mip.waves[wave][phase][y & 15]),
                                 y1 = _mm512_set1_ps(mip.waves[wave][phase][(y + 1) & 15]);
                    PutInputs<kTraining>(xp, xa, base + wave * 4 + phase * 2, column, group, x, x, y0, y1);
                }
            }
            const __m512 lod = _mm512_set1_ps(mip.lodInput);
            PutInputs<kTraining>(xp, xa, base + 12, column, group, lod, lod, lod, lod);
        }
    }
    /// Two rows of texels of inputs `slot` (e) and `slot` + 1 (o).
    template <bool kTraining>
    OPENNTC_AMX_TARGET static inline void PutInputs(Byte* xp, Byte* xa, int slot, int column, int group,
                                                    __m512 e0, __m512 e1, __m512 o0, __m512 o1) {
        Byte* p = xp + ((slot / 32) * kColumns + column) * 1024 + (slot % 32) * 32;
        _mm512_store_si512(p, PackPair(e0, o0));
        _mm512_store_si512(p + 1024, PackPair(e1, o1));
        if constexpr (!kTraining)
            return;
        Byte* a = xa + ((slot / 16) * kGroups + group) * 1024 + (slot % 16) * 64;
        _mm512_store_si512(a, PackTexels(e0, e1));
        _mm512_store_si512(a + 64, PackTexels(o0, o1));
    }

    /// Adds rows of texel gradients, already weighted along y, to a row of latents: a product with the small
    /// matrix of x weights, whose row t holds what texel t gives to each latent.
    OPENNTC_AMX_TARGET static inline void AddRow(const float* texels, const float* matrix, int pitch,
                                                 float* latents) {
        for (int j = 0; j < pitch; j += 16) {
            __m512 even = _mm512_load_ps(latents + j), odd = _mm512_setzero_ps();
            for (int t = 0; t < 16; t += 2) {
                even =
                    _mm512_fmadd_ps(_mm512_set1_ps(texels[t]), _mm512_load_ps(matrix + t * pitch + j), even);
                odd = _mm512_fmadd_ps(_mm512_set1_ps(texels[t + 1]),
                                      _mm512_load_ps(matrix + (t + 1) * pitch + j), odd);
            }
            _mm512_store_ps(latents + j, _mm512_add_ps(even, odd));
        }
    }
    static void FillMatrix(std::vector<float>& matrix, const AxisTaps& taps, const TileTask& tile,
                           const LocalGrid& grid, bool first, bool second) {
        matrix.assign(static_cast<std::size_t>(16 * grid.pitch) + 16, 0.0f);
        float* aligned = Align(matrix);
        for (int t = 0; t < tile.width; ++t) {
            const auto x = static_cast<std::size_t>(tile.x + t);
            if (first)
                aligned[t * grid.pitch + taps.first[x] - grid.originX] += 1.0f - taps.fraction[x];
            if (second)
                aligned[t * grid.pitch + taps.second[x] - grid.originX] += taps.fraction[x];
        }
    }
    static float* Align(std::vector<float>& matrix) {
        const auto address = reinterpret_cast<std::uintptr_t>(matrix.data());
        return matrix.data() + ((64 - address % 64) % 64) / sizeof(float);
    }

    OPENNTC_AMX_TARGET void Scatter(const TileTask& tile, int index, const float* inputGradient) {
        const MipGeometry& mip = *tile.mip;
        const int hf = shape_.highFeatures, lf = shape_.lowFeatures;
        FillMatrix(firstMatrix_, mip.highX, tile, tile.high, true, false);
        FillMatrix(secondMatrix_, mip.highX, tile, tile.high, false, true);
        FillMatrix(lowMatrix_, mip.lowX, tile, tile.low, true, true);
        const float* gradient = inputGradient + index * kTileTexels;
        rowSums_.resize(static_cast<std::size_t>(std::max(tile.high.rows, tile.low.rows)) * 16 + 16);
        float* rows = Align(rowSums_);
        for (int f = 0; f < hf; ++f) {
            float* to = tile.high.gradients + f * tile.high.rows * tile.high.pitch;
            std::memset(to, 0, sizeof(float) * static_cast<std::size_t>(tile.high.rows * tile.high.pitch));
            for (int cx = 0; cx < 2; ++cx) {
                std::memset(rows, 0, sizeof(float) * 16 * static_cast<std::size_t>(tile.high.rows));
                for (int y = 0; y < tile.height; ++y) {
                    const auto at = static_cast<std::size_t>(tile.y + y);
                    const float fy = mip.highY.fraction[at];
                    float* r0 = rows + (mip.highY.first[at] - tile.high.originY) * 16;
                    float* r1 = rows + (mip.highY.second[at] - tile.high.originY) * 16;
                    const float* g0 = gradient + (cx * hf + f) * kTexels + y * 16;
                    const float* g1 = gradient + ((2 + cx) * hf + f) * kTexels + y * 16;
                    _mm512_store_ps(r0, _mm512_fmadd_ps(_mm512_set1_ps(1.0f - fy), _mm512_load_ps(g0),
                                                        _mm512_load_ps(r0)));
                    _mm512_store_ps(
                        r1, _mm512_fmadd_ps(_mm512_set1_ps(fy), _mm512_load_ps(g1), _mm512_load_ps(r1)));
                }
                const float* matrix = cx == 0 ? Align(firstMatrix_) : Align(secondMatrix_);
                for (int r = 0; r < tile.high.rows; ++r)
                    AddRow(rows + r * 16, matrix, tile.high.pitch, to + r * tile.high.pitch);
            }
        }
        for (int f = 0; f < lf; ++f) {
            float* to = tile.low.gradients + f * tile.low.rows * tile.low.pitch;
            std::memset(to, 0, sizeof(float) * static_cast<std::size_t>(tile.low.rows * tile.low.pitch));
            std::memset(rows, 0, sizeof(float) * 16 * static_cast<std::size_t>(tile.low.rows));
            for (int y = 0; y < tile.height; ++y) {
                const auto at = static_cast<std::size_t>(tile.y + y);
                const float fy = mip.lowY.fraction[at];
                float* r0 = rows + (mip.lowY.first[at] - tile.low.originY) * 16;
                float* r1 = rows + (mip.lowY.second[at] - tile.low.originY) * 16;
                const __m512 g = _mm512_load_ps(gradient + (4 * hf + f) * kTexels + y * 16);
                _mm512_store_ps(r0, _mm512_fmadd_ps(_mm512_set1_ps(1.0f - fy), g, _mm512_load_ps(r0)));
                _mm512_store_ps(r1, _mm512_fmadd_ps(_mm512_set1_ps(fy), g, _mm512_load_ps(r1)));
            }
            for (int r = 0; r < tile.low.rows; ++r)
                AddRow(rows + r * 16, Align(lowMatrix_), tile.low.pitch, to + r * tile.low.pitch);
        }
    }

    NetworkShape shape_;
    std::vector<float> firstMatrix_, secondMatrix_, lowMatrix_, rowSums_;
};

} // namespace openntc::encode::detail

#if !defined(__clang__)
#pragma GCC diagnostic pop
#endif

#include "openntc/core/RestoreMacros.h"
#endif
