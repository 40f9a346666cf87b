// SPDX-License-Identifier: MIT
// The shader headers in a C++ program of a platform that has these names as macros.
#include <bit>
#include <cfloat>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include <glm/vec2.hpp>
#include <glm/vec4.hpp>

#define min(a, b) ((a) < (b) ? (a) : (b))
#define max(a, b) ((a) > (b) ? (a) : (b))
#define abs(x) ((x) > 0 ? (x) : -(x))
#define round(x) ((x) >= 0 ? (long)((x) + 0.5) : (long)((x)-0.5))
#define floor(x) myFloor(x)
#define sqrt(x) mySqrt(x)
#define exp(x) myExp(x)
#define log(x) myLog(x)
#define pow(x, y) myPow(x, y)

// A host's macros stand for functions that it has.
namespace openntc::shader {
float myFloor(float x);
float mySqrt(float x);
float myExp(float x);
float myLog(float x);
float myPow(float x, float y);
} // namespace openntc::shader

#define NETWORK_VERSION 1
#include "openntc/Inference.h"

int Decode(const openntc::NtcTextureSetConstants& constants, openntc::shader::NtcBuffer latents,
           openntc::shader::NtcBuffer weights, float (&outputs)[16]) {
    using namespace openntc::shader;
    return NtcSampleTextureSet(constants, latents, 0, weights, 0, int2(1, 2), 0, true, outputs) ? 1 : 0;
}
