// SPDX-License-Identifier: MIT
// Slices on the device: with the ordinary functions and the constants of the slice, and with the constants of the
// set and a row for each slice. Every texel has the bits that the reference decoder finds in the whole set, subnormal
// numbers taken as zero.
#include "shader/TestDevice.h"
#include "support/DeviceBits.h"
#include "support/RandomSlices.h"
#include "support/SpecificationVectors.h"
#include "vulkan_harness/GpuDecoder.h"

#include "slice_shaders.h"
#include "slice_shaders_hlsl.h"

#include "openntc/decode/ReferenceDecoder.h"

#include <doctest/doctest.h>

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

using namespace openntc;
using namespace openntc::harness;
using namespace openntc_tests;

namespace {

constexpr int kSets = 10;
constexpr int kSlices = 4; // of each set

/// A set, and slices of it behind rows in one buffer of latents: row 8 i + n is latent image n of slice i.
struct SlicedSet {
    TextureSetMetadata metadata;
    std::span<const std::byte> weights;
    std::vector<SliceDesc> slices;
    std::vector<NtcTextureSetConstants> sliceConstants;
    std::vector<std::vector<std::byte>> sliceLatents;
    std::vector<std::byte> buffer;
    NtcTextureSetConstants constants; // without latents
    std::vector<std::vector<float>> expected;
};

void AddSlice(SlicedSet& set, const SliceDesc& slice, std::span<const std::byte> file) {
    const std::size_t number = set.slices.size();
    const auto layout = GetSliceLayout(set.metadata, slice);
    REQUIRE(layout);
    std::vector<std::byte> latents(static_cast<std::size_t>(layout->bytes));
    ReadOnlyMemoryStream stream(file);
    const auto data =
        MakePartialInferenceData(set.metadata, stream, slice, InferenceWeightType::GenericInt8, latents);
    REQUIRE(data);
    const std::uint32_t place = static_cast<std::uint32_t>(set.buffer.size());
    for (int image = 0; image < NTC_MAX_NEURAL_MIPS; ++image) {
        const auto row = MoveSliceConstants(MakeSliceConstants(*layout, image), place);
        REQUIRE(row);
        const std::size_t at = (number * NTC_MAX_NEURAL_MIPS + static_cast<std::size_t>(image)) * sizeof *row;
        std::memcpy(set.buffer.data() + at, &*row, sizeof *row);
    }
    set.buffer.insert(set.buffer.end(), latents.begin(), latents.end());
    set.slices.push_back(slice);
    set.sliceConstants.push_back(data->constants);
    set.sliceLatents.push_back(std::move(latents));
}

SlicedSet MakeSet(SliceRandom& random, std::string& text) {
    SynthesisDesc synthesis = PickSet(random, 40);
    if (synthesis.shape.highResFeatures > 12) // the networks that are compiled
        synthesis.shape.highResFeatures = 12;
    synthesis.networkVersion = synthesis.shape.highResFeatures <= 4 ? NTC_NETWORK_SMALL : NTC_NETWORK_LARGE;
    text = ToText(synthesis);
    const std::vector<std::byte> file = MakeFile(synthesis);
    ReadOnlyMemoryStream stream(file);
    auto metadata = TextureSetMetadata::Load(stream);
    REQUIRE(metadata);
    const auto whole = MakeInferenceData(*metadata, kEntireStream, InferenceWeightType::GenericInt8);
    const auto none = MakeInferenceData(*metadata, StreamRange{}, InferenceWeightType::GenericInt8);
    REQUIRE(whole);
    REQUIRE(none);
    SlicedSet set{std::move(*metadata), {}, {}, {}, {}, {}, *none, {}};
    set.weights = *set.metadata.GetInferenceWeights(InferenceWeightType::GenericInt8);
    set.buffer.resize(kSlices * NTC_MAX_NEURAL_MIPS * sizeof(NtcSliceConstants));
    for (int i = 0; i < kSlices; ++i)
        AddSlice(set, PickSlice(random, set.metadata), file);
    for (int mip = 0; mip < set.metadata.GetDesc().mips; ++mip) {
        const ColorMip& size = set.metadata.GetColorMips()[static_cast<std::size_t>(mip)];
        std::vector<float> texels(16 * static_cast<std::size_t>(size.width * size.height));
        const DecodeSource source{&*whole, file, set.weights, set.metadata.GetNetworkVersion()};
        REQUIRE(DecodeReference(source, mip, {0, 0, size.width, size.height}, {}, texels));
        set.expected.push_back(std::move(texels));
    }
    return set;
}

std::size_t CountDifferent(const SlicedSet& set, int mip, const Rect& rect, std::span<const float> outputs) {
    const int width = set.metadata.GetColorMips()[static_cast<std::size_t>(mip)].width;
    std::size_t different = 0;
    for (std::size_t i = 0; i < outputs.size(); ++i) {
        const int texel = static_cast<int>(i / 16);
        const int x = rect.left + texel % rect.width;
        const int y = rect.top + texel / rect.width;
        const float expected = set.expected[static_cast<std::size_t>(mip)]
                                           [static_cast<std::size_t>(y * width + x) * 16 + i % 16];
        different += GetDeviceBits(expected) != GetDeviceBits(outputs[i]) ? 1u : 0u;
    }
    return different;
}

struct Push {
    Rect rect;
    int mip;
    std::uint32_t row;
};

/// One set on the device, with rows.
class RowDecoder {
public:
    RowDecoder(Context& context, const ComputePipeline& pipeline, const SlicedSet& set)
        : context_(context), pipeline_(pipeline), buffers_{Upload(std::as_bytes(std::span(&set.constants, 1)),
                                                                  BufferKind::Uniform),
                                                           Upload(set.buffer, BufferKind::Storage),
                                                           Upload(set.weights, BufferKind::Storage)} {}

