// SPDX-License-Identifier: MIT
// The pass DecompressToTextures on the device, in GLSL (with the form that the device's key asks for) and in HLSL: every
// texel of every output against the reference decoder, and the steps behind it against models of their own.
#include "shader/TestDevice.h"
#include "shader/passes/PassDevice.h"
#include "support/DeviceBits.h"
#include "unit/decode/ModeSets.h"

#include "decompress_hlsl_shaders.h"
#include "decompress_shaders.h"

#include "openntc/decode/ReferenceDecoder.h"
#include "openntc/inference/PartialInference.h"
#include "openntc/passes/DecompressTexel.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

using namespace openntc;
using namespace openntc::harness;
using namespace openntc_tests;
using namespace passes_test;

namespace {

constexpr int kWidth = 45;
constexpr int kHeight = 38;
/// Colour spaces of the sixteen channels as stored: linear, sRGB and HLG side by side, also within an output.
constexpr std::uint32_t kMixedSpaces = 0x24u | 0x1u << 8 | 0x2u << 14 | 0x1u << 20 | 0x2u << 30;

ColorSpace GetSpace(std::uint32_t spaces, int channel) {
    return static_cast<ColorSpace>(spaces >> (2 * channel) & 3u);
}

/// All channels of a mip, as stored.
std::vector<float> DecodeMip(const DecodeSource& source, int mip) {
    const Rect rect = {0, 0, std::max(source.constants->imageWidth >> mip, 1),
                       std::max(source.constants->imageHeight >> mip, 1)};
    std::vector<float> outputs(static_cast<std::size_t>(rect.width * rect.height) * 16);
    const auto result =
        DecodeReference(source, mip, rect, {.math = DecodeMath::Int8, .convertToLinear = false}, outputs);
    REQUIRE_MESSAGE(result.has_value(), std::string(result.error().GetText()));
    return outputs;
}

// --- models that share nothing with the shaders -------------------------------------------------------------------

std::uint32_t HashIndexModel(std::uint64_t index) {
    std::uint64_t a = index % 0x100000000u;
    const auto wrap = [](std::uint64_t x) { return x & 0xFFFFFFFFu; };
    a = wrap(wrap(a + 0x7ed55d16u) + a * 4096);
    a = (a ^ 0xc761c23cu) ^ a / 524288;
    a = wrap(wrap(a + 0x165667b1u) + a * 32);
    a = wrap(a + 0xd3a2646cu) ^ wrap(a * 512);
    a = wrap(wrap(a + 0xfd7046c5u) + a * 8);
    a = (a ^ 0xb55a4f09u) ^ a / 65536;
    return static_cast<std::uint32_t>(a);
}

std::uint32_t MurmurModel(std::uint32_t seed, std::uint32_t key) {
    std::uint32_t h = seed ^ std::rotl(key * 0xcc9e2d51u, 15) * 0x1b873593u;
    h = std::rotl(h, 13) * 5 + 0xe6546b64u;
    h ^= 4;
    h ^= h >> 16;
    h *= 0x85ebca6bu;
    h ^= h >> 13;
    h *= 0xc2b2ae35u;
    return h ^ h >> 16;
}

double ToLinearModel(double x, ColorSpace space) {
    if (space == ColorSpace::sRGB)
        return x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4);
    if (space == ColorSpace::HLG) {
        const double m = std::fabs(x);
        return std::copysign(m < 0.5 ? 4 * m * m : std::exp((m - 0.55991073) / 0.17883277) + 0.28466892, x);
    }
    return x;
}

double FromLinearModel(double e, ColorSpace space) {
    if (space == ColorSpace::sRGB)
        return e <= 0.0031308 ? 12.92 * e : 1.055 * std::pow(e, 1 / 2.4) - 0.055;
    if (space == ColorSpace::HLG) {
        const double m = std::fabs(e);
        return std::copysign(m < 1 ? 0.5 * std::sqrt(m) : 0.17883277 * std::log(m - 0.28466892) + 0.55991073,
                             e);
    }
    return e;
}

