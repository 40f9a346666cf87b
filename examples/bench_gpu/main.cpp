// SPDX-License-Identifier: MIT
// `bench_gpu SHADER_FOLDER [options]`: time and correctness of the GPU decoders.
//
// For each line of SHADER_FOLDER/index.txt a synthesised set (seed 1, one mip, the known latent shape of 4 bits per
// texel) is decoded whole to a buffer of binary16; timestamps lie round the dispatch alone. The first rows are compared
// bit by bit with the C++ reference decoder, in binary32 and in binary16.
#include "Device.h"

#include "openntc/MathModes.h"
#include "openntc/core/Half.h"
#include "openntc/decode/ReferenceDecoder.h"
#include "openntc/inference/InferenceData.h"
#include "openntc/inference/Synthesis.h"
#include "openntc/texture_set/LatentShape.h"
#include "openntc/texture_set/TextureSetMetadata.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

namespace {

using namespace openntc;
using namespace openntc::bench;

struct Options {
    std::string folder;
    std::string device;
    std::string only; ///< part of the variant's name
    std::string json;
    int size = 4096;
    int rows = 32; ///< compared
    int repetitions = 60;
};

/// One line of index.txt: a variant of the shader for one network.
struct Variant {
    std::string name;
    int network = 0;
    int math = 0; ///< NTC_MATH_*
    bool uniformWeights = false;
    int texels = 1; ///< per invocation
    int stage = 0;  ///< BENCH_STAGE
    std::string file16;
    std::string file32; ///< "-": not compared
};

struct Set {
    MemoryStream file;
    std::optional<TextureSetMetadata> metadata;
    std::span<const std::byte> latents;
    NtcTextureSetConstants constants[2]; ///< for Int8 and FP8 weights
    std::span<const std::byte> weights[2];
    std::map<DecodeMath, std::vector<float>> references;
};

template <typename T>
T Require(Expected<T> value) {
    if (!value) {
        std::fprintf(stderr, "bench_gpu: %s\n", value.error().GetText());
        std::exit(1);
    }
    if constexpr (!std::is_void_v<T>)
        return std::move(*value);
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
    const StreamRange range = Require(set->metadata->GetStreamRangeForLatents(0, 1));
    set->latents = set->file.GetBytes().subspan(static_cast<std::size_t>(range.offset),
                                                static_cast<std::size_t>(range.size));
    const InferenceWeightType types[] = {InferenceWeightType::GenericInt8, InferenceWeightType::GenericFP8};
    for (std::size_t i = 0; i < 2; ++i) {
        set->constants[i] = Require(MakeInferenceData(*set->metadata, range, types[i]));
        set->weights[i] = Require(set->metadata->GetInferenceWeights(types[i]));
    }
    return set;
}

bool UsesFP8(int math) {
    return math == NTC_MATH_FP8 || math == NTC_MATH_COOPVEC_FP8;
}

DecodeMath GetReferenceMath(int math) {
    switch (math) {
    case NTC_MATH_INT8_HALF:
        return DecodeMath::Int8Half;
    case NTC_MATH_FP8:
    case NTC_MATH_COOPVEC_FP8:
        return DecodeMath::FP8;
    case NTC_MATH_FP16:
        return DecodeMath::FP16;
    case NTC_MATH_FP32:
        return DecodeMath::FP32;
    default:
        return DecodeMath::Int8;
    }
}

const std::vector<float>& GetReference(Set& set, int network, int math, const Options& options) {
    const DecodeMath mode = GetReferenceMath(math);
    std::vector<float>& outputs = set.references[mode];
    if (!outputs.empty())
        return outputs;
    outputs.resize(16 * static_cast<std::size_t>(options.size) * static_cast<std::size_t>(options.rows));
    const std::size_t form = UsesFP8(math) ? 1 : 0;
    const DecodeSource source = {&set.constants[form], set.latents, set.weights[form], network,
                                 form == 1 ? DecodeWeights::FP8 : DecodeWeights::Int8};
    std::vector<std::thread> threads;
    for (int y = 0; y < options.rows; ++y) {
        const std::size_t row = 16 * static_cast<std::size_t>(options.size);
        threads.emplace_back([&source, &outputs, &options, mode, y, row] {
            Require(DecodeReference(source, 0, {0, y, options.size, 1}, {.math = mode},
                                    std::span(outputs).subspan(row * static_cast<std::size_t>(y), row)));
        });
    }
    for (std::thread& thread : threads)
        thread.join();
    return outputs;
}

struct Comparison {
    std::size_t values = 0;
    std::size_t different = 0; ///< bits
    double maximum = 0;        ///< absolute difference
    double squares = 0;
    double referenceSquares = 0;

