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
#include "textures/HintMaps.h"
#include "textures/SetModes.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
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
    bool inSet = false;
    bool compress = false;
    bool json = false;
    std::optional<DecodeMath> math;
    BackendOptions backend;
};

class OptimizeCommand {
public:
    explicit OptimizeCommand(const OptimizeOptions& options)
        : options_(options), path_(GetOutput(options)), set_(LoadTextureSet(options.file)),
          math_(ChooseMath(set_, options.math,
                           [&](const std::string& text) { PrintWarning(text, options.json); })),
          maker_(set_.metadata, options.effort, options.backend.threads, options.file) {
        if (options.inSet && set_.metadata.GetGeneration() != 3)
            throw CommandError(ExitCode::BadInput, options.file,
                               Format("--in-set: a set of generation %d: 3 keeps modes of blocks",
                                      set_.metadata.GetGeneration()));
    }

    int Run() {
        const auto start = std::chrono::steady_clock::now();
        ChooseTextures();
        const DecodeData data = LoadDecodeData(set_, math_);
        const std::unique_ptr<Decoder> decoder = RequireDecoder(options_.file, data, options_.backend);
        {
            Progress progress("optimize-bc", maker_.GetTexels(), options_.json);
            maker_.Run(*decoder, math_, [&](std::uint64_t texels) { progress.Advance(texels); });
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
    static std::string GetOutput(const OptimizeOptions& options) {
        if (options.output.empty() && options.inSet)
            FailUsage("--in-set", "writes another file: name it with -o");
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
            maker_.AddTexture(i, chosen->format);
        }
        if (maker_.GetTextures().empty())
            throw CommandError(ExitCode::Failed, options_.file,
                               options_.blocks.isAuto
                                   ? "textures: none is declared to be BC7: --bc bc7 takes all"
                                   : "textures: none that BC7 holds");
    }

    std::vector<std::byte> MakeFile() {
        const std::vector<bc::BlockHintMap> maps = maker_.GetMaps();
        if (options_.inSet) {
            std::vector<std::byte> set =
                PutModes(set_.metadata, set_.input.GetStream(), maps, options_.compress, options_.file);
            hintBytes_ = CountModeBytes(set);
            return set;
        }
        std::vector<std::byte> bytes(static_cast<std::size_t>(bc::GetBlockHintFileBytes(maps)));
        Require(bc::WriteBlockHintFile(maps, IdentifyFile(set_.input), bytes), ExitCode::Failed, path_);
        hintBytes_ = bytes.size();
        return bytes;
    }

    std::uint64_t CountModeBytes(std::span<const std::byte> file) const {
        ReadOnlyMemoryStream stream(file);
        const TextureSetMetadata set = Require(TextureSetMetadata::Load(stream), ExitCode::Failed, path_);
        std::uint64_t bytes = 0;
        for (const Texture& texture : set.GetTextures()) {
            for (const BlockModeBuffer& modes : texture.blockModes)
                bytes += modes.data.range.size;
        }
        return bytes;
    }

    void Print(std::size_t bytes, double seconds) const {
        HintStatistics all;
        for (const HintMapMaker::TextureWork& work : maker_.GetTextures())
            all += work.gatherer.GetStatistics();
        if (options_.json) {
            PrintJson(all, bytes, seconds);
            return;
        }
        for (const HintMapMaker::TextureWork& work : maker_.GetTextures()) {
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
                    Format(", hints %.2f bits a texel, %zu textures, %zu maps, made in %.2f s\n",
                           static_cast<double>(hintBytes_) * 8.0 / static_cast<double>(all.texels),
                           maker_.GetTextures().size(), maker_.GetMaps().size(), seconds));
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
        json.Member("maps", static_cast<std::uint64_t>(maker_.GetMaps().size()));
        json.Member("seconds", seconds);
        json.Member("quality", GetName(options_.effort));
        json.Member("math", GetName(math_, options_.backend));
        json.Key("textures");
        json.BeginArray();
        for (const HintMapMaker::TextureWork& work : maker_.GetTextures()) {
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
    DecodeMath math_;
    HintMapMaker maker_;
    std::uint64_t hintBytes_ = 0; ///< in the file that is written
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
    CLI::Option* const linear = command->add_flag("--linear", options->linear, "For ntc decode --linear");
    CLI::Option* const inSet = command->add_flag("--in-set", options->inSet,
                                                 "Write a copy of FILE, of generation 3, that keeps them "
                                                 "where LibNTC 0.9 looks for them (-o NAME.ntc)");
    inSet->excludes(linear);
    command->add_flag("--compress", options->compress, "With --in-set: by GDeflate where that is smaller")
        ->needs(inSet);
    command
        ->add_option("--quality", options->quality, "Search for good blocks: fast, normal or best (default)")
        ->type_name("LEVEL");
    command
        ->add_option("--bc", options->bc,
                     "auto (default: textures that the file declares to be BC7) or bc7 (all that it holds)")
        ->type_name("BLOCKS");
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
