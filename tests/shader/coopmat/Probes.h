// SPDX-License-Identifier: MIT
// Layouts of an accumulator, as passes/ProbeCoopMat would find them on a device.
#pragma once

#include "openntc/inference/CooperativeMatrices.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <random>
#include <vector>

namespace openntc_tests {

/// What ProbeCoopMat writes for a layout with these orders of rows and columns.
inline std::vector<std::int32_t> MakeProbe(const std::array<int, 16>& rows,
                                           const std::array<int, 16>& columns,
                                           const std::array<int, 32>& lanes) {
    std::vector<std::int32_t> probe(openntc::kCoopMatLanes * openntc::kCoopMatProbeNumbers);
    for (std::size_t i = 0; i < 32; ++i) {
        const std::size_t pair = i / 4, group = i % 4;
        const std::size_t at = static_cast<std::size_t>(lanes[i]) * openntc::kCoopMatProbeNumbers;
        for (std::size_t e = 0; e < 8; ++e)
            probe[at + e] = 16 * rows[2 * pair + e / 4] + columns[4 * group + e % 4];
        probe[at + 8] = 8;
    }
    return probe;
}

/// Lane l has rows l / 4 and 8 + l / 4, columns 2 (l % 4), the next, and the same 8 further, as on NVIDIA's GPUs.
inline std::vector<std::int32_t> MakeKnownProbe() {
    std::array<int, 16> rows{}, columns{};
    for (int i = 0; i < 16; ++i) {
        rows[static_cast<std::size_t>(i)] = i / 2 + 8 * (i % 2);
        columns[static_cast<std::size_t>(i)] = 2 * (i / 4) + i % 2 + 8 * (i / 2 % 2);
    }
    std::array<int, 32> lanes{};
    std::iota(lanes.begin(), lanes.end(), 0);
    return MakeProbe(rows, columns, lanes);
}

inline std::vector<std::int32_t> MakeRandomProbe(std::mt19937& random) {
    std::array<int, 16> rows{}, columns{};
    std::array<int, 32> lanes{};
    std::iota(rows.begin(), rows.end(), 0);
    std::iota(columns.begin(), columns.end(), 0);
    std::iota(lanes.begin(), lanes.end(), 0);
    std::shuffle(rows.begin(), rows.end(), random);
    std::shuffle(columns.begin(), columns.end(), random);
    std::shuffle(lanes.begin(), lanes.end(), random);
    return MakeProbe(rows, columns, lanes);
}

} // namespace openntc_tests
