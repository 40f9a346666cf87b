// SPDX-License-Identifier: MIT
// Many sets in shared buffers: alignment, limits, copying, constants that move.
#include "support/SpecificationVectors.h"

#include "openntc/inference/BufferPacking.h"
#include "openntc/inference/InferenceData.h"

#include <doctest/doctest.h>

#include <cstring>
#include <vector>

using namespace openntc;
using namespace openntc_tests;

namespace {

Status GetRefusal(std::span<const PackRequest> requests, const PackingLimits& limits) {
    std::vector<PackedSet> placements(requests.size());
    const auto result = PlanPacking(requests, limits, placements);
    REQUIRE_FALSE(result);
    return result.error().GetStatus();
}

} // namespace

TEST_CASE("sets follow each other at their alignments") {
    const PackRequest requests[] = {{100, 1000}, {12, 20}, {0, 8}, {7, 3}};
    PackedSet placements[4];
    const auto summary = PlanPacking(requests, {}, placements);
    REQUIRE(summary);
    CHECK(summary->buffers == 1);
    CHECK(placements[0].latentsOffset == 0);
    CHECK(placements[0].weightsOffset == 128);  // 100, up to 64
    CHECK(placements[1].latentsOffset == 1136); // 1128, up to 16
    CHECK(placements[1].weightsOffset == 1152);
    CHECK(placements[2].latentsOffset == 1184); // 1172, up to 16; empty
    CHECK(placements[2].weightsOffset == 1216);
    CHECK(placements[3].latentsOffset == 1232); // 1224
    CHECK(placements[3].weightsOffset == 1280);
    CHECK(summary->largestBufferBytes == 1284); // whole words
    CHECK(summary->paddingBytes == 1284 - (100 + 1000 + 12 + 20 + 8 + 7 + 3));
}

TEST_CASE("a new buffer starts where a set does not fit") {
    const PackRequest requests[] = {{256, 256}, {256, 256}, {500, 12}, {4, 4}};
    PackedSet placements[4];
    PackingLimits limits;
    limits.maxBufferBytes = 1024;
    const auto summary = PlanPacking(requests, limits, placements);
    REQUIRE(summary);
    CHECK(summary->buffers == 2);
    CHECK(placements[1].buffer == 0);
    CHECK(placements[1].weightsOffset == 768);
    CHECK(placements[2].buffer == 1);
    CHECK(placements[2].latentsOffset == 0);
    CHECK(placements[2].weightsOffset == 512);
    CHECK(placements[3].buffer == 1);
    CHECK(summary->largestBufferBytes == 1024);
    CHECK(summary->lastBufferBytes == 580);
}

TEST_CASE("limits and alignments that cannot be met") {
    const std::uint64_t gigabyte = std::uint64_t{1} << 30;
    PackingLimits limits;
    CHECK(GetRefusal(std::vector<PackRequest>{{(1u << 27) - 32, 64}}, limits) == Status::OutOfRange);
    limits.maxBufferBytes = ~std::uint64_t{0}; // 4 GiB remain the limit
    CHECK(GetRefusal(std::vector<PackRequest>{{4 * gigabyte + 4, 0}}, limits) == Status::OutOfRange);
    CHECK(GetRefusal(std::vector<PackRequest>{{~std::uint64_t{0}, ~std::uint64_t{0}}}, limits) ==
          Status::OutOfRange);
    PackedSet placements[3];
    const PackRequest large[] = {{3 * gigabyte, 1024}, {gigabyte, 0}, {gigabyte - 64, 64}};
    const auto summary = PlanPacking(large, limits, placements);
    REQUIRE(summary);
    CHECK(summary->buffers == 2);
    CHECK(placements[0].weightsOffset == 3 * gigabyte);
    CHECK(placements[1].buffer == 1);
    CHECK(placements[2].latentsOffset == gigabyte);
    CHECK(placements[2].weightsOffset == 2 * gigabyte - 64);
    const PackRequest whole[] = {{4 * gigabyte, 0}};
    REQUIRE(PlanPacking(whole, limits, placements));
    CHECK_FALSE(PlanPacking(large, limits, std::span(placements).first(2)));
    limits.latentAlignment = 2;
    CHECK(GetRefusal(std::vector<PackRequest>{{4, 4}}, limits) == Status::InvalidArgument);
    limits.latentAlignment = 24;
    CHECK(GetRefusal(std::vector<PackRequest>{{4, 4}}, limits) == Status::InvalidArgument);
    CHECK(PlanPacking({}, {}, {})->buffers == 0);
}

TEST_CASE("copies go to their places and nowhere else") {
    const PackRequest requests[] = {{5, 9}};
    PackedSet placement;
    REQUIRE(PlanPacking(requests, {}, std::span(&placement, 1)));
    const std::vector<std::byte> latents(5, std::byte{1});
    const std::vector<std::byte> weights(9, std::byte{2});
    std::vector<std::byte> buffer(80, std::byte{9});
    REQUIRE(CopyPacked(placement, latents, weights, buffer));
    for (std::size_t i = 0; i < buffer.size(); ++i)
        CHECK(static_cast<int>(buffer[i]) == (i < 5 ? 1 : i >= 64 && i < 73 ? 2 : 9));
    CHECK_FALSE(CopyPacked(placement, weights, latents, buffer));
    CHECK_FALSE(CopyPacked(placement, latents, weights, std::span(buffer).first(72)));
}

TEST_CASE("constants move, or stay as they are") {
    const std::vector<std::byte> file = SynthesizeV2();
    ReadOnlyMemoryStream stream(file);
    const auto set = TextureSetMetadata::Load(stream);
    REQUIRE(set);
    const auto original = MakeInferenceData(*set, kEntireStream, InferenceWeightType::GenericInt8);
    REQUIRE(original);
    NtcTextureSetConstants constants = *original;
    REQUIRE(MoveConstants(constants, 4096, 640));
    for (std::size_t i = 0; i < 2; ++i) {
        CHECK(constants.highResNeuralMips[i].dataOffset == original->highResNeuralMips[i].dataOffset + 4096);
        CHECK(constants.lowResNeuralMips[i].dataOffset == original->lowResNeuralMips[i].dataOffset + 4096);
    }
    CHECK(constants.highResNeuralMips[2].dataOffset == 0); // absent
    CHECK(constants.networkWeightOffset0 == original->networkWeightOffset0 + 640);
    CHECK(constants.networkWeightOffset3 == original->networkWeightOffset3 + 640);
    CHECK(constants.networkScaleBiasOffset == original->networkScaleBiasOffset + 640);
    CHECK(constants.imageWidth == original->imageWidth);

    const NtcTextureSetConstants moved = constants;
    CHECK(MoveConstants(constants, 0xFFFFFFF0u, 0).error().GetStatus() == Status::OutOfRange);
    CHECK(MoveConstants(constants, 0, 0x7FFFFFF0u).error().GetStatus() == Status::OutOfRange);
    CHECK(MoveConstants(constants, 2, 0).error().GetStatus() == Status::InvalidArgument);
    CHECK(std::memcmp(&constants, &moved, sizeof moved) == 0);
}
