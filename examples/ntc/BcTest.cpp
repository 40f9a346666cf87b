// SPDX-License-Identifier: MIT
// `ntc bc-test`: quality and speed of every block encoder on images.
#include "Arguments.h"
#include "Benchmark.h"
#include "Commands.h"
#include "Failure.h"
#include "Interrupt.h"
#include "Json.h"
#include "Output.h"
#include "Progress.h"
#include "encode/InputImage.h"
#include "textures/BcBaseline.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

namespace openntc::tool {

namespace {

constexpr std::array kEfforts = {BlockEffort::Fast, BlockEffort::Normal, BlockEffort::Best};

struct BcTestOptions {
    std::vector<std::string> files;
    std::vector<bc::BlockFormat> formats; // empty: those that suit each image
    std::vector<BlockEffort> efforts{kEfforts.begin(), kEfforts.end()};
    BlockRequest request;
    bool hints = false; ///< of BC7 each level also with the hints of the best one
    std::string baseline;
    BcLimits limits;
    bool csv = false;
    bool json = false;
};

class BcTest {
public:
    explicit BcTest(const BcTestOptions& options) : options_(options) {}

    int Run() {
        std::optional<BcBaseline> baseline; // read first: a bad file must not cost an hour
        if (!options_.baseline.empty())
            baseline.emplace(options_.baseline, options_.request.threads);
        Measure();
        AddPooled();
        std::vector<std::string> worse;
        if (baseline)
            worse = baseline->Compare(rows_, options_.limits);
        if (options_.json)
            PrintJson(worse);
        else
            PrintTable();
        FinishOutput();
        if (worse.empty())
            return 0;
        if (!options_.json)
            for (const std::string& line : worse)
                WriteOutput("worse: " + Printable(line) + "\n");
        FinishOutput();
        throw CommandError(ExitCode::Failed, options_.baseline,
                           Format("baseline: %zu results are worse", worse.size()));
    }

private:
    std::vector<bc::BlockFormat> GetFormats(const InputImage& image) const {
        return options_.formats.empty() ? ListBlockFormats(image) : options_.formats;
    }

    bool HasHints(bc::BlockFormat format) const { return options_.hints && format == bc::BlockFormat::Bc7; }

    std::size_t CountRuns(const std::vector<bc::BlockFormat>& formats) const {
        std::size_t runs = 0;
        for (const bc::BlockFormat format : formats)
            runs += options_.efforts.size() * (HasHints(format) ? 2 : 1);
        return runs;
    }

    void Measure() {
        // All images are read before the first is encoded, for the same reason.
        std::vector<InputImage> images;
        std::uint64_t work = 0;
        for (const std::string& file : options_.files) {
            ThrowIfInterrupted();
            images.push_back(ReadImage(file));
            const InputImage& image = images.back();
            if (GetFormats(image).empty())
                throw CommandError(ExitCode::Failed, file,
                                   "formats: this build has no encoder that suits it");
            work += static_cast<std::uint64_t>(image.width) * static_cast<std::uint64_t>(image.height) *
                    CountRuns(GetFormats(image)) * static_cast<std::uint64_t>(options_.request.repeat);
        }
        Progress progress("bc-test", work, options_.json);
        for (std::size_t i = 0; i < images.size(); ++i) {
            for (const bc::BlockFormat format : GetFormats(images[i])) {
                for (const BlockEffort effort : options_.efforts) {
                    for (int hinted = 0; hinted <= (HasHints(format) ? 1 : 0); ++hinted) {
                        BlockRequest request = options_.request;
                        request.format = format;
                        request.effort = effort;
                        request.hinted = hinted != 0;
                        const auto advance = [&](std::uint64_t texels) {
                            progress.Advance(texels);
                            ThrowIfInterrupted();
                        };
                        rows_.push_back({options_.files[i], format, effort,
                                         MeasureBlocks(images[i], request, options_.files[i], advance),
                                         request.hinted});
                    }
                }
            }
        }
    }

