// SPDX-License-Identifier: MIT
// Latents of generations 2 and 3 in a texture: every input inside the interval that the device's filter leaves, everything
// else bit for bit, outputs those of the network on the inputs that were read; mistakes are told.
#include "shader/TestDevice.h"
#include "shader/latents/LatentInterval.h"
#include "support/DeviceBits.h"

#include "openntc/Inference.h"
#include "openntc/MathModes.h"

#include "latent_hlsl.h"
#include "latent_shaders.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

using namespace openntc;
using namespace openntc::harness;
using namespace openntc_tests;
using decode_test::LatentMipSet;
using decode_test::LatentMipShape;

namespace {

constexpr std::size_t kWords = 64;
constexpr int kOutside = 3; // texels beyond every edge of a mip: they wrap

struct Push {
    int left, top, width, height, mip;
};

/// The set's latents as a texture, or nothing after printing why.
std::optional<Image> MakeTexture(Context& context, const LatentMipSet& set, ImageFormat format) {
    const unsigned size = set.GetGridSize(0);
    auto image = context.CreateImageArray(format, size & 0xFFFFu, size >> 16,
                                          static_cast<std::uint32_t>(set.GetShape().features / 4),
                                          static_cast<std::uint32_t>(set.GetLatentMips()));
    if (!image && image.error().GetStatus() == Status::Unsupported) {
        std::printf("SKIP: %s\n", image.error().GetText());
        return std::nullopt;
    }
    REQUIRE_MESSAGE(image.has_value(), std::string(image.error().GetText()));
    for (int mip = 0; mip < set.GetLatentMips(); ++mip) {
        const auto written = context.Write(*image, set.GetLatentBytes(mip), static_cast<std::uint32_t>(mip));
        REQUIRE_MESSAGE(written.has_value(), std::string(written.error().GetText()));
    }
    return std::move(*image);
}

enum class Language { GLSL, HLSL };

/// Records of LatentTexels.comp, or of its HLSL twin.
class TextureRunner {
public:
    TextureRunner(Context& context, const LatentMipSet& set, const Image& image, int math,
                  Language language = Language::GLSL)
        : context_(context), image_(image) {
        const DecodeSource source =
            set.GetSource(math == NTC_MATH_FP8 ? DecodeWeights::FP8 : DecodeWeights::Int8);
        const std::string defines =
            "NTC_LATENT_FETCH=2 NETWORK_VERSION=" + std::to_string(source.networkVersion) +
            " NTC_MATH=" + std::to_string(math);
        const auto spirv = language == Language::GLSL
                               ? latent_shaders::FindShader("LatentTexels.comp", defines)
                               : latent_hlsl::FindShader("LatentTexels.comp.hlsl", defines);
        REQUIRE_MESSAGE(spirv.has_value(), std::string(spirv.error().GetText()));
        static constexpr BufferSlot kSlots[] = {{0, BufferKind::Uniform},
                                                {1, BufferKind::FilteredTexture},
                                                {2, BufferKind::Storage},
                                                {3, BufferKind::Storage}};
        auto pipeline = context.CreateComputePipeline(*spirv, kSlots, sizeof(Push));
        REQUIRE_MESSAGE(pipeline.has_value(), std::string(pipeline.error().GetText()));
        pipeline_ = std::move(*pipeline);
        constants_ = MakeBuffer(std::as_bytes(std::span(source.constants, 1)), BufferKind::Uniform);
        weights_ = MakeBuffer(source.weights, BufferKind::Storage);
    }

    std::vector<std::uint32_t> Run(const Push& push) {
        const auto texels = static_cast<std::uint32_t>(push.width * push.height);
        std::vector<std::uint32_t> words(kWords * texels, 0xDEADBEEFu);
        Buffer results = MakeBuffer(std::as_bytes(std::span(words)), BufferKind::Storage);
        const BoundBuffer bound[] = {{0, &constants_}, {2, &weights_}, {3, &results}};
        const BoundImage images[] = {{1, &image_}};
        DispatchRequest request;
        request.pipeline = &pipeline_;
        request.buffers = bound;
        request.images = images;
        request.pushConstants = std::as_bytes(std::span(&push, 1));
        request.groups[0] = (texels + 31) / 32;
        const auto timing = context_.Dispatch(request);
        REQUIRE_MESSAGE(timing.has_value(), std::string(timing.error().GetText()));
        REQUIRE(context_.Read(results, 0, std::as_writable_bytes(std::span(words))));
        return words;
    }

private:
    Buffer MakeBuffer(std::span<const std::byte> bytes, BufferKind kind) {
        auto buffer = context_.CreateBuffer(bytes, kind, BufferMemory::HostVisible);
        REQUIRE_MESSAGE(buffer.has_value(), std::string(buffer.error().GetText()));
        return std::move(*buffer);
    }

