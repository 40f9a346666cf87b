// SPDX-License-Identifier: MIT
// Stability: internal
// Kernel for AMX: the hidden layers in matrix tiles (16 outputs by 64 inputs by 16 texels in one
// instruction), the rest as in the AVX-512 kernel.
#pragma once

#include "openntc/decode/fast/SimdAvx512.h"

#if OPENNTC_FAST_AMX

#if defined(__clang__)
#pragma clang attribute push(                                                                                \
    __attribute__((target("avx512f,avx512bw,avx512dq,avx512vl,avx512vnni,avx2,f16c,amx-tile,amx-int8"))),    \
    apply_to = function)
#else
// g++ 12 warns about its own headers: they initialise "undefined" vectors with themselves (GCC bug 105593).
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wuninitialized"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#pragma GCC push_options
#pragma GCC target("avx512f,avx512bw,avx512dq,avx512vl,avx512vnni,avx2,f16c,amx-tile,amx-int8")
#endif

#include "openntc/core/HideMacros.h"

namespace openntc::fast::avx512::amx {

inline constexpr OperandLayout kLayout = OperandLayout::Tiles;

#include "openntc/decode/fast/Inputs.inl"

#include "openntc/decode/fast/Fused.inl"

// Configures all tiles as 16 rows of 64 bytes and releases them at the end.
class TileState {
public:
    TileState() noexcept {
        struct Configuration {
            std::uint8_t palette = 1;
            std::uint8_t startRow = 0;
            std::uint8_t reserved[14] = {};
            std::uint16_t bytesPerRow[16] = {64, 64, 64, 64, 64, 64, 64, 64};
            std::uint8_t rows[16] = {16, 16, 16, 16, 16, 16, 16, 16};
        } const configuration;
        // The compiler's header does not say that the instruction reads all of the structure.
        __asm__ volatile("" : : "r"(&configuration) : "memory");
        _tile_loadconfig(&configuration);
    }
    ~TileState() { _tile_release(); }
    TileState(const TileState&) = delete;
    TileState& operator=(const TileState&) = delete;
};

// Sums of 16 outputs and one group of texels.
struct alignas(64) TileSums {
    std::int32_t values[kTileWords][kLanes];
};

// 16 outputs for the four groups of a batch. The left operand is signed weights, [output][4 inputs of each
// word], the right one unsigned inputs, [word][4 inputs of each texel], as they lie in a batch.
inline void MultiplyTiles(const std::int32_t* inputs, const std::int32_t* weights, int words,
                          TileSums (&sums)[kGroups]) noexcept {
    static_assert(kGroups == 4);
    constexpr int kInputStride = kBatchTexels * static_cast<int>(sizeof(std::int32_t));
    // Tile loads do not tell the compiler what memory they read: what was stored before must really be
    // stored.
    __asm__ volatile("" : : : "memory");
    _tile_zero(0);
    _tile_zero(1);
    _tile_zero(2);
    _tile_zero(3);
    for (int word = 0; word < words; word += kTileWords) {
        const std::int32_t* const operands = inputs + word * kBatchTexels;
        _tile_loadd(4, weights + word * kTileWords, 64);
        _tile_loadd(5, operands, kInputStride);
        _tile_loadd(6, operands + kLanes, kInputStride);
        _tile_loadd(7, operands + 2 * kLanes, kInputStride);
        _tile_dpbsud(0, 4, 5);
        _tile_loadd(5, operands + 3 * kLanes, kInputStride);
        _tile_dpbsud(1, 4, 6);
        _tile_dpbsud(2, 4, 7);
        _tile_dpbsud(3, 4, 5);
    }
    _tile_stored(0, sums[0].values, 64);
    _tile_stored(1, sums[1].values, 64);
    _tile_stored(2, sums[2].values, 64);
    _tile_stored(3, sums[3].values, 64);
    __asm__ volatile("" : : : "memory");
}

template <Epilogue kEpilogue>
OPENNTC_FAST_NOINLINE void RunHiddenLayer(const std::int32_t* inputs, const PreparedLayer& layer,
                                          std::int32_t* outputs) noexcept {
    TileSums sums[2][kGroups]; // so that one block is multiplied while another is requantised
    for (int block = 0; block < layer.rows; block += kTileWords) {
        TileSums(&blockSums)[kGroups] = sums[block / kTileWords % 2];
        MultiplyTiles(inputs, layer.weights + block * layer.units, layer.units, blockSums);
        for (int g = 0; g < kGroups; ++g) {
            for (int row = 0; row < kTileWords; row += 4) {
                Int four[4];
                OPENNTC_FAST_UNROLL
                for (int r = 0; r < 4; ++r)
                    four[r] =
                        AddInt(LoadInt(blockSums[g].values[row + r]), SetInt(layer.biases[block + row + r]));
                StoreOutputs<kEpilogue>(four, layer, block + row,
                                        outputs + ((block + row) / 4 * kGroups + g) * kLanes);
            }
        }
    }
}

#include "openntc/decode/fast/Tile.inl"

} // namespace openntc::fast::avx512::amx

#if defined(__clang__)
#pragma clang attribute pop
#else
#pragma GCC pop_options
#pragma GCC diagnostic pop
#endif

#include "openntc/core/RestoreMacros.h"
#endif
