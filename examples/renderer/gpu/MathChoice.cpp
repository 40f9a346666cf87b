// SPDX-License-Identifier: MIT
#include "renderer/gpu/MathChoice.h"

#include "renderer/gpu/CommandLine.h"

#include "openntc/MathModes.h"

namespace openntc::renderer {

bool UsesVectors(int math) {
    return math == NTC_MATH_COOPVEC_INT8 || math == NTC_MATH_COOPVEC_FP8;
}

// INT8 is arithmetic of integers, which hardware and compilers are least likely to get wrong.
std::vector<int> ListMathModes(int wanted) {
    switch (wanted) {
    case kFastestMath:
        return {NTC_MATH_COOPVEC_INT8, NTC_MATH_INT8};
    case NTC_MATH_COOPVEC_FP8: // as MathPreference::FP8First
        return {NTC_MATH_COOPVEC_FP8, NTC_MATH_COOPVEC_INT8, NTC_MATH_INT8};
    case NTC_MATH_INT8:
        return {NTC_MATH_INT8};
    default:
        return {wanted, NTC_MATH_INT8};
    }
}

MathObstacle FindObstacle(int math, const MathOffer& offer) {
    if (!UsesVectors(math))
        return {};
    const bool isFP8 = math == NTC_MATH_COOPVEC_FP8;
    if (isFP8 ? !offer.allowsVectorsFP8 : !offer.allowsVectorsInt8)
        return {isFP8 ? "switched off (--no-coopvec-fp8)" : "switched off (--no-coopvec-int8)"};
    const CoopVecDevice& vectors = offer.device->cooperativeVectors;
    constexpr auto kFeature = harness::Feature::CooperativeVectors;
    if (!offer.device->features.Has(kFeature))
        return {std::string(harness::GetFeatureName(kFeature)) + ": " +
                offer.device->features.GetAbsence(kFeature)};
    if (!vectors.hasInt8 || (isFP8 && !vectors.hasE4M3))
        return {"the device has cooperative vectors of other types"};
    if (!offer.device->hasFragmentVectors)
        return {"the device has no cooperative vectors in fragment shaders"};
    return {offer.whyNoCompiler(), true};
}

MathChoice ChooseMath(int wanted, const MathOffer& offer, const std::function<std::string(int math)>& test) {
    MathChoice choice;
    choice.isNotable = wanted != kFastestMath;
    std::string last;
    for (const int math : ListMathModes(wanted)) {
        MathObstacle obstacle = FindObstacle(math, offer);
        if (obstacle.text.empty())
            obstacle = {test(math), true};
        if (obstacle.text.empty()) {
            choice.math = math;
            return choice;
        }
        choice.isNotable = choice.isNotable || obstacle.isMendable;
        if (obstacle.text != last) // two modes that lack the same are one reason
            choice.reason +=
                (last.empty() ? "" : "; ") + std::string(GetMathName(math)) + ": " + obstacle.text;
        last = std::move(obstacle.text);
    }
    choice.reason = std::move(last);
    return choice;
}

} // namespace openntc::renderer
