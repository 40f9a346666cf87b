// SPDX-License-Identifier: MIT
// Latent geometry and quantisers against the format specification's tables.
#include "openntc/encode/detail/Geometry.h"

#include <doctest/doctest.h>

using namespace openntc::encode::detail;

TEST_CASE("neural mips: the specification's examples") {
    CHECK(openntc::GetNeuralMipCount({1024, 1024, 16, 11}, 4) == 4);
    CHECK(openntc::GetNeuralMipCount({24, 20, 16, 4}, 4) == 1);
    CHECK(openntc::GetNeuralMipCount({40, 64, 16, 6}, 2) == 2);
    CHECK(openntc::GetNeuralMipCount({5, 1, 16, 3}, 4) == 1);
    for (int mip = 0; mip < 3; ++mip)
        CHECK(openntc::GetNeuralMipForColorMip(mip, 2, 8) == 0);
    CHECK(openntc::GetNeuralMipForColorMip(3, 2, 8) == 1);
    CHECK(openntc::GetNeuralMipForColorMip(4, 8, 8) == 0);
    CHECK(openntc::GetNeuralMipForColorMip(5, 8, 8) == 1);
    CHECK(openntc::GetLatentGridDimension(20, 4, 0) == 5);
    CHECK(openntc::GetLatentGridDimension(64, 2, 1) == 8);
    CHECK(openntc::GetLatentGridDimension(3, 8, 2) == 1);
}

TEST_CASE("latent quantisers: levels, inputs per level") {
    struct Row {
        int bits, lowest, highest;
        float input;
    };
    for (const Row& row :
         {Row{1, 0, 1, 85.0f}, Row{2, -1, 2, 51.0f}, Row{4, -7, 8, 15.0f}, Row{8, -126, 127, 1.0f}}) {
        const LatentQuantiser q = MakeLatentQuantiser(row.bits);
        CHECK(q.lowestLevel == row.lowest);
        CHECK(q.highestLevel == row.highest);
        CHECK(q.levelInput == row.input);
    }
}

TEST_CASE("positional inputs: waves of vector V1") {
    // Texel (13, 7) of mip 0: -63, 63, 63, 63, 0, 0, -127, 127, -127, -127, 0, 0.
    const MipGeometry mip = MakeMipGeometry(24, 20, 0, 0, {6, 5}, {3, 2});
    const float expected[12] = {-63, 63, 63, 63, 0, 0, -127, 127, -127, -127, 0, 0};
    for (int wave = 0; wave < 3; ++wave) {
        for (int phase = 0; phase < 2; ++phase) {
            CHECK(mip.waves[wave][phase][13] == expected[wave * 4 + phase * 2]);
            CHECK(mip.waves[wave][phase][7] == expected[wave * 4 + phase * 2 + 1]);
        }
    }
    CHECK(MakeMipGeometry(24, 20, 1, 0, {6, 5}, {3, 2}).lodInput == 42.0f);
    CHECK(MakeMipGeometry(24, 20, 2, 0, {6, 5}, {3, 2}).lodInput == 85.0f);
}
