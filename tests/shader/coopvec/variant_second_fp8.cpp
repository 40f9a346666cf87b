// SPDX-License-Identifier: MIT
#define EMULATED_NAME EvaluateSecondFP8
#define EMULATED_NETWORK NTC_NETWORK_GENERATION_2
#define EMULATED_MATH NTC_MATH_COOPVEC_FP8
#include "EmulatedVariant.h"