    std::vector<float> Decode(const Push& push) {
        std::vector<float> outputs(16 * static_cast<std::size_t>(push.rect.width * push.rect.height), 77.0f);
        auto results =
            context_.CreateBuffer(outputs.size() * 4, BufferKind::Storage, BufferMemory::HostVisible);
        REQUIRE_MESSAGE(results.has_value(), std::string(results.error().GetText()));
        REQUIRE(context_.Write(*results, 0, std::as_bytes(std::span(outputs)))); // what no texel leaves
        const BoundBuffer bound[] = {{0, &buffers_[0]}, {1, &buffers_[1]}, {2, &buffers_[2]}, {3, &*results}};
        DispatchRequest request;
        request.pipeline = &pipeline_;
        request.buffers = bound;
        request.pushConstants = std::as_bytes(std::span(&push, 1));
        request.groups[0] = static_cast<std::uint32_t>((outputs.size() / 16 + 63) / 64);
        const auto timing = context_.Dispatch(request);
        REQUIRE_MESSAGE(timing.has_value(), std::string(timing.error().GetText()));
        REQUIRE(context_.Read(*results, 0, std::as_writable_bytes(std::span(outputs))));
        return outputs;
    }

private:
    Buffer Upload(std::span<const std::byte> bytes, BufferKind kind) {
        auto buffer = context_.CreateBuffer(bytes, kind, BufferMemory::DeviceLocal);
        REQUIRE_MESSAGE(buffer.has_value(), std::string(buffer.error().GetText()));
        return std::move(*buffer);
    }

