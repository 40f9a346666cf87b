// SPDX-License-Identifier: MIT
// Stability: internal
// BC4 and BC5 of one instruction set.

template <int Quality>
void EncodeChannel(BlockBatch& batch, int channel, bool isSigned, int word) noexcept {
    NtcLane texels[16];
    LoadChannel(batch, channel, texels);
    const shader::NTC_LANES_TARGET::NtcBc4Block block = shader::NTC_LANES_TARGET::NtcEncodeBc4(
        texels, isSigned ? 254 : 255, isSigned ? 127 : 0, channel == 3, Quality);
    StoreWord(batch, word, block.words[0]);
    StoreWord(batch, word + 1, block.words[1]);
}

inline void EncodeChannelOf(BlockBatch& batch, int channel, bool isSigned, int word) noexcept {
    if (batch.quality == BlockQuality::Fast)
        EncodeChannel<NTC_BC_QUALITY_FAST>(batch, channel, isSigned, word);
    else if (batch.quality == BlockQuality::Normal)
        EncodeChannel<NTC_BC_QUALITY_NORMAL>(batch, channel, isSigned, word);
    else
        EncodeChannel<NTC_BC_QUALITY_BEST>(batch, channel, isSigned, word);
}

template <bool IsSigned>
void EncodeBc4(BlockBatch& batch) noexcept {
    EncodeChannelOf(batch, 0, IsSigned, 0);
}

template <bool IsSigned>
void EncodeBc5(BlockBatch& batch) noexcept {
    EncodeChannelOf(batch, 0, IsSigned, 0);
    EncodeChannelOf(batch, 1, IsSigned, 2);
}
