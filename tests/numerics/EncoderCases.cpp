// SPDX-License-Identifier: MIT
// Materials that break encoders. Decoders of the files are compared with what training reports; tests/unit/encode has
// more materials and options.
#include "HardCases.h"
#include "support/HardPatterns.h"
#include "unit/decode/ModeSets.h"

#include "encode/Training.h"

#include "openntc/decode/ReferenceDecoder.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <stdexcept>

namespace numerics {

namespace {

using namespace openntc;
using namespace openntc::encode;

using Pattern = float (*)(int x, int y, int c);
using patterns::Disc, patterns::HugeRange, patterns::Noise, patterns::Ramp;

Material MakeMaterial(int width, int height, int channels, Pattern pattern) {
    Material material = *Material::Create(width, height);
    std::vector<float> texels;
    const int count = width * height * channels;
    texels.reserve(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i)
        texels.push_back(pattern(i / channels % width, i / channels / width, i % channels));
    if (!material.AddTexture({.name = "Texture", .firstChannel = 0, .channels = channels}, texels))
        throw std::runtime_error("material");
    material.GenerateMips();
    return material;
}

EncodeResult Encode(const Material& material, EncodeOptions options) {
    options.threads = 2;
    auto result = tool::Train(material, options, {});
    if (!result)
        throw std::runtime_error(result.error().GetText());
    return std::move(*result);
}

struct DecodedError {
    double worst = 0; ///< |decoded - source|
    double psnr = 0;
    int wrongMaskTexels = 0; ///< of channel 0: 0 and 1 that do not come back from 8 bits
};

DecodedError Measure(const Material& material, const EncodeResult& result, DecodeMath math) {
    const decode_test::ModeSet set(result.file);
    DecodedError error;
    double squares = 0;
    double count = 0;
    for (int m = 0; m < material.GetMipCount(); ++m) {
        const ColorMip& mip = set.GetMetadata().GetColorMips()[static_cast<std::size_t>(m)];
        std::vector<float> decoded(static_cast<std::size_t>(mip.width * mip.height) * 16);
        if (!DecodeReference(set.GetSource(GetDecodeWeights(math)), m, {0, 0, mip.width, mip.height},
                             {.math = math, .convertToLinear = false}, decoded))
            throw std::runtime_error("decode");
        for (int c = 0; c < 16; ++c) {
            if ((material.GetDeclaredChannels() >> c & 1u) == 0)
                continue;
            const auto plane = material.GetPlane(m, c);
            for (std::size_t i = 0; i < plane.size(); ++i) {
                const float value = decoded[16 * i + static_cast<std::size_t>(c)];
                const double difference =
                    std::fabs(static_cast<double>(value) - static_cast<double>(plane[i]));
                error.worst = difference <= error.worst ? error.worst : difference; // NaN counts
                squares += difference * difference;
                count += 1;
                const float unorm = std::floor(std::clamp(value, 0.0f, 1.0f) * 255.0f + 0.5f);
                error.wrongMaskTexels +=
                    c == 0 && ((plane[i] == 0.0f && unorm != 0.0f) || (plane[i] == 1.0f && unorm != 255.0f));
            }
        }
    }
    error.psnr = -10 * std::log10(squares / count);
    return error;
}

// Nothing to train: the network's output is a bias.
Measurement MeasureFlat() {
    struct {
        int size, channels;
        Pattern pattern;
    } const kMaterials[] = {{16, 3, [](int, int, int c) { return 0.1f + 0.3f * static_cast<float>(c); }},
                            {16, 4, [](int, int, int) { return 0.0f; }},
                            {16, 4, [](int, int, int) { return 1.0f; }},
                            {1, 3, Noise}};
    Measurement measurement{0, "constant, black, white, one texel; INT8 and FP8"};
    for (const auto& entry : kMaterials) {
        const Material material = MakeMaterial(entry.size, entry.size, entry.channels, entry.pattern);
        EncodeOptions options;
        options.fp8 = true;
        const EncodeResult result = Encode(material, options);
        for (const DecodeMath math : {DecodeMath::Int8, DecodeMath::FP8})
            measurement.worst = std::max(measurement.worst, Measure(material, result, math).worst);
    }
    return measurement;
}

/// Largest difference in dB between the PSNR that training reports and the decoded one; NaN is infinite.
Measurement MeasureReported(std::span<const Pattern> patterns, int channels) {
    Measurement measurement{0, "dB between reported and decoded PSNR, INT8 and FP8"};
    for (const Pattern pattern : patterns) {
        const Material material = MakeMaterial(16, 16, channels, pattern);
        EncodeOptions options;
        options.steps = 30;
        options.fp8 = true;
        const EncodeResult result = Encode(material, options);
        for (const double difference : {Measure(material, result, DecodeMath::Int8).psnr - result.psnr,
                                        Measure(material, result, DecodeMath::FP8).psnr - result.fp8Psnr}) {
            const double distance =
                std::isnan(difference) ? std::numeric_limits<double>::infinity() : std::fabs(difference);
            measurement.worst = std::max(measurement.worst, distance);
        }
    }
    return measurement;
}

Measurement MeasureNoise() {
    static constexpr Pattern kPatterns[] = {
        Noise, [](int x, int y, int c) { return Noise(x, y, c) < 0.5f ? 0.0f : 1.0f; }};
    return MeasureReported(kPatterns, 16);
}

Measurement MeasureHugeRange() {
    static constexpr Pattern kPatterns[] = {HugeRange,
                                            [](int x, int y, int c) { return -1000.0f * Ramp(x, y, c); }};
    return MeasureReported(kPatterns, 3);
}

Measurement MeasureMask() {
    const Material material = MakeMaterial(32, 32, 1, Disc);
    EncodeOptions options;
    options.maskChannel = 0;
    options.steps = 400;
    const EncodeResult result = Encode(material, options);
    const int wrong = Measure(material, result, DecodeMath::Int8).wrongMaskTexels;
    const int reported = static_cast<int>(result.maskViolations);
    return {static_cast<double>(std::max(wrong, std::abs(wrong - reported))),
            "texels of 0 and 1 that come back as others"};
}

// Steps 3000 times too large; 1e30 times is refused.
Measurement MeasureDivergence() {
    const Material material = MakeMaterial(16, 16, 3, Ramp);
    EncodeOptions options;
    options.steps = 250;
    options.rateScale = 3000.0f;
    const EncodeResult result = Encode(material, options);
    options.rateScale = 1e30f;
    const bool isRefused = !tool::Train(material, options, {}).has_value();
    char note[80];
    std::snprintf(note, sizeof note, "went back %d times, then %.1f dB", static_cast<int>(result.restarts),
                  result.psnr);
    const bool isGuarded = result.restarts > 0 && isRefused;
    return {isGuarded ? std::max(0.0, 10 - Measure(material, result, DecodeMath::Int8).psnr)
                      : std::numeric_limits<double>::infinity(),
            note};
}

constexpr HardCase kEncoderCases[] = {
    {"encoder-flat", "Materials without any contrast, and of one texel: gradients of zero, ranges of zero.",
     "Encoders that divide by a channel's range or by a scale; biases of round(bias / scale) beyond int32.",
     "A channel that never changes is a bias alone, with a scale that holds it; nothing is trained.", 0,
     MeasureFlat},
    {"encoder-noise",
     "Noise in 16 channels, grey and black and white: nothing to learn, latents and weights at their bounds.",
     "Encoders whose quantised network is not the one that was trained.",
     "What training reports was decoded with the integers that the file holds.", 0.05, MeasureNoise},
    {"encoder-huge-range", "Values from 1e-5 to 65504 beside each other, and negative ones down to -1000.",
     "Losses that overflow, ranges that swallow what is small.",
     "Channels are normalised by their own range; the PSNR is of stored values.", 0.05, MeasureHugeRange},
    {"encoder-masks", "A mask whose 0 and 1 must come back as they were.",
     "Encoders that minimise the mean: edges ring, alpha tests flicker.",
     "Mask channels are trained to overshoot, readers clamp; texels that do not come back are counted.", 0,
     MeasureMask},
    {"encoder-divergence",
     "Training with steps 3000 times too large. The worst error is what is missing to 10 dB.",
     "Networks of NaN, written as if nothing had happened.",
     "Training that falls 10 dB below its best, or to NaN, goes back to its last good state with smaller "
     "steps; what no number of restarts helps is refused.",
     0, MeasureDivergence},
};

} // namespace

std::span<const HardCase> ListEncoderCases() {
    return kEncoderCases;
}

} // namespace numerics
