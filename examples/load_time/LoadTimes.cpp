// SPDX-License-Identifier: MIT
#include "LoadTimes.h"

#include "GpuLoader.h"
#include "LatentWork.h"

#include "Arguments.h"
#include "Benchmark.h"
#include "Failure.h"
#include "Interrupt.h"
#include "OutputFolder.h"
#include "textures/HintFile.h"
#include "textures/TexelConverter.h"
#include "textures/TextureFile.h"

#include "openntc/core/Crc32.h"
#include "openntc/core/FileStream.h"

#include <algorithm>
#include <chrono>
#include <deque>
#include <filesystem>
#include <memory>
#include <optional>
#include <random>
#include <span>
#include <system_error>
#include <utility>

namespace openntc::load_time {

namespace {

namespace fs = std::filesystem;
using tool::CommandError;
using tool::ExitCode;
using tool::Require;

/// Adds what a piece of work takes to a stage.
template <typename F>
auto Time(double& milliseconds, F&& work) {
    struct Stopwatch {
        double& total;
        std::chrono::steady_clock::time_point start = std::chrono::steady_clock::now();
        ~Stopwatch() {
            total +=
                std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
        }
    } stopwatch{milliseconds};
    return work();
}

double Median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    const std::size_t middle = values.size() / 2;
    return values.size() % 2 != 0 ? values[middle] : (values[middle - 1] + values[middle]) / 2.0;
}

std::uint64_t CountBytes(const tool::TextureFormat& format, const TextureSetMetadata& metadata) {
    tool::TextureFileDesc desc;
    desc.format = format;
    desc.width = static_cast<std::uint32_t>(metadata.GetDesc().width);
    desc.height = static_cast<std::uint32_t>(metadata.GetDesc().height);
    desc.levels = static_cast<std::uint32_t>(metadata.GetDesc().mips);
    std::uint64_t bytes = 0;
    for (const tool::TextureFileLevel& level : tool::LayOutTextureFile(desc).levels)
        bytes += level.bytes;
    return bytes;
}

/// A file as a loader reads it: one request into memory that nobody clears first.
class FileBytes {
public:
    explicit FileBytes(const std::string& path) {
        FileReader file = Require(FileReader::Open(path), ExitCode::BadInput, path);
        size_ = static_cast<std::size_t>(file.Size());
        bytes_ = std::make_unique_for_overwrite<std::byte[]>(size_);
        if (!file.Read(bytes_.get(), size_))
            throw CommandError(ExitCode::BadInput, path, "cannot be read");
    }
    std::span<const std::byte> AsSpan() const { return {bytes_.get(), size_}; }

private:
    std::unique_ptr<std::byte[]> bytes_;
    std::size_t size_ = 0;
};

/// A texture of a set as it is loaded.
struct TextureWork {
    tool::TextureFormat format;
    tool::TexelConverter converter;
    const tool::TextureHints* hints;
    std::vector<std::byte> blocks; // of the mip at hand
};

/// What a side file has for one texture; nothing where its hints are of other texels.
tool::TextureHints ChooseHints(const tool::HintFile* file, const TextureSetMetadata& metadata,
                               std::size_t texture, const tool::TextureFormat& format) {
    tool::TextureHints hints;
    if (file == nullptr || format.block != bc::BlockFormat::Bc7)
        return hints;
    for (int mip = 0; mip < metadata.GetDesc().mips; ++mip) {
        const auto map = file->Find(texture, mip);
        const ColorMip& size = metadata.GetColorMips()[static_cast<std::size_t>(mip)];
        if (map && tool::DescribeMismatch(map->texels, DecodeMath::Int8, format).empty())
            hints.AddMip(mip, *map, {0, 0, size.width, size.height}, size.width, size.height,
                         file->KnowsTexels());
    }
    return hints;
}

class Loading {
public:
    explicit Loading(const LoadOptions& options)
        : options_(options),
          team_(options.backend.threads > 0 ? options.backend.threads : CountHardwareThreads()) {
        if (options.backend.backend == tool::Backend::Vulkan)
            gpu_ = GpuLoader::Create(options.backend.device);
        if (gpu_)
            gpu_->UseDecompressor(options.decompressor);
        else if (options.decompressor != Decompressor::Cpu)
            tool::FailUsage("--decompress",
                            std::string(GetName(options.decompressor)) + ": needs --backend vulkan");
    }

