// SPDX-License-Identifier: MIT
// `ntc optimize-bc`: hints for the BC7 blocks that are made of a texture set when it is loaded.
#include "Arguments.h"
#include "Commands.h"
#include "Failure.h"
#include "InputFile.h"
#include "Interrupt.h"
#include "Json.h"
#include "Output.h"
#include "OutputFolder.h"
#include "Progress.h"
#include "TextureSizes.h"
#include "textures/HintFile.h"
#include "textures/HintGatherer.h"
#include "textures/TexelConverter.h"

#include <algorithm>
#include <chrono>
#include <deque>
#include <memory>
#include <vector>

namespace openntc::tool {

namespace {

struct OptimizeOptions {
    std::string file;
    std::string output; // empty: beside the file
    std::string bc;     // as given
    std::string quality;
    BlockEffort effort = BlockEffort::Best;
    BlockChoice blocks;
    bool linear = false;
    bool json = false;
    DecodeMath math = DecodeMath::Int8;
    BackendOptions backend;
};

class OptimizeCommand {
public:
    explicit OptimizeCommand(const OptimizeOptions& options)
        : options_(options), path_(GetOutput(options)), set_(LoadTextureSet(options.file)) {}

    int Run() {
        const auto start = std::chrono::steady_clock::now();
        ChooseTextures();
        const DecodeData data = LoadDecodeData(set_, options_.math);
        const std::unique_ptr<Decoder> decoder = RequireDecoder(options_.file, data, options_.backend);
        {
            std::uint64_t texels = 0;
            for (const ColorMip& mip : set_.metadata.GetColorMips())
                texels += static_cast<std::uint64_t>(mip.width) * static_cast<std::uint64_t>(mip.height);
            Progress progress("optimize-bc", texels * work_.size(), options_.json);
            for (int mip = 0; mip < set_.metadata.GetDesc().mips; ++mip)
                GatherMip(*decoder, mip, progress);
        }
        const std::vector<std::byte> bytes = MakeFile();
        ThrowIfInterrupted();
        WriteBytes(path_, bytes);
        const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
        Print(bytes.size(), taken.count());
        FinishOutput();
        return 0;
    }

private:
    struct TextureWork {
        std::size_t index;
        const Texture* texture;
        TextureFormat format;
        TexelConverter converter;
        HintGatherer gatherer;
    };
    struct Map {
        bc::BlockHintMap map;
        std::vector<std::byte> packed;
    };

    static std::string GetOutput(const OptimizeOptions& options) {
        if (options.output.empty() && IsPipe(options.file))
            FailUsage("--output", "a pipe has no file beside it: name one");
        std::string path = options.output.empty() ? GetHintPath(options.file) : options.output;
        RefuseInputAsOutput("--output", path, std::span(&options.file, 1));
        return path;
    }

    void ChooseTextures() {
        const std::span<const Texture> textures = set_.metadata.GetTextures();
        for (std::size_t i = 0; i < textures.size(); ++i) {
            const Texture& texture = textures[i];
            if (options_.blocks.isAuto && texture.bcFormat != BlockCompressedFormat::BC7)
                continue;
            const std::optional<ChosenFormat> chosen =
                ChooseFormat(texture, {false, bc::BlockFormat::Bc7}, options_.linear);
            const std::string name(texture.name);
            if (!chosen) {
                PrintWarning(options_.file + ": " + name + ": no hints: " + GetName(texture.channelFormat) +
                                 Format(" x %d: BC7 does not hold it", texture.numChannels),
                             options_.json);
                continue;
            }
            work_.push_back({i, &texture, chosen->format,
                             TexelConverter(set_.metadata, texture, chosen->format),
                             HintGatherer(chosen->format, texture.numChannels, options_.effort,
                                          options_.backend.threads, options_.file)});
        }
        if (work_.empty())
            throw CommandError(ExitCode::Failed, options_.file,
                               options_.blocks.isAuto
                                   ? "textures: none is declared to be BC7: --bc bc7 takes all"
                                   : "textures: none that BC7 holds");
    }

