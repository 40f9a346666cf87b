// SPDX-License-Identifier: MIT
// `ntc decode`: textures to PNG and OpenEXR files.
#include "Arguments.h"
#include "Commands.h"
#include "Exr.h"
#include "Failure.h"
#include "FileNames.h"
#include "Interrupt.h"
#include "Json.h"
#include "Output.h"
#include "OutputFolder.h"
#include "Png.h"
#include "Progress.h"
#include "TextureImage.h"

#include <algorithm>
#include <array>
#include <memory>
#include <optional>
#include <vector>

namespace openntc::tool {

namespace {

enum class FileFormat { Auto, Png, Exr };

struct DecodeCommandOptions {
    std::string file;
    std::string folder;
    bool mips = false;
    bool json = false;
    FileFormat format = FileFormat::Auto;
    BackendOptions backend;
    DecodeOptions decode; // convertToLinear here means --linear: every texture is written linear
};

/// One of the two, being written.
struct ImageWriter {
    std::optional<PngWriter> png;
    std::optional<ExrWriter> exr;

    void Finish() {
        if (png)
            png->Finish();
        else
            exr->Finish();
    }
};

struct WrittenFile {
    std::size_t texture;
    int mip;
    int width;
    int height;
};

class DecodeCommand {
public:
    explicit DecodeCommand(const DecodeCommandOptions& options)
        : options_(options), set_(LoadTextureSet(options.file)) {}

    int Run() {
        PlanImages();
        const DecodeData data = LoadDecodeData(set_, options_.decode.math);
        const std::unique_ptr<Decoder> decoder = RequireDecoder(options_.file, data, options_.backend);
        const int mips = options_.mips ? set_.metadata.GetDesc().mips : 1;
        CheckSizes();

        OutputFolder folder(options_.folder);
        Progress progress("decode", CountTexels(mips), options_.json);
        for (int mip = 0; mip < mips && !images_.empty(); ++mip)
            DecodeMip(*decoder, mip, folder, progress);
        ThrowIfInterrupted();
        const std::vector<std::filesystem::path> paths = folder.Commit();
        PrintFiles(paths);
        FinishOutput();
        if (!unwritten_.empty())
            throw CommandError(ExitCode::Failed, options_.file, DescribeUnwritten());
        return 0;
    }

private:
    void PlanImages() {
        FileNames names;
        for (const Texture& texture : set_.metadata.GetTextures()) {
            const std::string name = names.Add(texture.name);
            const bool isExr = options_.format == FileFormat::Exr ||
                               (options_.format == FileFormat::Auto && TextureImage::IsFloat(texture));
            if (isExr ? IsExrAvailable() : TextureImage::IsSupported(texture)) {
                images_.emplace_back(set_.metadata, texture, options_.decode.convertToLinear);
                names_.push_back(name);
                isExr_.push_back(isExr);
            } else {
                unwritten_ += (unwritten_.empty() ? "" : ", ") + name + " (" +
                              GetName(texture.channelFormat) + Format(" x %d)", texture.numChannels);
            }
        }
        if (images_.empty())
            throw CommandError(ExitCode::Failed, options_.file,
                               unwritten_.empty() ? "textures: none in the file: at least 1"
                                                  : DescribeUnwritten());
    }
    std::string DescribeUnwritten() const {
        return "textures not written: " + unwritten_ +
               (IsExrAvailable()
                    ? ": PNG holds 1 to 4 channels of UNORM8 or UNORM16: --format exr holds all"
                    : ": PNG holds 1 to 4 channels of UNORM8 or UNORM16, and this build writes no OpenEXR");
    }

    void CheckSizes() const {
        const TextureSetDesc& desc = set_.metadata.GetDesc();
        if (std::max(desc.width, desc.height) > kPngMaxSide)
            throw CommandError(ExitCode::Failed, options_.file,
                               Format("size: %d x %d: PNG output has at most %d texels a side", desc.width,
                                      desc.height, kPngMaxSide));
    }

    std::uint64_t CountTexels(int mips) const {
        std::uint64_t texels = 0;
        for (int mip = 0; mip < mips; ++mip) {
            const ColorMip& size = set_.metadata.GetColorMips()[static_cast<std::size_t>(mip)];
            texels += static_cast<std::uint64_t>(size.width) * static_cast<std::uint64_t>(size.height);
        }
        return texels;
    }