// --- shaders ------------------------------------------------------------------------------------------------------

struct Language {
    const char* name;
    ShaderLanguage language;
};
constexpr Language kLanguages[] = {{"GLSL", ShaderLanguage::Glsl}, {"HLSL", ShaderLanguage::Hlsl}};

SceneNeeds GetNeeds(const Context& context, ShaderLanguage language) {
    const DeviceInfo& device = context.GetDevice();
    SceneNeeds needs;
    needs.language = language;
    // HLSL's dot products need another compiler than glslang.
    needs.device.integerDotProduct =
        language == ShaderLanguage::Glsl && device.features.Has(Feature::IntegerDotProduct);
    needs.device.subgroupShuffle = device.hasSubgroupShuffle && device.subgroupSize >= 8;
    needs.device.isCpu = device.isCpu;
    return needs;
}

/// The shader that the key finds among those compiled.
std::span<const std::uint32_t> FindPass(const DecompressionPass& pass, const char* ownDefines) {
    const PermutationKey& key = pass.permutation.key;
    const auto shader =
        key.language == ShaderLanguage::Hlsl
            ? decompress_hlsl_shaders::FindCoveringShader("DecompressToTextures.hlsl", key, ownDefines)
            : decompress_shaders::FindCoveringShader("DecompressToTextures.comp", key, ownDefines);
    REQUIRE_MESSAGE(shader.has_value(), std::string(shader.error().GetText()));
    return shader->words;
}

std::span<const std::uint32_t> FindPass(const DecompressionPass& pass) {
    return FindPass(pass, "");
}

/// A set with given colour spaces of the stored channels, and its pass.
struct Fixture {
    decode_test::ModeSet set;
    NtcTextureSetConstants constants;
    DecodeSource source;
    PassDevice device;

    Fixture(Context& context, int version, std::uint32_t spaces)
        : set(decode_test::MakeModeSet(version, kWidth, kHeight)),
          constants(*set.GetSource(DecodeWeights::Int8).constants),
          source(set.GetSource(DecodeWeights::Int8)), device(context, source.latents, source.weights) {
        constants.channelColorSpaces = spaces;
        source.constants = &constants;
    }
    Fixture(const Fixture&) = delete;

    DecompressionPass Make(const DecompressionRequest& request, const SceneNeeds& needs) const {
        return Take(MakeDecompressionPass(set.GetMetadata(), constants, request, needs));
    }
};

/// Texels of `decoded` that an RGBA32F image shows otherwise; what the output lacks is 0 and 1.
std::size_t CountWrong(const std::vector<std::array<float, 4>>& image, int imageWidth,
                       const std::vector<float>& decoded, int mipWidth, const Rect& rect,
                       const TexelOffset& destination, const DecompressionOutput& output) {
    std::size_t wrong = 0;
    for (int y = 0; y < rect.height; ++y) {
        for (int x = 0; x < rect.width; ++x) {
            const auto& texel =
                image[static_cast<std::size_t>((destination.top + y) * imageWidth + destination.left + x)];
            const std::size_t from = static_cast<std::size_t>((rect.top + y) * mipWidth + rect.left + x) * 16;
            for (int k = 0; k < 4; ++k) {
                const float expected = k < output.numChannels
                                           ? decoded[from + static_cast<std::size_t>(output.firstChannel + k)]
                                           : (k == 3 ? 1.0f : 0.0f);
                wrong += GetDeviceBits(texel[static_cast<std::size_t>(k)]) != GetDeviceBits(expected) ? 1 : 0;
            }
        }
    }
    return wrong;
}

} // namespace

