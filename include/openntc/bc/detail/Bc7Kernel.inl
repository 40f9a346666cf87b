// SPDX-License-Identifier: MIT
// Stability: internal
// BC7 of one instruction set. Blocks are packed one by one.

inline void EncodeBc7(BlockBatch& batch) noexcept {
    namespace lanes = shader::NTC_LANES_TARGET;
    NtcLane texels[64];
    for (int i = 0; i < 64; ++i)
        texels[i] = LoadLanes(batch.texels + i * NTC_LANES);
    const lanes::NtcBc7Coding coding =
        lanes::NtcBc7Search(texels, static_cast<int>(batch.quality), static_cast<int>(batch.allowedModes),
                            LoadLanes(batch.hints));
    NtcLane rotated[64];
    lanes::NtcBc7Rotate(texels, (coding.choice >> 9) & 3, rotated);
    lanes::NtcBc7Indices indices;
    lanes::NtcBc7ChooseIndices(coding, rotated, indices);
    std::int32_t choices[NTC_LANES];
    std::int32_t ends[6][NTC_LANES];
    std::int32_t words[4][NTC_LANES];
    __builtin_memcpy(choices, &coding.choice, sizeof choices);
    __builtin_memcpy(ends, coding.ends.ends, sizeof ends);
    __builtin_memcpy(words, indices.words, sizeof words);
    for (int l = 0; l < NTC_LANES; ++l) {
        const int ownEnds[6] = {ends[0][l], ends[1][l], ends[2][l], ends[3][l], ends[4][l], ends[5][l]};
        const int ownWords[4] = {words[0][l], words[1][l], words[2][l], words[3][l]};
        const shader::lanes1::NtcBc7Block block = shader::lanes1::NtcBc7Pack(choices[l], ownEnds, ownWords);
        for (int w = 0; w < 4; ++w)
            batch.words[4 * l + w] = block.words[w];
    }
}