    Context& context_;
    const Image& image_;
    ComputePipeline pipeline_;
    Buffer constants_, weights_;
};

/// What rounding may do to q on the way to a mode's number: twice in binary32.
constexpr double kRounding = 0x1p-23;

/// What a maths mode makes of a latent q: it grows with q.
double Quantize(int network, int math, double q) {
    if (math == NTC_MATH_INT8)
        return network == NTC_NETWORK_GENERATION_2 ? std::trunc(255 * q - 127.5)
                                                   : std::floor(255 * q + 0.0625) - 128;
    if (math == NTC_MATH_FP8)
        return static_cast<double>(
            shader::NtcRoundToE4M3(shader::NtcRoundToHalf(static_cast<float>(2 * q - 1))));
    const double scaled = 255 * q - (network == NTC_NETWORK_GENERATION_3 ? 128.0 : 127.5);
    return math == NTC_MATH_FP16
               ? static_cast<double>(shader::NtcRoundToHalf(static_cast<float>(scaled / 128)))
               : scaled;
}

/// Input `i` of a record.
double GetInput(const std::uint32_t* record, int math, int i) {
    if (math == NTC_MATH_INT8)
        return static_cast<std::int8_t>(record[i / 4] >> (8 * (i % 4)) & 0xFFu);
    return static_cast<double>(std::bit_cast<float>(record[i]));
}

/// Outputs of the C++ build of the network on a record's inputs.
void EvaluateNetwork(const DecodeSource& source, int math, const std::uint32_t* record, float* outputs) {
    const shader::NtcBuffer weights = {source.weights.data(), source.weights.size()};
    const shader::NtcLayerOffsets layers = shader::NtcGetLayerOffsets(*source.constants);
    float values[NTC_MAX_CHANNELS] = {};
    if (math == NTC_MATH_INT8) {
        shader::uint words[NTC_MAX_INPUT_WORDS] = {};
        std::copy_n(record, 12, words);
        shader::NtcEvaluateNetwork(source.networkVersion, math, weights, 0, layers, words, values);
    } else {
        float inputs[NTC_MAX_INPUTS] = {};
        std::memcpy(inputs, record, 48 * 4);
        if (math == NTC_MATH_FP8)
            shader::NtcEvaluateE4M3Network(source.networkVersion, weights, 0, layers, inputs, values);
        else if (math == NTC_MATH_FP16)
            shader::NtcEvaluateHalfNetwork(source.networkVersion, weights, 0, layers, inputs, values);
        else
            shader::NtcEvaluateRealNetwork(source.networkVersion, weights, 0, layers, inputs, values);
    }
    std::copy_n(values, NTC_MAX_CHANNELS, outputs);
}

/// The inputs of the byte buffer's filter, as a record has them.
std::vector<std::uint32_t> PrepareFromBuffer(const DecodeSource& source, int math, int x, int y, int mip) {
    const shader::NtcBuffer latents = {source.latents.data(), source.latents.size()};
    const shader::int2 texel(x, y);
    std::vector<std::uint32_t> record(kWords);
    if (math == NTC_MATH_INT8) {
        shader::uint words[NTC_MAX_INPUT_WORDS] = {};
        REQUIRE(shader::NtcPrepareNetworkInputs(source.networkVersion, *source.constants, latents, 0, texel,
                                                mip, words));
        std::copy_n(words, 12, record.begin());
    } else {
        float inputs[NTC_MAX_INPUTS] = {};
        REQUIRE(shader::NtcPrepareRealInputsFrom(source.networkVersion, math,
                                                 shader::NtcGetMip(*source.constants, mip), latents, 0, texel,
                                                 inputs));
        std::memcpy(record.data(), inputs, 48 * 4);
    }
    return record;
}

struct Findings {
    std::size_t latents = 0, outside = 0, otherInputs = 0, outputs = 0;
    double furthest = 0; ///< of a latent from what the byte buffer's filter gives, in its mode's numbers
};

int Wrap(int i, int size) {
    return (i % size + size) % size;
}

/// All texels of a mip and what surrounds it.
Push GetMipPush(const NtcTextureSetConstants& constants, int mip) {
    return {-kOutside, -kOutside, shader::NtcGetMipSize(constants.imageWidth, mip) + 2 * kOutside,
            shader::NtcGetMipSize(constants.imageHeight, mip) + 2 * kOutside, mip};
}

/// One mip and what surrounds it.
void CheckMip(const LatentMipSet& set, const LatentSampler& sampler, TextureRunner& runner, int math, int mip,
              Findings& findings) {
    const DecodeSource source =
        set.GetSource(math == NTC_MATH_FP8 ? DecodeWeights::FP8 : DecodeWeights::Int8);
    const NtcTextureSetConstants& constants = *source.constants;
    const int width = shader::NtcGetMipSize(constants.imageWidth, mip);
    const int height = shader::NtcGetMipSize(constants.imageHeight, mip);
    const Push push = GetMipPush(constants, mip);
    const std::vector<std::uint32_t> words = runner.Run(push);
    for (int i = 0; i < push.width * push.height; ++i) {
        const std::uint32_t* record = words.data() + kWords * static_cast<std::size_t>(i);
        const int x = push.left + i % push.width, y = push.top + i / push.width;
        const std::vector<std::uint32_t> expected = PrepareFromBuffer(source, math, x, y, mip);
        for (int k = 0; k < 48; ++k) {
            const double value = GetInput(record, math, k), own = GetInput(expected.data(), math, k);
            if (k >= 32 || k % 16 >= set.GetShape().features) {
                findings.otherInputs += value != own;
                continue;
            }
            const LatentInterval interval =
                sampler.GetInterval({constants.colorMips[mip].neuralMip + k / 16, k % 16,
                                     static_cast<double>(shader::NtcTexelCenter(Wrap(x, width), width)),
                                     static_cast<double>(shader::NtcTexelCenter(Wrap(y, height), height))});
            const int network = source.networkVersion;
            findings.outside += value < Quantize(network, math, interval.low - kRounding) ||
                                value > Quantize(network, math, interval.high + kRounding);
            findings.furthest = std::max(findings.furthest, std::fabs(value - own));
            ++findings.latents;
        }
        float outputs[NTC_MAX_CHANNELS];
        EvaluateNetwork(source, math, record, outputs);
        for (std::size_t c = 0; c < NTC_MAX_CHANNELS; ++c)
            findings.outputs +=
                GetDeviceBits(std::bit_cast<float>(record[48 + c])) != GetDeviceBits(outputs[c]);
    }
}

Findings CheckSet(const LatentMipSet& set, const LatentSampler& sampler, TextureRunner& runner, int math) {
    Findings findings;
    for (int mip = 0; mip < set.GetShape().mips; ++mip)
        CheckMip(set, sampler, runner, math, mip, findings);
    return findings;
}

void CheckGood(const Findings& findings) {
    CHECK(findings.latents > 0);
    CHECK(findings.outside == 0);
    CHECK(findings.otherInputs == 0);
    CHECK(findings.outputs == 0);
}

} // namespace

