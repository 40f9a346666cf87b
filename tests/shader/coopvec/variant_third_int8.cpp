// SPDX-License-Identifier: MIT
#define EMULATED_NAME EvaluateThirdInt8
#define EMULATED_NETWORK NTC_NETWORK_GENERATION_3
#define EMULATED_MATH NTC_MATH_COOPVEC_INT8
#include "EmulatedVariant.h"
