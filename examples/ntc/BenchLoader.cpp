// SPDX-License-Identifier: MIT
// `ntc bench loader`: tiles a second from the file to the slot, through the demand loader.
#include "Arguments.h"
#include "Benchmark.h"
#include "Commands.h"
#include "Failure.h"
#include "ImageTiles.h"
#include "InputFile.h"
#include "Json.h"
#include "LoaderTimes.h"
#include "Output.h"

#include "openntc/streaming/TextureSetTileSource.h"

#include <algorithm>
#include <memory>
#include <vector>

namespace openntc::tool {

namespace {

struct LoaderOptions {
    std::string file;
    int tile = 32;
    int textures = 0; ///< 64, of images 1
    int limit = 256;
    int repeat = 7;
    std::vector<int> threads = {0, 1, 2, 4};
    bool linear = false;
    bool json = false;
};

struct LoaderResult {
    bool isFile = false;
    int threads = 0;
    Rates tiles;     ///< a second
    Rates megabytes; ///< a second
    LoaderRun last;
};

Rates GetLoaderRates(std::vector<double> seconds, double work) {
    std::sort(seconds.begin(), seconds.end());
    const std::size_t middle = seconds.size() / 2;
    const double median =
        seconds.size() % 2 != 0 ? seconds[middle] : (seconds[middle - 1] + seconds[middle]) / 2;
    return {work / median, work / seconds.back(), work / seconds.front(), seconds.size()};
}

LoaderResult MeasureLoader(const LoaderOptions& options, const LoaderJob& job, bool isFile, int threads) {
    LoaderResult result;
    result.isFile = isFile;
    result.threads = threads;
    const std::vector<LoaderRun> runs = TimeLoader(job, threads, options.repeat);
    std::vector<double> seconds;
    for (const LoaderRun& run : runs)
        seconds.push_back(run.seconds);
    result.last = runs.back();
    result.tiles = GetLoaderRates(seconds, static_cast<double>(result.last.tiles));
    result.megabytes = GetLoaderRates(seconds, static_cast<double>(result.last.bytes) * 1e-6);
    return result;
}

/// A source for each texture, which opens the file, or reads `file`.
LoaderJob MakeSetJob(const LoaderOptions& options, std::span<const std::byte> file, bool isFile) {
    LoaderJob job;
    job.name = options.file;
    job.limit = options.limit;
    job.open = [&options, file, isFile] {
        std::vector<Shared<TileSource>> sources;
        for (int i = 0; i < options.textures; ++i) {
            sources.push_back(
                Require(isFile ? TextureSetTileSource::OpenFile(options.file, options.tile, options.tile)
                               : TextureSetTileSource::OpenMemory(file, options.tile, options.tile),
                        ExitCode::BadInput, options.file));
        }
        return sources;
    };
    return job;
}

/// One source, read once, for all textures.
LoaderJob MakeImageJob(const LoaderOptions& options) {
    const Shared<ImageTileSource> image =
        ImageTileSource::Open(options.file, options.tile, options.tile, !options.linear);
    LoaderJob job;
    job.name = options.file;
    job.limit = options.limit;
    job.format = image->GetFormat();
    job.open = [image, count = static_cast<std::size_t>(options.textures)] {
        return std::vector<Shared<TileSource>>(count, image);
    };
    return job;
}

const char* GetFormatName(TileFormat format) {
    switch (format) {
    case TileFormat::TextureSet:
        return "TextureSet";
    case TileFormat::R8:
        return "R8";
    case TileFormat::RGBA8:
        return "RGBA8";
    case TileFormat::RGBA8Srgb:
        return "RGBA8Srgb";
    case TileFormat::R16F:
        return "R16F";
    case TileFormat::RGBA16F:
        return "RGBA16F";
    case TileFormat::R32F:
        return "R32F";
    default:
        return "RGBA32F";
    }
}

void WriteLoaderRates(JsonWriter& json, const char* key, const Rates& rates) {
    json.Key(key);
    json.BeginObject();
    json.Member("median", rates.median);
    json.Member("minimum", rates.minimum);
    json.Member("maximum", rates.maximum);
    json.Member("runs", static_cast<std::uint64_t>(rates.runs));
    json.EndObject();
}

int RunBenchLoader(LoaderOptions options) {
    const std::vector<std::byte> file = ReadAll(options.file);
    const bool isImage = IsTileableImage(file);
    if (options.textures == 0)
        options.textures = isImage ? 1 : 64;
    std::vector<LoaderResult> results;
    TileFormat format = TileFormat::TextureSet;
    if (isImage) {
        const LoaderJob job = MakeImageJob(options);
        format = job.format;
        for (const int threads : options.threads)
            results.push_back(MeasureLoader(options, job, false, threads));
    } else {
        for (const bool isFile : {true, false}) {
            for (const int threads : options.threads)
                results.push_back(MeasureLoader(options, MakeSetJob(options, file, isFile), isFile, threads));
        }
    }
    const LoaderRun& any = results[0].last;
    JsonWriter json;
    json.BeginObject();
    json.Member("file", std::string_view(options.file));
    json.Member("cpu", std::string_view(GetCpuName()));
    json.Member("cores", GetCoreCount());
    json.Member("format", std::string_view(GetFormatName(format)));
    json.Member("tile", options.tile);
    json.Member("textures", options.textures);
    json.Member("limit", options.limit);
    json.Member("tiles", any.tiles);
    json.Member("bytes", any.bytes);
    json.Member("crc32Sum", any.crc);
    json.Key("results");
    json.BeginArray();
    std::string text = Format("cpu: %s\n%d textures (%s), %llu tiles, %.0f bytes each on average, at most %d "
                              "read at a time; median, "
                              "slowest ... fastest\n",
                              Printable(GetCpuName()).c_str(), options.textures, GetFormatName(format),
                              static_cast<unsigned long long>(any.tiles),
                              static_cast<double>(any.bytes) / static_cast<double>(any.tiles), options.limit);
    for (const LoaderResult& result : results) {
        if (result.last.crc != any.crc)
            throw CommandError(ExitCode::Failed, options.file, "tiles: differ from run to run");
        text +=
            Format("%-6s %3d threads %9.0f tiles/s, %.0f ... %.0f; %.0f MB/s; %u launches\n",
                   result.isFile ? "file" : "memory", result.threads, result.tiles.median,
                   result.tiles.minimum, result.tiles.maximum, result.megabytes.median, result.last.launches);
        json.BeginObject();
        json.Member("source", result.isFile ? std::string_view("file") : std::string_view("memory"));
        json.Member("threads", result.threads);
        json.Member("launches", static_cast<std::uint64_t>(result.last.launches));
        WriteLoaderRates(json, "tilesPerSecond", result.tiles);
        WriteLoaderRates(json, "megabytesPerSecond", result.megabytes);
        json.EndObject();
    }
    json.EndArray();
    json.EndObject();
    WriteOutput(options.json ? json.Take() : text);
    return 0;
}

} // namespace

void AddBenchLoaderCommand(CLI::App& bench, Action& action) {
    auto options = std::make_shared<LoaderOptions>();
    CLI::App* command = bench.add_subcommand(
        "loader",
        "Tiles of a texture set, from its file and from memory, or of a PNG or OpenEXR image to their slots "
        "through the demand loader");
    AddFileArgument(*command, options->file);
    AddNumberOption(*command, "--tile", options->tile, {1, 4096}, "Texels of a tile's sides (default 32)");
    AddNumberOption(
        *command, "--textures", options->textures, {1, 10000},
        "Textures, each with a source of its own (default 64); of an image, which all share (default 1)");
    AddNumberOption(*command, "--limit", options->limit, {1, 100000},
                    "Tiles that are read at a time, a launch (default 256)");
    AddNumberOption(*command, "--repeat", options->repeat, {1, 1000}, "Timed runs (default 7)");
    command
        ->add_option("--threads", options->threads,
                     "Threads that read, one result each; 0: the calling one (default 0,1,2,4)")
        ->delimiter(',')
        ->check(CLI::Range(0, 256));
    command->add_flag("--linear", options->linear, "The image's colours are linear, not sRGB");
    AddJsonFlag(*command, options->json);
    command->callback([options, &action] { action = [options] { return RunBenchLoader(*options); }; });
}

} // namespace openntc::tool