TEST_CASE("latents in a texture: inputs inside the filter's interval, outputs those of the network") {
    OPENNTC_REQUIRE_DEVICE(context);
    const unsigned bits = context->GetDevice().subTexelPrecisionBits;
    REQUIRE(bits >= 4); // Vulkan's least
    for (const ImageFormat format : {ImageFormat::ARGB4, ImageFormat::BGRA4}) {
        CAPTURE(static_cast<int>(format));
        Findings total;
        for (const LatentMipShape& shape : decode_test::kLatentMipShapes) {
            CAPTURE(shape.seed);
            const LatentMipSet set(shape);
            const std::optional<Image> image = MakeTexture(*context, set, format);
            if (!image)
                break;
            TextureRunner runner(*context, set, *image, NTC_MATH_INT8);
            const Findings findings = CheckSet(set, LatentSampler(set, bits), runner, NTC_MATH_INT8);
            CheckGood(findings);
            total.latents += findings.latents;
            total.furthest = std::max(total.furthest, findings.furthest);
        }
        if (total.latents > 0)
            std::printf(
                "latents in a texture, %u bits between texels: %zu inputs, at most %g of 255 steps from "
                "the byte buffer's\n",
                bits, total.latents, total.furthest);
    }
}

TEST_CASE("latents in a texture: all maths modes, and the same words of HLSL") {
    OPENNTC_REQUIRE_DEVICE(context);
    for (const LatentMipShape& shape : {LatentMipShape{21, NTC_NETWORK_GENERATION_2, 19, 12, 3, 3, 8},
                                        LatentMipShape{22, NTC_NETWORK_GENERATION_3, 21, 10, 3, 2, 16}}) {
        LatentMipSet set(shape);
        const std::optional<Image> image = MakeTexture(*context, set, ImageFormat::BGRA4);
        if (!image)
            return;
        for (const int math : {NTC_MATH_INT8, NTC_MATH_FP8, NTC_MATH_FP16, NTC_MATH_FP32}) {
            CAPTURE(math);
            const LatentSampler sampler(set, context->GetDevice().subTexelPrecisionBits);
            TextureRunner glsl(*context, set, *image, math);
            TextureRunner hlsl(*context, set, *image, math, Language::HLSL);
            CheckGood(CheckSet(set, sampler, glsl, math));
            CheckGood(CheckSet(set, sampler, hlsl, math));
            // A GPU may filter the same coordinates another way where a shader is another one.
            for (int mip = 0; mip < shape.mips && context->GetDevice().isCpu; ++mip) {
                const Push push = GetMipPush(set.GetConstants(), mip);
                CHECK(hlsl.Run(push) == glsl.Run(push));
            }
        }
    }
}