    /// A row for all images that have a format and effort, where there are several.
    void AddPooled() {
        std::vector<BcRow> pooled;
        for (const BcRow& row : rows_) {
            const auto same = std::find_if(pooled.begin(), pooled.end(), [&](const BcRow& other) {
                return other.format == row.format && other.effort == row.effort && other.hinted == row.hinted;
            });
            if (same == pooled.end()) {
                pooled.push_back(row);
                pooled.back().image.clear();
                continue;
            }
            // Alpha counts where an image has it; what is pooled of three and four channels is three.
            same->measurement.channels = std::min(same->measurement.channels, row.measurement.channels);
            same->measurement.Pool(row.measurement);
        }
        if (options_.files.size() > 1)
            rows_.insert(rows_.end(), pooled.begin(), pooled.end());
    }

    void PrintTable() const {
        if (options_.csv)
            WriteOutput("image,format,quality,psnr,worst,alphaMoved,megapixelsPerSecond,bytes,hinted\n");
        else
            WriteOutput(Format("cpu: %s, %s\n%-52s %-5s %-14s %9s %7s %12s\n",
                               Printable(GetCpuName()).c_str(),
                               options_.request.threads == 1 ? "one thread" : "threads", "image", "bc",
                               "level", "PSNR dB", "worst", "Mpixel/s"));
        for (const BcRow& row : rows_) {
            const BlockMeasurement& m = row.measurement;
            const double worst = *std::max_element(m.error.worst.begin(), m.error.worst.end());
            const std::string image = row.image.empty() ? "all" : Printable(row.image);
            const char* format = bc::BlockFormatToString(row.format);
            if (options_.csv)
                WriteOutput(QuoteCsv(image) +
                            Format(",%s,%s,%.4f,%.4g,%llu,%.4f,%llu,%d\n", format, GetName(row.effort),
                                   m.GetPsnr(), worst, static_cast<unsigned long long>(m.error.moved),
                                   m.GetMegapixelsPerSecond(), static_cast<unsigned long long>(m.bytes),
                                   row.hinted ? 1 : 0));
            else
                WriteOutput(Format("%-52s %-5s %-14s %9.3f %7.4g %12.3f\n", GetFileName(image).c_str(),
                                   format, row.GetLevel().c_str(), m.GetPsnr(), worst,
                                   m.GetMegapixelsPerSecond()));
        }
    }

    static std::string GetFileName(const std::string& path) {
        return std::filesystem::path(path).filename().string();
    }

    static std::string QuoteCsv(const std::string& text) {
        if (text.find_first_of(",\"") == std::string::npos)
            return text;
        std::string quoted = "\"";
        for (const char c : text)
            quoted += c == '"' ? "\"\"" : std::string(1, c);
        return quoted + "\"";
    }

    void PrintJson(const std::vector<std::string>& worse) const {
        JsonWriter json;
        json.BeginObject();
        json.Member("cpu", std::string_view(GetCpuName()));
        json.Member("threads", options_.request.threads);
        json.Member("repeat", options_.request.repeat);
        json.Key("results");
        json.BeginArray();
        for (const BcRow& row : rows_) {
            const BlockMeasurement& m = row.measurement;
            json.BeginObject();
            json.Member("image", std::string_view(row.image));
            json.Member("format", bc::BlockFormatToString(row.format));
            json.Member("quality", GetName(row.effort));
            json.Member("hinted", row.hinted);
            json.Member("channels", m.channels);
            json.Member("psnr", m.GetPsnr());
            json.Key("psnrOfChannels");
            json.BeginArray();
            for (int c = 0; c < bc::GetBlockChannels(row.format); ++c)
                json.Value(m.GetPsnr(c));
            json.EndArray();
            json.Member("worst", *std::max_element(m.error.worst.begin(), m.error.worst.end()));
            json.Member("alphaMoved", m.error.moved);
            json.Member("texels", m.texels);
            json.Member("bytes", m.bytes);
            json.Member("seconds", m.seconds);
            json.Member("megapixelsPerSecond", m.GetMegapixelsPerSecond());
            json.EndObject();
        }
        json.EndArray();
        if (!options_.baseline.empty()) {
            json.Key("worse");
            json.BeginArray();
            for (const std::string& line : worse)
                json.Value(std::string_view(line));
            json.EndArray();
        }
        json.EndObject();
        WriteOutput(json.Take());
    }

