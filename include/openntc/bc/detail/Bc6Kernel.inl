// SPDX-License-Identifier: MIT
// Stability: internal
// BC6H of one instruction set.

template <bool IsSigned>
void EncodeBc6(BlockBatch& batch) noexcept {
    NtcLane halves[48];
    for (int t = 0; t < 16; ++t) {
        for (int c = 0; c < 3; ++c)
            halves[3 * t + c] = shader::NTC_LANES_TARGET::NtcBc6Input(
                LoadLanes(batch.texels + (4 * t + c) * NTC_LANES), IsSigned);
    }
    const shader::NTC_LANES_TARGET::NtcBc6Block block =
        shader::NTC_LANES_TARGET::NtcEncodeBc6(halves, static_cast<int>(batch.quality), IsSigned);
    for (int w = 0; w < 4; ++w)
        StoreWord(batch, w, block.words[w]);
}