    LoadTimes Run() {
        CountSizes();
        StageTimes warmUp; // pipelines are made, threads have run; and a checksum, which is not timed again
        LoadAll(warmUp);
        result_.blocksCrc32 = crc_;
        isWarm_ = true;
        WarmUpClocks();
        std::vector<StageTimes> runs(static_cast<std::size_t>(options_.repeat));
        for (StageTimes& times : runs)
            LoadAll(times);
        const auto median = [&](double StageTimes::*stage) {
            std::vector<double> values;
            for (const StageTimes& run : runs)
                values.push_back(run.*stage);
            return Median(std::move(values));
        };
        LoadWay& onLoad = result_.ways[2];
        LoadWay& onSample = result_.ways[3];
        onLoad.times = {median(&StageTimes::read),   median(&StageTimes::parse),
                        median(&StageTimes::upload), median(&StageTimes::decompress),
                        median(&StageTimes::decode), median(&StageTimes::transcode)};
        onSample.times = onLoad.times;
        onSample.times.decode = onSample.times.transcode = 0.0;
        for (LoadWay* way : {&result_.ways[0], &result_.ways[1]})
            way->times.read = TimeReading(way->diskBytes);
        return result_;
    }

private:
    /// A GPU that waited for its pipelines (BC7's compile for seconds) runs at a fraction of its clock
    /// for most of a second.
    void WarmUpClocks() {
        const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(options_.warmUp);
        while (gpu_ && std::chrono::steady_clock::now() < end) {
            StageTimes ignored;
            LoadAll(ignored);
        }
    }
    void CountSizes() {
        result_.sets = options_.sets;
        result_.ways = {LoadWay{"raw texels", 0, 0, {}},
                        {"blocks", 0, 0, {}},
                        {"NTC on load", 0, 0, {}},
                        {"NTC on sample", 0, 0, {}}};
        for (const std::string& path : options_.sets) {
            tool::TextureSet set = tool::LoadTextureSet(path);
            // Decompresses everything on the CPU, with checksums: no device sees a tile that is corrupt.
            const tool::DecodeData data = tool::LoadDecodeData(set);
            for (int mip = 0; mip < set.metadata.GetDesc().mips; ++mip) {
                const ColorMip& size = set.metadata.GetColorMips()[static_cast<std::size_t>(mip)];
                result_.texels +=
                    static_cast<std::uint64_t>(size.width) * static_cast<std::uint64_t>(size.height);
            }
            for (const Texture& texture : set.metadata.GetTextures())
                CountTexture(path, texture, set.metadata);
            const std::uint64_t fileBytes = set.input.GetStream().Size();
            std::error_code error;
            const std::uint64_t hintBytes =
                HasHints(path) ? static_cast<std::uint64_t>(fs::file_size(tool::GetHintPath(path), error))
                               : 0;
            result_.hintBytes += error ? 0 : hintBytes;
            result_.ways[2].diskBytes += fileBytes + (error ? 0 : hintBytes);
            result_.ways[3].diskBytes += fileBytes;
            result_.ways[3].memoryBytes += data.latents.size() + data.weights.size() + sizeof data.constants;
        }
    }
    void CountTexture(const std::string& path, const Texture& texture, const TextureSetMetadata& metadata) {
        const auto plain = tool::ChooseFormat(texture, {false, std::nullopt}, false);
        const auto chosen = tool::ChooseFormat(texture, options_.blocks, false);
        if (!plain || !chosen)
            throw CommandError(ExitCode::Failed, path,
                               std::string(texture.name) + ": no DDS format holds this texture");
        if (chosen->format.block && !HasEncoder(*chosen->format.block))
            throw CommandError(ExitCode::Failed, path,
                               std::string(texture.name) + ": " + GetName(chosen->format) +
                                   ": there is no encoder");
        if (!chosen->format.block)
            result_.uncompressed.push_back(path + ": " + std::string(texture.name));
        ++result_.textures;
        const std::uint64_t plainBytes = CountBytes(plain->format, metadata);
        const std::uint64_t blockBytes = CountBytes(chosen->format, metadata);
        result_.ways[0].diskBytes += plainBytes;
        result_.ways[0].memoryBytes += plainBytes;
        result_.ways[1].diskBytes += blockBytes;
        result_.ways[1].memoryBytes += blockBytes;
        result_.ways[2].memoryBytes += blockBytes;
    }

