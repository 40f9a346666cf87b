// SPDX-License-Identifier: MIT
#include "encode/EncodeJob.h"

#include "Failure.h"
#include "InputFile.h"
#include "Interrupt.h"
#include "Output.h"
#include "Progress.h"
#include "TextureSet.h"
#include "encode/StateFile.h"
#include "encode/Training.h"

#include "openntc/encode/AdaptiveSearch.h"
#include "openntc/encode/UsefulSteps.h"

#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <filesystem>
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
            state_ = ReadState(GetStatePath(job_.output));
        inputs_ = LoadInputs(job_.inputs);
        RefuseInputAsOutput("-o", job_.output, inputs_.files);
        if (job_.keepsState)
            RefuseInputAsOutput("-o", GetStatePath(job_.output), inputs_.files);
        encode::EncodeOptions options = job_.training.encode;
        options.latentShape = shape;
        options.lossScales = inputs_.lossScales;
        options.maskChannel = inputs_.maskChannel;
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
        if (job_.explains && !job_.json && !job_.quiet)
            Explain();

        EncodedFile file;
        file.result = job_.training.targetPsnr > 0.0 ? Search(options) : TrainOnce(options);
        WriteWholeFile(job_.output, {file.result.file});
        std::error_code ignored;
        std::filesystem::remove(GetStatePath(job_.output), ignored);
        file.channelCount = inputs_.material.GetChannelCount();
        file.declaredChannels = inputs_.material.GetDeclaredChannels();
        file.bytes = file.result.file.size();
        file.textures = inputs_.textures;
        if (file.bytes >= inputs_.rawBytes)
            Warn(Format("%s: size: %" PRIu64 " bytes: the texels themselves are %" PRIu64
                        " (with their mips, uncompressed): the set is too small to gain",
                        job_.output.c_str(), file.bytes, inputs_.rawBytes));
        WarnOfFewSteps(file.result);
        return file;
    }

