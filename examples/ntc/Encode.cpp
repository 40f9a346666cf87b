// SPDX-License-Identifier: MIT
// `ntc encode`: images to a texture-set file.
#include "Arguments.h"
#include "Commands.h"
#include "Failure.h"
#include "Interrupt.h"
#include "Json.h"
#include "Output.h"
#include "Progress.h"
#include "encode/EncodeInputs.h"

#include "openntc/core/FileStream.h"
#include "openntc/encode/AdaptiveSearch.h"
#include "openntc/encode/Encoder.h"

#include <cinttypes>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <sstream>

namespace openntc::tool {

namespace {

struct Options {
    InputOptions inputs;
    std::string output;
    encode::EncodeOptions encode;
    std::string latentShape;
    std::string maskChannel;
    double targetPsnr = 0.0;
    double maximumBits = 0.0;
    bool resume = false;
    bool json = false;
    bool quiet = false;
};

/// What a cancelled run leaves beside its output.
struct StateHeader {
    char magic[8] = {'N', 'T', 'C', 'S', 'T', 'A', 'T', '1'};
    double fraction = 0.0;
    std::uint64_t bytes = 0;
};

class EncodeCommand {
public:
    explicit EncodeCommand(const Options& options) : options_(options), inputs_(LoadInputs(options.inputs)) {
        for (const std::string& warning : inputs_.warnings)
            std::fprintf(stderr, "ntc: warning: %s\n", Printable(warning).c_str());
    }

    int Run() {
        encode::EncodeOptions encode = options_.encode;
        encode.lossScales = inputs_.lossScales;
        encode.maskChannel = options_.maskChannel.empty() ? inputs_.maskChannel : ParseMask();
        if (!options_.latentShape.empty())
            encode.latentShape = ParseShape();
        if (inputs_.material.GetWidth() == 1 || inputs_.material.GetHeight() == 1)
            std::fprintf(stderr, "ntc: warning: %s: size: a side of 1: LibNTC will refuse this file\n",
                         Printable(options_.output).c_str());
        std::vector<std::byte> state;
        if (options_.resume) {
            state = ReadState(encode.resumeFraction);
            encode.resumeState = state;
        }
        encode::EncodeResult result = options_.targetPsnr > 0.0 ? Search(encode) : Train(encode);
        Save(result);
        std::error_code ignored;
        std::filesystem::remove(GetStatePath(), ignored);
        Print(result);
        FinishOutput();
        if (options_.targetPsnr > 0.0 && result.psnr < options_.targetPsnr)
            throw CommandError(ExitCode::Failed, options_.output,
                               Format("psnr: %.2f dB: the target is %.2f; the best file was kept",
                                      result.psnr, options_.targetPsnr));
        if (options_.inputs.strict && result.maskViolations > 0)
            throw CommandError(ExitCode::Failed, options_.output,
                               Format("mask: %" PRIu64 " texels of exactly 0 or 1 decode to another value",
                                      result.maskViolations));
        return 0;
    }

private:
    std::string GetStatePath() const { return options_.output + ".state"; }

    int ParseMask() const {
        if (options_.maskChannel == "none")
            return -1;
        char* end = nullptr;
        const long channel = std::strtol(options_.maskChannel.c_str(), &end, 10);
        if (*end != '\0' || channel < 0 || channel > 15)
            FailUsage("--mask-channel", options_.maskChannel + ": 0 to 15, or none");
        return static_cast<int>(channel);
    }
    LatentShape ParseShape() const {
        LatentShape shape;
        char rest = 0;
        if (std::sscanf(options_.latentShape.c_str(), "%d,%d,%d,%d,%d%c", &shape.gridSizeScale,
                        &shape.highResFeatures, &shape.lowResFeatures, &shape.highResQuantBits,
                        &shape.lowResQuantBits, &rest) != 5)
            FailUsage("--latent-shape", options_.latentShape + ": five numbers S,HF,LF,HB,LB");
        return shape;
    }

    std::vector<std::byte> ReadState(double& fraction) const {
        std::ifstream file(GetStatePath(), std::ios::binary);
        const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
        StateHeader header, expected;
        if (text.size() < sizeof(header))
            throw CommandError(ExitCode::BadInput, GetStatePath(), "state: absent or cut: nothing to resume");
        std::memcpy(&header, text.data(), sizeof(header));
        if (std::memcmp(header.magic, expected.magic, sizeof(header.magic)) != 0 ||
            header.bytes != text.size() - sizeof(header))
            throw CommandError(ExitCode::BadInput, GetStatePath(), "state: not of this version");
        fraction = header.fraction;
        const auto* bytes = reinterpret_cast<const std::byte*>(text.data());
        return {bytes + sizeof(header), bytes + text.size()};
    }
    void WriteBytes(const std::string& path, std::initializer_list<std::span<const std::byte>> parts) const {
        auto file = Require(FileWriter::Create(path), ExitCode::Failed, path);
        for (const std::span<const std::byte> part : parts) {
            if (!file.Write(part.data(), part.size()))
                throw CommandError(ExitCode::Failed, path, "file: cannot be written: disk full?");
        }
        Require(file.Commit(), ExitCode::Failed, path);
    }

