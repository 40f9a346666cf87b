// SPDX-License-Identifier: MIT
#include "report/Pictures.h"

#include "Output.h"
#include "Png.h"
#include "TextureImage.h"
#include "TextureSet.h"

#include "openntc/MathModes.h"

#include <algorithm>
#include <cmath>

namespace openntc::report {

namespace {

constexpr int kSide = 96; // texels of a crop
constexpr double kSourceAmplification = 8;
constexpr double kMathAmplification = 32;

std::string EncodeBase64(std::span<const std::byte> bytes) {
    constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t group = 0;
        for (std::size_t k = 0; k < 3; ++k)
            group = group << 8 | (i + k < bytes.size() ? std::to_integer<std::uint32_t>(bytes[i + k]) : 0u);
        for (std::size_t k = 0; k < 4; ++k)
            text += i + k <= bytes.size() ? kDigits[group >> (18 - 6 * k) & 63u] : '=';
    }
    return text;
}

/// The planes of three channels as outputs have them.
std::vector<float> MakeSourceOutputs(const encode::Material& material) {
    std::vector<float> outputs(static_cast<std::size_t>(material.GetWidth()) *
                               static_cast<std::size_t>(material.GetHeight()) * 16);
    for (std::size_t c = 0; c < 16; ++c) {
        const std::span<const float> plane = material.GetPlane(0, static_cast<int>(c));
        for (std::size_t i = 0; i < plane.size(); ++i)
            outputs[16 * i + c] = plane[i];
    }
    return outputs;
}

} // namespace

/// 8-bit RGB of a crop.
struct PictureMaker::Image {
    int width = 0, height = 0;
    std::vector<std::uint16_t> samples;

    /// Three channels of `outputs` in the middle of the image; with `minus`, the amplified absolute difference.
    Image(const Encoding& encoding, std::span<const float> outputs, std::span<const float> minus,
          double amplification, int firstChannel) {
        const int w = encoding.record.width, h = encoding.record.height;
        width = std::min(kSide, w);
        height = std::min(kSide, h);
        for (int y = (h - height) / 2; y < (h + height) / 2; ++y) {
            for (int x = (w - width) / 2; x < (w + width) / 2; ++x) {
                for (int c = 0; c < 3; ++c) {
                    const std::size_t at = 16 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(w) +
                                                 static_cast<std::size_t>(x)) +
                                           static_cast<std::size_t>(firstChannel + c);
                    double value = static_cast<double>(outputs[at]);
                    if (!minus.empty())
                        value = amplification * std::fabs(value - static_cast<double>(minus[at]));
                    samples.push_back(tool::QuantiseUnorm(static_cast<float>(value), 255));
                }
            }
        }
    }
};

std::string PictureMaker::Encode(const Image& image) {
    tool::PngWriter png(scratch_, "picture", {image.width, image.height, 3, 8});
    const std::size_t row = 3 * static_cast<std::size_t>(image.width);
    for (std::size_t y = 0; y < static_cast<std::size_t>(image.height); ++y)
        png.WriteRow(std::span(image.samples).subspan(y * row, row));
    png.Finish();
    const std::vector<std::byte> bytes = tool::ReadAll(scratch_.string());
    std::error_code ignored;
    std::filesystem::remove(scratch_, ignored);
    return EncodeBase64(bytes);
}

PictureRecord PictureMaker::MakeRecord(const Image& image, std::string group, std::string title,
                                       std::string caption) {
    return {std::move(group), std::move(title), std::move(caption), image.width, image.height, Encode(image)};
}

std::vector<PictureRecord> PictureMaker::MakeAll(const std::vector<Case>& cases, EncodingCache& cache,
                                                 ReferenceDecodes& references) {
    std::vector<PictureRecord> pictures;
    const auto isOn = [](const Case& c, const char* axis) {
        return std::find(c.axes.begin(), c.axes.end(), axis) != c.axes.end();
    };
    std::vector<Case> byBits = cases;
    std::stable_sort(byBits.begin(), byBits.end(),
                     [](const Case& a, const Case& b) { return a.bitsPerPixel < b.bitsPerPixel; });
    struct Shown {
        const char* name;
        int firstChannel;
    };
    for (const Shown& shown : {Shown{"base colour", 0}, Shown{"normal", 8}}) {
        const std::string group = std::string("Bits per pixel: ") + shown.name;
        bool hasSource = false;
        for (const Case& c : byBits) {
            if (c.material != kBricks || c.math != NTC_MATH_INT8 || !isOn(c, "bits per pixel"))
                continue;
            const Encoding& encoding = cache.Get(c);
            const std::vector<float> source = MakeSourceOutputs(encoding.source->material);
            if (!hasSource)
                pictures.push_back(MakeRecord(Image(encoding, source, {}, 1, shown.firstChannel), group,
                                              "source", "the material"));
            hasSource = true;
            const std::vector<float>& decoded = references.Get(encoding, c.math, false);
            const std::string title = tool::Format("%g bits per pixel", c.bitsPerPixel);
            pictures.push_back(MakeRecord(Image(encoding, decoded, {}, 1, shown.firstChannel), group, title,
                                          "decoded, int8"));
            pictures.push_back(MakeRecord(
                Image(encoding, decoded, source, kSourceAmplification, shown.firstChannel), group, title,
                tool::Format("difference from the source, %g times", kSourceAmplification)));
        }
    }
    for (const Case& c : cases) {
        if (c.material != kBricks || c.math > NTC_MATH_FP16 || !isOn(c, "maths"))
            continue;
        const Encoding& encoding = cache.Get(c);
        const std::vector<float>& exact = references.Get(encoding, NTC_MATH_FP32, false);
        pictures.push_back(
            MakeRecord(Image(encoding, references.Get(encoding, c.math, false), exact, kMathAmplification, 0),
                       "Maths modes: base colour", GetMathName(c.math),
                       tool::Format("difference from the FP32 decode, %g times", kMathAmplification)));
    }
    return pictures;
}

PictureRecord PictureMaker::MakeDevicePicture(const Case& c, const Encoding& encoding,
                                              const std::string& device, std::span<const float> outputs,
                                              ReferenceDecodes& references) {
    return MakeRecord(
        Image(encoding, outputs, references.Get(encoding, NTC_MATH_FP32, false), kMathAmplification, 0),
        "Maths modes: base colour", std::string(GetMathName(c.math)) + ", " + device,
        tool::Format("difference from the FP32 decode, %g times", kMathAmplification));
}

} // namespace openntc::report
