// SPDX-License-Identifier: MIT
// Stability: internal
// BC1, BC2 and BC3 of one instruction set.

template <int Quality>
void EncodeColors(BlockBatch& batch, bool isBc1, int word) noexcept {
    NtcLane red[16];
    NtcLane green[16];
    NtcLane blue[16];
    NtcLane alpha[16];
    LoadChannel(batch, 0, red);
    LoadChannel(batch, 1, green);
    LoadChannel(batch, 2, blue);
    LoadChannel(batch, 3, alpha);
    const shader::NTC_LANES_TARGET::NtcBc1Block block =
        shader::NTC_LANES_TARGET::NtcEncodeBc1(red, green, blue, alpha, batch.alphaThreshold, isBc1, Quality);
    StoreWord(batch, word, block.words[0]);
    StoreWord(batch, word + 1, block.words[1]);
}

inline void EncodeColorsOf(BlockBatch& batch, bool isBc1, int word) noexcept {
    if (batch.quality == BlockQuality::Fast)
        EncodeColors<NTC_BC_QUALITY_FAST>(batch, isBc1, word);
    else if (batch.quality == BlockQuality::Normal)
        EncodeColors<NTC_BC_QUALITY_NORMAL>(batch, isBc1, word);
    else
        EncodeColors<NTC_BC_QUALITY_BEST>(batch, isBc1, word);
}

inline void EncodeBc1(BlockBatch& batch) noexcept {
    EncodeColorsOf(batch, true, 0);
}

inline void EncodeBc2(BlockBatch& batch) noexcept {
    NtcLane alpha[16];
    LoadChannel(batch, 3, alpha);
    const shader::NTC_LANES_TARGET::NtcBc2Alpha packed = shader::NTC_LANES_TARGET::NtcEncodeBc2Alpha(alpha);
    StoreWord(batch, 0, packed.words[0]);
    StoreWord(batch, 1, packed.words[1]);
    EncodeColorsOf(batch, false, 2);
}

inline void EncodeBc3(BlockBatch& batch) noexcept {
    EncodeChannelOf(batch, 3, false, 0);
    EncodeColorsOf(batch, false, 2);
}
