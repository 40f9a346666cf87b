// SPDX-License-Identifier: MIT
// Conversion to linear colour, through whole decoders: an output row with zero weights, bias 1 and scale v outputs v.
#include "Decoders.h"
#include "HardCases.h"
#include "conformance/Comparison.h"

#include "openntc/decode/ReferenceDecoder.h"

#include <algorithm>
#include <cmath>

namespace numerics {

namespace {

using namespace openntc;
using shader::NtcConvertFromLinear;
using shader::NtcConvertToLinear;

// The worst ratio of error to bound over values in one colour space.
double MeasureSpace(ColorSpace space, std::span<const float> values) {
    std::uint32_t spaces = 0;
    for (std::uint32_t c = 0; c < 16; ++c)
        spaces |= static_cast<std::uint32_t>(space) << (2 * c);
    double worst = 0;
    for (std::size_t first = 0; first < values.size(); first += 16) {
        std::array<float, 16> part{};
        std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(first),
                    std::min<std::size_t>(16, values.size() - first), part.begin());
        conformance::EditableSet editable = MakeOneTexelSet(spaces);
        ForceOutputs(editable, part);
        const TestSet set(conformance::WriteSet(editable));
        const auto data = std::make_shared<const tool::DecodeData>(set.GetData(DecodeMath::Int8));
        const Texel texel;
        for (TestDecoder& decoder : GetDecoders()) {
            if (!decoder.Take(data))
                continue;
            const Outputs linear =
                decoder.Decode({DecodeMath::Int8, true}, set, std::span(&texel, 1)).front();
            for (std::size_t c = 0; c < 16; ++c) {
                // Rounding the model's value to binary32 is half a unit; the bound is for two evaluations and holds it.
                const float expected =
                    static_cast<float>(conformance::ConvertToLinear(static_cast<double>(part[c]), space));
                const double bound = conformance::GetLinearBound(
                    space, part[c],
                    decoder.IsDevice() ? conformance::Arithmetic::Vulkan : conformance::Arithmetic::Host);
                const double distance = conformance::GetDistance(linear[c], expected);
                if (distance > 0 && !conformance::IsSame(linear[c], expected, 0x1p-126f))
                    worst = std::max(worst, bound > 0 ? distance / bound : 1e30);
            }
        }
    }
    return worst;
}

std::vector<float> ListAround(std::initializer_list<float> centres) {
    std::vector<float> values;
    for (const float centre : centres) {
        values.push_back(std::nextafterf(centre, -1e30f));
        values.push_back(centre);
        values.push_back(std::nextafterf(centre, 1e30f));
    }
    return values;
}

Measurement MeasureSrgb() {
    return {MeasureSpace(ColorSpace::sRGB,
                         ListAround({0.04045f, 0.0f, 1.0f, 0.5f, -0.04045f, -1.0f, 1.5f, 12.0f})),
            "in units of the derived bound"};
}

Measurement MeasureHlg() {
    return {MeasureSpace(ColorSpace::HLG, ListAround({0.5f, -0.5f, 0.0f, 1.0f, -1.0f, 0.75f, 1.5f, -1.5f})),
            "in units of the derived bound"};
}

// Steps of one unit around the knees, and of 1/4096 elsewhere, never go down by more than two evaluations' error; and
// encoding what was decoded gives the value back within what the slope makes of the errors of both.
Measurement MeasureCurves() {
    double worst = 0;
    for (const int space : {NTC_COLOR_SPACE_SRGB, NTC_COLOR_SPACE_HLG}) {
        const ColorSpace colorSpace = static_cast<ColorSpace>(space);
        std::vector<float> values;
        for (int i = -4096; i <= 6144; ++i)
            values.push_back(static_cast<float>(i) / 4096);
        for (float knee : {0.04045f, 0.5f, -0.5f}) {
            float value = knee;
            for (int i = 0; i < 64; ++i)
                value = std::nextafterf(value, -10.0f);
            for (int i = 0; i < 128; ++i)
                values.push_back(value = std::nextafterf(value, 10.0f));
        }
        std::sort(values.begin(), values.end());
        float previous = NtcConvertToLinear(values.front(), space);
        for (std::size_t i = 1; i < values.size(); ++i) {
            const float linear = NtcConvertToLinear(values[i], space);
            const double bound =
                conformance::GetLinearBound(colorSpace, values[i], conformance::Arithmetic::Host);
            // The published sRGB constants leave a step of 5e-8 at the knee.
            const double knee = space == NTC_COLOR_SPACE_SRGB ? 5e-8 : 2e-7;
            worst = std::max(worst,
                             (static_cast<double>(previous) - static_cast<double>(linear)) / (bound + knee));
            const double back =
                static_cast<double>(NtcConvertFromLinear(linear, space)) - static_cast<double>(values[i]);
            worst = std::max(worst, std::fabs(back) /
                                        (2e-6 * std::max(1.0, std::fabs(static_cast<double>(values[i])))));
            previous = linear;
        }
    }
    return {worst, "in units of the bound"};
}

// 65504 and NaN as linear light.
Measurement MeasureLargeLight() {
    double worst = 0;
    for (const float light : {12.0f, 65504.0f, -65504.0f, 1.0f, 0.0f}) {
        const float stored = NtcConvertFromLinear(light, NTC_COLOR_SPACE_HLG);
        const double back = static_cast<double>(NtcConvertToLinear(stored, NTC_COLOR_SPACE_HLG));
        // d light / d stored = light / a, a = 0.179: a relative error of 2^-24 of the stored value (below 3) and of the
        // exponential grows to some 40 units of 2^-24.
        worst = std::max(worst, std::fabs(back - static_cast<double>(light)) /
                                    (40 * 0x1p-24 * std::max(1.0, std::fabs(static_cast<double>(light)))));
    }
    for (const int space : {NTC_COLOR_SPACE_SRGB, NTC_COLOR_SPACE_HLG}) {
        if (!std::isnan(NtcConvertToLinear(std::nanf(""), space)))
            worst = 1e30;
    }
    return {worst, "in units of the bound"};
}

constexpr HardCase kColorCases[] = {
    {"srgb-knee", "sRGB at the knee and beside it, negative, above 1; in units of the bound.",
     "pow of negative numbers, clamping, curves that are off by one branch.",
     "The linear branch takes everything up to 0.04045; pow never sees less.", 1, MeasureSrgb},
    {"hlg-negatives", "HLG at +-0.5 and beside it, negative and above 1; in units of the bound.",
     "Curves without a sign; exp that overflows early.", "The curve is odd.", 1, MeasureHlg},
    {"colour-curves",
     "Both curves rise, are continuous at their knees and invert each other; in units of the bound.",
     "Approximations by pieces.", "The published formulas in binary32.", 1, MeasureCurves},
    {"large-light", "HLG of 12.0 and 65504, there and back, and NaN; in units of the bound.",
     "HDR content in half textures.", "The logarithm's argument is positive; NaN stays NaN.", 1,
     MeasureLargeLight},
};

} // namespace

std::span<const HardCase> ListColorCases() {
    return kColorCases;
}

} // namespace numerics
