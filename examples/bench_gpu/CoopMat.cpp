// SPDX-License-Identifier: MIT
#include "CoopMat.h"

#include "openntc/core/Half.h"
#include "openntc/decode/FastDecoder.h"
#include "openntc/decode/ShaderMath.h"
#include "openntc/inference/CooperativeMatrices.h"
#include "openntc/passes/PassConstants.h"
#include "vulkan_harness/MatrixProbe.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <sstream>

namespace openntc::bench {

namespace {

/// A line of coopmat.txt: file, network, NTC_MATH, by lanes, latents in a texture.
struct Module {
    std::string file;
    int network = 0;
    int math = 0;
    bool isByLanes = false;
    bool latentTexture = false;
};

std::array<harness::BufferSlot, 4> GetSlots(const Module& module) {
    using harness::BufferKind;
    return {{{0, BufferKind::Uniform},
             {1, module.latentTexture ? BufferKind::FilteredTexture : BufferKind::Storage},
             {2, BufferKind::Storage},
             {3, BufferKind::Storage}}};
}

std::vector<Module> ReadModules(const Options& options) {
    std::ifstream file(options.folder + "/coopmat.txt");
    std::vector<Module> modules;
    std::string line;
    while (std::getline(file, line)) {
        std::istringstream fields(line);
        Module m;
        fields >> m.file >> m.network >> m.math >> m.isByLanes >> m.latentTexture;
        if (fields && (options.only.empty() || m.file.find(options.only) != std::string::npos))
            modules.push_back(m);
    }
    return modules;
}

/// The first and the last rows as binary16.
std::vector<std::uint16_t> DecodeRows(const Set& set, const Module& module, int size, int top, int rows) {
    const DecodeSource source = {&set.constants[0], set.latents, set.weights[0], module.network,
                                 DecodeWeights::Int8};
    const FastDecoder decoder = Require(FastDecoder::Create(source));
    std::vector<float> outputs(static_cast<std::size_t>(size) * static_cast<std::size_t>(rows) * 16);
    Require(decoder.Decode(0, {0, top, size, rows}, {.math = GetDecodeMath(module.math)}, outputs));
    std::vector<std::uint16_t> halves;
    for (const float value : outputs)
        halves.push_back(FloatToHalf(value));
    return halves;
}

/// Numbers of `rows` rows at both ends of the image that are others than the reference's.
std::size_t CountDifferent(harness::Context& device, const harness::Buffer& results, const Set& set,
                           const Module& module, const Options& options) {
    std::size_t different = 0;
    for (const int top : {0, options.size - options.rows}) {
        const std::vector<std::uint16_t> expected = DecodeRows(set, module, options.size, top, options.rows);
        std::vector<std::uint16_t> halves(expected.size());
        const std::uint64_t offset =
            std::uint64_t{32} * static_cast<std::uint64_t>(top) * static_cast<std::uint64_t>(options.size);
        Require(device.Read(results, offset, std::as_writable_bytes(std::span(halves))));
        for (std::size_t i = 0; i < halves.size(); ++i)
            different += halves[i] != expected[i] ? 1 : 0;
    }
    return different;
}

} // namespace

int PrintCoopMat(harness::Context& device, const Options& options) {
    const std::vector<Module> modules = ReadModules(options);
    if (modules.empty()) {
        std::fprintf(stderr, "bench_gpu: %s/coopmat.txt: nothing to run\n", options.folder.c_str());
        return 1;
    }
    if (!device.GetDevice().hasByteMatrices) {
        std::printf("SKIP: device or feature absent: cooperative matrices of signed bytes, 16 x 16 x 32\n");
        return 0;
    }
    const auto probed = harness::ProbeCoopMat(device);
    const std::optional<CoopMatLayout> layout = probed ? *probed : std::nullopt;
    if (!layout)
        std::printf("the lanes' form is not possible%s%s\n", probed ? "" : ": ",
                    probed ? "" : probed.error().GetText());
    int status = 0;
    std::map<int, std::unique_ptr<Set>> sets;
    const std::uint32_t size = static_cast<std::uint32_t>(options.size);
    const std::uint64_t texels = std::uint64_t{size} * size;
    for (const Module& module : modules) {
        if (module.isByLanes && !layout)
            continue;
        std::unique_ptr<Set>& set = sets[module.network];
        if (!set)
            set = MakeSet(module.network, options.size);
        const Expected<harness::ComputePipeline> pipeline = device.CreateComputePipeline(
            ReadWords(options.folder + "/" + module.file), GetSlots(module), sizeof(NtcDecodeBlocksConstants),
            {.isKept = false, .wantsStatistics = true});
        if (!pipeline) {
            std::printf("%-30s FAILED: %s\n", module.file.c_str(), pipeline.error().GetText());
            status = 1;
            continue;
        }
        const Array<std::byte> weights = Require(
            MakeCoopMatWeights(module.network, set->weights[0], module.isByLanes ? &*layout : nullptr));
        BenchBuffers buffers(device, set->constants[0], set->latents, weights.AsSpan(), texels * 32);
        const auto bound = buffers.Bind(false);
        if (module.latentTexture)
            buffers.MakeLatentTexture(*set->metadata);
        const harness::BoundImage images[] = {{1, buffers.GetLatentTexture()}};
        const NtcDecodeBlocksConstants push = {0, 0, size, size, 0};
        harness::DispatchRequest request;
        request.pipeline = &*pipeline;
        request.buffers = bound;
        if (module.latentTexture)
            request.images = images;
        request.pushConstants = std::as_bytes(std::span(&push, 1));
        std::string text;
        std::size_t different = 0;
        for (const std::uint32_t groups : {132u, 264u, 528u, 1056u}) {
            request.groups[0] = groups;
            const double start = GetSeconds();
            do { // until the clocks are up
                Require(device.TimeDispatches(request, options.repetitions > 1 ? 4u : 1u));
            } while (options.repetitions > 1 && GetSeconds() - start < 0.3);
            std::vector<double> seconds =
                Require(device.TimeDispatches(request, static_cast<std::uint32_t>(options.repetitions)));
            std::sort(seconds.begin(), seconds.end());
            char part[96];
            std::snprintf(part, sizeof part, "| %u groups: median %.4f best %.4f ", groups,
                          seconds[seconds.size() / 2] * 1e9 / static_cast<double>(texels),
                          seconds.front() * 1e9 / static_cast<double>(texels));
            text += part;
            different += CountDifferent(device, buffers.GetResults(), *set, module, options);
        }
        if (different != 0 && !module.latentTexture) // which the device filters in its own way
            status = 1;
        std::printf("%-30s ns/texel %s| %zu of %llu numbers differ | %s\n", module.file.c_str(), text.c_str(),
                    different,
                    static_cast<unsigned long long>(4u * 2u * 16u * std::uint64_t{size} *
                                                    static_cast<std::uint64_t>(options.rows)),
                    pipeline->GetStatistics().c_str());
        std::fflush(stdout);
    }
    return status;
}

} // namespace openntc::bench
