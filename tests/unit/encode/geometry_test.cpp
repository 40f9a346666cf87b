// SPDX-License-Identifier: MIT
// Latent geometry and quantisers against the format specification's tables.
#include "openntc/encode/detail/Geometry.h"

#include <doctest/doctest.h>

using namespace openntc::encode::detail;

TEST_CASE("neural mips: the specification's examples") {
    CHECK(NeuralMipCount(1024, 1024, 11, 4) == 4);
    CHECK(NeuralMipCount(24, 20, 4, 4) == 1);
    CHECK(NeuralMipCount(40, 64, 6, 2) == 2);
    CHECK(NeuralMipCount(5, 1, 3, 4) == 1);
    for (int mip = 0; mip < 3; ++mip)
        CHECK(NeuralMipOf(mip, 2, 8) == 0);
    CHECK(NeuralMipOf(3, 2, 8) == 1);
    CHECK(NeuralMipOf(4, 8, 8) == 0);
    CHECK(NeuralMipOf(5, 8, 8) == 1);
    CHECK(GridDimension(20, 4, 0) == 5);
    CHECK(GridDimension(64, 2, 1) == 8);
    CHECK(GridDimension(3, 8, 2) == 1);
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
