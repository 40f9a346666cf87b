// SPDX-License-Identifier: MIT
#include "encode/EncodeJob.h"

#include "Failure.h"
#include "Findings.h"
#include "InputFile.h"
#include "Interrupt.h"
#include "Output.h"
#include "Progress.h"
#include "TextureSet.h"
#include "encode/DeviceTraining.h"
#include "encode/ShapeChoice.h"
#include "encode/StateFile.h"
#include "encode/Training.h"
#include "encode/TrainingLimits.h"
#include "encode/TrainingProgress.h"
#include "textures/SetModes.h"

#include "openntc/encode/UsefulSteps.h"

#include <algorithm>
#include <chrono>
#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <utility>

namespace openntc::tool {

namespace {

ExitCode GetExitCode(Status status) {
    switch (status) {
    case Status::OutOfRange:
    case Status::InvalidArgument:
        return ExitCode::Usage;
    case Status::FileIncompatible:
        return ExitCode::BadInput;
    case Status::Unsupported:
        return ExitCode::NoDevice;
    default:
        return ExitCode::Failed;
    }
}

class JobRunner {
public:
    explicit JobRunner(const EncodeJob& job) : job_(job) {}

    EncodedFile Run() {
        CheckWritable(job_.output);
        const LatentShape shape = ChooseShape();
        if (job_.resume)
            LoadState();
        InputOptions inputs = job_.inputs;
        inputs.targets = job_.training.textureTargets;
        inputs_ = job_.load ? job_.load() : LoadInputs(inputs);
        FindTargets();
        RefuseInputAsOutput("-o", job_.output, inputs_.files);
        if (job_.keepsState)
            RefuseInputAsOutput("-o", job_.GetStatePath(), inputs_.files);
        encode::EncodeOptions options = job_.training.encode;
        options.lossScales = inputs_.lossScales;
        options.maskChannel = inputs_.maskChannel;
        Require(CheckWeights(options, inputs_.material.GetDeclaredChannels()), ExitCode::Usage, job_.output);
        if (options.discardMasked && options.maskChannel < 0)
            throw CommandError(ExitCode::Usage, "--discard-masked", "no channel is a mask: --mask-channel N");
        if (options.maskChannel >= 0 &&
            (inputs_.material.GetDeclaredChannels() >> options.maskChannel & 1u) == 0)
            throw CommandError(ExitCode::Usage, "--mask-channel",
                               Format("%d: belongs to no texture", options.maskChannel));
        if (inputs_.material.GetWidth() == 1 || inputs_.material.GetHeight() == 1)
            inputs_.warnings.push_back(job_.output + ": size: a side of 1: LibNTC will refuse this file");
        if (std::filesystem::path(job_.output).extension() != ".ntc")
            inputs_.warnings.push_back(job_.output + ": name: does not end in .ntc");
        for (const std::string& warning : inputs_.warnings)
            PrintWarning(warning, job_.json);
        options.latentShape = TakeAcceptedShape(shape);
        if (job_.explains && !job_.json && !job_.quiet)
            Explain();

        for (int m = 0; m < inputs_.material.GetMipCount(); ++m)
            texels_ += static_cast<double>(inputs_.material.GetWidth(m)) * inputs_.material.GetHeight(m);
        if (!job_.resume) // the run that it continues said so
            WarnOfFewSteps(options.steps);
        if (options.seconds > 0.0 && !Searches()) // a search gives each training the time
            options.seconds = GetSecondsLeft(options.seconds);
        EncodedFile file;
        file.result = Searches() ? Search(options) : TrainOnce(options);
        WriteWholeFile(job_.output, {file.result.file});
        std::error_code ignored;
        std::filesystem::remove(job_.GetStatePath(), ignored);
        if (job_.training.blockModes)
            AddBlockModes(options, file);
        WarnOfRefusals(file);
        file.channelCount = inputs_.material.GetChannelCount();
        file.declaredChannels = inputs_.material.GetDeclaredChannels();
        file.bytes = file.result.file.size();
        file.textures = inputs_.textures;
        file.missed = DescribeMissed(file.result);
        if (file.bytes >= inputs_.rawBytes)
            Warn(Format("%s: size: %" PRIu64 " bytes: the texels themselves are %" PRIu64
                        " (with their mips, uncompressed): the set is too small to gain",
                        job_.output.c_str(), file.bytes, inputs_.rawBytes));
        return file;
    }

private:
    /// dB that channels of the set are to reach together.
    struct Target {
        std::string name; ///< empty: all
        double psnr = 0.0;
        int firstChannel = 0, channels = 0;

