// SPDX-License-Identifier: MIT
#include "FetchForms.h"

#include "openntc/MathModes.h"

#include <algorithm>
#include <ctime>

namespace openntc::bench {

namespace {

constexpr int kFormSide = 128; // the straightforward form takes tenths of a second for it on a CPU

struct Form {
    Variant variant;
    harness::ComputePipeline kernel;
    double firstDispatch = 0;
    bool isEqual = true;
    std::vector<double> nanoseconds; // per texel: the best of two dispatches
    std::vector<double> processor;   // the same of the process's processor time, all threads
};

double GetProcessorSeconds() {
    return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

double GetBest(const std::vector<double>& values) {
    return *std::min_element(values.begin(), values.end());
}

std::vector<double> Run(harness::Context& device, const Form& form, BenchBuffers& buffers, int repetitions) {
    return TimeKernel(device, form.kernel, buffers.Bind(form.variant.uniformWeights), kFormSide,
                      kFormSide / (8 * static_cast<std::uint32_t>(form.variant.texels)), kFormSide / 8,
                      repetitions);
}

/// Creates the pipelines of one network and checks their results; false if one cannot be created.
bool Prepare(harness::Context& device, const Options& options, BenchBuffers& buffers,
             std::vector<Form>& forms) {
    constexpr std::uint64_t kResultBytes = std::uint64_t{kFormSide} * kFormSide * 32;
    std::vector<std::byte> expected;
    for (Form& form : forms) {
        Expected<harness::ComputePipeline> kernel = MakeKernel(
            device, ReadWords(options.folder + "/" + form.variant.file16), form.variant.uniformWeights);
        if (!kernel) {
            std::fprintf(stderr, "%s %d: %s\n", form.variant.name.c_str(), form.variant.network,
                         kernel.error().GetText());
            return false;
        }
        form.kernel = std::move(*kernel);
        const double start = GetSeconds();
        Run(device, form, buffers, 1);
        form.firstDispatch = GetSeconds() - start;
        std::vector<std::byte> results(kResultBytes);
        Require(device.Read(buffers.GetResults(), 0, results));
        if (expected.empty())
            expected = results;
        form.isEqual = results == expected;
    }
    return true;
}

} // namespace

int PrintFetchForms(harness::Context& device, const Options& options) {
    std::map<int, std::vector<Form>> networks;
    for (Variant& v : ReadIndex(options)) {
        if (v.stage == kPipelineStage && v.math == NTC_MATH_INT8) {
            Form form;
            form.variant = std::move(v);
            networks[form.variant.network].push_back(std::move(form));
        }
    }
    std::printf("\n| network | form | create, ms | first dispatch, ms | ns/texel, best / median | processor "
                "ns/texel, "
                "best / median | times as fast: best / median / processor median | bits |\n"
                "|---|---|---|---|---|---|---|---|\n");
    int failures = 0;
    const double texels = double{kFormSide} * kFormSide;
    for (auto& [network, forms] : networks) {
        const std::unique_ptr<Set> set = MakeSet(network, kFormSide);
        BenchBuffers buffers(device, set->constants[0], set->latents, set->weights[0],
                             std::uint64_t{kFormSide} * kFormSide * 64);
        if (!Prepare(device, options, buffers, forms))
            return 1;
        for (int round = 0; round < options.repetitions; ++round) {
            for (Form& form : forms) {
                const double start = GetProcessorSeconds();
                const std::vector<double> ms = Run(device, form, buffers, 2);
                form.processor.push_back((GetProcessorSeconds() - start) * 1e9 / (2 * texels));
                form.nanoseconds.push_back(GetBest(ms) * 1e6 / texels);
            }
        }
        const Form& first = forms.front();
        for (Form& form : forms) {
            std::printf(
                "| %d | %s | %.0f | %.0f | %.0f / %.0f | %.0f / %.0f | %.2f / %.2f / %.2f | %s |\n", network,
                form.variant.name.c_str(), form.kernel.GetCreationSeconds() * 1e3, form.firstDispatch * 1e3,
                GetBest(form.nanoseconds), GetMedian(form.nanoseconds), GetBest(form.processor),
                GetMedian(form.processor), GetBest(first.nanoseconds) / GetBest(form.nanoseconds),
                GetMedian(first.nanoseconds) / GetMedian(form.nanoseconds),
                GetMedian(first.processor) / GetMedian(form.processor), form.isEqual ? "equal" : "DIFFERENT");
            failures += form.isEqual ? 0 : 1;
        }
        std::fflush(stdout);
    }
    return failures == 0 ? 0 : 1;
}

} // namespace openntc::bench
