// SPDX-License-Identifier: MIT
#include "Diagnosis.h"

#include "ModelSet.h"

#include "../Output.h"

#include <algorithm>
#include <optional>

namespace openntc::conformance {

namespace {

Outputs GetStored(const Tolerance& tolerance, const tool::Texel& texel, Mistake mistake) {
    ModelRequest request = tolerance.suiteCase.MakeRequest(texel);
    request.linear = false;
    return tolerance.model.Decode(request, mistake);
}

bool Explains(const Tolerance& tolerance, const Evidence& evidence, Mistake mistake) {
    return std::all_of(evidence.sample.begin(), evidence.sample.end(), [&](std::size_t i) {
        const tool::Texel& texel = evidence.records[i].texel;
        const Outputs wrong = tolerance.model.Decode(tolerance.suiteCase.MakeRequest(texel), mistake);
        const Outputs stored = tolerance.suiteCase.linear ? GetStored(tolerance, texel, mistake) : wrong;
        for (std::size_t c = 0; c < 16; ++c) {
            if (!tolerance.Accepts(c, evidence.values[i][c], wrong[c], stored[c]))
                return false;
        }
        return true;
    });
}

// "channels are in another order", if every channel holds what one of the others should.
std::string FindOrder(const Tolerance& tolerance, const Evidence& evidence) {
    std::vector<Outputs> stored;
    for (const std::size_t i : evidence.sample)
        stored.push_back(tolerance.suiteCase.linear
                             ? GetStored(tolerance, evidence.records[i].texel, Mistake::None)
                             : evidence.records[i].outputs);
    const auto isSource = [&](std::size_t channel, std::size_t source) {
        for (std::size_t n = 0; n < evidence.sample.size(); ++n) {
            const std::size_t i = evidence.sample[n];
            if (!tolerance.Accepts(source, evidence.values[i][channel], evidence.records[i].outputs[source],
                                   stored[n][source]))
                return false;
        }
        return true;
    };
    std::array<std::size_t, 16> sources{};
    std::array<bool, 16> isTaken{};
    std::vector<std::size_t> moved;
    for (std::size_t c = 0; c < 16; ++c) {
        if (isSource(c, c)) {
            sources[c] = c;
            isTaken[c] = true;
        } else {
            moved.push_back(c);
        }
    }
    for (const std::size_t c : moved) {
        std::size_t source = 0;
        while (source < 16 && (isTaken[source] || !isSource(c, source)))
            ++source;
        if (source == 16)
            return {};
        sources[c] = source;
        isTaken[source] = true;
    }
    std::string text = "channels are in another order:";
    if (moved.size() == 2)
        return text + tool::Format(" %zu and %zu exchanged", moved[0], moved[1]);
    for (const std::size_t source : sources)
        text += tool::Format(" %zu", source);
    return text;
}

bool IsOrder(Mistake mistake) {
    return mistake == Mistake::SwappedChannels || mistake == Mistake::ReversedColors ||
           mistake == Mistake::RotatedChannels;
}

} // namespace

bool Tolerance::Accepts(std::size_t channel, float actual, float expected, float stored) const {
    if (IsSame(actual, expected, GetFlushLimit(arithmetic, suiteCase.math)))
        return true;
    const ColorSpace space = static_cast<ColorSpace>(model.GetSet().colorSpaces[channel]);
    return suiteCase.linear && GetDistance(actual, expected) <= GetLinearBound(space, stored, arithmetic);
}

std::string Diagnosis::Find(const Tolerance& tolerance, const Evidence& evidence) {
    if (std::string order = FindOrder(tolerance, evidence); !order.empty())
        return order;
    const MistakeInfo* found = nullptr;
    for (const MistakeInfo& info : ListMistakes()) {
        if (info.kind == MistakeKind::State || IsOrder(info.mistake))
            continue;
        const bool isKnown = info.mistake == known_;
        if (!Explains(tolerance, evidence, info.mistake))
            continue;
        if (isKnown)
            return info.cause;
        if (found != nullptr && known_ == Mistake::None)
            return {}; // any of them
        found = found == nullptr ? &info : found;
    }
    if (found == nullptr || known_ != Mistake::None)
        return {}; // two causes in one run: neither is certain
    known_ = found->mistake;
    return found->cause;
}

} // namespace openntc::conformance
