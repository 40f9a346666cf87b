// SPDX-License-Identifier: MIT
// An independent model of the maths modes FP8, FP16 and FP32, written from the format specification and MathModes.h's
// definitions: plain loops over raw bytes in double, number formats by scaling and nearbyint. Shares no code with the
// shaders. Double holds every product and sum below exactly enough: rounding it to binary32 or binary16 once more gives
// the correctly rounded result, because 53 >= 2 * 24 + 2.
#pragma once

#include "openntc/InferenceConstants.h"

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace openntc::models {

/// What a model reads: views, nothing checked. Texels given with it are inside their mip.
struct ModelSource {
    const NtcTextureSetConstants* constants;
    std::span<const std::byte> latents;
    std::span<const std::byte> weights;
    int networkVersion;
};

/// Where a layer begins in the weights, its size, and its first row among those of all layers.
struct ModelLayer {
    std::size_t weights, inputs, rows, firstRow;
};

std::array<ModelLayer, 4> GetModelLayers(const ModelSource& source);

/// Inputs of the FP8 network (network 5; generations 2 and 3: InputsMips.h), before their rounding to E4M3.
std::vector<double> GetFP8ModelInputs(const ModelSource& source, int mip, int x, int y);

/// Layer 3 of the FP8 network on the bytes of layer 2: int32 sums, exact; binary32 outputs.
std::array<double, 16> EvaluateFP8OutputLayer(const ModelSource& source, std::span<const int> bytes);

/// FP8 of every generation, to be equalled bit for bit.
std::array<double, 16> DecodeFP8Model(const ModelSource& source, int mip, int x, int y);

/// FP16 of generation 1, to be equalled bit for bit.
std::array<double, 16> DecodeFP16Model(const ModelSource& source, int mip, int x, int y);

/// FP32 of generation 1 in double, and how far a binary32 evaluation may be from it.
struct BoundedOutputs {
    std::array<double, 16> values;
    std::array<double, 16> bounds;
    std::array<double, 16> deviations; ///< standard deviation of the error if roundings were independent
};

/// The bound, with u = 2^-24 and first-order terms enlarged by 1 %:
/// - Inputs. A corner's weight has three roundings (1 - dx, 1 - dy, their product), the product with the latent one,
///   the blend three additions: |error| <= 7 u sum |v w|. A wave or level of detail: tri's subtractions and the product,
///   <= 4 u 127.5.
/// - Row. n products and n + 1 additions in any order: |error| <= (n + 2) u (sum |q X| + |B'|) + sum |q| |error of X|,
///   times S, plus u |z| for the last product and u |z| for rounding B'.
/// - Activation. |f'| <= 3/2. Rounded: c is 1/3 within u/2, then two roundings: gate within 2 u; y = z gate: 3 * 2 u + 3 u.
///   X = 80 y adds u 240: |error of X| <= 80 (3/2 |error of z| + 9 u) + 240 u.
/// It grows by sum |q| S, some 30, in every layer, which no real error does. So the same terms are also added up as
/// variances, as if roundings were independent: a yardstick for what to expect, not a bound.
BoundedOutputs DecodeFP32Model(const ModelSource& source, int mip, int x, int y);

} // namespace openntc::models
