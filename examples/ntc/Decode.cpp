// SPDX-License-Identifier: MIT
// `ntc decode`: textures to PNG, OpenEXR, TGA, DDS and KTX2 files.
#include "Arguments.h"
#include "Commands.h"
#include "DecodePlan.h"
#include "Exr.h"
#include "Failure.h"
#include "InputFile.h"
#include "Interrupt.h"
#include "Json.h"
#include "Output.h"
#include "OutputFolder.h"
#include "Progress.h"

#include <algorithm>
#include <memory>
#include <vector>

namespace openntc::tool {

namespace {

struct DecodeCommandOptions {
    std::string file;
    std::string folder;
    bool json = false;
    std::string bc, quality; // as given
    std::string hints;       // a file; empty: the one beside the set, if there is one
    bool noHints = false;
    bool setModes = false;
    DecodePlanOptions plan;
    BackendOptions backend;
    std::optional<DecodeMath> math;
};

class DecodeCommand {
public:
    explicit DecodeCommand(const DecodeCommandOptions& options)
        : options_(options), set_(LoadTextureSet(options.file)),
          math_(ChooseMath(set_, options.math,
                           [&](const std::string& text) { PrintWarning(text, options.json); })),
          plan_(set_.metadata, options.plan, options.file) {
        UseHints();
    }

    int Run() {
        const DecodeData data = LoadDecodeData(set_, math_);
        const std::unique_ptr<Decoder> decoder = RequireDecoder(options_.file, data, options_.backend);
        for (const std::string& warning : plan_.GetWarnings())
            PrintWarning(warning, options_.json);

        OutputFolder folder(options_.folder);
        std::vector<std::unique_ptr<ImageSink>> sinks;
        for (const PlannedFile& file : plan_.GetFiles()) {
            const std::string subject = (std::filesystem::path(options_.folder) / file.name).string();
            sinks.push_back(plan_.MakeSink(file, {folder.Stage(file.name), subject}));
        }
        Progress progress("decode", plan_.CountTexels(), options_.json);
        for (int mip = plan_.GetMips() - 1; mip >= 0; --mip)
            DecodeMip(*decoder, mip, sinks, progress);
        ThrowIfInterrupted();
        std::vector<std::uint64_t> bytes;
        for (std::size_t i = 0; i < sinks.size(); ++i)
            bytes.push_back(plan_.GetFiles()[i].mip ? 0 : sinks[i]->Finish());
        sinks.clear();
        PrintFiles(folder.Commit(), bytes);
        FinishOutput();
        if (!plan_.DescribeUnwritten().empty())
            throw CommandError(ExitCode::Failed, options_.file, plan_.DescribeUnwritten());
        return 0;
    }

private:
    void UseHints() {
        if (options_.setModes && !plan_.HasBc7())
            PrintWarning(options_.file + ": --set-modes: no texture is written as BC7: no modes used",
                         options_.json);
        if (options_.noHints || !plan_.HasBc7())
            return;
        if (options_.setModes) {
            hints_.emplace(set_.metadata, set_.input.GetStream(), options_.file, math_);
            plan_.UseHints(*hints_, math_);
            return;
        }
        std::string path = options_.hints;
        if (path.empty()) {
            path = GetHintPath(options_.file);
            std::error_code ignored;
            if (IsPipe(options_.file) || !std::filesystem::exists(path, ignored))
                return;
        }
        hints_.emplace(path, IdentifyFile(set_.input), set_.metadata);
        plan_.UseHints(*hints_, math_);
    }

