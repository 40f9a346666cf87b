// SPDX-License-Identifier: MIT
// Stability: internal
// BC4 of one instruction set.

inline void EncodeBc4(BlockBatch& batch) noexcept {
    NtcLane texels[16];
    LoadChannel(batch, 0, texels);
    const shader::NTC_LANES_TARGET::NtcBc4Block block = shader::NTC_LANES_TARGET::NtcEncodeBc4(texels);
    StoreWord(batch, 0, block.words[0]);
    StoreWord(batch, 1, block.words[1]);
}