        double Measure(const encode::EncodeResult& result) const {
            return name.empty() ? result.psnr : GetTexturePsnr(result, firstChannel, channels);
        }
    };

    void FindTargets() {
        if (job_.training.targetPsnr > 0.0)
            targets_.push_back({"", job_.training.targetPsnr});
        for (const UnderstoodTexture& texture : inputs_.textures) {
            if (texture.targetPsnr > 0.0)
                targets_.push_back(
                    {texture.name, texture.targetPsnr, texture.firstChannel, texture.channels});
        }
    }
    bool Searches() const { return !targets_.empty() && !job_.training.hasShape; }

    /// dB above the target that is the farthest from being reached.
    double GetMargin(const encode::EncodeResult& result) const {
        constexpr double kLargest = 150.0; // exact textures are infinitely good
        double margin = kLargest;
        for (const Target& target : targets_)
            margin = std::min(margin, target.Measure(result) - target.psnr);
        return margin;
    }
    std::string DescribeMissed(const encode::EncodeResult& result) const {
        std::string text;
        for (const Target& target : targets_) {
            const double psnr = target.Measure(result);
            if (psnr < target.psnr)
                text += (text.empty() ? "psnr: " : ", ") + Printable(target.name) +
                        (target.name.empty() ? "" : ": ") +
                        Format("%.2f dB: the target is %.2f", psnr, target.psnr);
        }
        return text;
    }

    /// Writes the file again. What goes wrong, or an interrupt, leaves the one that training made.
    void AddBlockModes(const encode::EncodeOptions& options, EncodedFile& file) const {
        std::optional<Progress> progress;
        const auto advance = [&](std::uint64_t texels, std::uint64_t all) {
            if (!progress && job_.isAlone && !job_.quiet)
                progress.emplace("modes", all, job_.json);
            if (progress)
                progress->Advance(texels);
        };
        try {
            SetModes modes =
                AddModes(file.result.file, options.compress, options.threads, job_.output, advance);
            if (modes.textures == 0) {
                Warn(job_.output + ": --bc7-modes: no texture is for BC7: none kept");
                return;
            }
            WriteWholeFile(job_.output, {modes.file});
            file.result.file = std::move(modes.file);
        } catch (const CommandError& error) {
            progress.reset();
            throw CommandError(
                error.GetCode(), job_.output,
                std::string(error.what()) +
                    ": the set was written without BC7 modes: ntc optimize-bc --in-set adds them");
        }
    }

    LatentShape ChooseShape() const {
        const encode::EncodeOptions& options = job_.training.encode;
        if (options.latentShape.IsEmpty())
            return Require(PickLatentShape(options.bitsPerPixel, options.networkVersion), ExitCode::Usage,
                           "--bits-per-pixel")
                .shape;
        Require(ValidateLatentShape(options.latentShape, options.networkVersion), ExitCode::Usage,
                "--latent-shape");
        return options.latentShape;
    }

    TextureSetDesc GetDesc() const {
        const encode::Material& material = inputs_.material;
        return {material.GetWidth(), material.GetHeight(), material.GetChannelCount(),
                material.GetMipCount()};
    }

    /// Generation 3: another shape near `wanted` where LibNTC would refuse a file of that one at this size, and no
    /// particular shape was asked for.
    LatentShape TakeAcceptedShape(const LatentShape& wanted) const {
        const TrainingChoices& training = job_.training;
        if (GetGeneration(training.encode.networkVersion) != 3 || Searches() ||
            (training.hasShape && !training.encode.latentShape.IsEmpty()))
            return wanted;
        const double wish = training.hasShape ? static_cast<double>(training.encode.bitsPerPixel) : 0.0;
        const LatentShape taken = FindAcceptedShape(GetDesc(), wanted, wish);
        if (taken != wanted)
            Warn(Format("%s: latents: %g bits per pixel: of %g LibNTC refuses a set of %d x %d",
                        job_.output.c_str(), static_cast<double>(GetLatentShapeBitsPerPixel(taken)),
                        static_cast<double>(GetLatentShapeBitsPerPixel(wanted)), GetDesc().width,
                        GetDesc().height));
        return taken;
    }

