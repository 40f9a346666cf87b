// SPDX-License-Identifier: MIT
// The fast decoder's activation with fused multiply-adds: rows that have it give the contract's integers for
// every sum, rows that cannot have it are found, and networks with rows of both kinds decode exactly.
#include "FastDecoderCases.h"

#include "openntc/core/Half.h"

#include <algorithm>
#include <cmath>
#include <random>

using namespace openntc;

namespace {

constexpr int kSumLimit = 400000; // sums of a trained network's rows stay below

/// 2^(firstExponent - 127) and more, below 2^exponents times that.
float MakeFloat(std::mt19937& random, unsigned firstExponent, unsigned exponents) {
    const auto exponent = static_cast<std::uint32_t>(firstExponent + random() % exponents);
    return BitCast<float>(exponent << 23 | static_cast<std::uint32_t>(random() & 0x7FFFFFu));
}

float DrawScale(std::mt19937& random) {
    // 2^-17 ... 2^-11, evenly by exponent: trained networks have 2^-16 ... 2^-12.
    return MakeFloat(random, 110, 6);
}

/// The integer that the contract in binary16 gives a z of -1.5 … 3.
int RequantizeHalf(float z) {
    const float third = RoundToHalf(fast::MultiplyRounded(z, 0.333251953125f));
    const float open = RoundToHalf(third + 0.5f);
    const float y = RoundToHalf(fast::MultiplyRounded(z, open < 1.0f ? open : 1.0f));
    const float steps = RoundToHalf(RoundToHalf(fast::MultiplyRounded(y, 80.0f)) - 113.0f);
    return static_cast<int>(steps + fast::kRoundingBase - fast::kRoundingBase);
}

/// The same with fast::HalfGate.
int RequantizeHalfGate(float z) {
    const float fine = fast::HalfGate::kThirdBase;
    const float base = std::signbit(z) ? fast::HalfGate::kNegativeBase : fast::HalfGate::kBase;
    const float open = fast::FuseMultiplyAdd(z, fast::HalfGate::kThird, fine + 0.5f) - fine;
    const float rounded = open + base - base;
    const float y = RoundToHalf(fast::MultiplyRounded(z, rounded < 1.0f ? rounded : 1.0f));
    const float steps = RoundToHalf(RoundToHalf(fast::MultiplyRounded(y, 80.0f)) - 113.0f);
    return static_cast<int>(steps + fast::kRoundingBase - fast::kRoundingBase);
}

} // namespace

TEST_CASE("fast decoder: fused multiply-adds without the processor's round once") {
    std::mt19937 random(11);
    int odd = 0;
    for (int i = 0; i < 20000; ++i) {
        const auto a = static_cast<float>(static_cast<std::int32_t>(random() % 0x2000000u) - 0x1000000);
        const float b = MakeFloat(random, 100, 12) * (random() % 2 == 0 ? 1.0f : -1.0f);
        // Addends that nearly cancel the product, and others.
        const float c = i % 2 == 0 ? -a * b : MakeFloat(random, 120, 16);
        const double exact = static_cast<double>(a) * static_cast<double>(b);
        const float fused = fast::FuseMultiplyAdd(a, b, c);
        const double error = (exact - static_cast<double>(fused)) + static_cast<double>(c);
        const float up = std::nextafterf(fused, INFINITY);
        const float down = std::nextafterf(fused, -INFINITY);
        const double half = 0.5 * (static_cast<double>(up) - static_cast<double>(fused));
        const double halfDown = 0.5 * (static_cast<double>(fused) - static_cast<double>(down));
        CHECK(error <= half);
        CHECK(-error <= halfDown);
        odd += error != 0.0 ? 1 : 0;
    }
    CHECK(odd > 5000);
}

TEST_CASE(
    "fast decoder: the cheaper gate in binary16 gives the contract's integer for every number it is given") {
    int tried = 0, lowest = 127, highest = -128;
    for (unsigned bits = 0; bits <= 0xFFFFu; ++bits) {
        const float z = HalfToFloat(static_cast<std::uint16_t>(bits));
        if (!(z >= -1.5f && z <= 3.0f))
            continue;
        const int wanted = RequantizeHalf(z);
        REQUIRE_MESSAGE(RequantizeHalfGate(z) == wanted, z);
        lowest = std::min(lowest, wanted);
        highest = std::max(highest, wanted);
        ++tried;
    }
    CHECK(tried == 0x4201 + 0x3E01); // 0 ... 3 and -0 ... -1.5
    CHECK(lowest == -128);
    CHECK(highest == 127);
}