TEST_CASE("latents in a texture: flat ones are the byte buffer's bits, whatever the filter's precision") {
    OPENNTC_REQUIRE_DEVICE(context);
    for (const int network : {NTC_NETWORK_GENERATION_2, NTC_NETWORK_GENERATION_3}) {
        LatentMipSet set({31, network, 8, 8, 2, 4, 8});
        for (unsigned code = 0; code < 16; ++code) {
            CAPTURE(code);
            std::fill(set.GetLatents().begin(), set.GetLatents().end(), static_cast<std::byte>(17 * code));
            const std::optional<Image> image = MakeTexture(*context, set, ImageFormat::BGRA4);
            if (!image)
                return;
            TextureRunner runner(*context, set, *image, NTC_MATH_INT8);
            const Findings findings = CheckSet(set, LatentSampler(set, 8), runner, NTC_MATH_INT8);
            CheckGood(findings);
            CHECK(findings.furthest == 0);
        }
    }
}

TEST_CASE("latents in a texture: mistakes lie outside of the interval, sliced latents are refused") {
    OPENNTC_REQUIRE_DEVICE(context);
    LatentMipSet set({41, NTC_NETWORK_GENERATION_3, 40, 24, 5, 4, 12});
    const std::optional<Image> image = MakeTexture(*context, set, ImageFormat::BGRA4);
    if (!image)
        return;
    const unsigned bits = context->GetDevice().subTexelPrecisionBits;
    TextureRunner runner(*context, set, *image, NTC_MATH_INT8);
    CheckGood(CheckSet(set, LatentSampler(set, bits), runner, NTC_MATH_INT8));
    for (const LatentMistake mistake :
         {LatentMistake::Clamp, LatentMistake::SwappedLayers, LatentMistake::OneLatentMip,
          LatentMistake::TexelCorners, LatentMistake::ReversedBits, LatentMistake::HalfAMip}) {
        CAPTURE(static_cast<int>(mistake));
        CHECK(CheckSet(set, LatentSampler(set, bits, mistake), runner, NTC_MATH_INT8).outside > 0);
    }
    // Nothing is written where the constants describe a slice.
    set.GetConstants().highResNeuralMips[0].sliceWidthHeight -= 1;
    TextureRunner sliced(*context, set, *image, NTC_MATH_INT8);
    CHECK(sliced.Run({0, 0, 1, 1, 0})[0] == 0xDEADBEEFu);
}
