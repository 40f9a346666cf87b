// SPDX-License-Identifier: MIT
#define EMULATED_NAME EvaluateMediumFP8
#define EMULATED_NETWORK NTC_NETWORK_MEDIUM
#define EMULATED_MATH NTC_MATH_COOPVEC_FP8
#include "EmulatedVariant.h"
