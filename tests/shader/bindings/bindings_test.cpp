// SPDX-License-Identifier: MIT
// The ways in which engines bind a texture set, each dispatched: the texels are those of the reference decoder, bit for
// bit, subnormal numbers taken as zero. (The default bindings: decode_test.cpp.)
#include "shader/TestDevice.h"
#include "support/DeviceBits.h"

#include "bound_by_address.h"
#include "bound_by_index.h"
#include "bound_by_number.h"
#include "bound_by_number_hlsl.h"
#include "bound_by_push.h"

#include "openntc/decode/ReferenceDecoder.h"
#include "openntc/inference/BufferPacking.h"
#include "openntc/inference/InferenceData.h"
#include "openntc/inference/Synthesis.h"
#include "openntc/texture_set/TextureSetMetadata.h"

#include <doctest/doctest.h>

#include <array>
#include <bit>
#include <string>
#include <vector>

using namespace openntc;
using namespace openntc::harness;

namespace {

constexpr int kWidth = 37;
constexpr int kHeight = 29;
constexpr int kMips = 3;
constexpr std::size_t kSets = 3;
constexpr std::string_view kDefines = "NETWORK_VERSION=2 NTC_MATH=1";

struct TestSet {
    TextureSetMetadata metadata;
    std::vector<std::byte> latents;
    NtcTextureSetConstants constants;
    std::span<const std::byte> weights;
};

TestSet MakeSet(std::uint32_t seed) {
    SynthesisDesc synthesis;
    synthesis.seed = seed;
    synthesis.desc = {kWidth, kHeight, 16, kMips};
    synthesis.networkVersion = NTC_NETWORK_MEDIUM;
    synthesis.shape = {4, 8, 16, 2, 4};
    MemoryStream stream;
    REQUIRE(SynthesizeTextureSet(stream, synthesis));
    REQUIRE(stream.Seek(0));
    Expected<TextureSetMetadata> metadata = TextureSetMetadata::Load(stream);
    REQUIRE_MESSAGE(metadata.has_value(), std::string(metadata.error().GetText()));
    const Expected<StreamRange> range = metadata->GetStreamRangeForLatents(0, kMips);
    REQUIRE(range);
    const auto constants = MakeInferenceData(*metadata, *range, InferenceWeightType::GenericInt8);
    REQUIRE(constants);
    const auto bytes = stream.GetBytes().subspan(static_cast<std::size_t>(range->offset),
                                                 static_cast<std::size_t>(range->size));
    TestSet set = {std::move(*metadata), {bytes.begin(), bytes.end()}, *constants, {}};
    set.weights = *set.metadata.GetInferenceWeights(InferenceWeightType::GenericInt8);
    return set;
}

std::array<TestSet, kSets> MakeSets() {
    return {MakeSet(21), MakeSet(22), MakeSet(23)};
}

std::vector<float> DecodeHere(const TestSet& set, int mip) {
    const DecodeSource source = {&set.constants, set.latents, set.weights, NTC_NETWORK_MEDIUM};
    const ColorMip& size = set.metadata.GetColorMips()[static_cast<std::size_t>(mip)];
    std::vector<float> outputs(16 * static_cast<std::size_t>(size.width * size.height));
    const auto result = DecodeReference(source, mip, {0, 0, size.width, size.height}, {}, outputs);
    REQUIRE_MESSAGE(result.has_value(), std::string(result.error().GetText()));
    return outputs;
}

Buffer Upload(Context& context, std::span<const std::byte> bytes, BufferKind kind = BufferKind::Storage) {
    auto buffer = context.CreateBuffer(bytes, kind, BufferMemory::DeviceLocal);
    REQUIRE_MESSAGE(buffer.has_value(), std::string(buffer.error().GetText()));
    return std::move(*buffer);
}

Buffer MakeResults(Context& context) {
    auto buffer = context.CreateBuffer(std::uint64_t{kWidth} * kHeight * 64, BufferKind::Storage,
                                       BufferMemory::HostVisible);
    REQUIRE_MESSAGE(buffer.has_value(), std::string(buffer.error().GetText()));
    return std::move(*buffer);
}

struct Size {
    std::int32_t width, height, mip;
};

Size GetSize(const TestSet& set, int mip) {
    const ColorMip& size = set.metadata.GetColorMips()[static_cast<std::size_t>(mip)];
    return {size.width, size.height, mip};
}

/// Runs a pipeline over a mip and returns how many outputs differ from `expected`.
template <typename Push>
std::size_t RunAndCount(Context& context, Expected<std::span<const std::uint32_t>> words,
                        std::span<const BufferSlot> slots, std::span<const BoundBuffer> bound,
                        const Push& push, Buffer& results, std::span<const float> expected) {
    REQUIRE_MESSAGE(words.has_value(), std::string(words.error().GetText()));
    const auto pipeline = context.CreateComputePipeline(*words, slots, sizeof(Push));
    REQUIRE_MESSAGE(pipeline.has_value(), std::string(pipeline.error().GetText()));
    std::vector<float> outputs(expected.size(), 77.0f); // what a shader that writes nothing leaves
    REQUIRE(context.Write(results, 0, std::as_bytes(std::span(outputs))));
    DispatchRequest request;
    request.pipeline = &*pipeline;
    request.buffers = bound;
    request.pushConstants = std::as_bytes(std::span(&push, 1));
    request.groups[0] = static_cast<std::uint32_t>((expected.size() / 16 + 63) / 64);
    const auto timing = context.Dispatch(request);
    REQUIRE_MESSAGE(timing.has_value(), std::string(timing.error().GetText()));
    REQUIRE(context.Read(results, 0, std::as_writable_bytes(std::span(outputs))));
    std::size_t different = 0;
    for (std::size_t i = 0; i < outputs.size(); ++i)
        different += openntc_tests::GetDeviceBits(outputs[i]) != openntc_tests::GetDeviceBits(expected[i]);
    return different;
}

/// Latents and weights of sets in one buffer, behind something else.
struct PackedSets {
    std::vector<std::byte> bytes;
    std::vector<PackedSet> places;
};

PackedSets Pack(std::span<const TestSet> sets) {
    std::vector<PackRequest> requests = {{.latentBytes = 100, .weightBytes = 0}};
    for (const TestSet& set : sets)
        requests.push_back({set.latents.size(), set.weights.size()});
    PackedSets packed;
    packed.places.resize(requests.size());
    const auto summary = PlanPacking(requests, {}, packed.places);
    REQUIRE(summary);
    REQUIRE(summary->buffers == 1);
    packed.bytes.assign(static_cast<std::size_t>(summary->largestBufferBytes), std::byte{0xA5});
    packed.places.erase(packed.places.begin());
    for (std::size_t i = 0; i < sets.size(); ++i) {
        REQUIRE(CopyPacked(packed.places[i], sets[i].latents, sets[i].weights, packed.bytes));
        CHECK(packed.places[i].latentsOffset > 0);
        CHECK(packed.places[i].weightsOffset > 0);
    }
    return packed;
}

} // namespace

