// SPDX-License-Identifier: MIT
#include "Checks.h"

#include "../Output.h"

#include <algorithm>

namespace openntc::conformance {

namespace {

using tool::Format;
using tool::FormatFloat;

std::string DescribeDifference(const TexelRecord& record, std::size_t channel, float actual, float expected,
                               const char* what) {
    return Format("mip %d texel (%d, %d) channel %zu: %s %s: expected %s", record.mip, record.x, record.y,
                  channel, what, FormatFloat(actual).c_str(), FormatFloat(expected).c_str());
}

class SquaredError {
public:
    void Add(float value, float source) {
        const double error = static_cast<double>(value) - static_cast<double>(source);
        sum_ += error * error;
        ++count_;
    }
    std::optional<double> GetPsnr() const {
        if (count_ == 0)
            return std::nullopt;
        return -10 * std::log10(sum_ / static_cast<double>(count_));
    }

private:
    double sum_ = 0;
    std::uint64_t count_ = 0;
};

bool IsInside(const TexelRecord& record, const TextureSetMetadata& metadata) {
    if (record.mip < 0 || record.mip >= metadata.GetDesc().mips)
        return false;
    const ColorMip& mip = metadata.GetColorMips()[static_cast<std::size_t>(record.mip)];
    return record.x >= 0 && record.x < mip.width && record.y >= 0 && record.y < mip.height;
}

} // namespace

TexelResult CheckTexels(const std::vector<TexelRecord>& records, const TextureSetMetadata& metadata,
                        Subject& subject) {
    const Arithmetic arithmetic = subject.GetArithmetic();
    TexelResult result;
    const auto differ = [&result](const std::string& text) {
        if (result.difference.empty())
            result.difference = text;
    };

    std::vector<tool::Texel> texels;
    std::vector<const TexelRecord*> compared;
    for (const TexelRecord& record : records) {
        if (!IsInside(record, metadata)) {
            differ(Format("mip %d texel (%d, %d): outside the image", record.mip, record.x, record.y));
        } else if ((record.flags & kHasExact) != 0) {
            texels.push_back({record.mip, record.x, record.y});
            compared.push_back(&record);
        }
    }
    const auto decode = [&](DecodeMath math, bool linear) {
        return subject.DecodeTexels(texels, DecodeOptions{math, linear});
    };
    const auto checkExact = [&](DecodeMath math, std::array<float, 16> TexelRecord::*block, const char* what,
                                double& worst) {
        std::vector<std::array<float, 16>> values = decode(math, false);
        for (std::size_t i = 0; i < values.size(); ++i) {
            for (std::size_t channel = 0; channel < 16; ++channel) {
                const float expected = (compared[i]->*block)[channel];
                if (IsSame(values[i][channel], expected, GetFlushLimit(arithmetic, math)))
                    continue;
                worst = std::max(worst, GetDistance(values[i][channel], expected));
                differ(DescribeDifference(*compared[i], channel, values[i][channel], expected, what));
            }
        }
        return values;
    };

    result.exact = compared.size();
    const std::vector<std::array<float, 16>> values =
        checkExact(DecodeMath::Int8, &TexelRecord::exact, "int8", result.worstFloat);
    checkExact(DecodeMath::Int8Half, &TexelRecord::exactHalf, "int8_half", result.worstHalf);

    const std::vector<std::array<float, 16>> linear = decode(DecodeMath::Int8, true);
    SquaredError decodedError;
    SquaredError exactError;
    for (std::size_t i = 0; i < compared.size(); ++i) {
        for (std::size_t channel = 0; channel < 16; ++channel) {
            const TexelRecord& record = *compared[i];
            const double distance = GetDistance(linear[i][channel], record.linear[channel]);
            const bool declared = static_cast<int>(channel) < metadata.GetDesc().channels;
            const ColorSpace space = declared
                                         ? metadata.GetChannelStorageColorSpace(static_cast<int>(channel))
                                         : ColorSpace::Linear;
            const double bound = GetLinearBound(space, record.exact[channel], arithmetic);
            if (distance > 0 && !IsSame(linear[i][channel], record.linear[channel],
                                        GetFlushLimit(arithmetic, DecodeMath::Int8))) {
                result.worstLinear = std::max(result.worstLinear, distance);
                result.worstLinearRatio =
                    std::max(result.worstLinearRatio,
                             bound > 0 ? distance / bound : std::numeric_limits<double>::infinity());
                if (distance > bound)
                    differ(DescribeDifference(record, channel, linear[i][channel], record.linear[channel],
                                              "linear") +
                           Format(" within %.3g", bound));
            }
            if ((record.flags & kHasSource) != 0 && ((metadata.GetValidChannelMask() >> channel) & 1u) != 0) {
                decodedError.Add(values[i][channel], record.source[channel]);
                exactError.Add(record.exact[channel], record.source[channel]);
            }
        }
    }
    result.psnr = decodedError.GetPsnr();
    result.psnrExact = exactError.GetPsnr();
    if (result.psnr && !(*result.psnr == *result.psnrExact) &&
        !(std::isnan(*result.psnr) && std::isnan(*result.psnrExact)) && arithmetic == Arithmetic::Host)
        differ(Format("PSNR: %.6f dB: the exact values give %.6f dB", *result.psnr, *result.psnrExact));
    return result;
}

} // namespace openntc::conformance
