// SPDX-License-Identifier: MIT
// What GDeflate costs on this machine, on one thread: of sets of generation 3 their latents, of other files all bytes,
// in tiles of 64 KiB, which libdeflate gets too, each as a raw DEFLATE stream of its own. Decompression also on all threads,
// and with --device on a GPU, by VK_NV_memory_decompression and by a compute pass. All in turns.
#include "DeviceTiles.h"

#include "openntc/container/GDeflateEncoder.h"
#include "openntc/core/FileStream.h"
#include "openntc/core/ThreadTeam.h"
#include "openntc/inference/ReadLatents.h"

#include <libdeflate.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace {

using namespace openntc;
using Bytes = std::vector<std::byte>;

struct Options {
    std::vector<std::string> files;
    int level = container::kDefaultGDeflateLevel;
    int rounds = 15;
    int threads = CountHardwareThreads();
    bool hasDevice = false; // --device was given
    std::string device;
};

/// Bytes by their time, one number a round.
struct Speed {
    std::vector<double> seconds;

    template <typename Work>
    void Measure(Work work) {
        const auto start = std::chrono::steady_clock::now();
        work();
        seconds.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    }
    /// Million bytes a second, at a quantile of the time.
    double Get(std::size_t bytes, double quantile) {
        std::sort(seconds.begin(), seconds.end());
        const auto at =
            static_cast<std::size_t>(std::lround(quantile * static_cast<double>(seconds.size() - 1)));
        return static_cast<double>(bytes) / seconds[at] / 1e6;
    }
};

[[noreturn]] void Die(const std::string& file, const char* text) {
    std::fprintf(stderr, "bench_gdeflate: %s: %s\n", file.c_str(), text);
    std::exit(3);
}

Bytes ReadData(const std::string& name) {
    Expected<FileReader> file = FileReader::Open(name);
    if (!file)
        Die(name, file.error().GetText());
    if (const auto set = TextureSetMetadata::Load(*file); set && set->GetGeneration() > 1) {
        Bytes latents(GetLatentBufferBytes(*set, 0, set->GetDesc().mips).value_or(0));
        if (const auto read = ReadLatents(*set, *file, 0, set->GetDesc().mips, latents); !read)
            Die(name, read.error().GetText());
        return latents;
    }
    Bytes bytes(static_cast<std::size_t>(file->Size()));
    if (!file->ReadAt(0, bytes.data(), bytes.size()) || bytes.empty())
        Die(name, "cannot be read, or is empty");
    return bytes;
}

struct DeflateTiles {
    std::vector<Bytes> tiles;
    std::size_t bytes = 0;
};

void Print(const char* name, std::size_t compressed, std::size_t bytes, Speed& encode, Speed& decode) {
    std::printf(
        "  %-22s %9zu bytes (%.3f)  compress %7.1f MB/s  decompress %7.1f MB/s (quartiles %.1f, %.1f)\n",
        name, compressed, static_cast<double>(compressed) / static_cast<double>(bytes),
        encode.Get(bytes, 0.5), decode.Get(bytes, 0.5), decode.Get(bytes, 0.75), decode.Get(bytes, 0.25));
}

/// The same on many threads: tiles know nothing of one another.
bool DecompressOnThreads(std::span<const std::byte> stream, std::span<std::byte> output, ThreadTeam& team) {
    const auto header = container::DecodeGDeflateHeader(stream);
    if (!header || header->GetBytes() != output.size())
        return false;
    std::atomic<bool> isRight = true;
    team.Run(static_cast<int>(header->tiles), [&](int job, int) {
        const auto tile = static_cast<std::uint32_t>(job);
        const auto range = container::FindGDeflateTile(*header, stream, stream.size(), tile);
        const bool isDone =
            range &&
            container::DecompressGDeflateTile(
                stream.subspan(static_cast<std::size_t>(range->offset), range->size),
                output.subspan(tile * container::kGDeflateTileBytes, header->GetTileBytes(tile)), tile);
        if (!isDone)
            isRight = false;
    });
    return isRight;
}

void PrintDecompression(const std::string& name, std::size_t bytes, Speed& speed) {
    std::printf("  %-66s decompress %8.1f MB/s (quartiles %.1f, %.1f)\n", name.c_str(), speed.Get(bytes, 0.5),
                speed.Get(bytes, 0.75), speed.Get(bytes, 0.25));
}

/// A device and what it took.
struct DeviceRun {
    std::unique_ptr<bench::DeviceTiles> tiles;
    Speed speed;
};

/// One round on a device. False if other bytes came back.
bool MeasureDevice(const Bytes& data, std::span<const std::byte> stream, DeviceRun& run) {
    const double seconds = run.tiles->Prepare(stream) ? run.tiles->Decompress() : -1.0;
    run.speed.seconds.push_back(seconds);
    Bytes output(data.size());
    return seconds >= 0.0 && run.tiles->Read(output) && output == data;
}

