// SPDX-License-Identifier: MIT
// Latent shapes and mip chain formulas against examples of the format specification.
#include "openntc/texture_set/LatentShape.h"
#include "openntc/texture_set/MipChain.h"

#include <doctest/doctest.h>

#include <limits>

using namespace openntc;

TEST_CASE(
    "every known shape is valid, fits its network, has its bits per pixel, and is what picking them finds") {
    for (int version = NTC_NETWORK_SMALL; version <= NTC_NETWORK_XLARGE; ++version) {
        const int count = GetKnownLatentShapeCount(version);
        CHECK(count == (version == NTC_NETWORK_SMALL ? 24 : 26));
        float previous = 0.0f;
        for (int i = 0; i < count; ++i) {
            CAPTURE(version);
            CAPTURE(i);
            const auto known = EnumerateKnownLatentShapes(i, version);
            REQUIRE(known);
            CHECK(ValidateLatentShape(known->shape, version));
            CHECK(GetLatentShapeBitsPerPixel(known->shape) ==
                  known->bitsPerPixel); // exact by the specification
            CHECK(known->bitsPerPixel > previous);
            previous = known->bitsPerPixel;
            CHECK(PickLatentShape(known->bitsPerPixel, version)->shape == known->shape);
        }
        CHECK(EnumerateKnownLatentShapes(count, version).error().GetStatus() == Status::OutOfRange);
    }
    CHECK(EnumerateKnownLatentShapes(25, NTC_NETWORK_UNKNOWN)->shape == LatentShape{2, 16, 8, 4, 8});
    CHECK(EnumerateKnownLatentShapes(14, NTC_NETWORK_MEDIUM)->shape == LatentShape{2, 4, 4, 4, 2});
    CHECK(GetKnownLatentShapeCount(7) == 0);
    CHECK(GetKnownLatentShapeCount(-1) == 0);
}

TEST_CASE("shapes of generations 2 and 3: the specification's table, and what is no shape of theirs") {
    struct Row {
        double bits;
        int scale, features;
    };
    const Row rows[] = {{1.11, 6, 8},  {1.67, 6, 12}, {2.5, 4, 8}, {3.75, 4, 12}, {5, 4, 16},
                        {6.67, 3, 12}, {10, 2, 8},    {15, 2, 12}, {20, 2, 16}};
    for (const int version : {NTC_NETWORK_GENERATION_2, NTC_NETWORK_GENERATION_3}) {
        REQUIRE(GetKnownLatentShapeCount(version) == 9);
        for (int i = 0; i < 9; ++i) {
            CAPTURE(i);
            const auto known = EnumerateKnownLatentShapes(i, version);
            REQUIRE(known);
            CHECK(known->shape == MakeLayeredShape(rows[i].scale, rows[i].features));
            CHECK(known->bitsPerPixel == doctest::Approx(rows[i].bits).epsilon(0.005)); // as rounded there
            CHECK(ValidateLatentShape(known->shape, version));
            CHECK(PickLatentShape(known->bitsPerPixel, version)->shape == known->shape);
        }
        CHECK(PickLatentShape(4.0f, version)->shape == MakeLayeredShape(4, 12));
        CHECK(ValidateLatentShape(MakeLayeredShape(1, 16), version));
        for (const LatentShape& bad :
             {MakeLayeredShape(0, 8), MakeLayeredShape(7, 8), MakeLayeredShape(4, 6), MakeLayeredShape(4, 20),
              LatentShape{4, 8, 4, 4, 4}, LatentShape{4, 8, 8, 4, 2}})
            CHECK(ValidateLatentShape(bad, version).error().GetStatus() == Status::OutOfRange);
        CHECK(PickLatentShape(0.8f, version).error().GetStatus() == Status::OutOfRange);
    }
}

TEST_CASE("latent mips of generations 2 and 3: sizes, pairs and positions of LibNTC 0.9.2's files") {
    const TextureSetDesc square{512, 512, 12, 10}, odd{96, 96, 14, 7}, sliver{3, 500, 1, 9},
        single{512, 512, 1, 1};
    CHECK(GetLatentMipCount(square, 4) == 8);
    CHECK(GetLatentMipCount(odd, 4) == 4);
    CHECK(GetLatentMipCount({128, 128, 10, 8}, 4) == 6);
    CHECK(GetLatentMipCount(sliver, 4) == 2);
    CHECK(GetLatentMipCount(single, 2) == 2);
    const int pairs[] = {0, 0, 0, 2, 2, 4, 4, 6, 6, 6};
    for (int mip = 0; mip < 10; ++mip)
        CHECK(GetLatentMipForColorMip(mip, 4, 8) == pairs[mip]);
    CHECK(GetLatentMipForColorMip(2, 1, 8) == 2);
    CHECK(GetLatentMipForColorMip(3, 5, 8) == 0);
    CHECK(GetLatentMipForColorMip(4, 6, 8) == 2);
    CHECK(GetLatentMipDimension(96, 4, 3) == 3);
    CHECK(GetLatentMipDimension(3, 4, 0) == 1);
    const float scales[] = {0.125f, 0.25f, 0.5f}, lods[] = {-0.75f, -0.5f, -0.25f};
    for (int mip = 0; mip < 3; ++mip) {
        const float scale = GetLatentPositionScale(512 >> mip, 512 >> mip, 128, 128);
        CHECK(scale == scales[mip]);
        CHECK(GetLatentPositionLod(scale) == lods[mip]);
    }
    CHECK(GetLatentPositionScale(8, 4, 2, 2) == 0.25f); // the larger of both axes
    CHECK(GetLatentPositionLod(32.0f) == 1.0f);
}

