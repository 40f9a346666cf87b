// SPDX-License-Identifier: MIT
#define EMULATED_NAME EvaluateThirdExplicit
#define EMULATED_NETWORK NTC_NETWORK_GENERATION_3
#define EMULATED_MATH NTC_MATH_COOPVEC_INT8
#define NTC_COOPVEC_EXPLICIT 1
#include "EmulatedVariant.h"
