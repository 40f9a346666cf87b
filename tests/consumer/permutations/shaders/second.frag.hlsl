// SPDX-License-Identifier: MIT
#include "both.h"
#ifndef NTC_HLSL
#error NTC_HLSL is not defined
#endif

float4 main(float4 position : SV_Position) : SV_Target0 {
    return position * float(BOTH_VALUE + NETWORK_VERSION + SHAPE);
}

float4 Twice(float4 position : SV_Position) : SV_Target0 {
    return position * float(2 * BOTH_VALUE);
}
