// SPDX-License-Identifier: MIT
#include "Textures.h"

#include "openntc/passes/DecompressionPass.h"
#include "openntc/passes/PassConstants.h"
#include "vulkan_harness/MatrixProbe.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <sstream>

namespace openntc::bench {

namespace {

constexpr std::size_t kImages = 4;

/// A line of textures.txt: what the shaders were compiled for (dots, cpu, lanes or portable), network, and their files.
struct Pair {
    std::string kind;
    int network = 0;
    std::string bare;
    std::string pass;
};

/// Needs whose key the shaders were compiled with. False if the device cannot run them.
bool MakeNeeds(const Pair& pair, const harness::DeviceInfo& device, bool hasLanes, SceneNeeds& needs) {
    needs.preference = MathPreference::Specific;
    needs.math = NTC_MATH_INT8;
    if (pair.kind == "dots") {
        needs.device.integerDotProduct = true;
        return device.features.Has(harness::Feature::IntegerDotProduct) && !device.isCpu;
    }
    if (pair.kind == "cpu") {
        needs.device.isCpu = needs.device.subgroupShuffle = true;
        return device.isCpu && device.hasSubgroupShuffle && device.subgroupSize >= 8;
    }
    needs.math = NTC_MATH_COOPMAT_INT8;
    needs.device.cooperativeMatrixInt8 = true;
    needs.device.cooperativeMatrixLanes = pair.kind == "lanes";
    return device.hasByteMatrices && (pair.kind != "lanes" || hasLanes);
}

/// Two halves as whole numbers in the order of their values.
int GetHalfOrder(std::uint16_t bits) {
    return (bits & 0x8000u) != 0 ? -(bits & 0x7FFF) : bits;
}

struct Differences {
    std::size_t count = 0;
    int largest = 0; ///< steps of binary16
};

/// The images against the buffer, which has the same numbers texel by texel.
Differences Compare(harness::Context& device, const harness::Buffer& results,
                    const std::vector<harness::Image>& images, std::size_t texels) {
    std::vector<std::uint16_t> expected(texels * 16);
    Require(device.Read(results, 0, std::as_writable_bytes(std::span(expected))));
    Differences differences;
    std::vector<std::uint16_t> found(texels * 4);
    for (std::size_t i = 0; i < kImages; ++i) {
        Require(device.Read(images[i], std::as_writable_bytes(std::span(found))));
        for (std::size_t t = 0; t < found.size(); ++t) {
            const std::uint16_t bits = expected[t / 4 * 16 + 4 * i + t % 4];
            differences.count += found[t] != bits ? 1 : 0;
            differences.largest =
                std::max(differences.largest, std::abs(GetHalfOrder(found[t]) - GetHalfOrder(bits)));
        }
    }
    return differences;
}

/// Both shaders of a line. Returns whether the images are right.
bool RunPair(harness::Context& device, const Pair& pair, const SceneNeeds& needs,
             const std::optional<CoopMatLayout>& layout, const Options& options) {
    using namespace harness;
    const std::unique_ptr<Set> set = MakeSet(pair.network, options.size);
    std::vector<DecompressionOutput> outputs;
    const auto space = [&](std::size_t channel) {
        return static_cast<ColorSpace>(set->constants[0].channelColorSpaces >> (2 * channel) & 3u);
    };
    for (std::size_t i = 0; i < kImages; ++i) { // as stored
        outputs.push_back({.firstChannel = static_cast<int>(4 * i), .numChannels = 4});
        outputs.back().rgbColorSpace = space(4 * i);
        outputs.back().alphaColorSpace = space(4 * i + 3);
    }
    DecompressionRequest decompression;
    decompression.outputs = outputs;
    const DecompressionPass pass =
        Require(MakeDecompressionPass(*set->metadata, set->constants[0], decompression, needs));
    const PermutationKey& key = pass.permutation.key;
    const bool onMatrices = pass.permutation.weightType == InferenceWeightType::CoopMatInt8;
    Array<std::byte> matrices;
    if (onMatrices)
        matrices =
            Require(MakeCoopMatWeights(pair.network, set->weights[0], key.matrixLanes ? &*layout : nullptr));
    const std::size_t texels =
        static_cast<std::size_t>(options.size) * static_cast<std::size_t>(options.size);
    const auto size = static_cast<std::uint32_t>(options.size);
    BenchBuffers buffers(device, set->constants[0], set->latents,
                         onMatrices ? matrices.AsSpan() : set->weights[0], texels * 32);

    static constexpr BufferSlot kBareSlots[] = {{0, BufferKind::Uniform},
                                                {1, BufferKind::Storage},
                                                {2, BufferKind::Storage},
                                                {3, BufferKind::Storage}};
    static constexpr BufferSlot kPassSlots[] = {{0, BufferKind::Uniform},
                                                {1, BufferKind::Storage},
                                                {2, BufferKind::Storage},
                                                {0, BufferKind::Image, 1, NTC_DECOMPRESS_OUTPUTS}};
    const NtcDecodeBlocksConstants push = {0, 0, size, size, 0};
    const std::size_t pushBytes = onMatrices ? sizeof push : sizeof size;
    const std::span<const std::byte> pushConstants =
        onMatrices ? std::as_bytes(std::span(&push, 1)) : std::as_bytes(std::span(&size, 1));
    const PipelineOptions pipelineOptions = {.isKept = false, .wantsStatistics = true};
    const ComputePipeline bare =
        Require(device.CreateComputePipeline(ReadWords(options.folder + "/" + pair.bare), kBareSlots,
                                             static_cast<std::uint32_t>(pushBytes), pipelineOptions));
    const ComputePipeline textures = Require(device.CreateComputePipeline(
        ReadWords(options.folder + "/" + pair.pass), kPassSlots, 0, pipelineOptions));
    const Buffer constants = Require(device.CreateBuffer(std::as_bytes(std::span(&pass.constants, 1)),
                                                         BufferKind::Uniform, BufferMemory::DeviceLocal));
    std::vector<Image> images;
    for (std::size_t i = 0; i < kImages; ++i)
        images.push_back(Require(device.CreateImage(ImageFormat::RGBA16F, size, size)));

    const auto bound = buffers.Bind(false);
    DispatchRequest requests[2];
    requests[0].pipeline = &bare;
    requests[0].buffers = bound;
    requests[0].pushConstants = pushConstants;
    requests[0].groups[0] =
        onMatrices ? pass.groups[0] : size / (8 * static_cast<std::uint32_t>(key.texelsPerInvocation));
    requests[0].groups[1] = onMatrices ? 1 : size / 8;
    const BoundBuffer passBuffers[] = {{0, &constants}, bound[1], bound[2]};
    std::vector<BoundImage> passImages;
    for (std::uint32_t i = 0; i < NTC_DECOMPRESS_OUTPUTS; ++i)
        passImages.push_back({0, &images[i < kImages ? i : 0], 1, i});
    requests[1].pipeline = &textures;
    requests[1].buffers = passBuffers;
    requests[1].images = passImages;
    std::copy(std::begin(pass.groups), std::end(pass.groups), std::begin(requests[1].groups));

    std::vector<double> times[2];
    const double start = GetSeconds();
    constexpr std::uint32_t kTogether = 4;
    do { // until the clocks are up
        for (const DispatchRequest& request : requests)
            Require(device.TimeDispatches(request, 1));
    } while (options.repetitions > 1 && GetSeconds() - start < 0.4);
    for (int done = 0; done < options.repetitions; done += static_cast<int>(kTogether)) {
        for (std::size_t i = 0; i < 2; ++i) {
            const std::vector<double> some = Require(device.TimeDispatches(requests[i], kTogether));
            times[i].insert(times[i].end(), some.begin(), some.end());
        }
    }
    const double scale = 1e9 / static_cast<double>(texels);
    const double medians[2] = {GetMedian(times[0]) * scale, GetMedian(times[1]) * scale};
    const Differences differences = Compare(device, buffers.GetResults(), images, texels);
    std::printf("%-18s network %d  buffer %8.4f  textures %8.4f ns/texel  %+5.1f %%  | %zu of %zu numbers "
                "differ, by %d "
                "steps of binary16 at most | %s | %s\n",
                pair.pass.c_str(), pair.network, medians[0], medians[1], 100 * (medians[1] / medians[0] - 1),
                differences.count, texels * 16, differences.largest, bare.GetStatistics().c_str(),
                textures.GetStatistics().c_str());
    std::fflush(stdout);
    return differences.largest <= 1;
}

} // namespace

int PrintTextures(harness::Context& device, const Options& options) {
    const auto probed = harness::ProbeCoopMat(device);
    const std::optional<CoopMatLayout> layout = probed ? *probed : std::nullopt;
    std::ifstream file(options.folder + "/textures.txt");
    std::string line;
    int status = 0;
    bool hasRun = false;
    while (std::getline(file, line)) {
        std::istringstream fields(line);
        Pair pair;
        fields >> pair.kind >> pair.network >> pair.bare >> pair.pass;
        SceneNeeds needs;
        if (!fields || (!options.only.empty() && line.find(options.only) == std::string::npos) ||
            !MakeNeeds(pair, device.GetDevice(), layout.has_value(), needs))
            continue;
        hasRun = true;
        if (!RunPair(device, pair, needs, layout, options))
            status = 1;
    }
    if (!hasRun) {
        std::fprintf(stderr, "bench_gpu: %s/textures.txt: nothing that this device runs\n",
                     options.folder.c_str());
        return 1;
    }
    return status;
}

} // namespace openntc::bench