TEST_CASE("dither noise is the specification's") {
    struct Row {
        std::uint32_t index, hash, first, second, third;
    };
    constexpr Row kRows[] = {{0, 0x6b4ed927, 0xe5dee3c0, 0x2276f4dc, 0xd11f8d92},
                             {1, 0xb48681b6, 0x5d8c2647, 0xfe2aedf2, 0x85567c73},
                             {2, 0xe267b84c, 0xd194fb41, 0xe2cefce6, 0xbc4c2d6f},
                             {1023, 0xdedaf7c4, 0x8771eead, 0x06c62eb4, 0xc2b4e806},
                             {4096, 0x09c2008b, 0x5f4503a4, 0x7db63749, 0x83f2bbf3},
                             {123456789, 0xd9ab9e21, 0xf7cf8703, 0xcdd21200, 0xa7a68106}};
    for (const Row& row : kRows) {
        CAPTURE(row.index);
        CHECK(shader::NtcHashWord(row.index) == row.hash);
        CHECK(HashIndexModel(row.index) == row.hash);
        const std::uint32_t expected[] = {row.first, row.second, row.third};
        for (std::uint32_t k = 1; k <= 3; ++k) {
            CHECK(shader::NtcHashKey(row.hash, k) == expected[k - 1]);
            CHECK(MurmurModel(row.hash, k) == expected[k - 1]);
        }
    }
    CHECK(shader::NtcGetDitherSeed(glm::ivec2(23, 1), 1000) == 0xdedaf7c4u);
}

TEST_CASE("sixteen single-channel outputs: every texel of every mip is the decoder's, in both languages") {
    OPENNTC_REQUIRE_DEVICE(context);
    for (const int version : {NTC_NETWORK_SMALL, NTC_NETWORK_LARGE}) {
        CAPTURE(version);
        Fixture fixture(*context, version, kMixedSpaces);
        std::vector<DecompressionOutput> outputs(16);
        for (int c = 0; c < 16; ++c) {
            DecompressionOutput& output = outputs[static_cast<std::size_t>(c)];
            output.firstChannel = (5 * c + 3) % 16;
            output.rgbColorSpace =
                GetSpace(kMixedSpaces, output.firstChannel); // as stored: nothing is converted
        }
        for (const Language& language : kLanguages) {
            const std::string languageName = language.name;
            CAPTURE(languageName);
            for (int mip = 0; mip < fixture.constants.imageMips; ++mip) {
                CAPTURE(mip);
                const int width = std::max(kWidth >> mip, 1), height = std::max(kHeight >> mip, 1);
                const auto images = fixture.device.MakeImages(16, ImageFormat::RGBA32F, width, height);
                DecompressionRequest request;
                request.mip = mip;
                request.outputs = outputs;
                const DecompressionPass pass = fixture.Make(request, GetNeeds(*context, language.language));
                CHECK(pass.batchCount == 1);
                fixture.device.Run(pass, FindPass(pass), images);
                const std::vector<float> decoded = DecodeMip(fixture.source, mip);
                for (std::size_t o = 0; o < 16; ++o)
                    CHECK(CountWrong(fixture.device.ReadTexels(images[o]), width, decoded, width,
                                     {0, 0, width, height}, {0, 0}, outputs[o]) == 0);
            }
        }
    }
    CHECK(context->GetValidationLog().errors.empty());
}

