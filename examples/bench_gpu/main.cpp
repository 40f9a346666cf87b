// SPDX-License-Identifier: MIT
// `bench_gpu SHADER_FOLDER [options]`: time and correctness of the GPU decoders.
//
// For each line of SHADER_FOLDER/index.txt a synthesised set (seed 1, one mip, the known latent shape of 4 bits per
// texel) is decoded whole to a buffer of binary16; timestamps lie round the dispatch alone. The first rows are compared
// bit by bit with the C++ reference decoder, in binary32 and in binary16; FP8 results also with the interval of all results
// that FP8 hardware may return. `--pipelines 1` prints a table of pipeline creation instead, `--forms 1` one that compares
// the ways to fetch weights, `--matrices 1` measures cooperative matrices, `--textures 1` decoding to textures,
// `--generations 1` generations of files in turns. Latents in a texture are filtered by the device: they differ.
#include "Benchmark.h"
#include "CoopMat.h"
#include "FetchForms.h"
#include "Generations.h"
#include "IntervalCheck.h"
#include "Pipelines.h"
#include "Textures.h"

#include "openntc/MathModes.h"
#include "openntc/core/Half.h"
#include "openntc/decode/ReferenceDecoder.h"
#include "openntc/decode/ShaderMath.h"

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

const std::vector<float>& GetReference(Set& set, int network, int math, const Options& options) {
    const DecodeMath mode = GetDecodeMath(math);
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
std::string RunVariant(harness::Context& device, const Variant& v, Set& set, const Options& options) {
    if (const char* const skip = FindObstacle(device, v); skip != nullptr) {
        std::printf("%-34s %d SKIP: %s\n", v.name.c_str(), v.network, skip);
        return {};
    }
    const std::size_t form = UsesFP8(v.math) ? 1 : 0;
    const DeviceWeights own = MakeDeviceWeights(device, v, set);
    const auto width = static_cast<std::uint32_t>(options.size);
    const auto rows = static_cast<std::uint32_t>(options.rows);
    const std::uint64_t texels = std::uint64_t{width} * width;
    BenchBuffers buffers(device, own.constants, set.latents, own.weights,
                         std::max(texels * 32, std::uint64_t{width} * rows * 64));
    const auto bound = buffers.Bind(v.uniformWeights);
    if (v.latentTexture)
        buffers.MakeLatentTexture(*set.metadata);
    const harness::Image* const texture = buffers.GetLatentTexture();
    const auto read = [&](std::size_t bytes) {
        std::vector<std::byte> contents(bytes);
        Require(device.Read(buffers.GetResults(), 0, contents));
        return contents;
    };
    const std::uint32_t groupsX = width / (8 * static_cast<std::uint32_t>(v.texels));

    std::string row;
    const Expected<harness::ComputePipeline> kernel =
        MakeKernel(device, ReadWords(options.folder + "/" + v.file16), v.uniformWeights, v.latentTexture);
    if (!kernel) {
        std::printf("%-34s %d FAILED: %s\n", v.name.c_str(), v.network, kernel.error().GetText());
    } else {
        // Until the clocks are up: a GPU needs some tenths of a second of work.
        const auto start = std::chrono::steady_clock::now();
        do {
            TimeKernel(device, *kernel, bound, width, groupsX, width / 8, options.repetitions > 1 ? 4 : 1,
                       texture);
        } while (options.repetitions > 1 &&
                 std::chrono::steady_clock::now() - start < std::chrono::milliseconds(400));
        std::vector<double> ms =
            TimeKernel(device, *kernel, bound, width, groupsX, width / 8, options.repetitions, texture);
        std::sort(ms.begin(), ms.end());
        const double scale = 1e6 / static_cast<double>(texels); // ns per texel
        const double median = ms[ms.size() / 2] * scale;
        Comparison exact, half;
        std::vector<float> values;
        if (v.stage == 0) {
            const std::vector<float>& reference = GetReference(set, v.network, v.math, options);
            const std::vector<std::byte> bytes16 = read(reference.size() * 2);
            for (std::size_t i = 0; i < reference.size(); ++i) {
                std::uint16_t bits = 0;
                std::memcpy(&bits, bytes16.data() + 2 * i, 2);
                half.Add(HalfToFloat(bits), HalfToFloat(FloatToHalf(reference[i])));
            }
            if (v.file32 != "-") {
                const Expected<harness::ComputePipeline> check = MakeKernel(
                    device, ReadWords(options.folder + "/" + v.file32), v.uniformWeights, v.latentTexture);
                if (check) {
                    TimeKernel(device, *check, bound, width, groupsX, rows / 8, 1, texture);
                    const std::vector<std::byte> bytes32 = read(reference.size() * 4);
                    for (std::size_t i = 0; i < reference.size(); ++i) {
                        float value = 0;
                        std::memcpy(&value, bytes32.data() + 4 * i, 4);
                        exact.Add(value, reference[i]);
                        values.push_back(value);
                    }
                }
            }
        }
        const double rms = std::sqrt(exact.squares / std::max(exact.referenceSquares, 1e-30));
        std::printf(
            "%-34s %d best %.4f p10 %.4f median %.4f p90 %.4f ns/texel (%.2f Gtexel/s median, %.2f best) | "
            "binary32 %zu of %zu differ, max %.3g, rel rms %.3g | binary16 %zu of %zu differ | pipeline %.0f "
            "ms | %s\n",
            v.name.c_str(), v.network, ms.front() * scale, ms[ms.size() / 10] * scale, median,
            ms[ms.size() * 9 / 10] * scale, 1 / median, 1 / (ms.front() * scale), exact.different,
            exact.values, exact.maximum, rms, half.different, half.values, kernel->GetCreationSeconds() * 1e3,
            kernel->GetStatistics().c_str());
        const std::string intervals = form == 1 && !values.empty() && IsNetworkVersion(v.network)
                                          ? CheckFP8Intervals(set, v.network, options.size, values)
                                          : "";
        char text[1024];
        std::snprintf(
            text, sizeof text,
            "{\"variant\":\"%s\",\"network\":%d,\"math\":%d,\"texelsPerInvocation\":%d,\"stage\":%d,"
            "\"repetitions\":%d,\"bestNs\":%.5f,\"p10Ns\":%.5f,\"medianNs\":%.5f,\"p90Ns\":%.5f,"
            "\"values\":%zu,\"different32\":%zu,\"maximumError\":%.6g,\"relativeRms\":%.6g,"
            "\"different16\":%zu,\"pipelineMs\":%.1f,\"statistics\":\"",
            v.name.c_str(), v.network, v.math, v.texels, v.stage, options.repetitions, ms.front() * scale,
            ms[ms.size() / 10] * scale, median, ms[ms.size() * 9 / 10] * scale, exact.values, exact.different,
            exact.maximum, rms, half.different, kernel->GetCreationSeconds() * 1e3);
        row = text + Escape(kernel->GetStatistics()) + "\"" + intervals + "}";
    }
    std::fflush(stdout);
    return row;
}

int Run(const Options& options) {
    if (options.pipelines || options.forms) { // what a driver keeps on disk would answer for it
        setenv("MESA_SHADER_CACHE_DISABLE", "true", 1);
        setenv("__GL_SHADER_DISK_CACHE", "0", 1);
    }
    harness::ContextOptions contextOptions;
    contextOptions.device = options.device;
    const auto context = harness::Context::Create(contextOptions);
    if (!context) {
        std::fprintf(stderr, "bench_gpu: %s\n", context.error().GetText());
        return 2;
    }
    harness::Context& device = **context;
    const harness::DeviceInfo& facts = device.GetDevice();
    std::printf("device %s, driver %s, OpSDot %d, subgroup %u, uniform buffer %llu bytes, %dx%d texels, %d "
                "repetitions\n",
                facts.name.c_str(), facts.driver.c_str(),
                facts.features.Has(harness::Feature::IntegerDotProduct), facts.subgroupSize,
                static_cast<unsigned long long>(facts.maxUniformBufferBytes), options.size, options.size,
                options.repetitions);
    for (const std::string& types : facts.cooperativeVectorTypes)
        std::printf("cooperative vectors: %s\n", types.c_str());
    if (options.pipelines)
        return PrintPipelines(device, options);
    if (options.forms)
        return PrintFetchForms(device, options);
    if (options.matrices)
        return PrintCoopMat(device, options);
    if (options.textures)
        return PrintTextures(device, options);
    if (options.generations)
        return PrintGenerations(device, options);
    std::string rows;
    std::map<int, std::unique_ptr<Set>> sets;
    for (const Variant& variant : ReadIndex(options)) {
        if (variant.stage == kPipelineStage)
            continue;
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
        else if (argument == "--pipelines")
            options.pipelines = std::atoi(value) != 0;
        else if (argument == "--forms")
            options.forms = std::atoi(value) != 0;
        else if (argument == "--matrices")
            options.matrices = std::atoi(value) != 0;
        else if (argument == "--textures")
            options.textures = std::atoi(value) != 0;
        else if (argument == "--generations")
            options.generations = std::atoi(value) != 0;
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
            "       [--size 4096, a multiple of 64] [--rows 32, a multiple of 8] [--repetitions 60]\n"
            "       bench_gpu SHADER_FOLDER --pipelines 1 [--device NAME] [--only VARIANT]\n"
            "       bench_gpu SHADER_FOLDER --forms 1 [--device NAME] [--repetitions 60]\n"
            "       bench_gpu SHADER_FOLDER --matrices 1 [--device NAME] [--only FILE] [--repetitions 60]\n"
            "       bench_gpu SHADER_FOLDER --textures 1 [--device NAME] [--only KIND] [--repetitions 60]\n"
            "       bench_gpu SHADER_FOLDER --generations 1 [--device NAME] [--only VARIANT] [--size 4096]\n"
            "       [--repetitions 60]\n");
        return 2;
    }
    return Run(options);
}