    bool HasEncoder(bc::BlockFormat format) const {
        return gpu_ ? gpu_->HasShader(format, options_.effort) : tool::HasBlockEncoder(format);
    }

    void LoadAll(StageTimes& times) {
        const std::size_t batch = gpu_ ? static_cast<std::size_t>(options_.batch) : 1;
        for (std::size_t first = 0; first < options_.sets.size(); first += batch) {
            tool::ThrowIfInterrupted();
            const std::size_t last = std::min(first + batch, options_.sets.size());
            std::vector<ParsedSet> sets;
            for (std::size_t i = first; i < last; ++i)
                sets.push_back(ParseSet(options_.sets[i], times));
            if (gpu_)
                LoadOnGpu(sets, times);
            else
                for (ParsedSet& set : sets)
                    LoadOnCpu(set, times);
        }
    }

    /// A set in memory, ready to be decoded.
    struct ParsedSet {
        std::string path;
        TextureSetMetadata metadata;
        tool::DecodeData data;
        std::optional<LatentWork> compressed;  // latents for the GPU to decompress
        std::unique_ptr<tool::HintFile> hints; // or null
    };

    bool HasHints(const std::string& path) const {
        std::error_code ignored;
        return !options_.noHints && !options_.setModes && fs::exists(tool::GetHintPath(path), ignored);
    }

    ParsedSet ParseSet(const std::string& path, StageTimes& times) {
        // Read as a whole, then taken apart: what is timed as reading is the file system's alone.
        const FileBytes file = Time(times.read, [&] { return FileBytes(path); });
        ParsedSet set = Time(times.parse, [&]() -> ParsedSet {
            ReadOnlyMemoryStream stream(file.AsSpan());
            TextureSetMetadata metadata = Require(TextureSetMetadata::Load(stream), ExitCode::BadInput, path);
            std::optional<LatentWork> compressed = ReadLatentWork(metadata, stream, path);
            tool::DecodeData data = compressed ? tool::PrepareDecodeData(metadata, path)
                                               : tool::LoadDecodeData(metadata, stream, path);
            std::unique_ptr<tool::HintFile> hints;
            if (options_.setModes)
                hints = std::make_unique<tool::HintFile>(metadata, stream, path, DecodeMath::Int8);
            else if (HasHints(path))
                hints = std::make_unique<tool::HintFile>(tool::GetHintPath(path),
                                                         tool::IdentifyFile(file.AsSpan()), metadata);
            return {path, std::move(metadata), std::move(data), std::move(compressed), std::move(hints)};
        });
        if (set.compressed)
            result_.decompressor = GetName(options_.decompressor);
        if (set.compressed && options_.decompressor == Decompressor::Cpu) {
            Time(times.decompress,
                 [&] { set.data.latents = DecompressOnCpu(*set.compressed, team_, set.path); });
            set.compressed.reset();
        }
        return set;
    }

    void LoadOnGpu(const std::vector<ParsedSet>& sets, StageTimes& times) {
        std::vector<GpuSet> work;
        for (const ParsedSet& set : sets) {
            GpuSet& item = work.emplace_back();
            item.metadata = &set.metadata;
            item.data = &set.data;
            item.compressed = set.compressed ? &*set.compressed : nullptr;
            const std::span<const Texture> textures = set.metadata.GetTextures();
            for (std::size_t i = 0; i < textures.size(); ++i) {
                item.textures.push_back(&textures[i]);
                item.formats.push_back(tool::ChooseFormat(textures[i], options_.blocks, false)->format);
                item.hints.push_back(ChooseHints(set.hints.get(), set.metadata, i, item.formats.back()));
            }
        }
        const GpuTimes taken = gpu_->Load(work, options_.effort);
        times.upload += taken.upload;
        times.decompress += taken.decompress;
        times.decode += taken.decode;
        times.transcode += taken.transcode;
        result_.device = gpu_->GetDeviceName();
        if (!isWarm_)
            for (const std::vector<std::byte>& blocks : gpu_->ReadBlocks())
                crc_ = Crc32(blocks, crc_);
    }

