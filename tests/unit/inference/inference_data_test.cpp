// SPDX-License-Identifier: MIT
// Stream ranges and weight types of MakeInferenceData; permutations of outputs; network layouts.
#include "support/SpecificationVectors.h"

#include "openntc/core/Crc32.h"
#include "openntc/inference/InferenceData.h"

#include <doctest/doctest.h>

#include <cstring>
#include <limits>
#include <span>
#include <string>

using namespace openntc;
using namespace openntc_tests;

namespace {

struct LoadedSet {
    std::vector<std::byte> file;
    TextureSetMetadata metadata;
};

LoadedSet LoadV2(bool withFP8) {
    SynthesisDesc synthesis = GetV2().synthesis;
    synthesis.withFP8 = withFP8;
    synthesis.channelColorSpaces = 0x24; // Linear, sRGB, HLG, Linear
    std::vector<std::byte> file = MakeFile(synthesis);
    ReadOnlyMemoryStream stream(file);
    auto set = TextureSetMetadata::Load(stream);
    REQUIRE(set);
    return {std::move(file), std::move(*set)};
}

template <typename T>
T Read(std::span<const std::byte> bytes, std::size_t offset) {
    T value;
    std::memcpy(&value, bytes.data() + offset, sizeof value);
    return value;
}

using Sources = std::array<ShuffleSource, NTC_MAX_CHANNELS>;

Sources Identity() {
    Sources sources;
    for (int c = 0; c < NTC_MAX_CHANNELS; ++c)
        sources[static_cast<std::size_t>(c)] = ShuffleSource::Channel(c);
    return sources;
}

// A stream that has the JSON at its start and the binary chunk 5 GiB further.
class FarStream final : public Stream {
public:
    explicit FarStream(std::vector<std::byte> file) : file_(std::move(file)) {
        std::memcpy(&binaryOffset_, file_.data() + 24, 8);
        const std::uint64_t moved = binaryOffset_ + kGap;
        std::memcpy(file_.data() + 24, &moved, 8);
    }
    bool Read(void* destination, std::size_t bytes) noexcept override {
        std::uint64_t at = position_ >= binaryOffset_ + kGap ? position_ - kGap : position_;
        if (at + bytes > file_.size())
            return false;
        std::memcpy(destination, file_.data() + at, bytes);
        position_ += bytes;
        return true;
    }
    bool Write(const void*, std::size_t) noexcept override { return false; }
    bool Seek(std::uint64_t offset) noexcept override {
        position_ = offset;
        return true;
    }
    std::uint64_t Tell() noexcept override { return position_; }
    std::uint64_t Size() noexcept override { return file_.size() + kGap; }

private:
    static constexpr std::uint64_t kGap = std::uint64_t{5} << 30;
    std::vector<std::byte> file_;
    std::uint64_t binaryOffset_ = 0;
    std::uint64_t position_ = 0;
};

} // namespace

TEST_CASE("network layouts: the specification's table") {
    const int int8Bytes[] = {13952, 14976, 16000, 17024};
    const int fp8Bytes[] = {12800, 13824, 14848, 15872};
    const int inputs[] = {48, 64, 80, 96};
    for (int version = 1; version <= 4; ++version) {
        const NetworkDescription network = GetNetworkDescription(version);
        CHECK(network.int8Bytes == int8Bytes[version - 1]);
        CHECK(network.fp8Bytes == fp8Bytes[version - 1]);
        CHECK(network.inputs[0] == inputs[version - 1]);
        CHECK(GetNetworkVersionForInputs(static_cast<std::size_t>(inputs[version - 1])) == version);
    }
    const NetworkDescription large = GetNetworkDescription(NTC_NETWORK_LARGE);
    CHECK(large.weightOffsets == std::array{0, 5120, 9216, 13312});
    CHECK(large.int8ScaleOffsets == std::array{14336, 14592, 14848, 15104});
    CHECK(large.int8BiasOffsets == std::array{15168, 15424, 15680, 15936});
    CHECK(large.fp8BiasOffsets == std::array{14336, 14464, 14592, 14784});
    CHECK(large.fp8ScaleOffset == 14720);
    CHECK(GetNetworkVersionForInputs(50) == NTC_NETWORK_UNKNOWN);
}

