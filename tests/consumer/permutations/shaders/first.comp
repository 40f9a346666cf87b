// SPDX-License-Identifier: MIT
#version 460
#include "first.h"
#include "openntc/InferenceConstants.h"

layout(local_size_x = 1) in;
layout(std430, binding = 0) buffer Results { int results[]; };

void main() {
    results[0] = FIRST_VALUE + NETWORK_VERSION + SHAPE;
}
