// SPDX-License-Identifier: MIT
// `ntc bench loader`: tiles a second from the file to the slot, through the demand loader.
#include "Arguments.h"
#include "Benchmark.h"
#include "Commands.h"
#include "Failure.h"
#include "InputFile.h"
#include "Interrupt.h"
#include "Json.h"
#include "Output.h"

#include "openntc/core/Crc32.h"
#include "openntc/streaming/DemandLoader.h"
#include "openntc/streaming/TextureSetTileSource.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <memory>
#include <vector>

namespace openntc::tool {

namespace {

struct LoaderOptions {
    std::string file;
    int tile = 32;
    int textures = 64;
    int limit = 256;
    int repeat = 7;
    std::vector<int> threads = {0, 1, 2, 4};
    bool json = false;
};

/// Slots in memory.
class MemoryPool final : public TileUploader {
public:
    explicit MemoryPool(std::size_t bytes) : bytes_(bytes) {}
    Expected<void> Upload(const TileUpload& upload) override {
        std::memcpy(bytes_.data() + upload.offset, upload.bytes.data(), upload.bytes.size());
        return {};
    }
    std::span<const std::byte> Get() const { return bytes_; }

private:
    std::vector<std::byte> bytes_;
};

struct LoaderRun {
    double seconds = 0;
    std::uint64_t tiles = 0;
    std::uint64_t bytes = 0;
    std::uint32_t launches = 0;
    std::uint32_t crc = 0;
};

using Source = Shared<TextureSetTileSource>;

/// Asks for all tiles of all textures until they are there.
LoaderRun LoadAll(const std::vector<Source>& sources, const LoaderOptions& options, int threads) {
    std::uint32_t tiles = 0;
    for (const Source& source : sources)
        tiles += static_cast<std::uint32_t>(source->GetLayout().GetTileCount());
    DemandLoaderOptions loading;
    loading.slots = tiles;
    loading.slotBytes = static_cast<std::uint32_t>((sources[0]->GetLargestTileBytes() + 15) / 16 * 16);
    const std::uint32_t textures = static_cast<std::uint32_t>(sources.size());
    loading.table = {textures, tiles, tiles, tiles, textures * NTC_MAX_MIPS, 0, 0};
    loading.framesInFlight = 1;
    loading.threads = threads;
    loading.maxOutstanding = static_cast<std::uint32_t>(options.limit);
    DemandLoader loader = Require(DemandLoader::Create(loading), ExitCode::Failed, "loader");
    MemoryPool pool(std::size_t{tiles} * loading.slotBytes);
    LoaderRun run;
    const auto begin = std::chrono::steady_clock::now();
    std::vector<NtcTileRequest> wanted, asked;
    for (const Source& source : sources) {
        TiledTextureDesc desc;
        desc.format = TileFormat::TextureSet;
        desc.hasFeedback = false;
        const DemandId id = Require(loader.CreateTexture(source, desc), ExitCode::Failed, "texture");
        for (std::uint32_t t = 0; t < static_cast<std::uint32_t>(source->GetLayout().GetTileCount()); ++t)
            wanted.push_back({id.index, t});
    }
    while (!wanted.empty()) {
        ThrowIfInterrupted();
        const LaunchPlan plan = Require(loader.LaunchPrepare(pool), ExitCode::Failed, "launch");
        asked.clear();
        for (const NtcTileRequest& request : wanted) { // as a launch would
            if (*loader.GetPageTable().GetSlot(request.textureId, request.tile) == NTC_TILE_MISSING)
                asked.push_back(request);
        }
        wanted = asked;
        const std::size_t count = std::min(asked.size(), static_cast<std::size_t>(2 * options.limit));
        const DemandReadback readback{{std::as_bytes(std::span(asked).first(count)), 0}, {}};
        const DemandTicket ticket =
            Require(loader.ProcessRequests(plan.context, readback), ExitCode::Failed, "requests");
        ticket.Wait();
        loader.WaitIdle();
        ++run.launches;
    }
    run.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    DemandError error;
    if (loader.TakeError(error))
        throw CommandError(ExitCode::Failed, options.file,
                           Format("tile %u: %s", error.tile, error.error.GetText()));
    const DemandStatistics statistics = loader.GetStatistics();
    run.tiles = statistics.uploaded;
    run.bytes = statistics.bytesUploaded;
    for (std::uint32_t slot = 0; slot < tiles; ++slot) { // whatever the order: sums of sums
        run.crc += Crc32(
            pool.Get().subspan(std::size_t{slot} * loading.slotBytes, sources[0]->GetLargestTileBytes()));
    }
    return run;
}

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

LoaderResult MeasureLoader(const LoaderOptions& options, std::span<const std::byte> file, bool isFile,
                           int threads) {
    LoaderResult result;
    result.isFile = isFile;
    result.threads = threads;
    std::vector<double> seconds;
    for (int run = -1; run < options.repeat; ++run) { // the first warms up
        std::vector<Source> sources;
        for (int i = 0; i < options.textures; ++i) {
            sources.push_back(
                Require(isFile ? TextureSetTileSource::OpenFile(options.file, options.tile, options.tile)
                               : TextureSetTileSource::OpenMemory(file, options.tile, options.tile),
                        ExitCode::BadInput, options.file));
        }
        const LoaderRun loaded = LoadAll(sources, options, threads);
        if (run >= 0)
            seconds.push_back(loaded.seconds);
        result.last = loaded;
    }
    result.tiles = GetLoaderRates(seconds, static_cast<double>(result.last.tiles));
    result.megabytes = GetLoaderRates(seconds, static_cast<double>(result.last.bytes) * 1e-6);
    return result;
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

int RunBenchLoader(const LoaderOptions& options) {
    const std::vector<std::byte> file = ReadAll(options.file);
    std::vector<LoaderResult> results;
    for (const bool isFile : {true, false}) {
        for (const int threads : options.threads)
            results.push_back(MeasureLoader(options, file, isFile, threads));
    }
    const LoaderRun& any = results[0].last;
    JsonWriter json;
    json.BeginObject();
    json.Member("file", std::string_view(options.file));
    json.Member("cpu", std::string_view(GetCpuName()));
    json.Member("cores", GetCoreCount());
    json.Member("tile", options.tile);
    json.Member("textures", options.textures);
    json.Member("limit", options.limit);
    json.Member("tiles", any.tiles);
    json.Member("bytes", any.bytes);
    json.Member("crc32Sum", any.crc);
    json.Key("results");
    json.BeginArray();
    std::string text = Format(
        "cpu: %s\n%d textures, %llu tiles, %.0f bytes each on average, at most %d read at a time; median, "
        "slowest ... fastest\n",
        Printable(GetCpuName()).c_str(), options.textures, static_cast<unsigned long long>(any.tiles),
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
        "loader", "Tiles from a file, and from memory, to their slots through the demand loader");
    AddFileArgument(*command, options->file);
    AddNumberOption(*command, "--tile", options->tile, {1, 4096}, "Texels of a tile's sides (default 32)");
    AddNumberOption(*command, "--textures", options->textures, {1, 10000},
                    "Textures, each with a source of its own (default 64)");
    AddNumberOption(*command, "--limit", options->limit, {1, 100000},
                    "Tiles that are read at a time, a launch (default 256)");
    AddNumberOption(*command, "--repeat", options->repeat, {1, 1000}, "Timed runs (default 7)");
    command
        ->add_option("--threads", options->threads,
                     "Threads that read, one result each; 0: the calling one (default 0,1,2,4)")
        ->delimiter(',')
        ->check(CLI::Range(0, 256));
    AddJsonFlag(*command, options->json);
    command->callback([options, &action] { action = [options] { return RunBenchLoader(*options); }; });
}

} // namespace openntc::tool
