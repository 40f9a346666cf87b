// SPDX-License-Identifier: MIT
#define EMULATED_NAME EvaluateThirdFP8
#define EMULATED_NETWORK NTC_NETWORK_GENERATION_3
#define EMULATED_MATH NTC_MATH_COOPVEC_FP8
#include "EmulatedVariant.h"