TEST_CASE("picking: within 25 %, ties to the first") {
    CHECK(PickLatentShape(3.25f, NTC_NETWORK_LARGE)->bitsPerPixel == 3.0f);
    CHECK(PickLatentShape(0.41f, NTC_NETWORK_LARGE)->bitsPerPixel == 0.5f);
    CHECK(PickLatentShape(26.6f, NTC_NETWORK_LARGE)->bitsPerPixel == 20.0f);
    CHECK(PickLatentShape(21.3f, NTC_NETWORK_SMALL)->bitsPerPixel == 16.0f);
    for (const float wish : {0.39f, 26.7f, 0.0f, -1.0f, std::numeric_limits<float>::quiet_NaN()})
        CHECK(PickLatentShape(wish, NTC_NETWORK_LARGE).error().GetStatus() == Status::OutOfRange);
    CHECK_FALSE(PickLatentShape(21.4f, NTC_NETWORK_SMALL));
    CHECK_FALSE(PickLatentShape(3.0f, 7));
}

TEST_CASE("shape limits") {
    CHECK(ValidateLatentShape({}));
    CHECK(ValidateLatentShape({8, 16, 4, 8, 1}));
    for (const LatentShape& bad :
         {LatentShape{1, 4, 4, 1, 1}, LatentShape{9, 4, 4, 1, 1}, LatentShape{4, 6, 4, 1, 1},
          LatentShape{4, 4, 20, 1, 1}, LatentShape{4, 4, 4, 3, 1}, LatentShape{4, 4, 4, 1, 16}})
        CHECK(ValidateLatentShape(bad).error().GetStatus() == Status::OutOfRange);
    CHECK_FALSE(ValidateLatentShape({4, 8, 4, 1, 1}, NTC_NETWORK_SMALL));
    CHECK(GetNetworkVersionForFeatures(12) == NTC_NETWORK_LARGE);
    CHECK(GetNetworkVersionForFeatures(17) == NTC_NETWORK_UNKNOWN);
}

TEST_CASE("mip chains: the specification's examples") {
    CHECK(GetNeuralMipCount({1024, 1024, 4, 11}, 4) == 4);
    CHECK(GetNeuralMipCount({24, 20, 4, 4}, 4) == 1);
    CHECK(GetNeuralMipCount({40, 64, 4, 6}, 2) == 2);
    CHECK(GetNeuralMipCount({1, 1, 4, 1}, 8) == 1);
    const int scale2[] = {0, 0, 0, 1, 1, 2, 2};
    const int scale4[] = {0, 0, 0, 0, 1, 1, 2, 2};
    const int scale8[] = {0, 0, 0, 0, 0, 1, 1, 2, 2};
    for (int mip = 0; mip < 7; ++mip)
        CHECK(GetNeuralMipForColorMip(mip, 2, 8) == scale2[mip]);
    for (int mip = 0; mip < 8; ++mip) {
        CHECK(GetNeuralMipForColorMip(mip, 4, 8) == scale4[mip]);
        CHECK(GetNeuralMipForColorMip(mip, 3, 8) == scale4[mip]);
    }
    for (int mip = 0; mip < 9; ++mip)
        CHECK(GetNeuralMipForColorMip(mip, 5, 8) == scale8[mip]);
    CHECK(GetNeuralMipForColorMip(15, 2, 3) == 2);
    CHECK(GetPositionLod(5, 0) == 0x1.aaaaaap0f);
    CHECK(GetPositionScale(5, 0) == 32.0f);
    CHECK(GetLatentGridBytes(3, 1, 4, 1) == 4); // 12 bits: one word
    // V1: 32 + 24 bytes of latents and a small network
    CHECK(*EstimateCompressedTextureSetSize({24, 20, 4, 4}, {4, 4, 8, 2, 4}) == 13952 + 32 + 24);
    CHECK(GetLatentMipBytes(3, 3, 3) == 56); // 27 texels of 2 bytes, and 2 more
    CHECK(*EstimateCompressedTextureSetSize({8, 8, 4, 1}, MakeLayeredShape(4, 8), NTC_NETWORK_GENERATION_3) ==
          9472 + 16 + 4);
}