TEST_CASE(
    "the engine's own sets and bindings, in GLSL and HLSL, at offsets in a buffer of several texture sets") {
    OPENNTC_REQUIRE_DEVICE(context);
    const std::array<TestSet, kSets> sets = MakeSets();
    const PackedSets packed = Pack(sets);
    const Buffer words = Upload(*context, packed.bytes);
    Buffer results = MakeResults(*context);
    constexpr BufferSlot kSlots[] = {{1, BufferKind::Storage, 0},
                                     {7, BufferKind::Storage, 2},
                                     {9, BufferKind::Storage, 2},
                                     {5, BufferKind::Uniform, 3}};
    struct Push {
        Size size;
        std::uint32_t latentsOffset, weightsOffset;
    };
    for (std::size_t i = 0; i < kSets; ++i) {
        CAPTURE(i);
        const Buffer constants =
            Upload(*context, std::as_bytes(std::span(&sets[i].constants, 1)), BufferKind::Uniform);
        const BoundBuffer bound[] = {{1, &results, 0}, {7, &words, 2}, {9, &words, 2}, {5, &constants, 3}};
        for (int mip = 0; mip < kMips; ++mip) {
            CAPTURE(mip);
            const std::vector<float> expected = DecodeHere(sets[i], mip);
            const Push push = {GetSize(sets[i], mip), packed.places[i].latentsOffset,
                               packed.places[i].weightsOffset};
            CHECK(RunAndCount(*context, bound_by_number::FindShader("BoundByNumber.comp", kDefines), kSlots,
                              bound, push, results, expected) == 0);
            CHECK(RunAndCount(*context, bound_by_number_hlsl::FindShader("BoundByNumber.hlsl", kDefines),
                              kSlots, bound, push, results, expected) == 0);
        }
    }
    CHECK(context->GetValidationLog().errors.empty());
}

