// SPDX-License-Identifier: MIT
// Stability: internal
// The encoders for NTC_LANES blocks at once, in namespace NTC_LANES_TARGET. Included once for each.
#undef OPENNTC_LANES_H
#undef OPENNTC_BC4_H
#include "openntc/bc/Lanes.h"

#include "openntc/bc/Bc4.h"

namespace openntc::bc::NTC_LANES_TARGET {

using shader::NTC_LANES_TARGET::NtcLane;

inline NtcLane LoadLanes(const std::int32_t* from) noexcept {
    NtcLane lanes;
    __builtin_memcpy(&lanes, from, sizeof lanes);
    return lanes;
}

inline void LoadChannel(const BlockBatch& batch, int channel, NtcLane (&texels)[16]) noexcept {
    for (int t = 0; t < 16; ++t)
        texels[t] = LoadLanes(batch.texels + (4 * t + channel) * NTC_LANES);
}

inline void StoreWord(BlockBatch& batch, int word, NtcLane value) noexcept {
    std::uint32_t values[NTC_LANES];
    __builtin_memcpy(values, &value, sizeof value);
    for (int l = 0; l < NTC_LANES; ++l)
        batch.words[4 * l + word] = values[l];
}

#include "openntc/bc/detail/Bc4Kernel.inl"

inline constexpr BlockKernels kKernels = {
    NTC_LANES,
    {nullptr, nullptr, nullptr, &EncodeBc4<false>, &EncodeBc4<true>, &EncodeBc5<false>, &EncodeBc5<true>,
     nullptr, nullptr, nullptr},
};

} // namespace openntc::bc::NTC_LANES_TARGET
