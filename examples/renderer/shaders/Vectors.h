// SPDX-License-Identifier: MIT
// What the renderer's maths needs beyond openntc/Portability.h: three components, and the functions of
// vectors under the names that GLSL and HLSL share.
#ifndef OPENNTC_RENDERER_VECTORS_H
#define OPENNTC_RENDERER_VECTORS_H

#include "openntc/Portability.h"

#if defined(__cplusplus)
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

namespace openntc::shader {

using float3 = glm::vec3;
using glm::abs;
using glm::clamp;
using glm::cross;
using glm::dot;
using glm::max;
using glm::min;
using glm::normalize;

} // namespace openntc::shader
#elif !defined(NTC_HLSL)
#ifndef float3
#define float3 vec3
#endif
#endif

#define NTCR_PI 3.14159265f

NTC_NAMESPACE_BEGIN

NTC_FUNCTION float NtcrSquare(float x) {
    return x * x;
}

NTC_FUNCTION float3 NtcrGray(float x) {
    return float3(x, x, x);
}

/// a at t = 0, b at t = 1: what GLSL and HLSL have different names for.
NTC_FUNCTION float3 NtcrMix(float3 a, float3 b, float t) {
    return a + (b - a) * t;
}

NTC_FUNCTION float NtcrGetLargest(float3 v) {
    return max(max(v.x, v.y), v.z);
}

NTC_NAMESPACE_END

#endif