TEST_CASE("rectangles at any position and offset write themselves and nothing else") {
    OPENNTC_REQUIRE_DEVICE(context);
    constexpr unsigned kSeed = 20261127;
    MESSAGE("seed " << kSeed);
    std::mt19937 random(kSeed);
    const auto pick = [&random](int low, int high) {
        return low + static_cast<int>(random() % static_cast<unsigned>(high - low + 1));
    };
    Fixture fixture(*context, NTC_NETWORK_SMALL, 0);
    constexpr int kImage = 70;
    const std::vector<std::byte> pattern(std::size_t{kImage * kImage} * 16, std::byte{0x3E});
    std::array<float, 4> untouched{};
    std::memcpy(untouched.data(), pattern.data(), 16);
    for (int i = 0; i < 24; ++i) {
        DecompressionRequest request;
        request.mip = pick(0, 2);
        const int width = kWidth >> request.mip, height = kHeight >> request.mip;
        Rect rect = {pick(0, width - 1), pick(0, height - 1), 1, 1};
        if (i > 2) { // single texels first
            rect.width = pick(1, width - rect.left);
            rect.height = pick(1, height - rect.top);
        }
        request.rect = rect;
        const TexelOffset destination = {pick(0, kImage - rect.width), pick(0, kImage - rect.height)};
        request.destination = destination;
        const DecompressionOutput output = {.firstChannel = pick(0, 13), .numChannels = 3};
        request.outputs = std::span(&output, 1);
        CAPTURE(i);
        const Language& language = kLanguages[i % 2];
        const auto images = fixture.device.MakeImages(1, ImageFormat::RGBA32F, kImage, kImage);
        REQUIRE(context->Write(images[0], pattern));
        const DecompressionPass pass = fixture.Make(request, GetNeeds(*context, language.language));
        fixture.device.Run(pass, FindPass(pass), images);
        auto texels = fixture.device.ReadTexels(images[0]);
        CHECK(CountWrong(texels, kImage, DecodeMip(fixture.source, request.mip), width, rect, destination,
                         output) == 0);
        for (int y = 0; y < rect.height; ++y)
            std::fill_n(texels.begin() + (destination.top + y) * kImage + destination.left, rect.width,
                        untouched);
        CHECK(std::ranges::all_of(texels, [&](const auto& texel) { return texel == untouched; }));
    }
    CHECK(context->GetValidationLog().errors.empty());
}

TEST_CASE("dither: the noise of texel and output, in batches too") {
    OPENNTC_REQUIRE_DEVICE(context);
    Fixture fixture(*context, NTC_NETWORK_SMALL, 0);
    std::vector<DecompressionOutput> outputs;
    for (int i = 0; i < 35; ++i) // three dispatches
        outputs.push_back({.firstChannel = i % 13,
                           .numChannels = 1 + i % 4,
                           .ditherScale = i == 3 ? 0.0f : (i % 2 == 0 ? 1.0f / 255.0f : 0.7f)});
    const Rect rect = {5, 9, 33, 21};
    const std::vector<float> decoded = DecodeMip(fixture.source, 0);
    for (const Language& language : kLanguages) {
        for (int batch = 0; batch < 3; ++batch) {
            CAPTURE(batch);
            DecompressionRequest request;
            request.rect = rect;
            request.destination = TexelOffset{0, 0};
            request.outputs = outputs;
            request.batch = batch;
            const DecompressionPass pass = fixture.Make(request, GetNeeds(*context, language.language));
            CHECK(pass.batchCount == 3);
            const auto images = fixture.device.MakeImages(16, ImageFormat::RGBA32F, rect.width, rect.height);
            fixture.device.Run(pass, FindPass(pass), images);
            for (std::size_t o = static_cast<std::size_t>(batch) * 16;
                 o < std::min<std::size_t>(outputs.size(), static_cast<std::size_t>(batch) * 16 + 16); ++o) {
                const DecompressionOutput& output = outputs[o];
                const auto texels = fixture.device.ReadTexels(images[o % 16]);
                std::size_t wrong = 0;
                for (int y = 0; y < rect.height; ++y) {
                    for (int x = 0; x < rect.width; ++x) {
                        const int texel = (rect.top + y) * kWidth + rect.left + x;
                        const std::uint32_t noise =
                            MurmurModel(HashIndexModel(static_cast<std::uint64_t>(texel)),
                                        static_cast<std::uint32_t>(o) + 1);
                        for (int k = 0; k < output.numChannels; ++k) {
                            const volatile float step =
                                (static_cast<float>(noise >> (8 * k) & 255u) / 256.0f - 0.5f) *
                                output.ditherScale;
                            const float expected =
                                decoded[static_cast<std::size_t>(texel * 16 + output.firstChannel + k)] +
                                step;
                            wrong +=
                                GetDeviceBits(texels[static_cast<std::size_t>(y * rect.width + x)]
                                                    [static_cast<std::size_t>(k)]) != GetDeviceBits(expected)
                                    ? 1
                                    : 0;
                        }
                    }
                }
                CAPTURE(o);
                CHECK(wrong == 0);
            }
        }
    }
}