    void Add(float value, float reference) {
        ++values;
        different += std::bit_cast<std::uint32_t>(value) != std::bit_cast<std::uint32_t>(reference);
        const double error = std::fabs(static_cast<double>(value) - static_cast<double>(reference));
        maximum = error <= maximum ? maximum : error; // NaN counts
        squares += error * error;
        referenceSquares += static_cast<double>(reference) * static_cast<double>(reference);
    }
};

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
            v.file32;
        if (fields && (options.only.empty() || v.name.find(options.only) != std::string::npos))
            variants.push_back(v);
    }
    return variants;
}

std::string Escape(const std::string& text) {
    std::string result;
    for (const char c : text) {
        if (c == '"' || c == '\\')
            result += '\\';
        result += c;
    }
    return result;
}

/// One row of the report; runs and compares one variant.
std::string RunVariant(Device& device, const Variant& v, Set& set, const Options& options) {
    const DeviceFacts& facts = device.GetFacts();
    const bool vectors = v.math == NTC_MATH_COOPVEC_INT8 || v.math == NTC_MATH_COOPVEC_FP8;
    const CoopVecDevice& cv = facts.cooperativeVectors;
    const char* skip = nullptr;
    if (vectors && !cv.hasCooperativeVectors)
        skip = "device or feature absent: VK_NV_cooperative_vector";
    else if (v.math == NTC_MATH_COOPVEC_FP8 && !cv.hasE4M3)
        skip = "device or feature absent: E4M3 matrices";
    if (skip != nullptr) {
        std::printf("%-34s %d SKIP: %s\n", v.name.c_str(), v.network, skip);
        return {};
    }
    const std::size_t form = UsesFP8(v.math) ? 1 : 0;
    NtcTextureSetConstants constants = set.constants[form];
    std::vector<std::byte> weights(set.weights[form].begin(), set.weights[form].end());
    if (vectors) {
        CoopVecWeights sources = Require(
            MakeCoopVecWeights(form == 1 ? InferenceWeightType::CoopVecFP8 : InferenceWeightType::CoopVecInt8,
                               v.network, weights));
        weights = device.ConvertWeights(sources);
        SetCoopVecOffsets(sources, constants);
    }
    const auto width = static_cast<std::uint32_t>(options.size);
    const auto rows = static_cast<std::uint32_t>(options.rows);
    const std::uint64_t texels = std::uint64_t{width} * width;
    DeviceBuffer buffers[] = {
        device.CreateBuffer(sizeof constants, std::as_bytes(std::span(&constants, 1))),
        device.CreateBuffer(set.latents.size(), set.latents), device.CreateBuffer(weights.size(), weights),
        device.CreateBuffer(std::max(texels * 32, std::uint64_t{width} * rows * 64), {})};
    const std::uint32_t groupsX = width / (8 * static_cast<std::uint32_t>(v.texels));

    std::string row;
    Kernel kernel = device.CreateKernel(ReadWords(options.folder + "/" + v.file16), v.uniformWeights);
    if (!kernel.error.empty()) {
        std::printf("%-34s %d FAILED: %s\n", v.name.c_str(), v.network, kernel.error.c_str());
    } else {
        // Until the clocks are up: a GPU needs some tenths of a second of work.
        const auto start = std::chrono::steady_clock::now();
        do {
            device.Run(kernel, buffers, width, groupsX, width / 8, options.repetitions > 1 ? 4 : 1);
        } while (options.repetitions > 1 &&
                 std::chrono::steady_clock::now() - start < std::chrono::milliseconds(400));
        std::vector<double> ms = device.Run(kernel, buffers, width, groupsX, width / 8, options.repetitions);
        std::sort(ms.begin(), ms.end());
        const double scale = 1e6 / static_cast<double>(texels); // ns per texel
        const double median = ms[ms.size() / 2] * scale;
        Comparison exact, half;
        if (v.stage == 0) {
            const std::vector<float>& reference = GetReference(set, v.network, v.math, options);
            const std::vector<std::byte> bytes16 = device.Read(buffers[3], reference.size() * 2);
            for (std::size_t i = 0; i < reference.size(); ++i) {
                std::uint16_t bits = 0;
                std::memcpy(&bits, bytes16.data() + 2 * i, 2);
                half.Add(HalfToFloat(bits), HalfToFloat(FloatToHalf(reference[i])));
            }
            if (v.file32 != "-") {
                Kernel check =
                    device.CreateKernel(ReadWords(options.folder + "/" + v.file32), v.uniformWeights);
                if (check.error.empty()) {
                    device.Run(check, buffers, width, groupsX, rows / 8, 1);
                    const std::vector<std::byte> bytes32 = device.Read(buffers[3], reference.size() * 4);
                    for (std::size_t i = 0; i < reference.size(); ++i) {
                        float value = 0;
                        std::memcpy(&value, bytes32.data() + 4 * i, 4);
                        exact.Add(value, reference[i]);
                    }
                }
                device.DestroyKernel(check);
            }
        }
        const double rms = std::sqrt(exact.squares / std::max(exact.referenceSquares, 1e-30));
        std::printf(
            "%-34s %d best %.4f p10 %.4f median %.4f p90 %.4f ns/texel (%.2f Gtexel/s median, %.2f best) | "
            "binary32 %zu of %zu differ, max %.3g, rel rms %.3g | binary16 %zu of %zu differ | pipeline %.0f "
            "ms | %s\n",
            v.name.c_str(), v.network, ms.front() * scale, ms[ms.size() / 10] * scale, median,
            ms[ms.size() * 9 / 10] * scale, 1 / median, 1 / (ms.front() * scale), exact.different,
            exact.values, exact.maximum, rms, half.different, half.values, kernel.creationSeconds * 1e3,
            kernel.statistics.c_str());
        char text[1024];
        std::snprintf(
            text, sizeof text,
            "{\"variant\":\"%s\",\"network\":%d,\"math\":%d,\"texelsPerInvocation\":%d,\"stage\":%d,"
            "\"repetitions\":%d,\"bestNs\":%.5f,\"p10Ns\":%.5f,\"medianNs\":%.5f,\"p90Ns\":%.5f,"
            "\"values\":%zu,\"different32\":%zu,\"maximumError\":%.6g,\"relativeRms\":%.6g,"
            "\"different16\":%zu,\"pipelineMs\":%.1f,\"statistics\":\"",
            v.name.c_str(), v.network, v.math, v.texels, v.stage, options.repetitions, ms.front() * scale,
            ms[ms.size() / 10] * scale, median, ms[ms.size() * 9 / 10] * scale, exact.values, exact.different,
            exact.maximum, rms, half.different, kernel.creationSeconds * 1e3);
        row = text + Escape(kernel.statistics) + "\"}";
    }
    std::fflush(stdout);
    device.DestroyKernel(kernel);
    for (DeviceBuffer& buffer : buffers)
        device.DestroyBuffer(buffer);
    return row;
}

