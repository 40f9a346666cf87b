// SPDX-License-Identifier: MIT
#include "../Output.h"
#include "Checks.h"
#include "Diagnosis.h"
#include "ModelSet.h"

#include <algorithm>
#include <cmath>

namespace openntc::conformance {

namespace {

using tool::Format;
using tool::FormatFloat;

// Texels that a diagnosis decodes with each mistake: those that differ, and as many that do not.
constexpr std::size_t kDiagnosedTexels = 12;

// Outputs before conversion to linear, by the independent model.
Outputs GetStored(const Model& model, const SuiteCase& suiteCase, const ValueRecord& record) {
    if (!suiteCase.linear)
        return record.outputs;
    ModelRequest request = suiteCase.MakeRequest(record.texel);
    request.linear = false;
    return model.Decode(request);
}

// The values of the records' texels, asked for in the manner of the case.
std::vector<Outputs> Ask(const SuiteCase& suiteCase, std::span<const ValueRecord> records, const Model& model,
                         Subject& subject) {
    std::vector<tool::Texel> texels;
    for (const ValueRecord& record : records)
        texels.push_back(record.texel);
    const DecodeOptions options{suiteCase.math, suiteCase.linear};
    const bool asksForMip = suiteCase.wholeMip && subject.GetCapabilities().wholeMips;
    if (!asksForMip && !suiteCase.slice)
        return subject.DecodeTexels(texels, options);
    const int mip = suiteCase.GetSliceMip(texels.front().mip);
    const auto getSize = [&](int n) -> const ModelMip& {
        return model.GetSet().mips[static_cast<std::size_t>(n)];
    };
    const Rect rect = suiteCase.slice.value_or(Rect{0, 0, getSize(mip).width, getSize(mip).height});
    const SliceRequest slice = MakeSliceRequest(mip, suiteCase.sliceMips, rect, getSize);
    const std::vector<Outputs> all = suiteCase.slice
                                         ? subject.DecodeSlice(slice, options)
                                         : subject.DecodeMip(mip, rect.width, rect.height, options);
    std::vector<Outputs> values;
    for (const tool::Texel& texel : texels)
        values.push_back(all.at(slice.GetIndex(texel)));
    return values;
}

std::string NameDifference(const SuiteCase& suiteCase, const ValueRecord& record, std::size_t channel,
                           float value) {
    std::string text =
        Format("mip %d texel (%d, %d) channel %zu: %s%s %s: expected %s", record.texel.mip, record.texel.x,
               record.texel.y, channel, tool::GetName(suiteCase.math), suiteCase.linear ? " linear" : "",
               FormatFloat(value).c_str(), FormatFloat(record.outputs[channel]).c_str());
    if (suiteCase.interval)
        text += " or from " + FormatFloat(record.low[channel]) + " to " + FormatFloat(record.high[channel]);
    return text;
}

} // namespace

SuiteResult CheckSuiteCase(const SuiteCase& suiteCase, std::span<const ValueRecord> records,
                           const Model& model, Subject& subject, Diagnosis& diagnosis) {
    SuiteResult result;
    result.texels = records.size();
    const std::vector<Outputs> values = Ask(suiteCase, records, model, subject);
    const Tolerance tolerance{model, suiteCase, subject.GetArithmetic()};
    std::vector<std::size_t> different;
    std::vector<std::size_t> equal;
    for (std::size_t i = 0; i < records.size(); ++i) {
        const ValueRecord& record = records[i];
        const Outputs stored = GetStored(model, suiteCase, record);
        bool isEqual = true;
        for (std::size_t c = 0; c < 16; ++c) {
            const float value = values[i][c];
            double distance = GetDistance(value, record.outputs[c]);
            const bool isInside = suiteCase.interval && value >= record.low[c] && value <= record.high[c];
            if (isInside || tolerance.Accepts(c, value, record.outputs[c], stored[c])) {
                result.worstAccepted = std::max(result.worstAccepted, distance);
                continue;
            }
            if (suiteCase.interval)
                distance = std::min(GetDistance(value, record.low[c]), GetDistance(value, record.high[c]));
            result.worst = std::max(result.worst, distance);
            if (isEqual && different.empty())
                result.difference = NameDifference(suiteCase, record, c, value);
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
    result.cause = diagnosis.Find(tolerance, {records, values, sample});
    return result;
}

} // namespace openntc::conformance
