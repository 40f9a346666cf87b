// SPDX-License-Identifier: MIT
// Every way to fetch weights with every network, on the device against the C++ reference decoder: the same bits,
// subnormal numbers taken as zero. One network runs the forms with every number of texels and dot product, and with
// the half epilogue; the others, whose layers differ in their sizes only, one form of each way. Software drivers spend
// seconds on compiling each.
#include "shader/TestDevice.h"
#include "support/DeviceBits.h"

#include "fetch_direct.h"
#include "fetch_half_direct.h"
#include "fetch_half_subgroup.h"
#include "fetch_half_uniform.h"
#include "fetch_subgroup.h"
#include "fetch_subgroup_default.h"
#include "fetch_uniform.h"

#include "unit/decode/LatentMipSets.h"

#include "openntc/MathModes.h"
#include "openntc/WeightFetch.h"
#include "openntc/decode/ReferenceDecoder.h"
#include "openntc/inference/Synthesis.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

using namespace openntc;
using namespace openntc::harness;

namespace {

constexpr int kWidth = 28; // neither a multiple of the group nor of the texels per invocation
constexpr int kHeight = 19;

using Find = Expected<std::span<const std::uint32_t>> (*)(std::string_view, std::string_view);

struct Form {
    Find find;
    Find findHalf;
    const char* defines;
    int texels;
    BufferKind weights;
    bool everyNetwork;
};

constexpr Form kForms[] = {
    {fetch_direct::FindShader, fetch_half_direct::FindShader, "NTC_WIDE_WEIGHT_LOADS=0", 2,
     BufferKind::Storage, false},
    {fetch_direct::FindShader, fetch_half_direct::FindShader, "NTC_WIDE_WEIGHT_LOADS=1", 1,
     BufferKind::Storage, false},
    {fetch_direct::FindShader, fetch_half_direct::FindShader, "NTC_WIDE_WEIGHT_LOADS=1", 2,
     BufferKind::Storage, true},
    {fetch_uniform::FindShader, fetch_half_uniform::FindShader, "NTC_WEIGHT_FETCH=2", 1, BufferKind::Uniform,
     true},
    {fetch_uniform::FindShader, fetch_half_uniform::FindShader, "NTC_WEIGHT_FETCH=2", 2, BufferKind::Uniform,
     false},
    {fetch_subgroup::FindShader, fetch_half_subgroup::FindShader,
     "NTC_WEIGHT_FETCH=3 NTC_SUBGROUP_DECODES_ONE_SET=1 NTC_FLOAT_DOT=0 NTC_WIDE_WEIGHT_LOADS=0", 1,
     BufferKind::Storage, false},
    {fetch_subgroup::FindShader, fetch_half_subgroup::FindShader,
     "NTC_WEIGHT_FETCH=3 NTC_SUBGROUP_DECODES_ONE_SET=1 NTC_FLOAT_DOT=0 NTC_WIDE_WEIGHT_LOADS=1", 2,
     BufferKind::Storage, false},
    {fetch_subgroup::FindShader, fetch_half_subgroup::FindShader,
     "NTC_WEIGHT_FETCH=3 NTC_SUBGROUP_DECODES_ONE_SET=1 NTC_FLOAT_DOT=1 NTC_WIDE_WEIGHT_LOADS=0", 1,
     BufferKind::Storage, false},
    {fetch_subgroup::FindShader, fetch_half_subgroup::FindShader,
     "NTC_WEIGHT_FETCH=3 NTC_SUBGROUP_DECODES_ONE_SET=1 NTC_FLOAT_DOT=1 NTC_WIDE_WEIGHT_LOADS=0", 2,
     BufferKind::Storage, false},
    {fetch_subgroup_default::FindShader, fetch_half_subgroup::FindShader,
     "NTC_WEIGHT_FETCH=3 NTC_SUBGROUP_DECODES_ONE_SET=1 NTC_FLOAT_DOT=1 NTC_WIDE_WEIGHT_LOADS=1", 1,
     BufferKind::Storage, true},
    {fetch_subgroup_default::FindShader, fetch_half_subgroup::FindShader,
     "NTC_WEIGHT_FETCH=3 NTC_SUBGROUP_DECODES_ONE_SET=1 NTC_FLOAT_DOT=1 NTC_WIDE_WEIGHT_LOADS=1", 2,
     BufferKind::Storage, true},
};

/// Channels 0, 5 and 10 are sRGB, 15 HLG, the others linear.
constexpr std::uint32_t kColorSpaces = 0x80100401;

/// A set of two mips and 16 channels with Int8 weights.
class SourceSet {
public:
    virtual ~SourceSet() = default;
    virtual DecodeSource GetSource() const = 0;
};

class GridSet final : public SourceSet {
public:
    explicit GridSet(int network) {
        SynthesisDesc synthesis;
        synthesis.seed = static_cast<std::uint32_t>(network);
        synthesis.desc = {kWidth, kHeight, 16, 2};
        synthesis.networkVersion = network;
        synthesis.shape = {4, 4 * network, 16, 4, 4};
        synthesis.channelColorSpaces = kColorSpaces;
        MemoryStream stream;
        REQUIRE(SynthesizeTextureSet(stream, synthesis));
        set_.emplace(std::vector<std::byte>(stream.GetBytes().begin(), stream.GetBytes().end()));
    }
    DecodeSource GetSource() const override { return set_->GetSource(DecodeWeights::Int8); }

private:
    std::optional<decode_test::ModeSet> set_;
};

class MipSet final : public SourceSet {
public:
    explicit MipSet(int network) : set_({3, network, kWidth, kHeight, 2, 3, 12}) {
        set_.GetConstants().channelColorSpaces = kColorSpaces;
    }
    DecodeSource GetSource() const override { return set_.GetSource(DecodeWeights::Int8); }

private:
    decode_test::LatentMipSet set_;
};

std::unique_ptr<SourceSet> MakeSourceSet(int network) {
    if (GetGeneration(network) > 1)
        return std::make_unique<MipSet>(network);
    return std::make_unique<GridSet>(network);
}

/// `outputs` in linear light; each texel of an invocation must hold numbers that conversion changes.
void CheckLinear(const std::vector<float>& outputs, const std::vector<float>& stored,
                 const std::vector<float>& linear, int texelsPerInvocation) {
    std::vector<int> changed(static_cast<std::size_t>(texelsPerInvocation));
    int different = 0;
    for (std::size_t i = 0; i < linear.size(); ++i) {
        if ((kColorSpaces >> 2 * (i % 16) & 3u) == NTC_COLOR_SPACE_LINEAR) {
            different += openntc_tests::GetDeviceBits(outputs[i]) != openntc_tests::GetDeviceBits(linear[i]);
            continue;
        }
        if (!std::isfinite(linear[i]))
            continue;
        // Vulkan's precision of pow and exp: effects/effects_test.cpp derives it.
        const float bound = std::ldexp(std::fabs(linear[i]), -14) + 1e-6f;
        different += !(std::fabs(outputs[i] - linear[i]) <= bound);
        if (std::fabs(stored[i] - linear[i]) > bound)
            ++changed[i / 16 % changed.size()];
    }
    CHECK(different == 0);
    for (const int count : changed)
        CHECK(count > 0);
}

} // namespace