    void DecodeMip(Decoder& decoder, int mip, std::span<const std::unique_ptr<ImageSink>> sinks,
                   Progress& progress) {
        const Rect rect = plan_.GetRect(mip);
        std::vector<ImageSink*> takers;
        std::vector<ImageSink*> done;
        for (std::size_t i = 0; i < sinks.size(); ++i) {
            const std::optional<int> own = plan_.GetFiles()[i].mip;
            if (own.value_or(mip) != mip)
                continue;
            takers.push_back(sinks[i].get());
            if (own)
                done.push_back(sinks[i].get());
        }
        for (ImageSink* sink : takers)
            sink->BeginLevel(static_cast<std::uint32_t>(mip), rect.width, rect.height);

        constexpr int kTexelsPerBand = 1 << 17;
        const int bandRows = std::max(4, kTexelsPerBand / rect.width / 4 * 4); // whole blocks
        std::vector<float> outputs;
        DecodeOptions stored;
        stored.math = math_; // each texture converts to its own colour space
        for (int top = 0; top < rect.height; top += bandRows) {
            ThrowIfInterrupted();
            const int rows = std::min(bandRows, rect.height - top);
            outputs.resize(static_cast<std::size_t>(rect.width) * 16 * static_cast<std::size_t>(rows));
            const Rect band{rect.left, rect.top + top, rect.width, rows};
            Require(decoder.Decode(mip, band, stored, outputs), ExitCode::Failed, options_.file);
            for (ImageSink* sink : takers) {
                ThrowIfInterrupted(); // searching for the best blocks takes longer than decoding
                sink->WriteRows(outputs);
            }
            progress.Advance(static_cast<std::uint64_t>(rect.width) * static_cast<std::uint64_t>(rows));
        }
        for (ImageSink* sink : takers)
            sink->EndLevel();
        for (ImageSink* sink : done)
            sink->Finish(); // ends what it holds open
    }

    void PrintFiles(const std::vector<std::filesystem::path>& paths,
                    std::span<const std::uint64_t> bytes) const {
        const std::vector<PlannedFile>& files = plan_.GetFiles();
        if (!options_.json) {
            for (std::size_t i = 0; i < paths.size(); ++i) {
                const Rect rect = plan_.GetRect(files[i].mip.value_or(0));
                std::string line =
                    Format("%s %d x %d", Printable(paths[i].string()).c_str(), rect.width, rect.height);
                if (!files[i].mip)
                    line += Format(" %s%s, %d mips", GetName(*files[i].format).c_str(),
                                   files[i].format->srgb ? " sRGB" : "", plan_.GetMips());
                if (files[i].hints != nullptr)
                    line += ", with hints of " + Printable(hints_->GetPath());
                WriteOutput(line + "\n");
            }
            return;
        }
        JsonWriter json;
        json.BeginObject();
        json.Member("folder", std::string_view(options_.folder));
        json.Member("backend", GetName(options_.backend.backend));
        json.Member("math", GetName(math_, options_.backend));
        json.Member("linear", options_.plan.linear);
        if (plan_.IsContainer())
            json.Member("quality", GetName(options_.plan.effort));
        if (hints_)
            json.Member("hints", std::string_view(hints_->GetPath()));
        json.Key("files");
        json.BeginArray();
        for (std::size_t i = 0; i < paths.size(); ++i) {
            const Rect rect = plan_.GetRect(files[i].mip.value_or(0));
            json.BeginObject();
            json.Member("path", std::string_view(paths[i].string()));
            json.Member("texture", files[i].texture->name);
            json.Member("mip", files[i].mip.value_or(0));
            json.Member("width", rect.width);
            json.Member("height", rect.height);
            if (!files[i].mip) {
                json.Member("mips", plan_.GetMips());
                json.Member("format", std::string_view(GetName(*files[i].format)));
                json.Member("srgb", files[i].format->srgb);
                json.Member("vulkanFormat", GetVulkanFormat(*files[i].format));
                json.Member("bytes", bytes[i]);
                if (hints_)
                    json.Member("hinted", files[i].hints != nullptr);
            }
            json.EndObject();
        }
        json.EndArray();
        json.EndObject();
        WriteOutput(json.Take());
    }

