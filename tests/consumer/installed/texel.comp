// SPDX-License-Identifier: MIT
#version 460
#extension GL_GOOGLE_include_directive : require
#include "openntc/InferenceConstants.h"

layout(local_size_x = 1) in;
layout(std430, binding = 0) buffer Sizes { int sizes[]; };
layout(std140, binding = 1) uniform Constants { NtcTextureSetConstants constants; };

void main() {
    sizes[0] = constants.imageWidth;
    sizes[1] = NETWORK_VERSION;
}