    encode::EncodeResult Train(const encode::EncodeOptions& encode) {
        auto result = Require(encode::Encoder::Encode(inputs_.material, encode,
                                                      [this](const encode::Progress& progress) {
                                                          Show(progress);
                                                          return !IsInterrupted();
                                                      }),
                              ExitCode::Usage, options_.output);
        if (shown_ && !options_.json)
            std::fputs("\r\033[K", stderr);
        shown_ = false;
        if (result.cancelled) {
            StateHeader header;
            header.fraction = result.fraction;
            header.bytes = result.state.size();
            WriteBytes(GetStatePath(), {std::as_bytes(std::span(&header, 1)), result.state});
            throw CommandError(ExitCode::Failed, options_.output,
                               Format("interrupted at step %" PRIu64 ": state kept in %s: --resume continues",
                                      result.steps, GetStatePath().c_str()));
        }
        return result;
    }

    encode::EncodeResult Search(encode::EncodeOptions encode) {
        auto search = Require(
            encode::AdaptiveSearch::Create(encode.networkVersion, options_.targetPsnr, options_.maximumBits),
            ExitCode::Usage, "--target-psnr");
        encode::EncodeResult best;
        std::size_t bestTrial = 0;
        while (!search.IsFinished()) {
            encode.latentShape = search.GetNext().shape;
            const float bits = search.GetNext().bitsPerPixel;
            encode::EncodeResult result = Train(encode);
            search.Report(result.psnr);
            const std::string event =
                options_.json
                    ? Format("{\"event\":\"trial\",\"bitsPerPixel\":%g,\"psnr\":%.4f}\n",
                             static_cast<double>(bits), result.psnr)
                    : Format("tried %g bits per pixel: %.2f dB\n", static_cast<double>(bits), result.psnr);
            std::fputs(event.c_str(), stderr);
            if (search.GetTrials().size() == 1 || search.GetBest() != bestTrial) {
                bestTrial = search.GetBest();
                best = std::move(result);
            }
        }
        return best;
    }

    void Show(const encode::Progress& progress) {
        if (options_.quiet || (!options_.json && !IsTerminal()))
            return;
        shown_ = true;
        if (options_.json) {
            std::fprintf(stderr,
                         "{\"event\":\"progress\",\"activity\":\"encode\",\"step\":%" PRIu64
                         ",\"steps\":%" PRIu64
                         ",\"fraction\":%.4f,\"psnr\":%.3f,\"seconds\":%.2f,\"secondsLeft\":%.1f}\n",
                         progress.step, progress.steps, progress.fraction, progress.psnr, progress.seconds,
                         progress.secondsLeft);
            return;
        }
        constexpr int kWidth = 24;
        const int full = static_cast<int>(progress.fraction * kWidth);
        std::fprintf(
            stderr, "\r[%.*s%*s] step %" PRIu64 "/%" PRIu64 "  ~%.2f dB  %.1f M texels/s  %.0f s left \033[K",
            full, "########################", kWidth - full, "", progress.step, progress.steps, progress.psnr,
            progress.texelsPerSecond * 1e-6, progress.secondsLeft);
    }

    void Save(const encode::EncodeResult& result) const { WriteBytes(options_.output, {result.file}); }

