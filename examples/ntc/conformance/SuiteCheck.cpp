// SPDX-License-Identifier: MIT
#include "../Output.h"
#include "Checks.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace openntc::conformance {

namespace {

using tool::Format;
using tool::FormatFloat;

// Texels that a diagnosis decodes with each mistake: those that differ, and as many that do not.
constexpr std::size_t kDiagnosedTexels = 12;

struct Tolerance {
    const TextureSetMetadata& metadata;
    const SuiteCase& suiteCase;
    Arithmetic arithmetic;

    // `stored`: the output before conversion to linear.
    bool Accepts(std::size_t channel, float actual, float expected, float stored) const {
        if (IsSame(actual, expected, GetFlushLimit(arithmetic, suiteCase.math)))
            return true;
        if (!suiteCase.linear || static_cast<int>(channel) >= metadata.GetDesc().channels)
            return false;
        const ColorSpace space = metadata.GetChannelStorageColorSpace(static_cast<int>(channel));
        return GetDistance(actual, expected) <= GetLinearBound(space, stored, arithmetic);
    }
};

// Outputs before conversion to linear, by the independent model.
Outputs GetStored(const Model& model, const SuiteCase& suiteCase, const ValueRecord& record) {
    if (!suiteCase.linear)
        return record.outputs;
    return model.Decode(suiteCase.math, false, record.texel.mip, record.texel.x, record.texel.y);
}

struct Difference {
    std::size_t record;
    std::size_t channel;
};

// The mistake that gives exactly the values that the subject gave, right ones included.
std::string FindCause(const Model& model, const Tolerance& tolerance, std::span<const ValueRecord> records,
                      std::span<const Outputs> values, std::span<const std::size_t> sample) {
    const SuiteCase& suiteCase = tolerance.suiteCase;
    for (const MistakeInfo& info : ListMistakes()) {
        const bool explains = std::all_of(sample.begin(), sample.end(), [&](std::size_t i) {
            const tool::Texel& texel = records[i].texel;
            const Outputs wrong =
                model.Decode(suiteCase.math, suiteCase.linear, texel.mip, texel.x, texel.y, info.mistake);
            const Outputs stored = suiteCase.linear ? model.Decode(suiteCase.math, false, texel.mip, texel.x,
                                                                   texel.y, info.mistake)
                                                    : wrong;
            for (std::size_t c = 0; c < 16; ++c) {
                if (!tolerance.Accepts(c, values[i][c], wrong[c], stored[c]))
                    return false;
            }
            return true;
        });
        if (explains)
            return info.cause;
    }
    return {};
}

} // namespace

SuiteResult CheckSuiteCase(const SuiteCase& suiteCase, std::span<const ValueRecord> records,
                           const TextureSetMetadata& metadata, std::span<const std::byte> file,
                           Subject& subject) {
    SuiteResult result;
    result.texels = records.size();
    std::vector<tool::Texel> texels;
    for (const ValueRecord& record : records)
        texels.push_back(record.texel);
    const DecodeOptions options{suiteCase.math, suiteCase.linear};
    std::vector<Outputs> values;
    if (suiteCase.wholeMip) {
        const int mip = texels.front().mip;
        const ColorMip& size = metadata.GetColorMips()[static_cast<std::size_t>(mip)];
        values = subject.DecodeMip(mip, size.width, size.height, options);
    } else {
        values = subject.DecodeTexels(texels, options);
    }

    const Model model(metadata, file);
    const Tolerance tolerance{metadata, suiteCase, subject.GetArithmetic()};
    std::vector<std::size_t> different;
    std::vector<std::size_t> equal;
    for (std::size_t i = 0; i < records.size(); ++i) {
        const Outputs stored = GetStored(model, suiteCase, records[i]);
        bool isEqual = true;
        for (std::size_t c = 0; c < 16; ++c) {
            const float expected = records[i].outputs[c];
            const float value = values[i][c];
            double distance = GetDistance(value, expected);
            const bool isInside =
                suiteCase.interval && value >= records[i].low[c] && value <= records[i].high[c];
            if (isInside || tolerance.Accepts(c, value, expected, stored[c])) {
                result.worstAccepted = std::max(result.worstAccepted, distance);
                continue;
            }
            if (suiteCase.interval)
                distance =
                    std::min(GetDistance(value, records[i].low[c]), GetDistance(value, records[i].high[c]));
            result.worst = std::max(result.worst, distance);
            if (isEqual && different.empty()) {
                result.difference = Format("mip %d texel (%d, %d) channel %zu: %s%s %s: expected %s",
                                           texels[i].mip, texels[i].x, texels[i].y, c,
                                           tool::GetName(suiteCase.math), suiteCase.linear ? " linear" : "",
                                           FormatFloat(value).c_str(), FormatFloat(expected).c_str());
                if (suiteCase.interval)
                    result.difference += " or from " + FormatFloat(records[i].low[c]) + " to " +
                                         FormatFloat(records[i].high[c]);
            }
            isEqual = false;
        }
        (isEqual ? equal : different).push_back(i);
    }
    if (different.empty())
        return result;
    result.differentTexels = different.size();
    std::vector<std::size_t> sample;
    for (const std::vector<std::size_t>* list : {&different, &equal}) {
        for (std::size_t i = 0; i < std::min(kDiagnosedTexels, list->size()); ++i)
            sample.push_back((*list)[i * list->size() / std::min(kDiagnosedTexels, list->size())]);
    }
    result.cause = FindCause(model, tolerance, records, values, sample);
    return result;
}

} // namespace openntc::conformance