    void DecodeMip(Decoder& decoder, int mip, OutputFolder& folder, Progress& progress) {
        const ColorMip& size = set_.metadata.GetColorMips()[static_cast<std::size_t>(mip)];
        std::vector<ImageWriter> writers(images_.size());
        for (std::size_t i = 0; i < images_.size(); ++i) {
            const char* extension = isExr_[i] ? "exr" : "png";
            const std::string file = mip == 0 ? names_[i] + "." + extension
                                              : Format("mips/%s.%02d.%s", names_[i].c_str(), mip, extension);
            const std::string subject = (std::filesystem::path(options_.folder) / file).string();
            const TextureImage& image = images_[i];
            if (isExr_[i])
                writers[i].exr.emplace(
                    folder.Stage(file), subject,
                    ExrFormat{size.width, size.height, image.GetLinearSampleCount(), image.IsHalf()});
            else
                writers[i].png.emplace(folder.Stage(file), subject,
                                       image.GetPngFormat(size.width, size.height));
            files_.push_back({i, mip, size.width, size.height});
        }

        constexpr int kTexelsPerBand = 1 << 17;
        const int bandRows = std::max(1, kTexelsPerBand / size.width);
        std::vector<float> outputs;
        std::vector<std::uint16_t> row;
        std::vector<float> floats;
        DecodeOptions stored = options_.decode;
        stored.convertToLinear = false; // each texture converts to its own colour space
        for (int top = 0; top < size.height; top += bandRows) {
            ThrowIfInterrupted();
            const int rows = std::min(bandRows, size.height - top);
            const std::size_t rowFloats = static_cast<std::size_t>(size.width) * 16;
            outputs.resize(rowFloats * static_cast<std::size_t>(rows));
            Require(decoder.Decode(mip, {0, top, size.width, rows}, stored, outputs), ExitCode::Failed,
                    options_.file);
            for (int y = 0; y < rows; ++y) {
                const std::span<const float> texels =
                    std::span(outputs).subspan(rowFloats * static_cast<std::size_t>(y), rowFloats);
                for (std::size_t i = 0; i < images_.size(); ++i) {
                    if (isExr_[i]) {
                        images_[i].ConvertRowToLinear(texels, floats);
                        writers[i].exr->WriteRow(floats);
                    } else {
                        images_[i].ConvertRow(texels, row);
                        writers[i].png->WriteRow(row);
                    }
                }
            }
            progress.Advance(static_cast<std::uint64_t>(size.width) * static_cast<std::uint64_t>(rows));
        }
        for (ImageWriter& writer : writers)
            writer.Finish();
    }

    void PrintFiles(const std::vector<std::filesystem::path>& paths) const {
        if (!options_.json) {
            for (std::size_t i = 0; i < paths.size(); ++i)
                WriteOutput(Format("%s %d x %d\n", Printable(paths[i].string()).c_str(), files_[i].width,
                                   files_[i].height));
            return;
        }
        JsonWriter json;
        json.BeginObject();
        json.Member("folder", std::string_view(options_.folder));
        json.Member("backend", GetName(options_.backend.backend));
        json.Member("math", GetName(options_.decode.math));
        json.Member("linear", options_.decode.convertToLinear);
        json.Key("files");
        json.BeginArray();
        for (std::size_t i = 0; i < paths.size(); ++i) {
            json.BeginObject();
            json.Member("path", std::string_view(paths[i].string()));
            json.Member("texture", images_[files_[i].texture].GetName());
            json.Member("mip", files_[i].mip);
            json.Member("width", files_[i].width);
            json.Member("height", files_[i].height);
            json.EndObject();
        }
        json.EndArray();
        json.EndObject();
        WriteOutput(json.Take());
    }

    const DecodeCommandOptions& options_;
    TextureSet set_;
    std::vector<TextureImage> images_;
    std::vector<std::string> names_; // of images_, safe as file names
    std::vector<bool> isExr_;        // of images_
    std::string unwritten_;
    std::vector<WrittenFile> files_;
};

FileFormat SelectFormat(const std::string& format) {
    static constexpr std::array kLater = {"tga", "dds", "ktx2"};
    if (format == "auto")
        return FileFormat::Auto;
    if (format == "png")
        return FileFormat::Png;
    if (format == "exr" && !IsExrAvailable())
        throw CommandError(ExitCode::NoDevice, "--format", "exr: this build has no tinyexr");
    if (format == "exr")
        return FileFormat::Exr;
    const bool isLater = std::find(kLater.begin(), kLater.end(), format) != kLater.end();
    FailUsage("--format", format + (isLater ? ": not in this version" : "") + ": auto, png or exr");
}

} // namespace

void AddDecodeCommand(CLI::App& app, Action& action) {
    auto options = std::make_shared<DecodeCommandOptions>();
    CLI::App* command =
        app.add_subcommand("decode", "Decode textures to DIR/NAME.png, of floats to DIR/NAME.exr");
    AddFileArgument(*command, options->file);
    command->add_option("-o,--output", options->folder, "Folder for the images; made if it does not exist")
        ->required()
        ->check(GetOutputNameCheck())
        ->type_name("DIR");
    command->add_flag("--mips", options->mips, "Also write the other mips: DIR/mips/NAME.LL.png or .exr");
    command->add_flag("--linear", options->decode.convertToLinear,
                      "Write linear colour, whatever the texture declares");
    command
        ->add_option_function<std::string>(
            "--format", [options](const std::string& format) { options->format = SelectFormat(format); },
            "auto (default: OpenEXR for textures of floats, else PNG), png or exr (linear light)")
        ->type_name("FORMAT");
    AddMathOption(*command, options->decode.math);
    AddBackendOptions(*command, options->backend);
    AddLaterOption(*command, "--rect");
    AddJsonFlag(*command, options->json);
    command->callback([options, &action] { action = [options] { return DecodeCommand(*options).Run(); }; });
}

} // namespace openntc::tool