TEST_CASE(
    "the constants of one mip, in push constants where the device has enough, and in a uniform buffer") {
    OPENNTC_REQUIRE_DEVICE(context);
    const TestSet set = MakeSet(24);
    const std::vector<float> expected = DecodeHere(set, 0);
    const Buffer latents = Upload(*context, set.latents);
    const Buffer weights = Upload(*context, set.weights);
    Buffer results = MakeResults(*context);
    const auto constants = MakeSingleMipConstants(set.constants);
    REQUIRE(constants);
    const Buffer uniforms = Upload(*context, std::as_bytes(std::span(&*constants, 1)), BufferKind::Uniform);
    constexpr BufferSlot kSlots[] = {{0, BufferKind::Uniform},
                                     {1, BufferKind::Storage},
                                     {2, BufferKind::Storage},
                                     {3, BufferKind::Storage}};
    const BoundBuffer bound[] = {{0, &uniforms}, {1, &latents}, {2, &weights}, {3, &results}};
    struct Sizes {
        std::int32_t width, height, padding0, padding1;
    };
    struct Push {
        Sizes sizes;
        NtcSingleMipConstants desc;
    };
    const Sizes sizes = {kWidth, kHeight, 0, 0};
    const std::string defines(kDefines);
    CHECK(RunAndCount(*context,
                      bound_by_push::FindShader("BoundByPush.comp", defines + " UNIFORM_CONSTANTS=1"), kSlots,
                      bound, sizes, results, expected) == 0);
    if (context->GetDevice().maxPushConstantBytes >= sizeof(Push))
        CHECK(RunAndCount(
                  *context, bound_by_push::FindShader("BoundByPush.comp", defines + " UNIFORM_CONSTANTS=0"),
                  std::span(kSlots).subspan(1), bound, Push{sizes, *constants}, results, expected) == 0);
    else
        MESSAGE("SKIP: " << sizeof(Push) << " bytes of push constants: the device has "
                         << context->GetDevice().maxPushConstantBytes);
    CHECK(context->GetValidationLog().errors.empty());

    NtcTextureSetConstants other = set.constants;
    other.colorMips[0].neuralMip = 1;
    CHECK(MakeSingleMipConstants(other).error().GetStatus() == Status::InvalidArgument);
}