/// 16 rows of drawn scales, every sum that is not beyond both limits; returns how many rows could be fused.
static int CompareFusedRows(const fast::ActivationForm& form) {
    std::mt19937 random(12);
    fast::ActivationFuser fuser(form);
    int fused = 0;
    for (int row = 0; row < 16; ++row) {
        const float scale = DrawScale(random);
        CAPTURE(scale);
        fast::FusedRow constants;
        if (!fuser.Fuse(scale, -kSumLimit, kSumLimit, constants))
            continue;
        ++fused;
        int different = 0;
        // Beyond z = -1.6 and 3.1 both are constant.
        const int first = std::max(static_cast<int>(-1.6f / scale), -kSumLimit);
        const int last = std::min(static_cast<int>(3.1f / scale), kSumLimit);
        for (int sum = first; sum <= last; ++sum)
            different +=
                fast::RequantizeFused(sum, constants) != fast::RequantizeExactly(sum, scale, form) ? 1 : 0;
        for (const int sum : {-kSumLimit, -kSumLimit / 2, kSumLimit / 2, kSumLimit})
            different +=
                fast::RequantizeFused(sum, constants) != fast::RequantizeExactly(sum, scale, form) ? 1 : 0;
        CHECK(different == 0);
    }
    return fused;
}

TEST_CASE("fast decoder: a fused row gives the contract's integers for every sum") {
    CHECK(CompareFusedRows({}) >= 8); // the others have sums that no constants get right
    CHECK(CompareFusedRows(fast::kGeneration3Form) >= 8);
}

TEST_CASE("fast decoder: rows that cannot be fused") {
    fast::ActivationFuser fuser;
    fast::FusedRow constants;
    constexpr float kScale = 0x1p-10f;
    REQUIRE(fuser.Fuse(kScale, -1000, 1000, constants));
    CHECK(fuser.Fuse(kScale, -(1 << 24), 256 << 10, constants));
    CHECK_FALSE(fuser.Fuse(kScale, -(1 << 24) - 1, 1000, constants));   // no longer exact as binary32
    CHECK_FALSE(fuser.Fuse(kScale, -1000, (256 << 10) + 1, constants)); // more than 16 bits
    CHECK_FALSE(fuser.Fuse(-kScale, -1000, 1000, constants));
    CHECK_FALSE(fuser.Fuse(0.0f, -1000, 1000, constants));
    CHECK_FALSE(fuser.Fuse(0x1p-20f, -1000, 1000, constants));
    CHECK_FALSE(fuser.Fuse(INFINITY, -1000, 1000, constants));
    CHECK_FALSE(fuser.Fuse(NAN, -1000, 1000, constants));
}

TEST_CASE("fast decoder: layers with fused rows and others") {
    const std::vector<decode_test::FastTarget> targets = decode_test::GetFastTargets(1);
    std::mt19937 random(13);
    for (int network = NTC_NETWORK_SMALL; network <= NTC_NETWORK_XLARGE; ++network) {
        decode_test::SpecificationShape shape{static_cast<std::uint32_t>(1200 + network),
                                              61,
                                              19,
                                              2,
                                              4,
                                              network,
                                              4 * network,
                                              8,
                                              4,
                                              4,
                                              {{15, 5, 7, 3}},
                                              {0, 0}};
        decode_test::SpecificationSet set = decode_test::MakeSpecificationSet(shape);
        const auto scaleOffset = static_cast<std::size_t>(set.constants.networkScaleBiasOffset);
        // Layer 0: as trained; 1: every seventh row negative; 2: the first fused row behind 63 others.
        for (std::size_t i = 0; i < 192; ++i) {
            float scale = DrawScale(random);
            if ((i >= 64 && i < 128 && i % 7 == 0) || (i >= 128 && i != 191))
                scale = -scale;
            std::memcpy(set.weights.data() + scaleOffset + 4 * i, &scale, sizeof scale);
        }
        fast::NetworkSource source;
        source.weights = set.weights.data();
        source.weightOffsets[0] = set.constants.networkWeightOffset0;
        source.weightOffsets[1] = set.constants.networkWeightOffset1;
        source.weightOffsets[2] = set.constants.networkWeightOffset2;
        source.weightOffsets[3] = set.constants.networkWeightOffset3;
        source.scaleOffset = set.constants.networkScaleBiasOffset;
        source.networkVersion = network;
        source.highResFeatures = 4 * network;
        source.lowResFeatures = 8;
        Array<std::int32_t> storage(GetDefaultAllocator());
        for (const bool fuses : {false, true}) {
            const auto prepared =
                fast::PrepareNetwork(source, fast::OperandLayout::UnsignedBytes, fuses, storage);
            REQUIRE(prepared.has_value());
            const auto& layers = prepared->layers;
            CHECK(layers[0].exactRows <= (fuses ? 32 : 64));
            CHECK(layers[1].exactRows >= (fuses ? 12 : 64)); // nine rows or more, in fours
            CHECK(layers[1].exactRows <= (fuses ? 44 : 64));
            CHECK(layers[2].exactRows == 64);
        }
        for (int mip = 0; mip < shape.mips; ++mip)
            CompareWithReference(set, mip, {0, 0, shape.width >> mip, shape.height >> mip}, targets);
    }
}