    const DecodeCommandOptions& options_;
    TextureSet set_;
    DecodeMath math_;
    std::optional<HintFile> hints_; // the plan refers to its maps
    DecodePlan plan_;
};

ImageFormat SelectFormat(const std::string& format) {
    static constexpr std::pair<const char*, ImageFormat> kFormats[] = {
        {"auto", ImageFormat::Auto}, {"png", ImageFormat::Png}, {"exr", ImageFormat::Exr},
        {"tga", ImageFormat::Tga},   {"dds", ImageFormat::Dds}, {"ktx2", ImageFormat::Ktx2}};
    for (const auto& [name, value] : kFormats) {
        if (format == name)
            return value;
    }
    FailUsage("--format", format + ": auto, png, exr, tga, dds or ktx2");
}

BlockChoice SelectBlocks(const std::string& name) {
    if (name.empty() || name == "auto")
        return {};
    const std::optional<bc::BlockFormat> block = FindBlockFormat(name);
    if (!block && name != "none")
        FailUsage("--bc", name + ": auto, none, bc1, bc2, bc3, bc4, bc4s, bc5, bc5s, bc6, bc6s or bc7");
    return {false, block};
}

// What depends on several options.
void CheckOptions(DecodeCommandOptions& options) {
    const ImageFormat format = options.plan.format;
    const bool isContainer = format == ImageFormat::Dds || format == ImageFormat::Ktx2;
    options.plan.blocks = SelectBlocks(options.bc);
    options.plan.effort = SelectEffort(options.quality, BlockEffort::Normal);
    const char* needsContainer = !options.bc.empty()        ? "--bc"
                                 : !options.quality.empty() ? "--quality"
                                 : options.plan.pad         ? "--pad"
                                 : !options.hints.empty()   ? "--hints"
                                 : options.noHints          ? "--no-hints"
                                 : options.setModes         ? "--set-modes"
                                                            : nullptr;
    if (!isContainer && needsContainer != nullptr)
        FailUsage(needsContainer, "blocks: only --format dds and ktx2 hold them");
    if (format != ImageFormat::Ktx2 && options.plan.zstdLevel != 0)
        FailUsage("--zstd", "Zstandard: only --format ktx2 has it");
    if (format == ImageFormat::Exr && !IsExrAvailable())
        throw CommandError(ExitCode::NoDevice, "--format", "exr: this build has no tinyexr");
    if (options.plan.zstdLevel != 0 && !IsZstdAvailable())
        throw CommandError(ExitCode::NoDevice, "--zstd", "Zstandard: this build has no libzstd");
}

} // namespace

void AddDecodeCommand(CLI::App& app, Action& action) {
    auto options = std::make_shared<DecodeCommandOptions>();
    CLI::App* command = app.add_subcommand(
        "decode", "Decode textures to image files, or to DDS and KTX2 with block compression");
    AddFileArgument(*command, options->file);
    command->add_option("-o,--output", options->folder, "Folder for the images; made if it does not exist")
        ->required()
        ->check(GetOutputNameCheck())
        ->type_name("DIR");
    command->add_flag("--mips", options->plan.mips,
                      "Also write the other mips: DIR/mips/NAME.LL.png; DDS and KTX2 always hold all");
    command->add_flag("--linear", options->plan.linear, "Write linear colour, whatever the texture declares");
    command
        ->add_option_function<std::string>(
            "--format", [options](const std::string& format) { options->plan.format = SelectFormat(format); },
            "auto (default: OpenEXR for textures of floats, else PNG), png, exr (linear light), tga, dds or "
            "ktx2")
        ->type_name("FORMAT");
    command
        ->add_option(
            "--bc", options->bc,
            "Blocks in DDS and KTX2: auto (default: as the file says, texture by texture), none, bc1 "
            "... bc7, or signed: bc4s, bc5s, bc6s")
        ->type_name("BLOCKS");
    command
        ->add_option("--quality", options->quality, "Search for good blocks: fast, normal (default) or best")
        ->type_name("LEVEL");
    CLI::Option* hints =
        command
            ->add_option("--hints", options->hints,
                         "Hints of ntc optimize-bc for BC7 (default: NAME.bcmodes beside FILE, if it exists)")
            ->type_name("HINTS");
    CLI::Option* noHints =
        command->add_flag("--no-hints", options->noHints, "Search, even where there are hints")
            ->excludes(hints);
    command
        ->add_flag(
            "--set-modes", options->setModes,
            "BC7: instead of hints and searches the modes that a set of generation 3 keeps; only as good "
            "as this decode is the one that they come from")
        ->excludes(hints)
        ->excludes(noHints);
    command->add_flag("--pad", options->plan.pad,
                      "Repeat edges until both sides are multiples of 4, which Direct3D wants of blocks");
    AddNumberOption(*command, "--zstd", options->plan.zstdLevel, {1, 22},
                    "KTX2: compress every level with Zstandard");
    command
        ->add_option_function<std::string>(
            "--rect", [options](const std::string& text) { options->plan.rect = ParseRect("--rect", text); },
            "Only this part of the first mip, in texels, and what lies at half the place in each next one")
        ->type_name("X,Y,W,H");
    AddMathOption(*command, options->math, &options->backend);
    AddBackendOptions(*command, options->backend);
    AddJsonFlag(*command, options->json);
    command->callback([options, &action] {
        CheckOptions(*options);
        action = [options] { return DecodeCommand(*options).Run(); };
    });
}

} // namespace openntc::tool
