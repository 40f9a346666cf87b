// SPDX-License-Identifier: MIT
#include "encode/EncodeJob.h"

#include "Failure.h"
#include "Interrupt.h"
#include "Output.h"
#include "Progress.h"
#include "encode/StateFile.h"
#include "encode/Training.h"

#include "openntc/encode/AdaptiveSearch.h"

#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <filesystem>

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
        if (job_.resume)
            state_ = ReadState(GetStatePath(job_.output));
        inputs_ = LoadInputs(job_.inputs);
        encode::EncodeOptions options = job_.training.encode;
        options.lossScales = inputs_.lossScales;
        options.maskChannel = job_.maskChannel.value_or(inputs_.maskChannel);
        if (options.discardMasked && options.maskChannel < 0)
            throw CommandError(ExitCode::Usage, "--discard-masked", "no channel is a mask: --mask-channel N");
        if (inputs_.material.GetWidth() == 1 || inputs_.material.GetHeight() == 1)
            inputs_.warnings.push_back(job_.output + ": size: a side of 1: LibNTC will refuse this file");
        for (const std::string& warning : inputs_.warnings)
            PrintWarning(warning, job_.json);

        EncodedFile file;
        file.result = job_.training.targetPsnr > 0.0 ? Search(options) : TrainOnce(options);
        WriteWholeFile(job_.output, {file.result.file});
        std::error_code ignored;
        std::filesystem::remove(GetStatePath(job_.output), ignored);
        file.channelCount = inputs_.material.GetChannelCount();
        file.declaredChannels = inputs_.material.GetDeclaredChannels();
        file.bytes = file.result.file.size();
        return file;
    }

private:
    encode::EncodeResult TrainOnce(encode::EncodeOptions options) {
        const bool resumes =
            job_.resume && (job_.training.targetPsnr <= 0.0 || options.latentShape == state_.latentShape);
        if (resumes) {
            options.resumeState = state_.bytes;
            options.resumeFraction = state_.fraction;
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
            WriteState(path, {result.latentShape, result.fraction, std::move(result.state)});
            throw CommandError(ExitCode::Failed, job_.output,
                               Format("interrupted at step %" PRIu64 ": state kept in %s: --resume continues",
                                      result.steps, path.c_str()));
        }
        return result;
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
            std::fprintf(stderr, "%sabout %.0f minutes on this machine; --seconds N ends within N seconds\n",
                         shown_ ? "\r\033[K" : "", std::ceil(progress.secondsLeft / 60.0));
    }

    void Show(const encode::Progress& progress) {
        ShowEstimate(progress);
        if (job_.quiet || (!job_.json && !IsTerminal()))
            return;
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

    const EncodeJob& job_;
    EncodeInputs inputs_;
    EncodeState state_;
    bool shown_ = false, estimated_ = false;
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
