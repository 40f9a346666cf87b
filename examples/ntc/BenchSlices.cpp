// SPDX-License-Identifier: MIT
// `ntc bench slices`: how many slices a second are cut out of a file that is in memory, beside copies of as many bytes.
#include "Arguments.h"
#include "Benchmark.h"
#include "Commands.h"
#include "Failure.h"
#include "InputFile.h"
#include "Json.h"
#include "Output.h"
#include "SliceTimes.h"

#include "openntc/core/Crc32.h"
#include "openntc/core/Stream.h"

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

SliceJob LoadJob(const SlicesOptions& options) {
    std::vector<std::byte> file = ReadAll(options.file);
    ReadOnlyMemoryStream stream(file);
    TextureSetMetadata set = Require(TextureSetMetadata::Load(stream), ExitCode::BadInput, options.file);
    const int mips = set.GetDesc().mips;
    if (options.firstMip >= mips)
        FailUsage("--first-mip", Format("%d: 0 ... %d", options.firstMip, mips - 1));
    if (options.mips > mips - options.firstMip)
        FailUsage("--mips", Format("%d: 1 ... %d from mip %d", options.mips, mips - options.firstMip,
                                   options.firstMip));
    const ColorMip& size = set.GetColorMips()[static_cast<std::size_t>(options.firstMip)];
    if (options.size > size.width || options.size > size.height)
        FailUsage("--size", Format("%d: the mip has %dx%d texels", options.size, size.width, size.height));
    return MakeSliceJob(std::move(file), std::move(set),
                        {options.firstMip, options.mips, {0, 0, options.size, options.size}}, options.file);
}

/// Of seconds in increasing order.
Rates GetRates(std::span<const double> seconds, double work) {
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
    SliceJob job = LoadJob(options);
    const std::vector<SliceTimes> times = TimeSlices(job, options.slices, options.repeat);
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
    json.Member("crc32", Crc32(job.buffer));
    json.Key("results");
    json.BeginArray();
    std::string text =
        Format("cpu: %s\nslices of %dx%d texels, mips %d ... %d, from memory, one thread: %.0f "
               "bytes each; median, slowest ... fastest\n",
               Printable(GetCpuName()).c_str(), options.size, options.size, options.firstMip,
               options.firstMip + options.mips - 1, bytes);
    for (const SliceTimes& entry : times) {
        const Rates slices = GetRates(entry.seconds, options.slices);
        const Rates gigabytes = GetRates(entry.seconds, options.slices * bytes * 1e-9);
        text += Format("%-65s %9.0f slices/s, %.0f ... %.0f; %.2f GB/s\n", entry.text, slices.median,
                       slices.minimum, slices.maximum, gigabytes.median);
        json.BeginObject();
        json.Member("name", std::string_view(entry.name));
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