    const BcTestOptions& options_;
    std::vector<BcRow> rows_;
};

std::vector<std::string> SplitList(const std::string& text) {
    std::vector<std::string> parts(1);
    for (const char c : text) {
        if (c == ',')
            parts.emplace_back();
        else
            parts.back() += c;
    }
    return parts;
}

void SelectFormats(const std::string& text, BcTestOptions& options) {
    options.formats.clear();
    for (const std::string& name : SplitList(text)) {
        const std::optional<bc::BlockFormat> format = FindBlockFormat(name);
        if (!format)
            FailUsage("--bc", text + ": bc1, bc2, bc3, bc4, bc4s, bc5, bc5s, bc6, bc6s or bc7, with commas");
        options.formats.push_back(*format);
    }
}

void SelectEfforts(const std::string& text, BcTestOptions& options) {
    options.efforts.clear();
    for (const std::string& name : SplitList(text)) {
        const auto found = std::find_if(kEfforts.begin(), kEfforts.end(),
                                        [&](BlockEffort effort) { return name == GetName(effort); });
        if (found == kEfforts.end())
            FailUsage("--quality", text + ": fast, normal or best, with commas");
        options.efforts.push_back(*found);
    }
}

} // namespace

void AddBcTestCommand(CLI::App& app, Action& action) {
    auto options = std::make_shared<BcTestOptions>();
    CLI::App* command =
        app.add_subcommand("bc-test", "Quality and speed of block compression, level by level");
    command->add_option("images", options->files, "Images: PNG, JPEG, TGA, BMP, HDR, OpenEXR")
        ->required()
        ->type_name("IMAGE");
    command
        ->add_option_function<std::string>(
            "--bc", [options](const std::string& text) { SelectFormats(text, *options); },
            "Formats, with commas between them (default: those that suit each image)")
        ->type_name("LIST");
    command
        ->add_option_function<std::string>(
            "--quality", [options](const std::string& text) { SelectEfforts(text, *options); },
            "Levels: fast, normal, best, with commas between them (default: all)")
        ->type_name("LIST");
    command
        ->add_option_function<std::string>(
            "--channel",
            [options](const std::string& text) {
                const std::size_t channel = std::string("rgba").find(text);
                if (text.size() != 1 || channel == std::string::npos)
                    FailUsage("--channel", text + ": r, g, b or a");
                options->request.channel = static_cast<int>(channel);
            },
            "What BC4 takes: r (default), g, b or a")
        ->type_name("CHANNEL");
    command->add_flag("--hints", options->hints,
                      "Of BC7 each level also with hints, as ntc optimize-bc gathers them");
    AddNumberOption(*command, "--threads", options->request.threads, {0, 1024},
                    "Threads; 0: all. With one, the default, the time is the processor's");
    AddNumberOption(*command, "--repeat", options->request.repeat, {1, 1000},
                    "Runs, of which the fastest counts (default 3)");
    command
        ->add_option("--baseline", options->baseline,
                     "Output of an earlier run with --json: exit with 1 if anything got worse")
        ->type_name("FILE");
    AddNumberOption(*command, "--max-loss", options->limits.decibels, {0, 100},
                    "PSNR that may be lost against the baseline (default 0.01)", "DB");
    AddNumberOption(*command, "--max-slower", options->limits.percent, {0, 100},
                    "Speed that may be lost against the baseline (default 10)", "PERCENT");
    CLI::Option* csv = command->add_flag("--csv", options->csv, "Print CSV");
    AddJsonFlag(*command, options->json);
    csv->excludes("--json");
    command->callback([options, &action] {
        CheckOneStandardInput(options->files);
        action = [options] { return BcTest(*options).Run(); };
    });
}

} // namespace openntc::tool