TEST_CASE("colour spaces: each channel from its own to that of the texture") {
    OPENNTC_REQUIRE_DEVICE(context);
    Fixture fixture(*context, NTC_NETWORK_SMALL, kMixedSpaces);
    std::vector<DecompressionOutput> outputs;
    for (int i = 0; i < 16; ++i)
        outputs.push_back({.firstChannel = std::min(i, 12),
                           .numChannels = 4,
                           .rgbColorSpace = static_cast<ColorSpace>(i % 3),
                           .alphaColorSpace = static_cast<ColorSpace>(i / 3 % 3)});
    const std::vector<float> decoded = DecodeMip(fixture.source, 1);
    const int width = kWidth / 2, height = kHeight / 2;
    for (const Language& language : kLanguages) {
        DecompressionRequest request;
        request.mip = 1;
        request.outputs = outputs;
        const DecompressionPass pass = fixture.Make(request, GetNeeds(*context, language.language));
        const auto images = fixture.device.MakeImages(16, ImageFormat::RGBA32F, width, height);
        fixture.device.Run(pass, FindPass(pass), images);
        for (std::size_t o = 0; o < 16; ++o) {
            const DecompressionOutput& output = outputs[o];
            const auto texels = fixture.device.ReadTexels(images[o]);
            double worst = 0;
            for (std::size_t i = 0; i < texels.size(); ++i) {
                for (int k = 0; k < 4; ++k) {
                    const int channel = output.firstChannel + k;
                    const double value = decoded[i * 16 + static_cast<std::size_t>(channel)];
                    const ColorSpace from = GetSpace(kMixedSpaces, channel);
                    const ColorSpace to = k < 3 ? output.rgbColorSpace : output.alphaColorSpace;
                    const double expected =
                        from == to ? value : FromLinearModel(ToLinearModel(value, from), to);
                    const double result = static_cast<double>(texels[i][static_cast<std::size_t>(k)]);
                    worst = std::max(worst, std::fabs(result - expected) / (1 + std::fabs(expected)));
                }
            }
            // Vulkan's exp2 and log2 are within 3 + 2 |x| and 3 units in the last place, of powers whose exponents stay
            // below 16: 35 * 2^-24 for each of two conversions, doubled for the steps round them.
            CAPTURE(o);
            CHECK(worst < 140 * 0x1p-24);
        }
    }
}

TEST_CASE("without code for conversion: the same texels, and an output that needs it is not written") {
    OPENNTC_REQUIRE_DEVICE(context);
    Fixture fixture(*context, NTC_NETWORK_SMALL, kMixedSpaces);
    std::vector<DecompressionOutput> outputs;
    for (int channel = 0; channel < 16; ++channel)
        outputs.push_back({.firstChannel = channel,
                           .rgbColorSpace = GetSpace(kMixedSpaces, channel),
                           .ditherScale = channel % 2 == 0 ? 1 / 255.0f : 0.0f});
    const int width = kWidth / 2, height = kHeight / 2;
    for (const Language& language : kLanguages) {
        CAPTURE(std::string(language.name));
        DecompressionRequest request;
        request.mip = 1;
        request.outputs = outputs;
        const SceneNeeds needs = GetNeeds(*context, language.language);
        const DecompressionPass pass = fixture.Make(request, needs);
        CHECK_FALSE(pass.convertsColors);
        const std::span<const std::uint32_t> spirv = FindPass(pass, pass.GetOwnDefines());
        CHECK(spirv.size() < FindPass(pass).size());
        const auto with = fixture.device.MakeImages(16, ImageFormat::RGBA32F, width, height);
        const auto without = fixture.device.MakeImages(16, ImageFormat::RGBA32F, width, height);
        fixture.device.Run(pass, FindPass(pass), with);
        fixture.device.Run(pass, spirv, without);
        for (std::size_t o = 0; o < 16; ++o)
            CHECK(fixture.device.Read(with[o]) == fixture.device.Read(without[o]));

        std::vector<DecompressionOutput> other = outputs;
        other[5].rgbColorSpace = static_cast<ColorSpace>((static_cast<int>(other[5].rgbColorSpace) + 1) % 3);
        request.outputs = other;
        const DecompressionPass converting = fixture.Make(request, needs);
        CHECK(converting.convertsColors);
        CHECK(std::string(converting.GetOwnDefines()).empty());
        const auto images = fixture.device.MakeImages(16, ImageFormat::RGBA32F, width, height);
        fixture.device.Run(converting, spirv, images); // promised otherwise
        for (std::size_t o = 0; o < 16; ++o) {
            const std::vector<std::byte> texels = fixture.device.Read(images[o]);
            const bool isEmpty =
                std::all_of(texels.begin(), texels.end(), [](std::byte b) { return b == std::byte{0}; });
            CHECK(isEmpty == (o == 5));
            CHECK((texels == fixture.device.Read(with[o])) == (o != 5));
        }
    }
}