    Context& context_;
    const ComputePipeline& pipeline_;
    std::array<Buffer, 3> buffers_;
};

using Pipelines = std::map<int, std::array<ComputePipeline, 2>>; // by network: GLSL, HLSL

const std::array<ComputePipeline, 2>& GetPipelines(Context& context, Pipelines& pipelines, int network) {
    constexpr BufferSlot kSlots[] = {{0, BufferKind::Uniform},
                                     {1, BufferKind::Storage},
                                     {2, BufferKind::Storage},
                                     {3, BufferKind::Storage}};
    if (!pipelines.contains(network)) {
        const std::string defines = "NETWORK_VERSION=" + std::to_string(network) + " NTC_MATH=1";
        const auto make = [&](Expected<std::span<const std::uint32_t>> words) {
            REQUIRE_MESSAGE(words.has_value(), std::string(words.error().GetText()));
            auto pipeline = context.CreateComputePipeline(*words, kSlots, sizeof(Push));
            REQUIRE_MESSAGE(pipeline.has_value(), std::string(pipeline.error().GetText()));
            return std::move(*pipeline);
        };
        pipelines.emplace(network,
                          std::array{make(slice_shaders::FindShader("SliceTexels.comp", defines)),
                                     make(slice_shaders_hlsl::FindShader("SliceTexels.hlsl", defines))});
    }
    return pipelines.at(network);
}

/// Every mip of every slice of a set, three ways; returns the texels compared.
std::size_t CheckSet(Context& context, Pipelines& pipelines, std::optional<GpuDecoder>& ordinary,
                     const SlicedSet& set) {
    std::size_t texels = 0;
    const auto& pair = GetPipelines(context, pipelines, set.metadata.GetNetworkVersion());
    RowDecoder glsl(context, pair[0], set);
    RowDecoder hlsl(context, pair[1], set);
    for (std::size_t i = 0; i < set.slices.size(); ++i) {
        const SliceDesc& slice = set.slices[i];
        INFO("slice " << ToText(slice));
        const DecodeSource source{&set.sliceConstants[i], set.sliceLatents[i], set.weights,
                                  set.metadata.GetNetworkVersion()};
        if (ordinary) {
            REQUIRE(ordinary->SetSource(source));
        } else {
            auto made = GpuDecoder::Create(context, source);
            REQUIRE_MESSAGE(made.has_value(), std::string(made.error().GetText()));
            ordinary.emplace(std::move(*made));
        }
        for (int k = 0; k < slice.numMips; ++k) {
            const int mip = slice.firstMip + k;
            const Rect held = GetHeldTexels(set.metadata, slice, k);
            if (held.width == 0 || held.height == 0)
                continue;
            CAPTURE(mip);
            const int image = set.metadata.GetColorMips()[static_cast<std::size_t>(mip)].neuralMip;
            const Push push{held, mip,
                            static_cast<std::uint32_t>(i) * NTC_MAX_NEURAL_MIPS +
                                static_cast<std::uint32_t>(image)};
            std::vector<float> outputs(16 * static_cast<std::size_t>(held.width * held.height));
            const auto timing = ordinary->Decode(mip, held, {}, outputs);
            REQUIRE_MESSAGE(timing.has_value(), std::string(timing.error().GetText()));
            CHECK(CountDifferent(set, mip, held, outputs) == 0);
            CHECK(CountDifferent(set, mip, held, glsl.Decode(push)) == 0);
            CHECK(CountDifferent(set, mip, held, hlsl.Decode(push)) == 0);
            texels += outputs.size() / 16;
        }
    }
    return texels;
}

} // namespace

TEST_CASE("slices on the device: any texel of any slice has the bits of the whole set") {
    OPENNTC_REQUIRE_DEVICE(context);
    const std::uint64_t seed = openntc::test::GetTestSeed();
    MESSAGE("OPENNTC_TEST_SEED=" << seed);
    SliceRandom random(seed);
    Pipelines pipelines;
    std::optional<GpuDecoder> ordinary;
    std::size_t texels = 0;
    for (int i = 0; i < kSets; ++i) {
        std::string text;
        const SlicedSet set = MakeSet(random, text);
        INFO("OPENNTC_TEST_SEED=" << seed << ": " << text);
        texels += CheckSet(*context, pipelines, ordinary, set);
    }
    MESSAGE("compared " << texels << " texels");
    CHECK(texels > 0);
    CHECK(context->GetValidationLog().errors.empty());
}

TEST_CASE("slices on the device: an absent row and a mip that does not exist write nothing") {
    OPENNTC_REQUIRE_DEVICE(context);
    SliceRandom random(1);
    std::string text;
    const SlicedSet set = MakeSet(random, text);
    Pipelines pipelines;
    const auto& pair = GetPipelines(*context, pipelines, set.metadata.GetNetworkVersion());
    const std::uint32_t absent = NTC_MAX_NEURAL_MIPS - 1; // sets of this size have fewer latent images
    REQUIRE(set.metadata.GetLatentImages().size() < NTC_MAX_NEURAL_MIPS);
    for (const ComputePipeline& pipeline : pair) {
        RowDecoder decoder(*context, pipeline, set);
        for (const Push& push :
             {Push{{0, 0, 1, 1}, 0, absent}, Push{{0, 0, 1, 1}, set.metadata.GetDesc().mips, 0},
              Push{{0, 0, 1, 1}, -1, 0}}) {
            for (const float value : decoder.Decode(push))
                CHECK(value == 77.0f);
        }
    }
    CHECK(context->GetValidationLog().errors.empty());
}