int Run(const Options& options) {
    Device device(options.device);
    const DeviceFacts& facts = device.GetFacts();
    std::printf("device %s, driver %s, OpSDot %d, subgroup %u, uniform buffer %u bytes, %dx%d texels, %d "
                "repetitions\n",
                facts.name.c_str(), facts.driver.c_str(), facts.hasIntegerDotProduct, facts.subgroupSize,
                facts.maxUniformBytes, options.size, options.size, options.repetitions);
    std::string rows;
    std::map<int, std::unique_ptr<Set>> sets;
    for (const Variant& variant : ReadIndex(options)) {
        std::unique_ptr<Set>& set = sets[variant.network];
        if (!set)
            set = MakeSet(variant.network, options.size);
        const std::string row = RunVariant(device, variant, *set, options);
        if (!row.empty())
            rows += (rows.empty() ? "\n    " : ",\n    ") + row;
    }
    if (!options.json.empty()) {
        std::ofstream file(options.json);
        file << "{\n  \"device\": \"" << Escape(facts.name) << "\",\n  \"driver\": \"" << Escape(facts.driver)
             << "\",\n  \"size\": " << options.size << ",\n  \"results\": [" << rows << "\n  ]\n}\n";
        if (!file)
            return 1;
    }
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    Options options;
    for (int i = 1; i < argc; ++i) {
        const std::string argument = argv[i];
        const bool isOption = argument.starts_with("--");
        const char* value = isOption && i + 1 < argc ? argv[++i] : "";
        if (!isOption)
            options.folder = argument;
        else if (argument == "--device")
            options.device = value;
        else if (argument == "--only")
            options.only = value;
        else if (argument == "--json")
            options.json = value;
        else if (argument == "--size")
            options.size = std::atoi(value);
        else if (argument == "--rows")
            options.rows = std::atoi(value);
        else if (argument == "--repetitions")
            options.repetitions = std::atoi(value);
        else
            options.folder.clear();
    }
    if (options.folder.empty() || options.size < 64 || options.size % 64 != 0 || options.size > 16384 ||
        options.rows < 8 || options.rows % 8 != 0 || options.rows > options.size || options.repetitions < 1) {
        std::fprintf(
            stderr,
            "usage: bench_gpu SHADER_FOLDER [--device NAME] [--only VARIANT] [--json FILE]\n"
            "       [--size 4096, a multiple of 64] [--rows 32, a multiple of 8] [--repetitions 60]\n");
        return 2;
    }
    return Run(options);
}
