// SPDX-License-Identifier: MIT
// Covering sets: few rows in which every pair of values of two factors occurs. Greedy and without chance, so that the same
// factors always give the same rows.
#pragma once

#include <cstddef>
#include <set>
#include <tuple>
#include <vector>

namespace openntc_tests {

using Row = std::vector<std::size_t>; ///< a value's index for every factor
/// Factor a, its value, factor b > a, its value.
using Pair = std::tuple<std::size_t, std::size_t, std::size_t, std::size_t>;

/// Every pair that a covering set must hold; `counts` are the factors' numbers of values.
inline std::set<Pair> ListPairs(const std::vector<std::size_t>& counts) {
    std::set<Pair> pairs;
    for (std::size_t a = 0; a < counts.size(); ++a) {
        for (std::size_t b = a + 1; b < counts.size(); ++b) {
            for (std::size_t i = 0; i < counts[a]; ++i) {
                for (std::size_t k = 0; k < counts[b]; ++k)
                    pairs.emplace(a, i, b, k);
            }
        }
    }
    return pairs;
}

/// The pairs that occur in `rows`.
inline std::set<Pair> ListCoveredPairs(const std::vector<Row>& rows) {
    std::set<Pair> pairs;
    for (const Row& row : rows) {
        for (std::size_t a = 0; a < row.size(); ++a) {
            for (std::size_t b = a + 1; b < row.size(); ++b)
                pairs.emplace(a, row[a], b, row[b]);
        }
    }
    return pairs;
}

inline std::vector<Row> MakePairwiseCover(const std::vector<std::size_t>& counts) {
    std::set<Pair> open = ListPairs(counts);
    std::vector<Row> rows;
    while (!open.empty()) {
        // The first pair still open, then for each factor in turn the value that closes most pairs with those chosen.
        const auto [firstFactor, firstValue, secondFactor, secondValue] = *open.begin();
        Row row(counts.size());
        std::vector<bool> chosen(counts.size());
        row[firstFactor] = firstValue;
        row[secondFactor] = secondValue;
        chosen[firstFactor] = chosen[secondFactor] = true;
        for (std::size_t factor = 0; factor < counts.size(); ++factor) {
            if (chosen[factor])
                continue;
            std::size_t best = 0, bestClosed = 0;
            for (std::size_t offset = 0; offset < counts[factor]; ++offset) {
                const std::size_t value = (offset + rows.size()) % counts[factor]; // equal ones take turns
                std::size_t closed = 0;
                for (std::size_t other = 0; other < counts.size(); ++other) {
                    if (!chosen[other])
                        continue;
                    closed += other < factor ? open.count({other, row[other], factor, value})
                                             : open.count({factor, value, other, row[other]});
                }
                if (offset == 0 || closed > bestClosed) {
                    best = value;
                    bestClosed = closed;
                }
            }
            row[factor] = best;
            chosen[factor] = true;
        }
        for (const Pair& pair : ListCoveredPairs({row}))
            open.erase(pair);
        rows.push_back(row);
    }
    return rows;
}

} // namespace openntc_tests
