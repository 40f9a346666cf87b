// SPDX-License-Identifier: MIT
// The encoder: from a material's texels to a texture-set file, on any processor.
#pragma once

#include "openntc/core/Stream.h"
#include "openntc/encode/EncodeOptions.h"
#include "openntc/encode/Material.h"
#include "openntc/encode/detail/AmxKernel.h"
#include "openntc/encode/detail/Avx2Kernel.h"
#include "openntc/encode/detail/FileAssembly.h"
#include "openntc/encode/detail/Fp8Kernel.h"
#include "openntc/encode/detail/PortableKernel.h"
#include "openntc/encode/detail/Schedule.h"

#include <chrono>
#include <memory>
#include <thread>

namespace openntc::encode {

namespace detail {

/// Two cores with AMX make 800 to 900 steps per second with the medium network: about 8 seconds, 8 minutes, 45 minutes.
inline std::uint64_t GetEffortSteps(Effort effort) {
    switch (effort) {
    case Effort::Fast:
        return 6000;
    case Effort::Normal:
        return 360000;
    case Effort::Best:
        break;
    }
    return 2200000;
}

/// A part of the training of one set, with its own trainer and schedule.
struct TrainingPhase {
    double begin = 0.0, end = 1.0; ///< fractions of the whole
    std::uint64_t steps = 0;       ///< planned, unless a time limit ends training
    bool latents = true;           ///< false: latents are given, only the network is trained
};

/// One run of training, from texels to bytes. Kernel trains latents and Int8 network, HeadKernel the FP8 network.
template <typename Kernel, typename HeadKernel>
class EncodeRun {
public:
    EncodeRun(const Material& material, const EncodeOptions& options, const LatentShape& shape)
        : material_(material), options_(options), shape_(shape), team_(GetThreads(options)),
          set_(TrainingSet::Make(
              material.GetWidth(), material.GetHeight(), material.GetMipCount(),
              [&](int mip, int channel) { return material.GetPlane(mip, channel); },
              material.GetDeclaredChannels(), options.maskChannel, options.discardMasked,
              options.lossScales)) {
        MakeTrainer(trainer_);
    }

    Expected<EncodeResult> Run(const ProgressCallback& progress) {
        progress_ = &progress;
        const auto steps = options_.steps > 0 ? options_.steps : GetEffortSteps(options_.effort);
        timed_ = options_.steps == 0 && options_.seconds > 0.0;
        if (!options_.resumeState.empty() && !trainer_->Load(options_.resumeState))
            return Fail(Status::FileIncompatible, "state: %zu bytes: of another material, shape or network",
                        options_.resumeState.size());
        EncodeResult& result = result_;
        result.latentShape = shape_;
        if (timed_ && trainer_->GetStep() > 0)
            resumed_ = std::clamp(options_.resumeFraction, 0.0, 1.0);
        std::uint64_t headSteps = 0;
        if (options_.fp8)
            headSteps = std::clamp<std::uint64_t>(steps / 10, 1, kMostHeadSteps);
        const std::uint64_t firstSteps = std::max(steps, headSteps + 1) - headSteps;
        double split = 1.0;
        if (options_.fp8)
            split = timed_ ? 1.0 - kHeadShare : static_cast<double>(firstSteps) / static_cast<double>(steps);
        OPENNTC_ASSIGN(bool finished, RunPhase(*trainer_, {0.0, split, firstSteps, true}));
        if (!finished) {
            trainer_->Save(result.state);
            return Finish();
        }
        trainer_->FreezeLatents();
        Measure();
        OPENNTC_ASSIGN(TrainedParts parts, CollectParts(*trainer_, set_, options_.networkVersion));
        if (options_.fp8) {
            OPENNTC_ASSIGN(finished, TrainHead(parts, {split, 1.0, headSteps, false}));
            if (!finished)
                return Finish();
        }
        MemoryStream stream;
        OPENNTC_CHECK(WriteTextureSet(parts, set_, material_, shape_, stream));
        const auto bytes = stream.GetBytes();
        result.file.assign(bytes.begin(), bytes.end());
        return Finish();
    }

private:
    static constexpr int kBatchTiles =
        32; ///< small batches learn more per texel; fewer than 4 per slice waste time
    static constexpr double kSurestFraction = 0.005; ///< before it the pace is not known
    static constexpr double kTrainingShare = 0.99;
    static constexpr double kHeadShare =
        0.1; ///< of the time that an FP8 network gets, or of the steps, up to
    static constexpr std::uint64_t kMostHeadSteps = 2000;
    static constexpr std::uint64_t kSnapshotSteps = 2000;
    static constexpr int kMaxRestarts = 8;
    static constexpr double kHighestPsnr = 150.0; ///< exact batches must not swamp the average
    static constexpr double kDivergence = 10.0;   ///< dB below the best average: training went astray

