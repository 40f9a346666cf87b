// SPDX-License-Identifier: MIT
// The ground: gentle hills, the same function for the shader that looks for them and the camera that stays
// above.
#ifndef OPENNTC_LANDSCAPE_TERRAIN_H
#define OPENNTC_LANDSCAPE_TERRAIN_H

#include "openntc/Portability.h"
#if defined(__cplusplus)
#include <cmath>
#define LANDSCAPE_SIN std::sin
#else
#define LANDSCAPE_SIN sin
#endif

NTC_NAMESPACE_BEGIN

#define LANDSCAPE_HIGHEST 9.5f // metres: the sum of all amplitudes
#define LANDSCAPE_STEEPEST 0.4f

/// Metres above or below the mean at (x, z).
NTC_FUNCTION float GetTerrainHeight(float x, float z) {
    return 6.0f * LANDSCAPE_SIN(0.021f * x + 0.4f) * LANDSCAPE_SIN(0.017f * z + 1.9f) +
           2.5f * LANDSCAPE_SIN(0.055f * x + 1.3f) * LANDSCAPE_SIN(0.048f * z + 0.7f) +
           1.0f * LANDSCAPE_SIN(0.11f * x) * LANDSCAPE_SIN(0.09f * z + 2.0f);
}

NTC_NAMESPACE_END

#undef LANDSCAPE_SIN
#endif