void RunFile(const std::string& name, const Options& options, ThreadTeam& team,
             std::vector<DeviceRun>& devices) {
    const Bytes data = ReadData(name);
    Bytes output(data.size());
    Array<std::byte> stream;
    Speed encode;
    Speed decode;
    container::GDeflateEncoder encoder(options.level);
    libdeflate_compressor* const compressor = libdeflate_alloc_compressor(options.level);
    libdeflate_decompressor* const decompressor = libdeflate_alloc_decompressor();
    Speed otherEncode;
    Speed otherDecode;
    DeflateTiles other;
    Speed threads;
    for (DeviceRun& run : devices)
        run.speed = Speed();
    bool isRight = true;
    for (int round = 0; round < options.rounds; ++round) {
        encode.Measure([&] { isRight = isRight && encoder.Compress(data, stream).has_value(); });
        decode.Measure(
            [&] { isRight = isRight && container::DecompressGDeflate(stream.AsSpan(), output).has_value(); });
        isRight = isRight && output == data;
        const std::span<const std::byte> compressed = std::as_const(stream).AsSpan();
        threads.Measure([&] { isRight = isRight && DecompressOnThreads(compressed, output, team); });
        isRight = isRight && output == data;
        for (DeviceRun& run : devices)
            isRight = isRight && MeasureDevice(data, compressed, run);
        other = {};
        otherEncode.Measure([&] {
            for (std::size_t at = 0; at < data.size(); at += container::kGDeflateTileBytes) {
                const std::size_t bytes = std::min(container::kGDeflateTileBytes, data.size() - at);
                Bytes tile(libdeflate_deflate_compress_bound(compressor, bytes));
                tile.resize(libdeflate_deflate_compress(compressor, data.data() + at, bytes, tile.data(),
                                                        tile.size()));
                other.bytes += tile.size();
                other.tiles.push_back(std::move(tile));
            }
        });
        otherDecode.Measure([&] {
            for (std::size_t i = 0; i < other.tiles.size(); ++i) {
                const std::size_t at = i * container::kGDeflateTileBytes;
                const std::size_t bytes = std::min(container::kGDeflateTileBytes, data.size() - at);
                isRight = isRight && libdeflate_deflate_decompress(decompressor, other.tiles[i].data(),
                                                                   other.tiles[i].size(), output.data() + at,
                                                                   bytes, nullptr) == LIBDEFLATE_SUCCESS;
            }
        });
        isRight = isRight && output == data;
    }
    libdeflate_free_compressor(compressor);
    libdeflate_free_decompressor(decompressor);
    if (!isRight)
        Die(name, "what was compressed did not come back");
    std::printf("%s: %zu bytes, level %d, medians of %d rounds\n", name.c_str(), data.size(), options.level,
                options.rounds);
    Print("GDeflate", stream.size(), data.size(), encode, decode);
    Print("DEFLATE of libdeflate", other.bytes, data.size(), otherEncode, otherDecode);
    PrintDecompression("GDeflate on " + std::to_string(team.GetThreadCount()) + " threads", data.size(),
                       threads);
    for (DeviceRun& run : devices)
        PrintDecompression("GDeflate on " + run.tiles->GetName(), data.size(), run.speed);
}

Options ParseOptions(int count, char** arguments) {
    Options options;
    for (int i = 1; i < count; ++i) {
        const std::string argument = arguments[i];
        const bool hasValue = i + 1 < count;
        if (argument == "--level" && hasValue)
            options.level = std::atoi(arguments[++i]);
        else if (argument == "--rounds" && hasValue)
            options.rounds = std::atoi(arguments[++i]);
        else if (argument == "--threads" && hasValue)
            options.threads = std::atoi(arguments[++i]);
        else if (argument == "--device" && hasValue) {
            options.hasDevice = true;
            options.device = arguments[++i];
        } else
            options.files.push_back(argument);
    }
    if (options.files.empty() || options.level < 1 || options.level > 12 || options.rounds < 1 ||
        options.threads < 1 || options.threads > kMaxThreads) {
        std::fprintf(stderr, "bench_gdeflate: usage: FILE... [--level 1 ... 12] [--rounds N] [--threads N] "
                             "[--device NAME]\n");
        std::exit(2);
    }
    return options;
}

} // namespace

int main(int count, char** arguments) {
    const Options options = ParseOptions(count, arguments);
    std::vector<DeviceRun> devices;
    for (const bool byShader : {false, true}) {
        if (!options.hasDevice)
            break;
        std::string reason;
        if (auto tiles = bench::DeviceTiles::Create(options.device, byShader, reason))
            devices.push_back({std::move(tiles), {}});
        else
            std::fprintf(stderr, "bench_gdeflate: --device: %s\n", reason.c_str());
    }
    if (options.hasDevice && devices.empty())
        return 4;
    ThreadTeam team(options.threads);
    for (const std::string& file : options.files)
        RunFile(file, options, team, devices);
    return 0;
}
