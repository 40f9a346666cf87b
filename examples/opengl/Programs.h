// SPDX-License-Identifier: MIT
// The fragment shaders' main functions: GLSL 3.30, after the decoder and SAMPLE(texel, mip, channels).
#pragma once

#include "Host.h"

#include <string>

namespace opengl_example {

/// Every channel of the texel under the pixel.
extern const char* const kTexelsMain;

/// A sphere with the material on it, lit by one lamp and a sky; constants say which channels are what.
std::string MakeSphereMain(const Material& material);

} // namespace opengl_example
