// SPDX-License-Identifier: MIT
#include "Generations.h"

#include "openntc/MathModes.h"

#include <algorithm>
#include <string_view>

namespace openntc::bench {

namespace {

constexpr std::string_view kTextureEnding = "-texture"; // of variants whose latents are one

struct Timed {
    Variant variant;
    harness::ComputePipeline kernel;
    BenchBuffers* buffers = nullptr;
    std::vector<double> nanoseconds; ///< per texel, of each round
};

/// The variant of generation 1 that does the same, or null.
const Timed* FindFirst(const std::vector<std::unique_ptr<Timed>>& all, const Timed& later) {
    std::string_view name = later.variant.name;
    if (name.ends_with(kTextureEnding))
        name.remove_suffix(kTextureEnding.size());
    for (const std::unique_ptr<Timed>& timed : all) {
        if (timed->variant.network == NTC_NETWORK_MEDIUM && timed->variant.name == name)
            return timed.get();
    }
    return nullptr;
}

double GetQuantile(std::vector<double> values, double fraction) {
    std::sort(values.begin(), values.end());
    return values[static_cast<std::size_t>(fraction * static_cast<double>(values.size() - 1))];
}

void PrintRow(const Timed& timed, const Timed* first) {
    std::printf("| %s | %s | %.4f | %.4f (%.4f – %.4f) |", timed.variant.name.c_str(),
                GetNetworkName(timed.variant.network), GetQuantile(timed.nanoseconds, 0),
                GetMedian(timed.nanoseconds), GetQuantile(timed.nanoseconds, 0.25),
                GetQuantile(timed.nanoseconds, 0.75));
    if (first == nullptr || first == &timed) {
        std::printf(" |\n");
        return;
    }
    std::vector<double> ratios;
    for (std::size_t i = 0; i < timed.nanoseconds.size(); ++i)
        ratios.push_back(timed.nanoseconds[i] / first->nanoseconds[i]);
    std::printf(" %.3f (%.3f – %.3f) |\n", GetMedian(ratios), GetQuantile(ratios, 0.25),
                GetQuantile(ratios, 0.75));
}

/// Sets of each network, and what they are on the device for each kind of weights.
class Sets {
public:
    Sets(harness::Context& device, int size) : device_(device), size_(size) {}

    BenchBuffers& Get(const Variant& v) {
        std::unique_ptr<Set>& set = sets_[v.network];
        if (!set)
            set = MakeSet(v.network, size_);
        // A maths mode's own, but those with the same weights share them.
        const int weights = UsesVectors(v.math) ? v.math : UsesFP8(v.math) ? NTC_MATH_FP8 : NTC_MATH_INT8;
        std::unique_ptr<BenchBuffers>& buffers = buffers_[{v.network, weights}];
        if (!buffers) {
            const DeviceWeights own = MakeDeviceWeights(device_, v, *set);
            buffers = std::make_unique<BenchBuffers>(device_, own.constants, set->latents, own.weights,
                                                     std::uint64_t{32} * static_cast<std::uint64_t>(size_) *
                                                         static_cast<std::uint64_t>(size_));
        }
        if (v.latentTexture)
            buffers->MakeLatentTexture(*set->metadata);
        return *buffers;
    }

private:
    harness::Context& device_;
    int size_;
    std::map<int, std::unique_ptr<Set>> sets_;
    std::map<std::pair<int, int>, std::unique_ptr<BenchBuffers>> buffers_;
};

double TimeOne(harness::Context& device, const Timed& timed, int size, int dispatches) {
    const auto width = static_cast<std::uint32_t>(size);
    const Variant& v = timed.variant;
    const std::vector<double> ms =
        TimeKernel(device, timed.kernel, timed.buffers->Bind(v.uniformWeights), width,
                   width / (8 * static_cast<std::uint32_t>(v.texels)), width / 8, dispatches,
                   v.latentTexture ? timed.buffers->GetLatentTexture() : nullptr);
    return GetMedian(ms) * 1e6 / (static_cast<double>(size) * size);
}

} // namespace

int PrintGenerations(harness::Context& device, const Options& options) {
    Sets sets(device, options.size);
    std::vector<std::unique_ptr<Timed>> all;
    std::vector<Variant> variants = ReadIndex(options);
    const auto hasLater = [&](const Variant& v) {
        return std::any_of(variants.begin(), variants.end(), [&](const Variant& other) {
            return other.name == v.name && !IsNetworkVersion(other.network);
        });
    };
    for (const Variant& v : variants) {
        const bool isOfAll = v.network == NTC_NETWORK_MEDIUM && hasLater(v);
        if (v.stage >= kPipelineStage || (!isOfAll && IsNetworkVersion(v.network)))
            continue;
        if (const char* const skip = FindObstacle(device, v); skip != nullptr) {
            std::printf("%s %d SKIP: %s\n", v.name.c_str(), v.network, skip);
            continue;
        }
        Expected<harness::ComputePipeline> kernel =
            MakeKernel(device, ReadWords(options.folder + "/" + v.file16), v.uniformWeights, v.latentTexture);
        if (!kernel) {
            std::printf("%s %d SKIP: %s\n", v.name.c_str(), v.network, kernel.error().GetText());
            continue;
        }
        all.push_back(std::make_unique<Timed>(Timed{v, std::move(*kernel), &sets.Get(v), {}}));
    }
    const int dispatches = device.GetDevice().isCpu ? 1 : 4; // of a round
    for (int round = 0; round <= options.repetitions; ++round) {
        for (const std::unique_ptr<Timed>& timed : all) {
            const double time = TimeOne(device, *timed, options.size, dispatches);
            if (round > 0) // the first makes machine code, and raises clocks
                timed->nanoseconds.push_back(time);
        }
    }
    std::printf("\n| variant | network | ns/texel, best | median (quartiles) | by medium, round by round |\n"
                "|---|---|---|---|---|\n");
    for (const std::unique_ptr<Timed>& timed : all)
        PrintRow(*timed, FindFirst(all, *timed));
    return all.empty() ? 1 : 0;
}

} // namespace openntc::bench
