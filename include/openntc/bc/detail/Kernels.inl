// SPDX-License-Identifier: MIT
// Stability: internal
// The encoders for NTC_LANES blocks at once, in namespace NTC_LANES_TARGET. Included once for each.
#undef OPENNTC_LANES_H
#undef OPENNTC_BC_LINE_FIT_H
#undef OPENNTC_BC1_H
#undef OPENNTC_BC1_AXIS_H
#undef OPENNTC_BC1_SOLID_H
#undef OPENNTC_BC4_H
#undef OPENNTC_BC6_H
#undef OPENNTC_BC6_BLOCK_H
#undef OPENNTC_BC6_FIT_H
#undef OPENNTC_BC6_SEARCH_H
#undef OPENNTC_BC6_TABLES_H
#undef OPENNTC_BC7_H
#undef OPENNTC_BC7_AXES_H
#undef OPENNTC_BC7_ENDPOINTS_H
#undef OPENNTC_BC7_ESTIMATE_H
#undef OPENNTC_BC7_INDICES_H
#undef OPENNTC_BC7_MODES_H
#undef OPENNTC_BC7_PACK_H
#undef OPENNTC_BC7_TABLES_H
#include "openntc/bc/Lanes.h"

#include "openntc/bc/Bc1.h"
#include "openntc/bc/Bc4.h"
#include "openntc/bc/Bc6.h"
#include "openntc/bc/Bc7Pack.h"

namespace openntc::bc::NTC_LANES_TARGET {

using shader::NTC_LANES_TARGET::NtcLane;

inline NtcLane LoadLanes(const std::int32_t* from) noexcept {
    NtcLane lanes;
    __builtin_memcpy(&lanes, from, sizeof lanes);
    return lanes;
}

/// Of packed texels.
inline void LoadChannel(const BlockBatch& batch, int channel, NtcLane (&texels)[16]) noexcept {
    for (int t = 0; t < 16; ++t) {
        NtcLane word;
        __builtin_memcpy(&word, batch.packed + t * NTC_LANES, sizeof word);
        if (batch.isSigned)
            texels[t] = shader::NTC_LANES_TARGET::NtcLaneMax((word << (24 - 8 * channel)) >> 24,
                                                             shader::NTC_LANES_TARGET::NtcSplat(-127));
        else
            texels[t] = (word >> (8 * channel)) & 255;
    }
}

inline void StoreWord(BlockBatch& batch, int word, NtcLane value) noexcept {
    std::uint32_t values[NTC_LANES];
    __builtin_memcpy(values, &value, sizeof value);
    for (int l = 0; l < NTC_LANES; ++l)
        batch.words[4 * l + word] = values[l];
}

#include "openntc/bc/detail/Bc4Kernel.inl"
#include "openntc/bc/detail/Bc6Kernel.inl"
#include "openntc/bc/detail/Bc7Kernel.inl"

#include "openntc/bc/detail/Bc1Kernel.inl"

inline constexpr BlockKernels kKernels = {
    NTC_LANES,
    {&EncodeBc1, &EncodeBc2, &EncodeBc3, &EncodeBc4<false>, &EncodeBc4<true>, &EncodeBc5<false>,
     &EncodeBc5<true>, &EncodeBc6<false>, &EncodeBc6<true>, &EncodeBc7},
};

} // namespace openntc::bc::NTC_LANES_TARGET