TEST_CASE("network layouts of generations 2 and 3: the specification's numbers") {
    const NetworkDescription small = GetNetworkDescription(NTC_NETWORK_SMALL);
    const NetworkDescription second = GetNetworkDescription(NTC_NETWORK_GENERATION_2);
    CHECK(second.generation == 2);
    CHECK(second.inputs == std::array{48, 64, 64, 64});
    CHECK(second.outputs == std::array{64, 64, 64, 16});
    CHECK(second.weightOffsets == std::array{0, 3072, 7168, 11264});
    CHECK(second.int8ScaleOffsets[0] == 12288);
    CHECK(second.int8BiasOffsets[0] == 13120);
    CHECK(second.int8Bytes == 13952);
    CHECK(second.fp8Bytes == 12800);
    CHECK(second.int8ScaleOffsets == small.int8ScaleOffsets);
    CHECK(second.int8BiasOffsets == small.int8BiasOffsets);
    CHECK(second.fp8BiasOffsets == small.fp8BiasOffsets);
    CHECK(second.fp8ScaleOffset == small.fp8ScaleOffset);

    const NetworkDescription third = GetNetworkDescription(NTC_NETWORK_GENERATION_3);
    CHECK(third.generation == 3);
    CHECK(third.inputs == std::array{48, 64, 48, 32});
    CHECK(third.outputs == std::array{64, 48, 32, 16});
    CHECK(third.outputsOfAllLayers == 160);
    CHECK(third.weightOffsets == std::array{0, 3072, 6144, 7680});
    CHECK(third.weightBytes == 8192);
    CHECK(third.int8ScaleOffsets == std::array{8192, 8448, 8640, 8768});
    CHECK(third.int8BiasOffsets == std::array{8832, 9088, 9280, 9408});
    CHECK(third.int8Bytes == 9472);
    CHECK(third.fp8BiasOffsets == std::array{8192, 8320, 8416, 8544});
    CHECK(third.fp8ScaleOffset == 8480);
    CHECK(third.fp8Bytes == 8608);
}

TEST_CASE("network versions: their generations and names") {
    const int generations[] = {0, 1, 1, 1, 1, 2, 3, 0};
    const char* const names[] = {"unknown", "small", "medium", "large", "xlarge", "gen2", "gen3", "unknown"};
    for (int version = 0; version < 8; ++version) {
        CHECK(GetGeneration(version) == generations[version]);
        CHECK(IsKnownNetwork(version) == (generations[version] != 0));
        CHECK(IsNetworkVersion(version) == (generations[version] == 1));
        CHECK(std::string(GetNetworkName(version)) == names[version]);
    }
    CHECK(GetGeneration(-1) == 0);
}

TEST_CASE("latent images not wholly inside the range are absent") {
    const LoadedSet set = LoadV2(false);
    const auto fine = *set.metadata.GetStreamRangeForLatents(0, 1);
    const auto coarse = *set.metadata.GetStreamRangeForLatents(5, 1);
    const auto all = *set.metadata.GetStreamRangeForLatents(0, 6);
    const auto make = [&](StreamRange range) {
        const auto constants = MakeInferenceData(set.metadata, range, InferenceWeightType::GenericInt8);
        REQUIRE(constants);
        return *constants;
    };
    const auto isPresent = [](const NtcTextureSetConstants& c, int image) {
        CHECK((c.highResNeuralMips[image].sliceWidthHeight == 0) ==
              (c.lowResNeuralMips[image].sliceWidthHeight == 0));
        return c.highResNeuralMips[image].sliceWidthHeight != 0;
    };
    CHECK(isPresent(make(all), 0));
    CHECK(isPresent(make(all), 1));
    CHECK(make(all).highResNeuralMips[0].dataOffset == 0);
    CHECK(isPresent(make(fine), 0));
    CHECK_FALSE(isPresent(make(fine), 1));
    CHECK(make(fine).highResNeuralMips[1].imageWidthHeight == 0);
    CHECK_FALSE(isPresent(make(coarse), 0));
    CHECK(isPresent(make(coarse), 1));
    CHECK(make(coarse).highResNeuralMips[1].dataOffset == 0);
    CHECK_FALSE(isPresent(make({fine.offset, fine.size - 1}), 0));
    CHECK_FALSE(isPresent(make({fine.offset + 4, fine.size}), 0));
    CHECK_FALSE(isPresent(make({0, 0}), 0));
    CHECK_FALSE(isPresent(make({~std::uint64_t{0}, ~std::uint64_t{0}}), 1));
    CHECK(make(kEntireStream).highResNeuralMips[0].dataOffset == fine.offset);
    const auto odd =
        MakeInferenceData(set.metadata, {fine.offset - 2, fine.size + 2}, InferenceWeightType::GenericInt8);
    REQUIRE_FALSE(odd);
    CHECK(odd.error().GetStatus() == Status::InvalidArgument);
}