    void LoadOnCpu(const ParsedSet& set, StageTimes& times) {
        std::unique_ptr<tool::Decoder> decoder =
            Time(times.decode, [&] { return tool::RequireDecoder(set.path, set.data, options_.backend); });
        result_.device = tool::GetCpuName();
        std::vector<TextureWork> work;
        std::deque<tool::TextureHints> hints;
        const std::span<const Texture> textures = set.metadata.GetTextures();
        for (std::size_t i = 0; i < textures.size(); ++i) {
            const auto format = tool::ChooseFormat(textures[i], options_.blocks, false)->format;
            hints.push_back(ChooseHints(set.hints.get(), set.metadata, i, format));
            work.push_back({format, {set.metadata, textures[i], format}, &hints.back(), {}});
        }
        for (int mip = 0; mip < set.metadata.GetDesc().mips; ++mip) {
            LoadMip(*decoder, set.metadata, mip, work, times);
            if (!isWarm_)
                for (const TextureWork& texture : work)
                    crc_ = Crc32(texture.blocks, crc_);
        }
    }

    void LoadMip(tool::Decoder& decoder, const TextureSetMetadata& metadata, int mip,
                 std::vector<TextureWork>& work, StageTimes& times) {
        for (TextureWork& texture : work)
            texture.blocks.clear();
        const ColorMip& size = metadata.GetColorMips()[static_cast<std::size_t>(mip)];
        constexpr int kTexelsPerBand = 1 << 17;
        const int bandRows = std::max(4, kTexelsPerBand / size.width / 4 * 4); // whole blocks
        for (int top = 0; top < size.height; top += bandRows) {
            tool::ThrowIfInterrupted();
            const int rows = std::min(bandRows, size.height - top);
            outputs_.resize(static_cast<std::size_t>(size.width) * 16 * static_cast<std::size_t>(rows));
            Time(times.decode, [&] {
                Require(decoder.Decode(mip, {0, top, size.width, rows}, {}, outputs_), ExitCode::Failed,
                        "decoding");
            });
            for (TextureWork& texture : work) {
                texels_.clear();
                Time(times.decode, [&] { texture.converter.Append(outputs_, texels_); });
                if (!texture.format.block)
                    continue;
                const tool::TexelRows band{texels_, static_cast<std::uint32_t>(size.width),
                                           static_cast<std::uint32_t>(rows)};
                Time(times.transcode, [&] {
                    const auto mipBlocks = bc::CountBlocks(band.width);
                    texture.hints->Get(
                        static_cast<std::uint32_t>(mip),
                        {0, static_cast<std::uint32_t>(top) / 4, mipBlocks, bc::CountBlocks(band.height)},
                        hints_);
                    tool::EncodeTexelBlocks(texture.format, options_.effort, band, options_.backend.threads,
                                            "transcoding", blocks_, hints_);
                    texture.blocks.insert(texture.blocks.end(), blocks_.begin(), blocks_.end());
                });
            }
        }
    }

    /// Median of reading a file of as many bytes.
    double TimeReading(std::uint64_t bytes) const {
        std::random_device random;
        const fs::path path =
            fs::temp_directory_path() / ("openntc-load-" + std::to_string(random()) + ".bin");
        struct Remover {
            const fs::path& path;
            ~Remover() {
                std::error_code ignored;
                fs::remove(path, ignored);
            }
        } remover{path};
        tool::WriteBytes(path, std::vector<std::byte>(static_cast<std::size_t>(bytes), std::byte{0x5A}));
        std::vector<double> runs;
        for (int run = 0; run < options_.repeat; ++run) {
            tool::ThrowIfInterrupted();
            double milliseconds = 0.0;
            Time(milliseconds, [&] { return FileBytes(path.string()); });
            runs.push_back(milliseconds);
        }
        return Median(std::move(runs));
    }

    const LoadOptions& options_;
    ThreadTeam team_;
    std::unique_ptr<GpuLoader> gpu_; // or the CPU
    LoadTimes result_;
    std::uint32_t crc_ = 0;
    bool isWarm_ = false;
    std::vector<float> outputs_;
    std::vector<std::byte> texels_, blocks_;
    std::vector<std::int32_t> hints_;
};

} // namespace

LoadTimes MeasureLoading(const LoadOptions& options) {
    return Loading(options).Run();
}

} // namespace openntc::load_time
