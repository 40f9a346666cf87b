// SPDX-License-Identifier: MIT
// A network of random numbers and the references of a tile, for tests of the training's kernels.
#pragma once

#include "openntc/encode/detail/LatentStore.h"
#include "openntc/encode/detail/NetworkState.h"
#include "openntc/encode/detail/Random.h"
#include "openntc/encode/detail/TrainingSet.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace openntc_tests {

/// Weights of variance `variance` / inputs, biases of 0.25.
inline void FillNetwork(openntc::encode::detail::NetworkState& network,
                        const openntc::encode::detail::NetworkShape& shape, float variance,
                        openntc::encode::detail::RandomStream& random) {
    using namespace openntc::encode::detail;
    for (int layer = 0; layer < kLayers; ++layer) {
        const int outputs = shape.LayerOutputs(layer),
                  inputs = layer == 0 ? shape.Inputs() : shape.LayerInputs(layer);
        for (int o = 0; o < outputs; ++o) {
            network.biases[NetworkShape::BiasOffset(layer) + o] = 0.5f * random.NextNormal();
            for (int i = 0; i < inputs; ++i)
                network.weights[static_cast<std::size_t>(shape.WeightOffset(layer) +
                                                         WeightIndex(outputs, i, o))] =
                    random.NextNormal() * std::sqrt(variance / static_cast<float>(inputs));
        }
    }
}

/// Points the context to the network, with three channels of outputs 1, 6 and 11; returns their references of a tile.
inline std::vector<std::uint16_t> FillContext(openntc::encode::detail::KernelContext& context,
                                              const openntc::encode::detail::NetworkShape& shape,
                                              const openntc::encode::detail::NetworkState& network,
                                              openntc::encode::detail::RandomStream& random) {
    using namespace openntc::encode::detail;
    context.shape = shape;
    context.packed = &network.packed;
    context.channels = 3;
    for (int c = 0; c < 3; ++c) {
        context.outputOf[c] = 5 * c + 1;
        context.gain[c] = 1.0f + static_cast<float>(c);
        context.squaredRange[c] = 1.0f;
    }
    std::vector<std::uint16_t> reference;
    for (int i = 0; i < 3 * kTileTexels; ++i)
        reference.push_back(static_cast<std::uint16_t>(random.NextBits() & 0xffffu));
    return reference;
}

/// The tile of a mip of width x height texels whose first texel is (left, top), with where its latents are.
inline openntc::encode::detail::TileTask MakeTile(const openntc::encode::detail::MipGeometry& mip, int left,
                                                  int top, int width, int height,
                                                  const std::vector<std::uint16_t>& reference) {
    using namespace openntc::encode::detail;
    TileTask task;
    task.mip = &mip;
    task.x = left;
    task.y = top;
    task.width = std::min(kTileWidth, width - left);
    task.height = std::min(kTileHeight, height - top);
    task.reference = reference.data();
    PlaceLocalGrid(task.high, mip.highX, mip.highY, left, top, task.width, task.height);
    PlaceLocalGrid(task.low, mip.lowX, mip.lowY, left, top, task.width, task.height);
    return task;
}

} // namespace openntc_tests