private:
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

    /// Whoever says a time does not know how many steps that makes.
    void WarnOfFewSteps(const encode::EncodeResult& result) const {
        if (job_.training.encode.seconds <= 0.0)
            return;
        double texels = 0.0;
        for (int m = 0; m < inputs_.material.GetMipCount(); ++m)
            texels += static_cast<double>(inputs_.material.GetWidth(m)) * inputs_.material.GetHeight(m);
        const std::uint64_t needed = encode::GetUsefulSteps(texels);
        if (result.steps < needed)
            Warn(Format("%s: --seconds %g: %" PRIu64
                        " steps: too few for this quality: a useful result needs %" PRIu64
                        " or more at this size, about %.0f seconds here",
                        job_.output.c_str(), job_.training.encode.seconds, result.steps, needed,
                        std::ceil(result.seconds * static_cast<double>(needed) /
                                  static_cast<double>(std::max<std::uint64_t>(result.steps, 1)))));
    }

    void Warn(const std::string& text) const { PrintWarning(text, job_.json); }

    encode::EncodeResult TrainOnce(encode::EncodeOptions options) {
        const bool resumes =
            job_.resume && (job_.training.targetPsnr <= 0.0 || options.latentShape == state_.latentShape);
        if (resumes) {
            options.resumeState = state_.bytes;
            options.resumeFraction = state_.fraction;
        }
        if (job_.keepsState && job_.saveSeconds > 0.0) {
            options.saveSeconds = job_.saveSeconds;
            options.save = [this, shape = options.latentShape](std::span<const std::byte> state,
                                                               double fraction) {
                SaveState(shape, state, fraction);
            };
        }
        const auto watch = [this](const encode::Progress& progress) {
            Show(progress);
            return !IsInterrupted();
        };
        const bool once = job_.training.targetPsnr <= 0.0; // a search needs the texels again
        Expected<encode::EncodeResult> trained = once ? Train(std::move(inputs_.material), options, watch)
                                                      : Train(inputs_.material, options, watch);
        if (shown_ && !job_.json)
            std::fputs("\r\033[K", stderr);
        shown_ = false;
        const ExitCode code = trained ? ExitCode::Ok : GetExitCode(trained.error().GetStatus());
        encode::EncodeResult result = Require(std::move(trained), code, job_.output);
        if (result.cancelled && !job_.keepsState)
            throw CommandError(ExitCode::Failed, job_.output,
                               Format("interrupted at step %" PRIu64 ": not written", result.steps));
        if (result.cancelled) {
            const std::string path = GetStatePath(job_.output);
            WriteState(path, result.latentShape, result.fraction, result.state);
            throw CommandError(ExitCode::Failed, job_.output,
                               Format("interrupted at step %" PRIu64 ": state kept in %s: --resume continues",
                                      result.steps, path.c_str()));
        }
        return result;
    }

    /// Training goes on when the disk is full: its file may still find room.
    void SaveState(const LatentShape& shape, std::span<const std::byte> state, double fraction) {
        try {
            WriteState(GetStatePath(job_.output), shape, fraction, state);
            saveFailed_ = false;
        } catch (const CommandError& error) {
            if (!std::exchange(saveFailed_, true))
                Warn(error.GetSubject() + ": " + error.what());
        }
    }

    /// The smallest known shape that reaches the target, or the best that there is.
    encode::EncodeResult Search(encode::EncodeOptions options) {
        auto search = Require(encode::AdaptiveSearch::Create(options.networkVersion, job_.training.targetPsnr,
                                                             job_.training.maximumBits),
                              ExitCode::Usage, "--target-psnr");
        encode::EncodeResult best;
        std::size_t bestTrial = 0;
        while (!search.IsFinished()) {
            options.latentShape = search.GetNext().shape;
            const auto bits = static_cast<double>(search.GetNext().bitsPerPixel);
            encode::EncodeResult result = TrainOnce(options);
            search.Report(result.psnr);
            if (job_.json)
                std::fprintf(stderr, "{\"event\":\"trial\",\"bitsPerPixel\":%g,\"psnr\":%.4f}\n", bits,
                             result.psnr);
            else if (!job_.quiet)
                std::fprintf(stderr, "tried %g bits per pixel: %.2f dB\n", bits, result.psnr);
            if (search.GetTrials().size() == 1 || search.GetBest() != bestTrial) {
                bestTrial = search.GetBest();
                best = std::move(result);
            }
        }
        return best;
    }

    /// Once, when the pace is known.
    void ShowEstimate(const encode::Progress& progress) {
        constexpr double kPaceSeconds = 2.0, kLongSeconds = 60.0;
        const encode::EncodeOptions& options = job_.training.encode;
        if (estimated_ || job_.quiet || job_.json || progress.seconds < kPaceSeconds)
            return;
        estimated_ = true;
        if (options.steps == 0 && options.seconds <= 0.0 && progress.secondsLeft > kLongSeconds)
            std::fprintf(
                stderr,
                "%sabout %.0f minutes on this machine; --seconds N ends after about N seconds, later where "
                "other programs take the processor\n",
                shown_ ? "\r\033[K" : "", std::ceil(progress.secondsLeft / 60.0));
    }

    void Show(const encode::Progress& progress) {
        ShowEstimate(progress);
        if (job_.quiet)
            return;
        if (!job_.json && !IsTerminal()) {
            ShowInLog(progress);
            return;
        }
        shown_ = true;
        if (job_.json) {
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

    void ShowInLog(const encode::Progress& progress) {
        if (!logPace_.IsDue(progress.seconds))
            return;
        std::fprintf(stderr, "%s: step %" PRIu64 " of %" PRIu64 ", about %.2f dB, %.0f s left\n",
                     Printable(job_.output).c_str(), progress.step, progress.steps, progress.psnr,
                     progress.secondsLeft);
    }

    const EncodeJob& job_;
    EncodeInputs inputs_;
    EncodeState state_;
    bool shown_ = false, estimated_ = false, saveFailed_ = false;
    LogPace logPace_;
};

} // namespace

EncodedFile RunEncodeJob(const EncodeJob& job) {
    return JobRunner(job).Run();
}

void CheckGoals(const EncodeJob& job, const encode::EncodeResult& result) {
    if (job.training.targetPsnr > 0.0 && result.psnr < job.training.targetPsnr)
        throw CommandError(ExitCode::Failed, job.output,
                           Format("psnr: %.2f dB: the target is %.2f; the best file was kept", result.psnr,
                                  job.training.targetPsnr));
    if (job.training.strict && result.maskViolations > 0)
        throw CommandError(ExitCode::Failed, job.output,
                           Format("mask: %" PRIu64
                                  " texels of exactly 0 or 1 decode to another value; the file was kept",
                                  result.maskViolations));
}

} // namespace openntc::tool
