// SPDX-License-Identifier: MIT
// The fast decoder on sets of generations 2 and 3: the bits of the reference decoder, with every kernel.
#include "FastDecoderCases.h"
#include "LatentMipSets.h"

#include <algorithm>

using namespace openntc;

TEST_CASE("fast decoder: whole mips of generations 2 and 3") {
    const std::vector<decode_test::FastTarget> targets = decode_test::GetFastTargets(1);
    for (const decode_test::LatentMipShape& shape : decode_test::kLatentMipShapes) {
        CAPTURE(shape.seed);
        decode_test::LatentMipSet set(shape);
        set.GetConstants().channelColorSpaces = 0x26262626u; // HLG, sRGB, HLG, linear, …
        for (int mip = 0; mip < shape.mips; ++mip)
            decode_test::CompareWithReference(
                set.GetSource(DecodeWeights::Int8), mip,
                {0, 0, std::max(shape.width >> mip, 1), std::max(shape.height >> mip, 1)}, targets);
    }
}

TEST_CASE("fast decoder: generations 2 and 3 beyond the borders, with odd lods, and slices that wrap") {
    const std::vector<decode_test::FastTarget> targets = decode_test::GetFastTargets(2);
    for (const int version : {NTC_NETWORK_GENERATION_2, NTC_NETWORK_GENERATION_3}) {
        decode_test::LatentMipSet set({21, version, 30, 44, 3, 3, 12});
        for (const Rect& rect : {Rect{-70, -3, 140, 9}, Rect{28, 40, 5, 50}, Rect{-4194304, 4194300, 3, 4}})
            decode_test::CompareWithReference(set.GetSource(DecodeWeights::Int8), 0, rect, targets);
        NtcTextureSetConstants& c = set.GetConstants();
        for (const float lod : {1.75f, -1.1f, 3e20f, -0.0f}) {
            c.colorMips[1].positionLod = lod;
            decode_test::CompareWithReference(set.GetSource(DecodeWeights::Int8), 1, {0, 0, 3, 2}, targets);
        }
        // The grid has 10 x 14 texels: four columns from the ninth on, three rows from the last one on. Their bytes are
        // not those of the whole grid: what matters is which are read.
        c.highResNeuralMips[0].sliceLeftTop = 13u << 16 | 8u;
        c.highResNeuralMips[0].sliceWidthHeight = 3u << 16 | 4u;
        decode_test::CompareWithReference(set.GetSource(DecodeWeights::Int8), 0, {0, 0, 30, 44}, targets);
    }
}
