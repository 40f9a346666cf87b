// SPDX-License-Identifier: MIT
#define EMULATED_NAME EvaluateSecondInt8
#define EMULATED_NETWORK NTC_NETWORK_GENERATION_2
#define EMULATED_MATH NTC_MATH_COOPVEC_INT8
#include "EmulatedVariant.h"
