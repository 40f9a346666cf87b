// SPDX-License-Identifier: MIT
// Latents of generation 3: who reads which around the edges, and how they are packed.
#include "openntc/encode/detail/FileAssembly.h"
#include "openntc/encode/detail/LatentRefiner.h"

#include <doctest/doctest.h>

using namespace openntc;
using namespace openntc::encode;
using namespace openntc::encode::detail;

TEST_CASE("generation 3: footprints are the texels whose taps read a pixel, around the edges too") {
    for (int texels : {1, 2, 5, 37, 94}) {
        for (int latents : {1, 2, 3, 9, 47, 94, 95}) {
            CAPTURE(texels);
            CAPTURE(latents);
            const AxisTaps taps = MakeAxisTaps(texels, latents, true);
            const AxisFootprints footprints = AxisFootprints::MakeWrapped(taps, latents);
            for (int pixel = 0; pixel < latents; ++pixel) {
                const auto p = static_cast<std::size_t>(pixel);
                for (int t = 0; t < texels; ++t) {
                    const auto at = static_cast<std::size_t>(t);
                    const bool reads = WrapLatent(taps.first[at], latents) == pixel ||
                                       WrapLatent(taps.second[at], latents) == pixel;
                    const auto isInside = [&](int texel) {
                        return texel >= footprints.begin[p] && texel < footprints.end[p];
                    };
                    CHECK(reads == (isInside(t) || isInside(t + texels)));
                }
                CHECK(footprints.end[p] - footprints.begin[p] <= texels);
            }
        }
    }
}

TEST_CASE(
    "generation 3: no texel reads two pixels of a class that moves, and every pixel moves in some sweep") {
    for (int count = 1; count < 12; ++count) {
        CAPTURE(count);
        std::vector<int> moved(static_cast<std::size_t>(count));
        for (int turn = 0; turn < count; ++turn) {
            for (int odd = 0; odd < 2; ++odd) {
                const AxisClass axis{count, odd, turn, true};
                for (int i = 0; i < axis.GetCount(); ++i) {
                    CHECK(axis.Has(axis.GetPixel(i)));
                    CHECK(axis.Has(axis.GetPixel(i) - count));
                    ++moved[static_cast<std::size_t>(axis.GetPixel(i))];
                }
                int members = 0;
                for (int pixel = 0; pixel < count; ++pixel) {
                    members += axis.Has(pixel) ? 1 : 0;
                    CHECK((count == 1 || !(axis.Has(pixel) && axis.Has(pixel + 1))));
                }
                CHECK(members == axis.GetCount());
            }
        }
        for (const int times : moved)
            CHECK(times >= std::max(count - 1, 1));
    }
}

TEST_CASE("generation 3: four features to a texel of 16 bits, the first in the lowest bits") {
    LatentPlanes grid;
    grid.Create({5, 3}, 8, MakeBlendedQuantiser());
    for (std::size_t i = 0; i < grid.values.size(); ++i)
        grid.values[i] = static_cast<float>(i * 7 % 16) / 15.0f;
    const std::vector<std::byte> bytes = PackLayers(grid);
    REQUIRE(bytes.size() == 60);
    for (std::size_t layer = 0; layer < 2; ++layer) {
        for (std::size_t pixel = 0; pixel < 15; ++pixel) {
            const std::size_t at = 2 * (15 * layer + pixel);
            const unsigned texel = static_cast<unsigned>(bytes[at]) | static_cast<unsigned>(bytes[at + 1])
                                                                          << 8;
            for (std::size_t k = 0; k < 4; ++k)
                CHECK((texel >> (4 * k) & 15u) == ((4 * layer + k) * 15 + pixel) * 7 % 16);
        }
    }
}
