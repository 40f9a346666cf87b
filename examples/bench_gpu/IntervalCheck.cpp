// SPDX-License-Identifier: MIT
#include "IntervalCheck.h"

#include "models/FP8Interval.h"

#include <algorithm>
#include <thread>

namespace openntc::bench {

namespace {

constexpr std::size_t kMaxTexels = 16'384; // some tens of microseconds each

struct Excess {
    std::size_t inside = 0;
    double worst = 0; ///< distance from the interval
    double widest = 0;
    double widths = 0; ///< their sum

    void Add(double value, const models::Interval& interval) {
        const double excess = std::max(interval.low - value, value - interval.high);
        inside += excess <= 0 ? 1u : 0u;
        worst = excess <= worst ? worst : excess; // NaN counts
        widest = std::max(widest, interval.high - interval.low);
        widths += interval.high - interval.low;
    }
};

} // namespace

std::string CheckFP8Intervals(const Set& set, int network, int size, std::span<const float> values) {
    const models::ModelSource source = {&set.constants[1], set.latents, set.weights[1], network};
    const std::size_t texels = std::min(values.size() / 16, kMaxTexels);
    const std::size_t threadCount = std::max(1u, std::thread::hardware_concurrency());
    std::string json = ",\"fp8Intervals\":[";
    // The activation of the shaders is `precise`.
    struct {
        int accumulatorBits;
        const char* name;
        models::FP8Assumptions assumptions;
    } const kAssumptions[] = {
        {24, "binary32 sums in any order", {.contraction = false}},
        {13, "14-bit sums in any order", {.unit = 0x1p-13, .contraction = false}},
        {11, "binary16 sums in any order", {.unit = 0x1p-11, .contraction = false}},
        {11,
         "binary16 sums of blocks of 16, activations in binary16",
         {.halfInputs = true, .block = 16, .contraction = false}},
    };
    for (const auto& [bits, name, assumptions] : kAssumptions) {
        const models::FP8Interval interval(assumptions);
        std::vector<Excess> parts(threadCount);
        std::vector<std::thread> threads;
        for (std::size_t part = 0; part < threadCount; ++part) {
            threads.emplace_back([&, part] {
                for (std::size_t i = part; i < texels; i += threadCount) {
                    const int x = static_cast<int>(i % static_cast<std::size_t>(size));
                    const int y = static_cast<int>(i / static_cast<std::size_t>(size));
                    const auto expected = interval.Decode(source, 0, x, y);
                    for (std::size_t c = 0; c < 16; ++c)
                        parts[part].Add(static_cast<double>(values[16 * i + c]), expected[c]);
                }
            });
        }
        for (std::thread& thread : threads)
            thread.join();
        Excess total;
        for (const Excess& part : parts) {
            total.inside += part.inside;
            total.worst = part.worst <= total.worst ? total.worst : part.worst;
            total.widest = std::max(total.widest, part.widest);
            total.widths += part.widths;
        }
        const double count = static_cast<double>(16 * texels);
        const double fraction = static_cast<double>(total.inside) / count;
        std::printf("    FP8 interval, %s: %zu of %zu inside (%.6f), worst excess %.3g (%.2f steps of "
                    "1/255), intervals %.3g wide on average, %.3g at most\n",
                    name, total.inside, 16 * texels, fraction, total.worst, total.worst * 255,
                    total.widths / count, total.widest);
        char text[320];
        std::snprintf(text, sizeof text,
                      "%s{\"accumulatorBits\":%d,\"assumptions\":\"%s\",\"values\":%zu,\"inside\":%zu,"
                      "\"worstExcess\":%.6g,\"widestInterval\":%.6g}",
                      bits == 24 ? "" : ",", bits, name, 16 * texels, total.inside, total.worst,
                      total.widest);
        json += text;
    }
    return json + "]";
}

} // namespace openntc::bench