TEST_CASE("bindless: an index into arrays of buffers, the same for all lanes or not") {
    OPENNTC_REQUIRE_DEVICE(context);
    const DeviceInfo& device = context->GetDevice();
    if (!device.features.Has(Feature::BufferArrays)) {
        MESSAGE("SKIP: the device lacks shaderStorageBufferArrayDynamicIndexing");
        return;
    }
    if (!device.features.Has(Feature::NonUniformIndexing))
        MESSAGE("SKIP: indices that differ between lanes: the device lacks "
                "shaderStorageBufferArrayNonUniformIndexing");
    const std::array<TestSet, kSets> sets = MakeSets();
    std::vector<Buffer> words, constants;
    PackedSet place;
    for (const TestSet& set : sets) {
        const PackedSets packed = Pack(std::span(&set, 1)); // equal shapes: equal places in every buffer
        place = packed.places.front();
        words.push_back(Upload(*context, packed.bytes));
        constants.push_back(Upload(*context, std::as_bytes(std::span(&set.constants, 1))));
    }
    Buffer results = MakeResults(*context);
    const BufferSlot slots[] = {{0, BufferKind::Storage, 0},
                                {0, BufferKind::Storage, 1, static_cast<std::uint32_t>(kSets)},
                                {1, BufferKind::Storage, 1, static_cast<std::uint32_t>(kSets)}};
    std::vector<BoundBuffer> bound = {{0, &results, 0}};
    for (std::uint32_t i = 0; i < kSets; ++i) {
        bound.push_back({0, &words[i], 1, i});
        bound.push_back({1, &constants[i], 1, i});
    }
    struct Push {
        Size size;
        std::uint32_t textureSet, latentsOffset, weightsOffset;
    };
    for (std::uint32_t i = 0; i < kSets; ++i) {
        CAPTURE(i);
        for (int mip = 0; mip < kMips; ++mip) {
            CAPTURE(mip);
            const Push push = {GetSize(sets[i], mip), i, place.latentsOffset, place.weightsOffset};
            std::vector<float> expected = DecodeHere(sets[i], mip);
            const std::string defines(kDefines);
            CHECK(
                RunAndCount(*context,
                            bound_by_index::FindShader("BoundByIndex.comp", defines + " NON_UNIFORM_SETS=0"),
                            slots, bound, push, results, expected) == 0);
            if (!device.features.Has(Feature::NonUniformIndexing) || i + 1 == kSets)
                continue;
            const std::vector<float> next = DecodeHere(sets[i + 1], mip);
            for (std::size_t k = 16; k < expected.size(); k += 32)
                std::copy_n(next.begin() + static_cast<std::ptrdiff_t>(k), 16,
                            expected.begin() + static_cast<std::ptrdiff_t>(k));
            CHECK(
                RunAndCount(*context,
                            bound_by_index::FindShader("BoundByIndex.comp", defines + " NON_UNIFORM_SETS=1"),
                            slots, bound, push, results, expected) == 0);
        }
    }
    CHECK(context->GetValidationLog().errors.empty());
}

TEST_CASE("buffer device addresses") {
    OPENNTC_REQUIRE_DEVICE(context);
    if (!context->GetDevice().features.Has(Feature::BufferDeviceAddress)) {
        MESSAGE("SKIP: the device lacks bufferDeviceAddress");
        return;
    }
    const TestSet set = MakeSet(25);
    const Buffer constants = Upload(*context, std::as_bytes(std::span(&set.constants, 1)));
    const Buffer latents = Upload(*context, set.latents);
    const Buffer weights = Upload(*context, set.weights);
    Buffer results = MakeResults(*context);
    struct Push {
        std::uint64_t constants, latents, weights, results;
        Size size;
        std::uint32_t padding;
    };
    for (int mip = 0; mip < kMips; ++mip) {
        CAPTURE(mip);
        const Push push = {
            constants.GetDeviceAddress(), latents.GetDeviceAddress(), weights.GetDeviceAddress(),
            results.GetDeviceAddress(),   GetSize(set, mip),          0};
        CHECK(RunAndCount(*context, bound_by_address::FindShader("BoundByAddress.comp", kDefines), {}, {},
                          push, results, DecodeHere(set, mip)) == 0);
    }
    CHECK(context->GetValidationLog().errors.empty());
}
