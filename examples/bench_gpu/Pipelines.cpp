// SPDX-License-Identifier: MIT
#include "Pipelines.h"

#include "openntc/MathModes.h"

#include <algorithm>
#include <array>

namespace openntc::bench {

namespace {

constexpr int kPipelineSide = 64;

const char* GetMathName(int math) {
    constexpr std::array<const char*, 8> kNames = {"",     "INT8", "INT8_HALF",    "FP8",
                                                   "FP16", "FP32", "COOPVEC_INT8", "COOPVEC_FP8"};
    return math > 0 && math < 8 ? kNames[static_cast<std::size_t>(math)] : "?";
}

} // namespace

int PrintPipelines(harness::Context& device, const Options& options) {
    std::map<int, std::unique_ptr<Set>> sets;
    std::printf("\n| network | maths mode | variant | SPIR-V bytes | create, ms | first dispatch, ms |\n"
                "|---|---|---|---|---|---|\n");
    double slowest = 0;
    double slowestDispatch = 0;
    for (const Variant& v : ReadIndex(options)) {
        if (v.stage != kPipelineStage)
            continue;
        std::unique_ptr<Set>& set = sets[v.network];
        if (!set)
            set = MakeSet(v.network, kPipelineSide);
        const std::vector<std::uint32_t> words = ReadWords(options.folder + "/" + v.file16);
        std::array<double, 3> create{};
        double dispatch = 0; // once: it takes seconds
        for (std::size_t i = 0; i < 3; ++i) {
            const Expected<harness::ComputePipeline> kernel = MakeKernel(device, words, v.uniformWeights);
            if (!kernel) {
                std::fprintf(stderr, "%s %d: %s\n", v.name.c_str(), v.network, kernel.error().GetText());
                return 1;
            }
            create[i] = kernel->GetCreationSeconds();
            if (i == 0) {
                const std::size_t form = UsesFP8(v.math) ? 1 : 0;
                BenchBuffers buffers(device, set->constants[form], set->latents, set->weights[form],
                                     std::uint64_t{kPipelineSide} * kPipelineSide * 64);
                const auto bound = buffers.Bind(v.uniformWeights);
                const double start = GetSeconds();
                TimeKernel(device, *kernel, bound, kPipelineSide, 1, 1, 1);
                dispatch = GetSeconds() - start;
            }
        }
        std::sort(create.begin(), create.end());
        slowest = std::max(slowest, create[1]);
        slowestDispatch = std::max(slowestDispatch, dispatch);
        std::printf("| %d | %s | %s | %zu | %.0f | %.0f |\n", v.network, GetMathName(v.math), v.name.c_str(),
                    words.size() * 4, create[1] * 1e3, dispatch * 1e3);
        std::fflush(stdout);
    }
    std::printf("\nSlowest: %.0f ms to create, %.0f ms in the first dispatch.\n", slowest * 1e3,
                slowestDispatch * 1e3);
    return 0;
}

} // namespace openntc::bench
