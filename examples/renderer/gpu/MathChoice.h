// SPDX-License-Identifier: MIT
// Which maths mode shaders decode with, by what was asked for and what there is. Needs no device.
#pragma once

#include "vulkan_harness/Devices.h"

#include <functional>
#include <string>
#include <vector>

namespace openntc::renderer {

/// In the place of NTC_MATH_*: the fastest mode that has the bits of NTC_MATH_INT8.
inline constexpr int kFastestMath = 0;

/// NTC_MATH_COOPVEC_*.
bool UsesVectors(int math);

/// What was asked for, and what stands in for it, in order; the last needs nothing of a device.
std::vector<int> ListMathModes(int wanted);

/// What there is.
struct MathOffer {
    const harness::DeviceInfo* device = nullptr;
    bool allowsVectorsInt8 = true; ///< --no-coopvec-int8
    bool allowsVectorsFP8 = true;  ///< --no-coopvec-fp8
    /// Why cooperative vectors cannot be compiled; empty: they can. Called only where the device has them.
    std::function<std::string()> whyNoCompiler;
};

/// Why a mode is not to be had, and whether it is worth telling somebody who did not ask for that mode: the device could.
struct MathObstacle {
    std::string text; ///< empty: none
    bool isMendable = false;
};

MathObstacle FindObstacle(int math, const MathOffer& offer);

/// A mode, and why it is not the one that was asked for.
struct MathChoice {
    int math = 0;
    std::string reason;    ///< "coopvec_int8: …"; empty: it is, or of kFastestMath the first
    bool isNotable = true; ///< worth a line
};

/// Takes the first mode of ListMathModes without an obstacle for which `test` (the self-test) returns nothing; else it returns what
/// is wrong. Without any, the result's `math` is 0 and `reason` is the last mode's.
MathChoice ChooseMath(int wanted, const MathOffer& offer, const std::function<std::string(int math)>& test);

} // namespace openntc::renderer