    void GatherMip(Decoder& decoder, int mip, Progress& progress) {
        const ColorMip& size = set_.metadata.GetColorMips()[static_cast<std::size_t>(mip)];
        // So few that an interrupt does not wait long for the search.
        constexpr int kTexelsPerBand = 1 << 16;
        const int bandRows = std::max(4, kTexelsPerBand / size.width / 4 * 4); // whole blocks
        DecodeOptions stored;
        stored.math = options_.math; // each texture converts to its own colour space
        for (int top = 0; top < size.height; top += bandRows) {
            const int rows = std::min(bandRows, size.height - top);
            outputs_.resize(static_cast<std::size_t>(size.width) * 16 * static_cast<std::size_t>(rows));
            Require(decoder.Decode(mip, {0, top, size.width, rows}, stored, outputs_), ExitCode::Failed,
                    options_.file);
            for (TextureWork& work : work_) {
                texels_.clear();
                work.converter.Append(outputs_, texels_);
                work.gatherer.AddRows(
                    {texels_, static_cast<std::uint32_t>(size.width), static_cast<std::uint32_t>(rows)});
                progress.Advance(static_cast<std::uint64_t>(size.width) * static_cast<std::uint64_t>(rows));
            }
        }
        for (TextureWork& work : work_) {
            Map& map = maps_.emplace_back();
            map.map.texture = static_cast<std::uint32_t>(work.index);
            map.map.mip = static_cast<std::uint32_t>(mip);
            map.map.width = bc::CountBlocks(static_cast<std::uint32_t>(size.width));
            map.map.height = bc::CountBlocks(static_cast<std::uint32_t>(size.height));
            map.map.texels = {work.gatherer.GetTexelCrc(), static_cast<std::uint8_t>(options_.math),
                              work.format.srgb, ToBlockQuality(options_.effort)};
            map.packed = work.gatherer.TakeMap();
            map.map.packed = map.packed;
        }
    }

    std::vector<std::byte> MakeFile() {
        // Texture by texture, so that a loader finds what belongs together.
        std::stable_sort(maps_.begin(), maps_.end(),
                         [](const Map& a, const Map& b) { return a.map.texture < b.map.texture; });
        std::vector<bc::BlockHintMap> maps;
        for (const Map& map : maps_)
            maps.push_back(map.map);
        std::vector<std::byte> bytes(static_cast<std::size_t>(bc::GetBlockHintFileBytes(maps)));
        Require(bc::WriteBlockHintFile(maps, IdentifyFile(set_.input), bytes), ExitCode::Failed, path_);
        return bytes;
    }

    void Print(std::size_t bytes, double seconds) const {
        HintStatistics all;
        for (const TextureWork& work : work_)
            all += work.gatherer.GetStatistics();
        if (options_.json) {
            PrintJson(all, bytes, seconds);
            return;
        }
        for (const TextureWork& work : work_) {
            const HintStatistics& one = work.gatherer.GetStatistics();
            std::string modes;
            for (std::size_t mode = 0; mode < one.modes.size(); ++mode)
                modes += Format(" %.0f", 100.0 * static_cast<double>(one.modes[mode]) /
                                             static_cast<double>(one.blocks));
            WriteOutput(Printable(work.texture->name) +
                        Format(": %llu blocks, %.2f dB, %% of modes 0 to 7:",
                               static_cast<unsigned long long>(one.blocks), one.search.GetPsnr()) +
                        modes + "\n");
        }
        WriteOutput(Printable(path_) + ": " + FormatBytes(bytes) +
                    Format(", %.2f bits a texel, %zu textures, %zu maps, made in %.2f s\n",
                           static_cast<double>(bytes) * 8.0 / static_cast<double>(all.texels), work_.size(),
                           maps_.size(), seconds));
        WriteOutput(
            Format("blocks of %s with hints: %.2f dB in %.3f s, %.1f times as fast as the search (%.3f s) ",
                   GetName(options_.effort), all.hinted.GetPsnr(), all.hinted.seconds,
                   all.search.seconds / std::max(all.hinted.seconds, 1e-9), all.search.seconds) +
            (all.different == 0
                 ? "and the same; "
                 : Format("but %llu differ; ", static_cast<unsigned long long>(all.different))) +
            Format("a search of fast: %.2f dB in %.3f s\n", all.fast.GetPsnr(), all.fast.seconds));
    }

