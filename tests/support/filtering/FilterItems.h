// SPDX-License-Identifier: MIT
// Items of every kind of filtering from a seed, edges of floats and of textures among them.
#pragma once

#include "FilterVectors.h"

#include <iterator>
#include <random>

namespace openntc_tests {

/// Floats at which something changes: zeros, denormals, ones, 64, 2^24, infinities, NaN.
inline constexpr std::uint32_t kFilterEdges[] = {
    0,          0x80000000, 1,          0x80000001, 0x007FFFFF, 0x00800000, 0x3F800000, 0xBF800000,
    0x3F000000, 0x3F7FFFFF, 0x40000000, 0xC0000000, 0x42800000, 0xC2800000, 0x42800001, 0x4B7FFFFF,
    0x4B800000, 0xCB800000, 0x7F7FFFFF, 0x7F800000, 0xFF800000, 0x7FC00000, 0xFFC00000, 0xBEAAAAAB};

/// `count` items. Gaussians only where `hasGaussian`: their weights are the device's.
inline std::vector<FilterItem> MakeFilterItems(std::size_t count, std::uint32_t seed, bool hasGaussian) {
    std::mt19937 random(seed);
    const auto below = [&random](std::uint32_t n) { return static_cast<std::uint32_t>(random()) % n; };
    const auto coordinate = [&] {
        if (below(8) == 0)
            return kFilterEdges[below(std::size(kFilterEdges))];
        return std::bit_cast<std::uint32_t>((static_cast<float>(below(1u << 24)) / 16777216.0f - 0.5f) *
                                            static_cast<float>(1u << below(6)));
    };
    const auto derivative = [&] {
        if (below(10) == 0)
            return kFilterEdges[below(std::size(kFilterEdges))];
        return (below(2) << 31) | ((100u + below(40)) << 23) | below(1u << 23);
    };
    std::vector<FilterItem> items;
    for (std::size_t i = 0; i < count; ++i) {
        FilterItem item = MakeFilterItem(static_cast<std::uint32_t>(i) % FILTER_KINDS);
        item.kernel = below(hasGaussian ? NTC_KERNEL_GAUSSIAN + 1 : NTC_KERNEL_GAUSSIAN);
        item.mips = below(2);
        item.wrapX = below(4);
        item.wrapY = below(4);
        item.width = static_cast<int>(below(4) == 0 ? 1 + below(4) : 1 + below(16384));
        item.height = static_cast<int>(below(4) == 0 ? 1 + below(4) : 1 + below(16384));
        item.levels = 1 + static_cast<int>(below(15));
        item.u = coordinate();
        item.v = coordinate();
        item.lod = static_cast<int>(below(static_cast<std::uint32_t>(item.levels) * 65536)) - 32768;
        item.taps = below(3) == 0 ? 1 + below(16) : 1;
        item.axisX = derivative();
        item.axisY = derivative();
        item.maxAnisotropy = 1 + below(16);
        item.lodBias = static_cast<int>(below(200000)) - 100000;
        const bool isWord = item.kind == FILTER_PCG || item.kind == FILTER_RANDOM;
        std::uint32_t* const numbers[] = {&item.r0, &item.r1, &item.r2, &item.r3};
        for (std::uint32_t* number : numbers)
            *number = isWord ? static_cast<std::uint32_t>(random()) : below(65536);
        if (item.kind == FILTER_STRETCH) {
            item.r0 = static_cast<std::uint32_t>(random());
            item.r1 = 1 + below(65535);
        }
        std::uint32_t* const gradients[] = {&item.dudx, &item.dvdx, &item.dudy, &item.dvdy};
        for (std::uint32_t* gradient : gradients)
            *gradient = derivative();
        item.index = static_cast<std::uint32_t>(random()) % (item.kind == FILTER_RANDOM ? 65536 : 32);
        items.push_back(item);
    }
    return items;
}

} // namespace openntc_tests
