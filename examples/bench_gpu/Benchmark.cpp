// SPDX-License-Identifier: MIT
#include "Benchmark.h"

#include "openntc/MathModes.h"
#include "openntc/inference/CooperativeVectors.h"
#include "openntc/inference/InferenceData.h"
#include "openntc/inference/LatentTextures.h"
#include "openntc/inference/ReadLatents.h"
#include "openntc/inference/Synthesis.h"
#include "openntc/texture_set/LatentShape.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>

namespace openntc::bench {

namespace {

std::array<harness::BufferSlot, 4> GetSlots(bool uniformWeights, bool latentTexture) {
    using harness::BufferKind;
    return {{{0, BufferKind::Uniform},
             {1, latentTexture ? BufferKind::FilteredTexture : BufferKind::Storage},
             {2, uniformWeights ? BufferKind::Uniform : BufferKind::Storage},
             {3, BufferKind::Storage}}};
}

} // namespace

BenchBuffers::BenchBuffers(harness::Context& device, const NtcTextureSetConstants& constants,
                           std::span<const std::byte> latents, std::span<const std::byte> weights,
                           std::uint64_t resultBytes)
    : device_(device), latentBytes_(latents), weightBytes_(weights.begin(), weights.end()) {
    const auto make = [&](std::span<const std::byte> bytes, harness::BufferKind kind) {
        return Require(device.CreateBuffer(bytes, kind, harness::BufferMemory::DeviceLocal));
    };
    constants_ = make(std::as_bytes(std::span(&constants, 1)), harness::BufferKind::Uniform);
    latents_ = make(latents, harness::BufferKind::Storage);
    weights_ = make(weights, harness::BufferKind::Storage);
    results_ = Require(
        device.CreateBuffer(resultBytes, harness::BufferKind::Storage, harness::BufferMemory::DeviceLocal));
}

std::array<harness::BoundBuffer, 4> BenchBuffers::Bind(bool uniformWeights) {
    if (uniformWeights && !uniformWeights_)
        uniformWeights_ = Require(device_.CreateBuffer(weightBytes_, harness::BufferKind::Uniform,
                                                       harness::BufferMemory::DeviceLocal));
    return {{{0, &constants_},
             {1, &latents_},
             {2, uniformWeights ? &*uniformWeights_ : &weights_},
             {3, &results_}}};
}

void BenchBuffers::MakeLatentTexture(const TextureSetMetadata& metadata) {
    if (texture_)
        return;
    const LatentTextureSize size = Require(GetLatentTextureSize(metadata));
    texture_ = Require(device_.CreateImageArray(harness::ImageFormat::BGRA4, size.width, size.height,
                                                size.layers, size.levels));
    for (const LatentTextureCopy& copy :
         Require(GetLatentTextureCopies(metadata, 0, metadata.GetDesc().mips)))
        Require(device_.Write(*texture_,
                              std::span(latentBytes_).subspan(copy.offset, texture_->GetBytes(copy.level)),
                              copy.level));
}

Expected<harness::ComputePipeline> MakeKernel(harness::Context& device, std::span<const std::uint32_t> spirv,
                                              bool uniformWeights, bool latentTexture) {
    return device.CreateComputePipeline(spirv, GetSlots(uniformWeights, latentTexture), sizeof(std::uint32_t),
                                        {.isKept = false, .wantsStatistics = true});
}

std::vector<double> TimeKernel(harness::Context& device, const harness::ComputePipeline& kernel,
                               const std::array<harness::BoundBuffer, 4>& buffers, std::uint32_t width,
                               std::uint32_t groupsX, std::uint32_t groupsY, int repetitions,
                               const harness::Image* latentTexture) {
    harness::DispatchRequest request;
    const harness::BoundImage images[] = {{1, latentTexture}};
    if (latentTexture != nullptr)
        request.images = images;
    request.pipeline = &kernel;
    request.buffers = buffers;
    request.pushConstants = std::as_bytes(std::span(&width, 1));
    request.groups[0] = groupsX;
    request.groups[1] = groupsY;
    std::vector<double> times =
        Require(device.TimeDispatches(request, static_cast<std::uint32_t>(repetitions)));
    for (double& time : times)
        time *= 1e3;
    return times;
}

std::unique_ptr<Set> MakeSet(int network, int size) {
    auto set = std::make_unique<Set>();
    SynthesisDesc synthesis;
    synthesis.seed = 1;
    synthesis.desc = {size, size, 16, 1};
    synthesis.networkVersion = network;
    synthesis.shape = Require(PickLatentShape(4.0f, network)).shape;
    synthesis.channelColorSpaces = 0x15; // three channels are sRGB
    synthesis.withFP8 = true;
    Require(SynthesizeTextureSet(set->file, synthesis));
    Require(set->file.Seek(0) ? Expected<void>() : Fail(Status::IOError, "seek"));
    set->metadata = Require(TextureSetMetadata::Load(set->file));
    set->latents.resize(Require(GetLatentBufferBytes(*set->metadata, 0, 1)));
    Require(ReadLatents(*set->metadata, set->file, 0, 1, set->latents));
    const InferenceWeightType types[] = {InferenceWeightType::GenericInt8, InferenceWeightType::GenericFP8};
    for (std::size_t i = 0; i < 2; ++i) {
        set->constants[i] = Require(MakeInferenceData(*set->metadata, 0, 1, types[i]));
        set->weights[i] = Require(set->metadata->GetInferenceWeights(types[i]));
    }
    return set;
}

double GetSeconds() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

bool UsesFP8(int math) {
    return math == NTC_MATH_FP8 || math == NTC_MATH_COOPVEC_FP8;
}

bool UsesVectors(int math) {
    return math == NTC_MATH_COOPVEC_INT8 || math == NTC_MATH_COOPVEC_FP8;
}

const char* FindObstacle(harness::Context& device, const Variant& v) {
    const CoopVecDevice& vectors = device.GetDevice().cooperativeVectors;
    if (UsesVectors(v.math) && !vectors.hasCooperativeVectors)
        return "device or feature absent: VK_NV_cooperative_vector";
    if (v.math == NTC_MATH_COOPVEC_FP8 && !vectors.hasE4M3)
        return "device or feature absent: E4M3 matrices";
    return nullptr;
}

DeviceWeights MakeDeviceWeights(harness::Context& device, const Variant& v, const Set& set) {
    const std::size_t form = UsesFP8(v.math) ? 1 : 0;
    DeviceWeights own = {set.constants[form], {set.weights[form].begin(), set.weights[form].end()}};
    if (UsesVectors(v.math)) {
        CoopVecWeights sources = Require(
            MakeCoopVecWeights(form == 1 ? InferenceWeightType::CoopVecFP8 : InferenceWeightType::CoopVecInt8,
                               v.network, own.weights));
        own.weights = Require(device.ConvertWeights(sources));
        SetCoopVecOffsets(sources, own.constants);
    }
    return own;
}

std::vector<std::uint32_t> ReadWords(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    std::stringstream text;
    text << file.rdbuf();
    const std::string bytes = text.str();
    std::vector<std::uint32_t> words(bytes.size() / 4);
    std::memcpy(words.data(), bytes.data(), words.size() * 4);
    return words;
}

std::vector<Variant> ReadIndex(const Options& options) {
    std::ifstream file(options.folder + "/index.txt");
    std::vector<Variant> variants;
    std::string line;
    while (std::getline(file, line)) {
        std::istringstream fields(line);
        Variant v;
        fields >> v.name >> v.network >> v.math >> v.uniformWeights >> v.texels >> v.stage >> v.file16 >>
            v.file32 >> v.latentTexture;
        if (fields && (options.only.empty() || v.name.find(options.only) != std::string::npos))
            variants.push_back(v);
    }
    if (variants.empty()) {
        std::fprintf(stderr, "bench_gpu: %s/index.txt: nothing to run%s\n", options.folder.c_str(),
                     options.only.empty() ? "" : (" for --only " + options.only).c_str());
        std::exit(1);
    }
    return variants;
}

double GetMedian(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
}

} // namespace openntc::bench