TEST_CASE("weight types: only what the set holds") {
    const LoadedSet set = LoadV2(false);
    for (const auto type : {InferenceWeightType::Unknown, InferenceWeightType::GenericFP8,
                            InferenceWeightType::CoopVecInt8, InferenceWeightType::CoopVecFP8}) {
        const auto constants = MakeInferenceData(set.metadata, kEntireStream, type);
        REQUIRE_FALSE(constants);
        CHECK(constants.error().GetStatus() == Status::Unsupported);
    }
}

TEST_CASE("weights of another network version are refused") {
    const LoadedSet large = LoadV2(false);
    const std::vector<std::byte> file = SynthesizeV1();
    ReadOnlyMemoryStream stream(file);
    const auto small = TextureSetMetadata::Load(stream);
    REQUIRE(small);
    const auto constants = MakeInferenceData(large.metadata, kEntireStream, InferenceWeightType::GenericInt8,
                                             small->GetWeights());
    REQUIRE_FALSE(constants);
    CHECK(constants.error().GetStatus() == Status::InvalidArgument);
    CHECK(std::string(constants.error().GetText()) == "weights: of a small network: the set has a large one");
}

TEST_CASE("constants of a single mip: each member is that of the set") {
    const LoadedSet set = LoadV2(false);
    const auto all = MakeInferenceData(set.metadata, kEntireStream, InferenceWeightType::GenericInt8);
    REQUIRE(all);
    const auto one = MakeSingleMipConstants(*all);
    REQUIRE(one);
    const auto sameEncoding = [](const NtcLatentEncodingConstants& a, const NtcLatentEncodingConstants& b) {
        return std::memcmp(&a, &b, sizeof a) == 0;
    };
    const auto sameGrid = [](const NtcNeuralMipConstants& a, const NtcNeuralMipConstants& b) {
        return a.dataOffset == b.dataOffset && a.imageWidthHeight == b.imageWidthHeight &&
               a.sliceWidthHeight == b.sliceWidthHeight && a.sliceLeftTop == b.sliceLeftTop;
    };
    CHECK_FALSE(
        sameGrid(all->highResNeuralMips[0], all->lowResNeuralMips[0])); // or the next lines would say little
    CHECK_FALSE(sameEncoding(all->highResEncoding, all->lowResEncoding));
    CHECK(sameEncoding(one->highResEncoding, all->highResEncoding));
    CHECK(sameEncoding(one->lowResEncoding, all->lowResEncoding));
    CHECK(sameGrid(one->highResNeuralMips[0], all->highResNeuralMips[0]));
    CHECK(sameGrid(one->lowResNeuralMips[0], all->lowResNeuralMips[0]));
    CHECK(one->colorMips[0].neuralMip == all->colorMips[0].neuralMip);
    CHECK(one->colorMips[0].positionLod == all->colorMips[0].positionLod);
    CHECK(one->colorMips[0].positionScale == all->colorMips[0].positionScale);
    CHECK(one->networkWeightOffset0 == all->networkWeightOffset0);
    CHECK(one->networkWeightOffset1 == all->networkWeightOffset1);
    CHECK(one->networkWeightOffset2 == all->networkWeightOffset2);
    CHECK(one->networkWeightOffset3 == all->networkWeightOffset3);
    CHECK(one->networkScaleBiasOffset == all->networkScaleBiasOffset);
    CHECK(one->imageWidth == 40);
    CHECK(one->imageHeight == 64);
    CHECK(one->imageMips == 6);
    CHECK(one->validChannelMask == all->validChannelMask);
    CHECK(one->channelColorSpaces == 0x24);
}

TEST_CASE("latents 4 GiB behind the start of the range do not fit the constants") {
    FarStream stream(SynthesizeV1());
    const auto set = TextureSetMetadata::Load(stream);
    REQUIRE_MESSAGE(set, std::string(set.error().GetText()));
    const auto far = MakeInferenceData(*set, kEntireStream, InferenceWeightType::GenericInt8);
    REQUIRE_FALSE(far);
    CHECK(far.error().GetStatus() == Status::OutOfRange);
    CHECK(MakeInferenceData(*set, *set->GetStreamRangeForLatents(0, 4), InferenceWeightType::GenericInt8));
}

