// SPDX-License-Identifier: MIT
// `ntc bench slices`: how many slices a second are cut out of a file that is in memory, beside copies of as many bytes.
#include "Arguments.h"
#include "Benchmark.h"
#include "Commands.h"
#include "Failure.h"
#include "InputFile.h"
#include "Interrupt.h"
#include "Json.h"
#include "Output.h"

#include "openntc/core/Crc32.h"
#include "openntc/inference/PartialInference.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstring>
#include <memory>
#include <vector>

namespace openntc::tool {

namespace {

struct SlicesOptions {
    std::string file;
    int size = 128;
    int firstMip = 0;
    int mips = 4;
    int slices = 20000;
    int repeat = 15;
    bool json = false;
};

/// A file in memory, its slices side by side from the upper left corner on, and a place for each.
struct SliceJob {
    std::vector<std::byte> file;
    TextureSetMetadata set;
    std::vector<SliceDesc> slices;
    std::vector<std::size_t> places; // one more than slices
    std::vector<std::byte> buffer;
};

SliceJob MakeJob(const SlicesOptions& options) {
    std::vector<std::byte> file = ReadAll(options.file);
    ReadOnlyMemoryStream stream(file);
    SliceJob job{
        {}, Require(TextureSetMetadata::Load(stream), ExitCode::BadInput, options.file), {}, {0}, {}};
    const int mips = job.set.GetDesc().mips;
    if (options.firstMip >= mips)
        FailUsage("--first-mip", Format("%d: 0 ... %d", options.firstMip, mips - 1));
    if (options.mips > mips - options.firstMip)
        FailUsage("--mips", Format("%d: 1 ... %d from mip %d", options.mips, mips - options.firstMip,
                                   options.firstMip));
    const ColorMip& size = job.set.GetColorMips()[static_cast<std::size_t>(options.firstMip)];
    if (options.size > size.width || options.size > size.height)
        FailUsage("--size", Format("%d: the mip has %dx%d texels", options.size, size.width, size.height));
    std::size_t bytes = 0;
    for (int top = 0; top + options.size <= size.height; top += options.size) {
        for (int left = 0; left + options.size <= size.width; left += options.size) {
            const SliceDesc slice{options.firstMip, options.mips, {left, top, options.size, options.size}};
            bytes += static_cast<std::size_t>(
                Require(GetPartialLatentBufferSize(job.set, slice), ExitCode::BadInput, options.file));
            job.slices.push_back(slice);
            job.places.push_back(bytes);
        }
    }
    job.buffer.resize(bytes);
    job.file = std::move(file);
    return job;
}

std::span<std::byte> GetPlace(SliceJob& job, std::size_t i) {
    return std::span(job.buffer).subspan(job.places[i], job.places[i + 1] - job.places[i]);
}

/// What one slice is made with. Results go to `sink`, so that no compiler leaves the work out.
void MakeWhole(SliceJob& job, std::size_t i, std::uint32_t& sink) {
    ReadOnlyMemoryStream stream(job.file);
    const auto data = MakePartialInferenceData(job.set, stream, job.slices[i],
                                               InferenceWeightType::GenericInt8, GetPlace(job, i));
    sink += Require(Expected<PartialInferenceData>(data), ExitCode::Failed, "slice")
                .constants.highResNeuralMips[0]
                .sliceLeftTop;
}

void MakeRow(SliceJob& job, std::size_t i, std::uint32_t& sink) {
    const SliceLayout layout = Require(GetSliceLayout(job.set, job.slices[i]), ExitCode::Failed, "slice");
    Require(ReadSlice(layout, job.file, 0, GetPlace(job, i)), ExitCode::Failed, "slice");
    const auto row = MoveSliceConstants(MakeSliceConstants(layout, layout.grids[0].neuralMip), 64);
    sink += row->lowRes.dataOffset;
}

void Copy(SliceJob& job, std::size_t i, std::uint32_t& sink) {
    const std::span<std::byte> place = GetPlace(job, i);
    const std::size_t from =
        job.places[i] % (job.file.size() - place.size() + 1); // a file is longer than its slices
    std::memcpy(place.data(), job.file.data() + from, place.size());
    sink += static_cast<std::uint32_t>(place[i % place.size()]);
}

struct Method {
    const char* name;
    const char* text;
    void (*run)(SliceJob&, std::size_t, std::uint32_t&);
};

constexpr std::array kMethods = {
    Method{"makePartialInferenceData", "MakePartialInferenceData: latents and 624 bytes of constants",
           MakeWhole},
    Method{"readSlice", "GetSliceLayout, ReadSlice, a row of constants", MakeRow},
    Method{"memcpy", "memcpy of as many bytes in one piece a slice", Copy},
};

/// Seconds of each method for `slices` slices, `repeat` times in turns.
std::array<std::vector<double>, kMethods.size()> Measure(SliceJob& job, const SlicesOptions& options,
                                                         std::uint32_t& sink) {
    std::array<std::vector<double>, kMethods.size()> seconds;
    for (int run = -1; run < options.repeat; ++run) { // the first warms up
        for (std::size_t m = 0; m < kMethods.size(); ++m) {
            ThrowIfInterrupted();
            const auto begin = std::chrono::steady_clock::now();
            for (int i = 0; i < options.slices; ++i)
                kMethods[m].run(job, static_cast<std::size_t>(i) % job.slices.size(), sink);
            const std::chrono::duration<double> time = std::chrono::steady_clock::now() - begin;
            if (run >= 0)
                seconds[m].push_back(time.count());
        }
    }
    return seconds;
}

Rates GetRates(std::vector<double> seconds, double work) {
    std::sort(seconds.begin(), seconds.end());
    const std::size_t middle = seconds.size() / 2;
    const double median =
        seconds.size() % 2 != 0 ? seconds[middle] : (seconds[middle - 1] + seconds[middle]) / 2;
    return {work / median, work / seconds.back(), work / seconds.front(), seconds.size()};
}

void WriteRatesOf(JsonWriter& json, const char* key, const Rates& rates) {
    json.Key(key);
    json.BeginObject();
    json.Member("median", rates.median);
    json.Member("minimum", rates.minimum);
    json.Member("maximum", rates.maximum);
    json.Member("runs", static_cast<std::uint64_t>(rates.runs));
    json.EndObject();
}

int RunBenchSlices(const SlicesOptions& options) {
    SliceJob job = MakeJob(options);
    std::uint32_t sink = 0;
    const auto seconds = Measure(job, options, sink);
    for (std::size_t i = 0; i < job.slices.size(); ++i) // what is left is slices, not copies
        MakeRow(job, i, sink);
    const std::uint32_t crc = Crc32(job.buffer);
    const double bytes = static_cast<double>(job.buffer.size()) / static_cast<double>(job.slices.size());
    JsonWriter json;
    json.BeginObject();
    json.Member("file", std::string_view(options.file));
    json.Member("cpu", std::string_view(GetCpuName()));
    json.Member("size", options.size);
    json.Member("firstMip", options.firstMip);
    json.Member("mips", options.mips);
    json.Member("positions", static_cast<std::uint64_t>(job.slices.size()));
    json.Member("bytesPerSlice", bytes);
    json.Member("crc32", crc);
    json.Key("results");
    json.BeginArray();
    std::string text =
        Format("cpu: %s\nslices of %dx%d texels, mips %d ... %d, from memory, one thread: %.0f "
               "bytes each; median, slowest ... fastest\n",
               Printable(GetCpuName()).c_str(), options.size, options.size, options.firstMip,
               options.firstMip + options.mips - 1, bytes);
    for (std::size_t m = 0; m < kMethods.size(); ++m) {
        const Rates slices = GetRates(seconds[m], options.slices);
        const Rates gigabytes = GetRates(seconds[m], options.slices * bytes * 1e-9);
        text += Format("%-65s %9.0f slices/s, %.0f ... %.0f; %.2f GB/s\n", kMethods[m].text, slices.median,
                       slices.minimum, slices.maximum, gigabytes.median);
        json.BeginObject();
        json.Member("name", std::string_view(kMethods[m].name));
        WriteRatesOf(json, "slicesPerSecond", slices);
        WriteRatesOf(json, "gigabytesPerSecond", gigabytes);
        json.EndObject();
    }
    json.EndArray();
    json.EndObject();
    WriteOutput(options.json ? json.Take() : text);
    return 0;
}

} // namespace

void AddBenchSlicesCommand(CLI::App& bench, Action& action) {
    auto options = std::make_shared<SlicesOptions>();
    CLI::App* command = bench.add_subcommand(
        "slices", "Cutting slices out of a file in memory, beside copies of as many bytes");
    AddFileArgument(*command, options->file);
    AddNumberOption(*command, "--size", options->size, {1, 1 << 20},
                    "Texels of a slice's sides (default 128)");
    AddNumberOption(*command, "--first-mip", options->firstMip, {0, 15}, "Mip of the rectangle (default 0)");
    AddNumberOption(*command, "--mips", options->mips, {1, 16}, "Mips of a slice (default 4)");
    AddNumberOption(*command, "--slices", options->slices, {1, 10000000}, "Slices of a run (default 20000)");
    AddNumberOption(*command, "--repeat", options->repeat, {1, 1000}, "Timed runs (default 15)");
    AddJsonFlag(*command, options->json);
    command->callback([options, &action] { action = [options] { return RunBenchSlices(*options); }; });
}

} // namespace openntc::tool