    static void WriteStatistics(JsonWriter& json, const HintStatistics& one) {
        json.Member("texels", one.texels);
        json.Member("blocks", one.blocks);
        json.Key("modes");
        json.BeginArray();
        for (const std::uint64_t blocks : one.modes)
            json.Value(blocks);
        json.EndArray();
        json.Member("differentBlocks", one.different);
        const auto write = [&](const char* name, const HintTrial& trial) {
            json.Key(name);
            json.BeginObject();
            json.Member("psnr", trial.GetPsnr());
            json.Member("seconds", trial.seconds);
            json.EndObject();
        };
        write("search", one.search);
        write("hinted", one.hinted);
        write("fastSearch", one.fast);
    }

    void PrintJson(const HintStatistics& all, std::size_t bytes, double seconds) const {
        JsonWriter json;
        json.BeginObject();
        json.Member("file", std::string_view(options_.file));
        json.Member("output", std::string_view(path_));
        json.Member("bytes", static_cast<std::uint64_t>(bytes));
        json.Member("maps", static_cast<std::uint64_t>(maps_.size()));
        json.Member("seconds", seconds);
        json.Member("quality", GetName(options_.effort));
        json.Member("math", GetName(options_.math, options_.backend));
        json.Key("textures");
        json.BeginArray();
        for (const TextureWork& work : work_) {
            json.BeginObject();
            json.Member("texture", work.texture->name);
            json.Member("srgb", work.format.srgb);
            WriteStatistics(json, work.gatherer.GetStatistics());
            json.EndObject();
        }
        json.EndArray();
        json.Key("all");
        json.BeginObject();
        WriteStatistics(json, all);
        json.EndObject();
        json.EndObject();
        WriteOutput(json.Take());
    }

    const OptimizeOptions& options_;
    std::string path_;
    TextureSet set_;
    std::deque<TextureWork> work_;
    std::deque<Map> maps_;
    std::vector<float> outputs_;
    std::vector<std::byte> texels_;
};

} // namespace

void AddOptimizeBcCommand(CLI::App& app, Action& action) {
    auto options = std::make_shared<OptimizeOptions>();
    CLI::App* command = app.add_subcommand(
        "optimize-bc", "Find out how BC7 blocks are coded best, so that loading need not search");
    AddFileArgument(*command, options->file);
    command->add_option("-o,--output", options->output, "File of hints (default: NAME.bcmodes beside FILE)")
        ->check(GetOutputNameCheck())
        ->type_name("NAME.bcmodes");
    command
        ->add_option("--quality", options->quality, "Search for good blocks: fast, normal or best (default)")
        ->type_name("LEVEL");
    command
        ->add_option("--bc", options->bc,
                     "auto (default: textures that the file declares to be BC7) or bc7 (all that it holds)")
        ->type_name("BLOCKS");
    command->add_flag("--linear", options->linear, "For ntc decode --linear");
    AddMathOption(*command, options->math, &options->backend);
    AddBackendOptions(*command, options->backend);
    AddNumberOption(*command, "--threads", options->backend.threads, {0, 1024}, "Threads (default 0: all)");
    AddJsonFlag(*command, options->json);
    command->callback([options, &action] {
        options->effort = SelectEffort(options->quality, BlockEffort::Best);
        if (options->bc == "bc7")
            options->blocks = {false, bc::BlockFormat::Bc7};
        else if (!options->bc.empty() && options->bc != "auto")
            FailUsage("--bc", options->bc + ": auto or bc7");
        action = [options] { return OptimizeCommand(*options).Run(); };
    });
}

} // namespace openntc::tool
