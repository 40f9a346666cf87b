// SPDX-License-Identifier: MIT
// The specification's vectors, bit for bit.
#include "support/Vectors.h"
#include "support/filtering/FilterVectors.h"

#include <doctest/doctest.h>

#include <map>

using namespace openntc_tests;

TEST_CASE("filtering: all vectors, bit for bit") {
    const std::vector<FilterVector> vectors = ReadFilterVectors();
    if (vectors.empty()) {
        MESSAGE("SKIP: no vectors of filtering: set OPENNTC_SHARED_DIR");
        return;
    }
    std::map<std::string, int> ran;
    int different = 0;
    for (const FilterVector& vector : vectors) {
        const std::vector<std::uint32_t> words = RunFilter(vector.item);
        ++ran[vector.name];
        if (CountDifferences(vector, words.data()) == 0)
            continue;
        if (++different <= 5) {
            for (const auto& word : vector.words) {
                if (words[word.first] != word.second)
                    MESSAGE(vector.name << " word " << word.first << ": " << words[word.first] << ", not "
                                        << word.second);
            }
            for (const auto& part : vector.fractions)
                MESSAGE(vector.name << " weight " << part.first << ": " << words[part.first] << ", not "
                                    << part.second);
        }
    }
    CHECK(different == 0);
    for (const auto& [name, least] : {std::pair{"coord", 200}, std::pair{"log2", 48},
                                      std::pair{"lod, anisotropic", 60}, std::pair{"stretch", 20}})
        CHECK(ran[name] == least);
    int picks = 0;
    for (const auto& [name, count] : ran)
        picks += name.ends_with("pick") ? count : 0;
    CHECK(picks == 400);
    ReportVectors("filtering", static_cast<int>(vectors.size()), 0);
}