    void WarnOfRefusals(const EncodedFile& file) const {
        ReadOnlyMemoryStream stream(file.result.file);
        const TextureSetMetadata metadata =
            Require(TextureSetMetadata::Load(stream), ExitCode::Failed, job_.output);
        for (const Finding& finding : FindRefusals(metadata))
            Warn(job_.output + Format(": %d: ", finding.number) + finding.text);
    }

    void LoadState() {
        const std::string path = job_.GetStatePath();
        state_ = ReadState(path);
        const int network = job_.training.encode.networkVersion;
        if (state_.networkVersion != network)
            throw CommandError(ExitCode::BadInput, path,
                               Format("state: network: %s: this command trains %s",
                                      GetNetworkName(state_.networkVersion), GetNetworkName(network)));
    }

    /// One line for each image, before the work begins.
    void Explain() const {
        for (const UnderstoodTexture& texture : inputs_.textures) {
            WriteOutput(Printable(texture.file) +
                        Format(": %d channel%s, ", texture.channels, texture.channels == 1 ? "" : "s") +
                        GetName(texture.space) + " (" + Printable(texture.reason) + ")\n");
            if (!texture.hint.empty())
                WriteOutput("  " + texture.hint + "\n");
        }
        FinishOutput();
    }

    void Warn(const std::string& text) const { PrintWarning(text, job_.json); }

    void WarnOfFewSteps(std::uint64_t steps) const {
        const std::uint64_t needed = encode::GetUsefulSteps(texels_);
        if (steps > 0 && steps < needed)
            Warn(Format("%s: --steps %" PRIu64 ": too few for this quality: a useful result needs %" PRIu64
                        " or more at this size",
                        job_.output.c_str(), steps, needed));
    }

    /// What loading took belongs to the time that was said, or the promise would be of no use to the user.
    double GetSecondsLeft(double seconds) const {
        constexpr double kLeastShare = 0.1;
        const double spent = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
        return std::max(seconds - spent, seconds * kLeastShare);
    }

    TrainingProgress::Settings GetProgressSettings(const encode::EncodeOptions& options) const {
        TrainingProgress::Settings settings;
        settings.file = job_.output;
        settings.seconds = options.steps == 0 ? job_.training.encode.seconds : 0.0;
        settings.limit = options.seconds * (1.0 - options.resumeFraction);
        settings.hasEffort = options.steps == 0 && options.seconds <= 0.0;
        settings.texels = texels_;
        settings.json = job_.json;
        settings.quiet = job_.quiet;
        settings.isAlone = job_.isAlone;
        return settings;
    }

    encode::EncodeResult TrainOnce(encode::EncodeOptions options) {
        const bool resumes = job_.resume && (!Searches() || options.latentShape == state_.latentShape);
        if (resumes) {
            options.resumeState = state_.bytes;
            options.resumeFraction = state_.fraction;
        }
        if (job_.keepsState && (job_.saveSeconds > 0.0 || job_.training.device)) { // a device can be lost
            constexpr double kNever = 1e30;
            options.saveSeconds = job_.saveSeconds > 0.0 ? job_.saveSeconds : kNever;
            options.save = [this, shape = options.latentShape](std::span<const std::byte> state,
                                                               double fraction) {
                SaveState(shape, state, fraction);
            };
        }
        TrainingProgress progress(GetProgressSettings(options));
        const auto watch = [this, &progress](const encode::Progress& now) {
            progress.Show(now);
            if (job_.watch)
                job_.watch(now);
            return !IsInterrupted();
        };
        // A search needs the texels again.
        Expected<encode::EncodeResult> trained = Searches()
                                                     ? TrainBy(inputs_.material, options, watch)
                                                     : TrainBy(std::move(inputs_.material), options, watch);
        progress.Clear();
        const ExitCode code = trained ? ExitCode::Ok : GetExitCode(trained.error().GetStatus());
        encode::EncodeResult result = Require(std::move(trained), code, job_.output);
        progress.Finish(result);
        if (result.cancelled && !job_.keepsState)
            throw CommandError(ExitCode::Failed, job_.output,
                               Format("interrupted at step %" PRIu64 ": not written", result.steps));
        if (result.cancelled) {
            const std::string path = job_.GetStatePath();
            WriteState(path, result.latentShape, options.networkVersion, result.fraction, result.state);
            throw CommandError(ExitCode::Failed, job_.output,
                               Format("interrupted at step %" PRIu64 ": state kept in %s: --resume continues",
                                      result.steps, path.c_str()));
        }
        return result;
    }