    static int GetThreads(const EncodeOptions& options) {
        const auto cores = static_cast<int>(std::thread::hardware_concurrency());
        return options.threads > 0 ? options.threads : std::max(cores, 1);
    }
    template <typename AnyKernel>
    void MakeTrainer(std::unique_ptr<Trainer<AnyKernel>>& trainer) {
        TrainerShape shape;
        shape.network.highFeatures = shape_.highResFeatures;
        shape.network.lowFeatures = shape_.lowResFeatures;
        shape.network.highSlots = GetNetworkDescription(options_.networkVersion).highResSlots;
        shape.gridScale = shape_.gridSizeScale;
        shape.highBits = shape_.highResQuantBits;
        shape.lowBits = shape_.lowResQuantBits;
        trainer = std::make_unique<Trainer<AnyKernel>>(set_, shape, options_.seed, kBatchTiles, team_);
    }
    double Elapsed() const {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    }

    /// Trains to the end of the phase; false when cancelled.
    template <typename AnyKernel>
    Expected<bool> RunPhase(Trainer<AnyKernel>& trainer, const TrainingPhase& phase) {
        if (set_.GetTrainedChannels().empty()) // constants need no training
            return true;
        std::vector<std::byte> snapshot;
        trainer.Save(snapshot);
        float caution = options_.rateScale;
        double average = 0.0, best = 0.0;
        bool begun = false, frozen = !phase.latents;
        const std::uint64_t firstStep = trainer.GetStep();
        for (;;) {
            const double elapsed = Elapsed();
            double fraction = static_cast<double>(trainer.GetStep()) / static_cast<double>(phase.steps);
            if (timed_) { // the last hundredth is for evaluation and writing
                const double whole =
                    resumed_ + (1.0 - resumed_) * elapsed / (options_.seconds * kTrainingShare);
                fraction = std::max(0.0, (whole - phase.begin) / (phase.end - phase.begin));
            }
            if (fraction >= 1.0)
                break;
            const double planned =
                timed_ ? static_cast<double>(trainer.GetStep() + 1) / std::max(fraction, kSurestFraction)
                       : static_cast<double>(phase.steps);
            StepSettings settings = phase.latents ? Schedule::Make(planned).At(fraction)
                                                  : Schedule::MakeNetworkOnly(planned).At(fraction);
            settings.networkRate *= caution;
            settings.latentRate *= caution;
            if (settings.latentRate == 0.0f && !frozen) {
                trainer.FreezeLatents();
                frozen = true;
            }
            const double psnr = std::min(trainer.Step(settings).Psnr(set_.GetDeclaredCount()), kHighestPsnr);
            ++stepsDone_;
            average = begun ? average + 0.02 * (psnr - average) : psnr;
            best = begun ? std::max(best, average) : average;
            begun = true;
            if (!(average > best - kDivergence)) { // also when it is not a number
                if (++result_.restarts > kMaxRestarts)
                    return Fail(Status::InternalError, "training: diverged %d times: gives up",
                                result_.restarts);
                caution *= 0.25f;
                begun = false;
                frozen = !phase.latents;
                trainer.Load(snapshot);
                continue;
            }
            if (trainer.GetStep() % kSnapshotSteps == 0 && average > best - 1.0)
                trainer.Save(snapshot);
            if (*progress_ && elapsed - lastReport_ >= options_.reportSeconds) {
                lastReport_ = elapsed;
                const double done = phase.begin + (phase.end - phase.begin) * fraction;
                const double before =
                    timed_ ? resumed_
                           : static_cast<double>(firstStep) / static_cast<double>(phase.steps) * phase.end;
                Progress report;
                report.step = trainer.GetStep();
                report.fraction = done;
                report.steps = static_cast<std::uint64_t>(static_cast<double>(trainer.GetStep()) /
                                                          std::max(fraction, 1e-6));
                report.psnr = average;
                report.seconds = elapsed;
                report.secondsLeft = timed_ ? options_.seconds - elapsed
                                            : elapsed * (1.0 - done) / std::max(done - before, 1e-6);
                report.texelsPerSecond =
                    static_cast<double>(stepsDone_) * kBatchTiles * kTileTexels / std::max(elapsed, 1e-6);
                if (!(*progress_)(report)) {
                    result_.cancelled = true;
                    result_.fraction = done;
                    result_.steps = trainer.GetStep();
                    return false;
                }
            }
        }
        result_.steps += trainer.GetStep();
        return true;
    }