    void Print(const encode::EncodeResult& result) const {
        const double bits = static_cast<double>(GetLatentShapeBitsPerPixel(result.latentShape));
        if (!options_.json) {
            WriteOutput(Format("%s: %zu bytes, %g bits per pixel, %.2f dB, %" PRIu64
                               " steps in %.1f s (%s, %.2f M texels/s)\n",
                               Printable(options_.output).c_str(), result.file.size(), bits, result.psnr,
                               result.steps, result.seconds, result.kernel, result.texelsPerSecond * 1e-6));
            if (result.maskViolations > 0)
                WriteOutput(Format("mask: %" PRIu64 " texels of exactly 0 or 1 decode to another value\n",
                                   result.maskViolations));
            return;
        }
        JsonWriter json;
        json.BeginObject();
        json.Member("file", std::string_view(options_.output));
        json.Member("bytes", static_cast<std::uint64_t>(result.file.size()));
        json.Member("bitsPerPixel", bits);
        const LatentShape& s = result.latentShape;
        json.Key("latentShape");
        json.BeginArray();
        for (int value :
             {s.gridSizeScale, s.highResFeatures, s.lowResFeatures, s.highResQuantBits, s.lowResQuantBits})
            json.Value(value);
        json.EndArray();
        json.Member("network", options_.encode.networkVersion);
        json.Member("psnr", result.psnr);
        json.Key("mipPsnr");
        json.BeginArray();
        for (double psnr : result.mipPsnr)
            json.Value(psnr);
        json.EndArray();
        json.Key("channelPsnr");
        json.BeginArray();
        for (int c = 0; c < inputs_.material.GetChannelCount(); ++c) {
            if ((inputs_.material.GetDeclaredChannels() >> c & 1u) != 0)
                json.Value(result.channelPsnr[static_cast<std::size_t>(c)]);
            else
                json.Null();
        }
        json.EndArray();
        json.Member("steps", result.steps);
        json.Member("seed", options_.encode.seed);
        json.Member("seconds", result.seconds);
        json.Member("texelsPerSecond", result.texelsPerSecond);
        json.Member("kernel", result.kernel);
        json.Member("maskViolations", result.maskViolations);
        json.EndObject();
        WriteOutput(json.Take());
    }

    const Options& options_;
    EncodeInputs inputs_;
    bool shown_ = false;
};

template <typename T, std::size_t N>
T SelectName(const char* option, const std::string& name, const char* const (&names)[N],
             const T (&values)[N]) {
    std::string all;
    for (std::size_t i = 0; i < N; ++i) {
        if (name == names[i])
            return values[i];
        all += (i == 0 ? "" : ", ") + std::string(names[i]);
    }
    FailUsage(option, name + ": " + all);
}

} // namespace

void AddEncodeCommand(CLI::App& app, Action& action) {
    auto options = std::make_shared<Options>();
    CLI::App* command = app.add_subcommand("encode", "Encode images to a texture set");
    command
        ->add_option("inputs", options->inputs.paths, "Images, or a folder of images, or a manifest (.json)")
        ->required();
    command->add_option("-o,--output", options->output, "File to write")->required()->type_name("FILE");
    command->add_option("--bits-per-pixel", options->encode.bitsPerPixel, "Size of the latents (default 4)")
        ->type_name("B");
    command
        ->add_option("--latent-shape", options->latentShape,
                     "Instead: grid scale, high- and low-res features, high- and low-res bits")
        ->type_name("S,HF,LF,HB,LB");
    command
        ->add_option_function<std::string>(
            "--network",
            [options](const std::string& name) {
                options->encode.networkVersion = SelectName(
                    "--network", name, {"small", "medium", "large", "xlarge"},
                    {NTC_NETWORK_SMALL, NTC_NETWORK_MEDIUM, NTC_NETWORK_LARGE, NTC_NETWORK_XLARGE});
            },
            "small, medium (default), large or xlarge")
        ->type_name("NAME");
    command
        ->add_option("--target-psnr", options->targetPsnr, "Smallest known shape that reaches this quality")
        ->type_name("DB");
    command->add_option("--max-bits-per-pixel", options->maximumBits, "Limit of the search")->type_name("B");
    command
        ->add_option_function<std::string>(
            "--effort",
            [options](const std::string& name) {
                options->encode.effort =
                    SelectName("--effort", name, {"fast", "normal", "best"},
                               {encode::Effort::Fast, encode::Effort::Normal, encode::Effort::Best});
            },
            "fast, normal (default) or best")
        ->type_name("NAME");
    command->add_option("--seconds", options->encode.seconds, "Instead: end training within this time")
        ->type_name("N");
    command->add_option("--steps", options->encode.steps, "Instead: number of training steps")
        ->type_name("N");
    command->add_option("--seed", options->encode.seed, "Same seed and steps: same bytes (default 1)")
        ->type_name("N");
    command->add_option("--threads", options->encode.threads, "Default: all cores; never changes the result")
        ->type_name("N");
    command->add_option("--mips", options->inputs.mips, "Number of mips (default: the full chain)")
        ->check(CLI::Range(1, 16))
        ->type_name("N");
    command->add_option("--mask-channel", options->maskChannel, "Channel whose exact 0 and 1 are kept")
        ->type_name("N");
    command->add_flag("--discard-masked", options->encode.discardMasked,
                      "Texels whose mask is 0 may become anything");
    command->add_flag("--strict", options->inputs.strict,
                      "Refuse sizes that differ; fail when mask texels change");
    command->add_flag("--resume", options->resume, "Continue the interrupted run of the same command");
    command->add_flag("--quiet", options->quiet, "No progress");
    AddJsonFlag(*command, options->json);
    command->callback([options, &action] { action = [options] { return EncodeCommand(*options).Run(); }; });
}

} // namespace openntc::tool