    template <typename AnyMaterial>
    Expected<encode::EncodeResult> TrainBy(AnyMaterial&& material, const encode::EncodeOptions& options,
                                           const encode::ProgressCallback& watch) const {
        if (job_.training.device)
            return TrainOnVulkan(*job_.training.device, std::forward<AnyMaterial>(material), options, watch);
        return Train(std::forward<AnyMaterial>(material), options, watch);
    }

    /// Training goes on when the disk is full: its file may still find room.
    void SaveState(const LatentShape& shape, std::span<const std::byte> state, double fraction) {
        try {
            WriteState(job_.GetStatePath(), shape, job_.training.encode.networkVersion, fraction, state);
            saveFailed_ = false;
        } catch (const CommandError& error) {
            if (!std::exchange(saveFailed_, true))
                Warn(error.GetSubject() + ": " + error.what());
        }
    }

    /// The smallest known shape that reaches all targets, or the one that comes nearest.
    encode::EncodeResult Search(encode::EncodeOptions options) {
        encode::AdaptiveSearch search =
            MakeShapeSearch(GetDesc(), options.networkVersion, job_.training.maximumBits);
        encode::EncodeResult best;
        std::size_t bestTrial = 0;
        while (!search.IsFinished()) {
            options.latentShape = search.GetNext().shape;
            const auto bits = static_cast<double>(search.GetNext().bitsPerPixel);
            encode::EncodeResult result = TrainOnce(options);
            const double margin = GetMargin(result);
            search.Report(margin);
            if (job_.json)
                std::fprintf(stderr,
                             "{\"event\":\"trial\",\"bitsPerPixel\":%g,\"psnr\":%.4f,\"margin\":%.4f}\n",
                             bits, result.psnr, margin);
            else if (!job_.quiet)
                std::fprintf(stderr, "tried %g bits per pixel: %.2f dB, %.2f dB %s\n", bits, result.psnr,
                             std::fabs(margin), margin < 0.0 ? "too little" : "to spare");
            if (search.GetTrials().size() == 1 || search.GetBest() != bestTrial) {
                bestTrial = search.GetBest();
                best = std::move(result);
            }
        }
        return best;
    }

    const EncodeJob& job_;
    EncodeInputs inputs_;
    std::vector<Target> targets_;
    EncodeState state_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
    double texels_ = 0.0; ///< of all mips
    bool saveFailed_ = false;
};

} // namespace

std::string EncodeJob::GetStatePath() const {
    return statePath.empty() ? tool::GetStatePath(output) : statePath;
}

EncodedFile RunEncodeJob(const EncodeJob& job) {
    return JobRunner(job).Run();
}

double GetTexturePsnr(const encode::EncodeResult& result, int firstChannel, int channels) {
    double error = 0.0;
    for (int c = firstChannel; c < firstChannel + channels; ++c)
        error += std::pow(10.0, -0.1 * result.channelPsnr[static_cast<std::size_t>(c)]);
    return -10.0 * std::log10(error / channels);
}

void CheckGoals(const EncodeJob& job, const EncodedFile& file) {
    if (!file.missed.empty())
        throw CommandError(ExitCode::Failed, job.output, file.missed + "; the best file was kept");
    if (job.training.strict && file.result.maskViolations > 0)
        throw CommandError(ExitCode::Failed, job.output,
                           Format("mask: %" PRIu64
                                  " texels of exactly 0 or 1 decode to another value; the file was kept",
                                  file.result.maskViolations));
}

} // namespace openntc::tool