    /// The FP8 network: starts from the Int8 network's weights, on latents that stay. A cancelled run keeps the state
    /// before it.
    Expected<bool> TrainHead(TrainedParts& parts, const TrainingPhase& phase) {
        trainer_->Save(result_.state);
        const NetworkState network = std::move(trainer_->GetNetwork());
        auto high = std::move(trainer_->GetHighGrids()), low = std::move(trainer_->GetLowGrids());
        trainer_.reset();
        std::unique_ptr<Trainer<HeadKernel>> head;
        MakeTrainer(head);
        head->StartFrom(network, high, low);
        const std::uint64_t steps = result_.steps;
        OPENNTC_ASSIGN(const bool finished, RunPhase(*head, phase));
        if (!finished) {
            result_.fraction = phase.begin;
            result_.steps = steps;
            return false;
        }
        result_.state.clear();
        LossSums total;
        for (int mip = 0; mip < set_.GetMipCount(); ++mip)
            total.Add(head->Evaluate(mip));
        result_.fp8Psnr = total.Psnr(set_.GetDeclaredCount());
        OPENNTC_CHECK(AddFp8Network(*head, set_, parts));
        return true;
    }

    void Measure() {
        EncodeResult& result = result_;
        LossSums total;
        for (int mip = 0; mip < set_.GetMipCount(); ++mip) {
            const LossSums sums = trainer_->Evaluate(mip);
            result.mipPsnr.push_back(sums.Psnr(set_.GetDeclaredCount()));
            total.Add(sums);
        }
        result.psnr = total.Psnr(set_.GetDeclaredCount());
        for (std::size_t c = 0; c < kMaxChannels; ++c)
            result.channelPsnr[c] = -10.0 * std::log10(total.perOutput[c] / total.texels);
        result.maskViolations = total.maskViolations;
    }

    EncodeResult Finish() {
        result_.seconds = Elapsed();
        result_.texelsPerSecond =
            static_cast<double>(stepsDone_) * kBatchTiles * kTileTexels / std::max(result_.seconds, 1e-6);
        return std::move(result_);
    }