TEST_CASE("8-bit textures by the set's own list, with dither, and from a slice") {
    OPENNTC_REQUIRE_DEVICE(context);
    std::array<Texture, 3> textures;
    const auto set = [&textures](std::size_t i, const char* name, int first, int channels,
                                 ChannelFormat format) {
        textures[i].name = name;
        textures[i].firstChannel = first;
        textures[i].numChannels = channels;
        textures[i].channelFormat = format;
    };
    set(0, "a", 0, 3, ChannelFormat::UNORM8);
    set(1, "b", 15, 1, ChannelFormat::UNORM8);
    set(2, "c", 4, 4, ChannelFormat::FLOAT16);
    SynthesisDesc synthesis;
    synthesis.seed = 5;
    synthesis.desc = {kWidth, kHeight, 16, 3};
    synthesis.networkVersion = NTC_NETWORK_SMALL;
    synthesis.shape = {4, 4, 8, 2, 4};
    synthesis.textures = textures;
    MemoryStream stream;
    REQUIRE(SynthesizeTextureSet(stream, synthesis));
    const decode_test::ModeSet file({stream.GetBytes().begin(), stream.GetBytes().end()});
    const DecodeSource source = file.GetSource(DecodeWeights::Int8);
    const Rect rect = {13, 7, 20, 18};
    SliceDesc slice;
    slice.rect = rect;
    const auto layout = GetSliceLayout(file.GetMetadata(), slice);
    REQUIRE(layout);
    std::vector<std::byte> latents(static_cast<std::size_t>(layout->bytes));
    const auto data = MakePartialInferenceData(file.GetMetadata(), stream, slice,
                                               InferenceWeightType::GenericInt8, latents);
    REQUIRE(data);
    PassDevice device(*context, latents, source.weights);
    DecompressionRequest request;
    request.rect = rect;
    request.destination = TexelOffset{0, 0};
    const DecompressionPass pass = Take(MakeDecompressionPass(file.GetMetadata(), data->constants, request,
                                                              GetNeeds(*context, ShaderLanguage::Glsl)));
    CHECK(pass.constants.outputCount == 3);
    const auto images = device.MakeImages(3, ImageFormat::RGBA8, rect.width, rect.height);
    device.Run(pass, FindPass(pass), images);
    const std::vector<float> decoded = DecodeMip(source, 0);
    for (std::size_t i = 0; i < 3; ++i) {
        const std::vector<std::byte> bytes = device.Read(images[i]);
        double worst = 0;
        int others = 0; // than the nearest code
        for (int y = 0; y < rect.height; ++y) {
            for (int x = 0; x < rect.width; ++x) {
                const std::size_t texel = static_cast<std::size_t>((rect.top + y) * kWidth + rect.left + x);
                const std::uint32_t noise =
                    MurmurModel(HashIndexModel(texel), static_cast<std::uint32_t>(i) + 1);
                for (int k = 0; k < 4; ++k) {
                    float value = k == 3 ? 1 : 0;
                    if (k < textures[i].numChannels) {
                        value = decoded[texel * 16 + static_cast<std::size_t>(textures[i].firstChannel + k)];
                        if (textures[i].channelFormat == ChannelFormat::UNORM8) {
                            const volatile float step =
                                (static_cast<float>(noise >> (8 * k) & 255u) / 256.0f - 0.5f) *
                                (1.0f / 255.0f);
                            value += step;
                        }
                    }
                    const double code = std::clamp(double{value}, 0.0, 1.0) * 255;
                    const auto stored =
                        std::to_integer<int>(bytes[static_cast<std::size_t>(y * rect.width + x) * 4 +
                                                   static_cast<std::size_t>(k)]);
                    worst = std::max(worst, std::fabs(code - stored));
                    others += static_cast<int>(std::floor(code + 0.5)) != stored ? 1 : 0;
                }
            }
        }
        CHECK(worst <= 0.6); // Vulkan's conversion to UNORM8 may err by 0.1 code beyond rounding
        if (textures[i].channelFormat == ChannelFormat::UNORM8)
            CHECK(others == 0); // the pass rounds itself
    }
    // Outside the slice there are no latents.
    request.rect = Rect{0, 0, 8, 8};
    const auto outside = MakeDecompressionPass(file.GetMetadata(), data->constants, request,
                                               GetNeeds(*context, ShaderLanguage::Glsl));
    REQUIRE_FALSE(outside);
    CHECK(outside.error().GetStatus() == Status::OutOfRange);
    CHECK(context->GetValidationLog().errors.empty());
}

