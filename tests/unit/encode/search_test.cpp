// SPDX-License-Identifier: MIT
// Adaptive search on made-up quality curves.
#include "openntc/encode/AdaptiveSearch.h"

#include <doctest/doctest.h>

using namespace openntc;

namespace {

/// Runs a search where `bits` bits per pixel give offset + slope * ln(bits).
encode::AdaptiveSearch Search(double target, double offset, double slope) {
    auto search = *encode::AdaptiveSearch::Create(NTC_NETWORK_MEDIUM, target);
    while (!search.IsFinished())
        search.Report(offset + slope * std::log(static_cast<double>(search.GetNext().bitsPerPixel)));
    return search;
}

} // namespace

TEST_CASE("the search finds the smallest shape that reaches the target") {
    for (double slope : {3.0, 6.5, 9.0}) {
        for (double target : {28.0, 32.0, 36.0, 40.0, 44.0}) {
            CAPTURE(slope);
            CAPTURE(target);
            const auto search = Search(target, 30.0, slope);
            const auto& best = search.GetTrials()[search.GetBest()];
            float expected = 0.0f; // none reaches it
            for (int i = GetKnownLatentShapeCount(NTC_NETWORK_MEDIUM) - 1; i >= 0; --i) {
                const float bits = EnumerateKnownLatentShapes(i, NTC_NETWORK_MEDIUM)->bitsPerPixel;
                if (30.0 + slope * std::log(static_cast<double>(bits)) >= target)
                    expected = bits;
            }
            CHECK(search.IsReached() == (expected > 0.0f));
            CHECK(best.shape.bitsPerPixel == (expected > 0.0f ? expected : 20.0f));
            CHECK(search.GetTrials().size() <=
                  7); // a bisection of 26 shapes needs at most 5 and its two ends
        }
    }
}

TEST_CASE("a limit of bits per pixel is kept") {
    auto search = *encode::AdaptiveSearch::Create(NTC_NETWORK_SMALL, 60.0, 5.0);
    while (!search.IsFinished()) {
        CHECK(search.GetNext().bitsPerPixel <= 5.0f);
        search.Report(30.0);
    }
    CHECK_FALSE(search.IsReached());
    CHECK_FALSE(encode::AdaptiveSearch::Create(NTC_NETWORK_SMALL, 60.0, 0.1).has_value());
}