    const Material& material_;
    const EncodeOptions& options_;
    LatentShape shape_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
    ThreadTeam team_;
    TrainingSet set_;
    std::unique_ptr<Trainer<Kernel>> trainer_;
    EncodeResult result_;
    const ProgressCallback* progress_ = nullptr;
    bool timed_ = false;
    double resumed_ = 0.0;    ///< fraction of the schedule that an earlier run did
    double lastReport_ = 0.0; ///< seconds
    std::uint64_t stepsDone_ = 0;
};

} // namespace detail

/// Encodes materials. No state: calls may run in parallel.
class Encoder {
public:
    /// Trains and returns the complete file. `progress` is called on the calling thread; when it returns
    /// false the result is marked cancelled and holds the state to resume from instead of a file. Errors:
    /// OutOfRange (shape, options), InvalidArgument (incomplete material), FileIncompatible (resume state),
    /// OutOfMemory.
    static Expected<EncodeResult> Encode(const Material& material, const EncodeOptions& options,
                                         const ProgressCallback& progress = {}) {
        return Dispatch(material, nullptr, options, progress);
    }
    /// The same, and frees the material's texels (Material::ReleaseTexels) before training, which keeps its own copy in
    /// 16 bits: a third of the memory stays in use.
    static Expected<EncodeResult> Encode(Material&& material, const EncodeOptions& options,
                                         const ProgressCallback& progress = {}) {
        return Dispatch(material, &material, options, progress);
    }

private:
    static constexpr int kMaxThreads = 256;

    /// `disposable`: null or `material`.
    static Expected<EncodeResult> Dispatch(const Material& material, Material* disposable,
                                           const EncodeOptions& options, const ProgressCallback& progress) {
        if (!material.IsComplete())
            return Fail(Status::InvalidArgument, "material: a channel lacks a mip: all are needed");
        if (options.networkVersion < NTC_NETWORK_SMALL || options.networkVersion > NTC_NETWORK_XLARGE)
            return Fail(Status::OutOfRange, "network: %d: must be 1 ... 4", options.networkVersion);
        if (options.maskChannel >= 0 && (options.maskChannel >= Material::kMaxChannels ||
                                         (material.GetDeclaredChannels() >> options.maskChannel & 1u) == 0))
            return Fail(Status::OutOfRange, "maskChannel: %d: belongs to no texture", options.maskChannel);
        if (options.threads < 0 || options.threads > kMaxThreads)
            return Fail(Status::OutOfRange, "threads: %d: must be 0 ... %d", options.threads, kMaxThreads);
        LatentShape shape = options.latentShape;
        if (shape.IsEmpty()) {
            OPENNTC_ASSIGN(const KnownLatentShape known,
                           PickLatentShape(options.bitsPerPixel, options.networkVersion));
            shape = known.shape;
        }
        OPENNTC_CHECK(ValidateLatentShape(shape, options.networkVersion));
        const KernelChoice choice = options.kernel;
#if defined(OPENNTC_ENCODE_AMX)
        if ((choice == KernelChoice::Best || choice == KernelChoice::Amx) && detail::IsAmxAvailable())
            return Run<detail::AmxKernel, detail::Fp8Avx2Kernel>(material, disposable, options, shape,
                                                                 progress, "amx-bf16");
#endif
#if defined(OPENNTC_ENCODE_AVX2)
        if ((choice == KernelChoice::Best || choice == KernelChoice::Avx2) && detail::IsAvx2Available())
            return Run<detail::Avx2Kernel, detail::Fp8Avx2Kernel>(material, disposable, options, shape,
                                                                  progress, "avx2");
#endif
        if (choice == KernelChoice::Amx || choice == KernelChoice::Avx2)
            return Fail(Status::Unsupported, "kernel: %s: this machine or build does not have it",
                        choice == KernelChoice::Amx ? "amx" : "avx2");
        return Run<detail::PortableKernel, detail::Fp8Kernel>(material, disposable, options, shape, progress,
                                                              "portable");
    }

    template <typename Kernel, typename HeadKernel>
    static Expected<EncodeResult> Run(const Material& material, Material* disposable,
                                      const EncodeOptions& options, const LatentShape& shape,
                                      const ProgressCallback& progress, const char* name) {
        const auto run = std::make_unique<detail::EncodeRun<Kernel, HeadKernel>>(material, options, shape);
        if (disposable != nullptr) // its texels are in the training set now
            disposable->ReleaseTexels();
        Expected<EncodeResult> result = run->Run(progress);
        if (result)
            result->kernel = name;
        return result;
    }
};

} // namespace openntc::encode
