// SPDX-License-Identifier: MIT
#include "Benchmark.h"

#include "DotProducts.h"
#include "Failure.h"
#include "Interrupt.h"

#include "openntc/core/Crc32.h"
#include "openntc/format/NetworkDescription.h"

#include <algorithm>
#include <chrono>
#include <fstream>
#include <thread>

namespace openntc::tool {

namespace {

// Rectangles of at most this many texels, so that results stay in a buffer of a known size whatever the
// image.
constexpr int kTexelsPerCall = 1 << 18;

struct Run {
    double seconds = 0;
    std::optional<double> deviceSeconds;
};

// Decodes every mip; with `crc`, also checksums the outputs (untimed).
Run DecodeAll(Decoder& decoder, const TextureSetMetadata& metadata, const DecodeOptions& options,
              std::vector<float>& outputs, const std::string& name, std::uint32_t* crc) {
    Run run;
    run.deviceSeconds = 0.0;
    for (int mip = 0; mip < metadata.GetDesc().mips; ++mip) {
        const ColorMip& size = metadata.GetColorMips()[static_cast<std::size_t>(mip)];
        const int bandRows = std::max(1, kTexelsPerCall / size.width);
        for (int top = 0; top < size.height; top += bandRows) {
            ThrowIfInterrupted();
            const Rect rect{0, top, size.width, std::min(bandRows, size.height - top)};
            const std::size_t floats =
                static_cast<std::size_t>(rect.width) * static_cast<std::size_t>(rect.height) * 16;
            if (outputs.size() < floats)
                outputs.resize(floats);
            const auto start = std::chrono::steady_clock::now();
            Require(decoder.Decode(mip, rect, options, std::span(outputs).first(floats)), ExitCode::Failed,
                    name);
            run.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
            if (const std::optional<double> seconds = decoder.GetDeviceSeconds();
                seconds && run.deviceSeconds)
                run.deviceSeconds = *run.deviceSeconds + *seconds;
            else
                run.deviceSeconds.reset();
            if (crc != nullptr)
                *crc = Crc32(std::as_bytes(std::span(outputs).first(floats)), *crc);
        }
    }
    return run;
}

Rates Summarise(std::vector<double> rates) {
    std::sort(rates.begin(), rates.end());
    const std::size_t middle = rates.size() / 2;
    const double median = rates.size() % 2 != 0 ? rates[middle] : (rates[middle - 1] + rates[middle]) / 2;
    return {median, rates.front(), rates.back(), rates.size()};
}

} // namespace

std::vector<BenchmarkTarget> ListTargets(const std::vector<std::string>& backends, const std::string& device,
                                         bool onMatrices) {
    const auto isNamed = [&](const char* name) {
        return std::find(backends.begin(), backends.end(), name) != backends.end();
    };
    const auto isWanted = [&](const char* name) { return backends.empty() || isNamed(name); };
    std::vector<BenchmarkTarget> targets;
    if (isWanted("reference"))
        targets.push_back({"reference, 1 thread", {Backend::Reference, {}, {}, 0}, false});
    if (isWanted("cpu")) {
        for (const auto& [simd, name] : ListSimdTargets()) {
            targets.push_back(
                {std::string("cpu ") + name + ", 1 thread", {Backend::Cpu, {}, simd, 1}, false});
            targets.push_back(
                {std::string("cpu ") + name + ", " + std::to_string(GetCoreCount()) + " threads",
                 {Backend::Cpu, {}, simd, GetCoreCount()},
                 false});
        }
    }
    if (isWanted("vulkan"))
        targets.push_back({onMatrices ? "vulkan, matrices" : "vulkan",
                           {Backend::Vulkan, device, {}, 0, onMatrices},
                           isNamed("vulkan") || !device.empty() || onMatrices});
    return targets;
}

BenchmarkResult RunBenchmark(const BenchmarkTarget& target, const TextureSetMetadata& metadata,
                             const DecodeData& data, const DecodeOptions& options, int repeat) {
    BenchmarkResult result;
    result.name = target.name;
    result.backend = target.options.backend;
    result.threads = target.options.backend == Backend::Reference ? 1
                     : target.options.backend == Backend::Cpu     ? target.options.threads
                                                                  : 0;
    Expected<std::unique_ptr<Decoder>> made = MakeDecoder(data, target.options);
    if (!made && made.error().GetStatus() == Status::Unsupported) {
        result.skipped = made.error().GetText();
        return result;
    }
    const std::unique_ptr<Decoder> decoder = Require(std::move(made), ExitCode::BadInput, target.name);
    result.device = decoder->GetDeviceName();

    std::vector<float> outputs;
    DecodeAll(*decoder, metadata, options, outputs, target.name, &result.crc32);
    const double megatexels = static_cast<double>(CountTexels(metadata)) * 1e-6;
    std::vector<double> rates;
    std::vector<double> deviceRates;
    const double products = GetNetworkDescription(data.networkVersion).weightBytes; // one a weight
    for (int i = 0; i < repeat; ++i) {
        const Run run = DecodeAll(*decoder, metadata, options, outputs, target.name, nullptr);
        rates.push_back(megatexels / run.seconds);
        if (run.deviceSeconds)
            deviceRates.push_back(megatexels / *run.deviceSeconds);
        if (target.options.backend != Backend::Cpu || target.options.threads != 1 ||
            data.math > DecodeMath::Int8Half)
            continue;
        if (const std::optional<double> rate = MeasureDotProducts(target.options.simd))
            result.dotProducts = std::max(result.dotProducts.value_or(0.0), *rate / products * 1e-6);
    }
    result.rates = Summarise(rates);
    if (deviceRates.size() == rates.size())
        result.deviceRates = Summarise(deviceRates);
    return result;
}

std::vector<double> TimeLoads(std::span<const std::byte> file, int repeat, const std::string& path) {
    std::vector<double> microseconds;
    microseconds.reserve(static_cast<std::size_t>(repeat));
    for (int i = -1; i < repeat; ++i) { // the first touches pages and fills caches
        ThrowIfInterrupted();
        ReadOnlyMemoryStream stream(file);
        const auto begin = std::chrono::steady_clock::now();
        const Expected<TextureSetMetadata> set = TextureSetMetadata::Load(stream);
        const std::chrono::duration<double, std::micro> time = std::chrono::steady_clock::now() - begin;
        if (!set)
            throw CommandError(ExitCode::BadInput, path, set.error().GetText());
        if (i >= 0)
            microseconds.push_back(time.count());
    }
    std::sort(microseconds.begin(), microseconds.end());
    return microseconds;
}

std::uint64_t CountTexels(const TextureSetMetadata& metadata) {
    std::uint64_t texels = 0;
    for (const ColorMip& mip : metadata.GetColorMips())
        texels += static_cast<std::uint64_t>(mip.width) * static_cast<std::uint64_t>(mip.height);
    return texels;
}

std::string GetCpuName() {
    std::ifstream file("/proc/cpuinfo");
    for (std::string line; std::getline(file, line);) {
        const std::size_t colon = line.find(": ");
        if (colon != std::string::npos && (line.starts_with("model name") || line.starts_with("Processor")))
            return line.substr(colon + 2);
    }
    return "unknown";
}

int GetCoreCount() {
    return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

} // namespace openntc::tool