TEST_CASE("a slice of generation 3, compressed, that wraps at the left and upper edge") {
    OPENNTC_REQUIRE_DEVICE(context);
    SynthesisDesc synthesis;
    synthesis.seed = 6;
    synthesis.desc = {kWidth, kHeight, 16, 3};
    synthesis.networkVersion = NTC_NETWORK_GENERATION_3;
    synthesis.shape = MakeLayeredShape(1, 8);
    synthesis.compression = {true, false, 1, 2.0f};
    MemoryStream stream;
    REQUIRE(SynthesizeTextureSet(stream, synthesis));
    const decode_test::ModeSet file({stream.GetBytes().begin(), stream.GetBytes().end()});
    const DecodeSource source = file.GetSource(DecodeWeights::Int8);
    SliceDesc slice;
    slice.rect = {0, 0, 20, 18};
    std::vector<std::byte> latents(
        static_cast<std::size_t>(*GetPartialLatentBufferSize(file.GetMetadata(), slice)));
    const auto data = MakePartialInferenceData(file.GetMetadata(), stream, slice,
                                               InferenceWeightType::GenericInt8, latents);
    REQUIRE(data);
    const std::vector<DecompressionOutput> outputs(
        16, DecompressionOutput{.firstChannel = 0, .numChannels = 4, .rgbColorSpace = ColorSpace::Linear});
    DecompressionRequest request;
    request.outputs = outputs;
    request.rect = slice.rect;
    PassDevice device(*context, latents, source.weights);
    const DecompressionPass pass = Take(MakeDecompressionPass(file.GetMetadata(), data->constants, request,
                                                              GetNeeds(*context, ShaderLanguage::Glsl)));
    const auto images = device.MakeImages(16, ImageFormat::RGBA32F, slice.rect.width, slice.rect.height);
    device.Run(pass, FindPass(pass), images);
    CHECK(CountWrong(device.ReadTexels(images[0]), slice.rect.width, DecodeMip(source, 0), kWidth, slice.rect,
                     {0, 0}, outputs[0]) == 0);
    CHECK(context->GetValidationLog().errors.empty());
}
