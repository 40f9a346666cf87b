// SPDX-License-Identifier: MIT
#define EMULATED_NAME EvaluateMediumInt8
#define EMULATED_NETWORK NTC_NETWORK_MEDIUM
#define EMULATED_MATH NTC_MATH_COOPVEC_INT8
#include "EmulatedVariant.h"