TEST_CASE("every way to fetch weights decodes the reference's bits") {
    OPENNTC_REQUIRE_DEVICE(context);
    std::size_t compared = 0;
    // Medium differs from its neighbours in constants only.
    for (const int network :
         {NTC_NETWORK_SMALL, NTC_NETWORK_LARGE, NTC_NETWORK_XLARGE, NTC_NETWORK_GENERATION_3}) {
        const std::unique_ptr<SourceSet> set = MakeSourceSet(network);
        const DecodeSource source = set->GetSource();
        const auto constantBuffer = context->CreateBuffer(std::as_bytes(std::span(source.constants, 1)),
                                                          BufferKind::Uniform, BufferMemory::DeviceLocal);
        const auto latentBuffer =
            context->CreateBuffer(source.latents, BufferKind::Storage, BufferMemory::DeviceLocal);
        const auto results = context->CreateBuffer(std::uint64_t{kWidth} * kHeight * 64, BufferKind::Storage,
                                                   BufferMemory::HostVisible);
        REQUIRE(constantBuffer);
        REQUIRE(latentBuffer);
        REQUIRE(results);
        for (const DecodeMath math : {DecodeMath::Int8, DecodeMath::Int8Half}) {
            if (math == DecodeMath::Int8Half && network != NTC_NETWORK_LARGE)
                continue;
            std::vector<float> reference(std::size_t{kWidth} * kHeight * 16);
            REQUIRE(DecodeReference(source, 0, {0, 0, kWidth, kHeight}, {.math = math}, reference));
            std::vector<float> linear(reference.size());
            REQUIRE(DecodeReference(source, 0, {0, 0, kWidth, kHeight},
                                    {.math = math, .convertToLinear = true}, linear));
            for (const Form& form : kForms) {
                if (!form.everyNetwork && network != NTC_NETWORK_LARGE)
                    continue;
                const std::string defines =
                    "NETWORK_VERSION=" + std::to_string(network) + " NTC_MATH=" +
                    std::to_string(math == DecodeMath::Int8 ? NTC_MATH_INT8 : NTC_MATH_INT8_HALF) +
                    " NTC_TEXELS_PER_INVOCATION=" + std::to_string(form.texels) + " " + form.defines;
                CAPTURE(defines);
                const auto spirv =
                    (math == DecodeMath::Int8 ? form.find : form.findHalf)("FetchTexels.comp", defines);
                REQUIRE_MESSAGE(spirv.has_value(), std::string(spirv.error().GetText()));
                const auto weightBuffer =
                    context->CreateBuffer(source.weights, form.weights, BufferMemory::DeviceLocal);
                REQUIRE(weightBuffer);
                const BufferSlot slots[] = {{0, BufferKind::Uniform},
                                            {1, BufferKind::Storage},
                                            {2, form.weights},
                                            {3, BufferKind::Storage}};
                const auto pipeline = context->CreateComputePipeline(*spirv, slots, 16);
                REQUIRE_MESSAGE(pipeline.has_value(), std::string(pipeline.error().GetText()));
                const BoundBuffer buffers[] = {
                    {0, &*constantBuffer}, {1, &*latentBuffer}, {2, &*weightBuffer}, {3, &*results}};
                const std::uint32_t perGroup = 64u * static_cast<std::uint32_t>(form.texels);
                std::vector<float> outputs(reference.size());
                const auto dispatch = [&](std::uint32_t mip, std::uint32_t isLinear) {
                    const std::uint32_t push[] = {kWidth, kHeight, mip, isLinear};
                    const auto dispatched =
                        context->Dispatch({&*pipeline,
                                           buffers,
                                           std::as_bytes(std::span(push)),
                                           {(kWidth * kHeight + perGroup - 1) / perGroup, 1, 1}});
                    REQUIRE_MESSAGE(dispatched.has_value(), std::string(dispatched.error().GetText()));
                    REQUIRE(context->Read(*results, 0, std::as_writable_bytes(std::span(outputs))));
                };
                dispatch(0, 0);
                std::size_t different = 0;
                for (std::size_t i = 0; i < outputs.size(); ++i)
                    different += openntc_tests::GetDeviceBits(outputs[i]) !=
                                 openntc_tests::GetDeviceBits(reference[i]);
                CHECK(different == 0);
                // A mip that is not there: sampling says so and leaves every texel alone.
                dispatch(2, 0);
                CHECK(std::all_of(outputs.begin(), outputs.end(), [](float x) { return x == 78.0f; }));
                dispatch(0, 1);
                CheckLinear(outputs, reference, linear, form.texels);
                compared += outputs.size() / 16;
            }
        }
    }
    MESSAGE("texels compared: " << compared);
}