TEST_CASE("shuffling: channels, constants, undefined, in both buffers") {
    const LoadedSet set = LoadV2(true);
    const InferenceWeights& original = set.metadata.GetWeights();
    const auto same = ShuffleInferenceOutputs(original, Identity());
    REQUIRE(same);
    CHECK(Crc32(same->int8.AsSpan()) == Crc32(original.int8.AsSpan()));
    CHECK(Crc32(same->fp8.AsSpan()) == Crc32(original.fp8.AsSpan()));

    Sources sources; // everything undefined
    sources[0] = ShuffleSource::Channel(2);
    sources[3] = ShuffleSource::Channel(9); // no texture covers it
    sources[5] = ShuffleSource::Constant(-0.75f);
    sources[15] = ShuffleSource::Channel(1);
    const auto shuffled = ShuffleInferenceOutputs(original, sources);
    REQUIRE(shuffled);
    CHECK(shuffled->validChannelMask == 0x8021);
    CHECK(shuffled->channelColorSpaces == (2u | 1u << 30)); // HLG first, sRGB last
    const struct {
        std::span<const std::byte> before, after;
        std::size_t scales, biases;
    } buffers[] = {{original.int8.AsSpan(), shuffled->int8.AsSpan(), 15104, 15936},
                   {original.fp8.AsSpan(), shuffled->fp8.AsSpan(), 14720, 14784}};
    for (const auto& b : buffers) {
        constexpr std::size_t kWeights = 13312;
        CHECK(std::equal(b.before.begin(), b.before.begin() + kWeights, b.after.begin())); // other layers
        CHECK(std::memcmp(b.after.data() + kWeights, b.before.data() + kWeights + 2 * 64, 64) == 0);
        CHECK(Read<float>(b.after, b.scales) == Read<float>(b.before, b.scales + 8));
        CHECK(Read<std::int32_t>(b.after, b.biases + 60) == Read<std::int32_t>(b.before, b.biases + 4));
        CHECK(Read<std::uint64_t>(b.after, kWeights + 5 * 64) == 0);
        CHECK(Read<float>(b.after, b.scales + 20) == 0x1p-16f);
        CHECK(Read<std::int32_t>(b.after, b.biases + 20) == -49152);
        CHECK(Read<float>(b.after, b.scales + 4) == 0x1p-16f);
        CHECK(Read<std::int32_t>(b.after, b.biases + 4) == 0);
    }
    const auto constants =
        MakeInferenceData(set.metadata, kEntireStream, InferenceWeightType::GenericInt8, *shuffled);
    REQUIRE(constants);
    CHECK(constants->validChannelMask == 0x8021);
    CHECK(constants->channelColorSpaces == shuffled->channelColorSpaces);
}

TEST_CASE("shuffles compose: a rotation sixteen times is the identity") {
    const LoadedSet set = LoadV2(true);
    Sources rotation;
    for (int c = 0; c < NTC_MAX_CHANNELS; ++c)
        rotation[static_cast<std::size_t>(c)] = ShuffleSource::Channel((c + 1) % NTC_MAX_CHANNELS);
    auto weights = set.metadata.GetWeights().Clone(GetDefaultAllocator());
    REQUIRE(weights);
    for (int i = 0; i < NTC_MAX_CHANNELS; ++i) {
        auto next = ShuffleInferenceOutputs(*weights, rotation);
        REQUIRE(next);
        if (i == 0)
            CHECK(Crc32(next->int8.AsSpan()) != Crc32(weights->int8.AsSpan()));
        *weights = std::move(*next);
    }
    CHECK(Crc32(weights->int8.AsSpan()) == Crc32(set.metadata.GetWeights().int8.AsSpan()));
    CHECK(Crc32(weights->fp8.AsSpan()) == Crc32(set.metadata.GetWeights().fp8.AsSpan()));
    CHECK(weights->validChannelMask == set.metadata.GetValidChannelMask());
    CHECK(weights->channelColorSpaces == 0x24);
}

TEST_CASE("shuffle sources outside their range are refused") {
    const LoadedSet set = LoadV2(false);
    const auto check = [&](ShuffleSource source, Status status) {
        Sources sources = Identity();
        sources[7] = source;
        const auto result = ShuffleInferenceOutputs(set.metadata.GetWeights(), sources);
        REQUIRE_FALSE(result);
        CHECK(result.error().GetStatus() == status);
    };
    check(ShuffleSource::Channel(16), Status::OutOfRange);
    check(ShuffleSource::Channel(-1), Status::OutOfRange);
    check(ShuffleSource::Constant(32768.0f), Status::OutOfRange);
    check(ShuffleSource::Constant(std::numeric_limits<float>::quiet_NaN()), Status::OutOfRange);
    check({static_cast<ShuffleSource::Kind>(3), 0, 0.0f}, Status::InvalidArgument);
}
