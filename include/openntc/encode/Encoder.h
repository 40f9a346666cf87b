// SPDX-License-Identifier: MIT
// The encoder: from a material's texels to a texture-set file, on any processor.
#pragma once

#include "openntc/core/Stream.h"
#include "openntc/encode/EncodeOptions.h"
#include "openntc/encode/Material.h"
#include "openntc/encode/detail/AmxKernel.h"
#include "openntc/encode/detail/Avx2Kernel.h"
#include "openntc/encode/detail/FileAssembly.h"
#include "openntc/encode/detail/PortableKernel.h"
#include "openntc/encode/detail/Schedule.h"

#include <chrono>
#include <thread>

namespace openntc::encode {

namespace detail {

inline std::uint64_t GetEffortSteps(Effort effort) {
    switch (effort) {
    case Effort::Fast:
        return 6000;
    case Effort::Normal:
        return 400000;
    case Effort::Best:
        break;
    }
    return 2400000;
}

/// One run of training, from texels to bytes.
template <typename Kernel>
class EncodeRun {
public:
    EncodeRun(const Material& material, const EncodeOptions& options, const LatentShape& shape)
        : material_(material), options_(options), shape_(shape), team_(GetThreads(options)),
          set_(TrainingSet::Make(
              material.GetWidth(), material.GetHeight(), material.GetMipCount(),
              [&](int mip, int channel) { return material.GetPlane(mip, channel); },
              material.GetDeclaredChannels(), options.maskChannel, options.discardMasked,
              options.lossScales)),
          trainer_(set_, MakeShape(shape, options.networkVersion), options.seed, kBatchTiles, team_) {}

    Expected<EncodeResult> Run(const ProgressCallback& progress) {
        const auto steps = options_.steps > 0 ? options_.steps : GetEffortSteps(options_.effort);
        const bool timed = options_.steps == 0 && options_.seconds > 0.0;
        const bool trains = !set_.GetTrainedChannels().empty(); // constants need no training
        if (!options_.resumeState.empty() && !trainer_.Load(options_.resumeState))
            return Fail(Status::FileIncompatible, "state: %zu bytes: of another material, shape or network",
                        options_.resumeState.size());
        EncodeResult result;
        result.latentShape = shape_;
        const std::uint64_t firstStep = trainer_.GetStep();
        double lastReport = 0.0, resumed = 0.0;
        bool frozen = false, cancelled = false;
        trainer_.Save(snapshot_);
        if (timed && firstStep > 0)
            resumed = options_.resumeFraction;
        while (trains) {
            const double elapsed = Elapsed();
            double fraction = static_cast<double>(trainer_.GetStep()) / static_cast<double>(steps);
            if (timed) // the last hundredth is for evaluation and writing
                fraction = resumed + (1.0 - resumed) * elapsed / (options_.seconds * kTrainingShare);
            if (fraction >= 1.0)
                break;
            const double planned =
                timed ? static_cast<double>(trainer_.GetStep() + 1) / std::max(fraction, kSurestFraction)
                      : static_cast<double>(steps);
            StepSettings settings = Schedule::Make(planned).At(fraction);
            settings.networkRate *= caution_;
            settings.latentRate *= caution_;
            if (settings.latentRate == 0.0f && !frozen) {
                trainer_.FreezeLatents();
                frozen = true;
            }
            const LossSums loss = trainer_.Step(settings);
            const double psnr = loss.Psnr(set_.GetDeclaredCount());
            if (!(psnr > -200.0)) {
                OPENNTC_CHECK(Recover());
                continue;
            }
            if (trainer_.GetStep() % kSnapshotSteps == 0)
                trainer_.Save(snapshot_);
            average_ = average_ == 0.0 ? psnr : average_ + 0.02 * (psnr - average_);
            if (progress && elapsed - lastReport >= options_.reportSeconds) {
                lastReport = elapsed;
                const double done = static_cast<double>(trainer_.GetStep() - firstStep);
                Progress report;
                report.step = trainer_.GetStep();
                report.fraction = fraction;
                report.steps = timed ? static_cast<std::uint64_t>(static_cast<double>(report.step) /
                                                                  std::max(fraction, 1e-6))
                                     : steps;
                report.psnr = average_;
                report.seconds = elapsed;
                const double begun = static_cast<double>(firstStep) / static_cast<double>(steps);
                report.secondsLeft = timed ? options_.seconds - elapsed
                                           : elapsed * (1.0 - fraction) / std::max(fraction - begun, 1e-6);
                report.texelsPerSecond = done * kBatchTiles * kTileTexels / std::max(elapsed, 1e-6);
                if (!progress(report)) {
                    cancelled = true;
                    result.fraction = fraction;
                    break;
                }
            }
        }
        result.steps = trainer_.GetStep();
        result.seconds = Elapsed();
        result.texelsPerSecond = static_cast<double>(result.steps - firstStep) * kBatchTiles * kTileTexels /
                                 std::max(result.seconds, 1e-6);
        if (cancelled) {
            result.cancelled = true;
            trainer_.Save(result.state);
            return result;
        }
        trainer_.FreezeLatents();
        Measure(result);
        OPENNTC_CHECK(WriteFile(result));
        result.seconds = Elapsed();
        return result;
    }

private:
    static constexpr int kBatchTiles =
        32; ///< small batches learn more per texel; fewer than 4 per slice waste time
    static constexpr double kSurestFraction = 0.005; ///< before it the pace is not known
    static constexpr double kTrainingShare = 0.99;
    static constexpr std::uint64_t kSnapshotSteps = 2000;
    static constexpr int kMaxRecoveries = 8;

    static int GetThreads(const EncodeOptions& options) {
        const auto cores = static_cast<int>(std::thread::hardware_concurrency());
        return options.threads > 0 ? options.threads : std::max(cores, 1);
    }
    static TrainerShape MakeShape(const LatentShape& shape, int networkVersion) {
        TrainerShape trainer;
        trainer.network.highFeatures = shape.highResFeatures;
        trainer.network.lowFeatures = shape.lowResFeatures;
        trainer.network.highSlots = GetNetworkDescription(networkVersion).highResSlots;
        trainer.gridScale = shape.gridSizeScale;
        trainer.highBits = shape.highResQuantBits;
        trainer.lowBits = shape.lowResQuantBits;
        return trainer;
    }
    double Elapsed() const {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    }

    /// Goes back to the last good state with smaller steps.
    Expected<void> Recover() {
        if (++recoveries_ > kMaxRecoveries)
            return Fail(Status::InternalError, "training: diverged %d times: gives up", recoveries_);
        caution_ *= 0.5f;
        trainer_.Load(snapshot_);
        return {};
    }

    void Measure(EncodeResult& result) {
        LossSums total;
        for (int mip = 0; mip < set_.GetMipCount(); ++mip) {
            const LossSums sums = trainer_.Evaluate(mip);
            result.mipPsnr.push_back(sums.Psnr(set_.GetDeclaredCount()));
            total.Add(sums);
        }
        result.psnr = total.Psnr(set_.GetDeclaredCount());
        for (std::size_t c = 0; c < kMaxChannels; ++c)
            result.channelPsnr[c] = -10.0 * std::log10(total.perOutput[c] / total.texels);
        result.maskViolations = total.maskViolations;
    }

    Expected<void> WriteFile(EncodeResult& result) {
        MemoryStream stream;
        OPENNTC_CHECK(WriteTextureSet(trainer_, set_, material_, shape_, options_.networkVersion, stream));
        const auto bytes = stream.GetBytes();
        result.file.assign(bytes.begin(), bytes.end());
        return {};
    }

    const Material& material_;
    const EncodeOptions& options_;
    LatentShape shape_;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
    ThreadTeam team_;
    TrainingSet set_;
    Trainer<Kernel> trainer_;
    std::vector<std::byte> snapshot_;
    double average_ = 0.0;
    float caution_ = 1.0f;
    int recoveries_ = 0;
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
            return Run<detail::AmxKernel>(material, options, shape, progress, "amx-bf16");
#endif
#if defined(OPENNTC_ENCODE_AVX2)
        if ((choice == KernelChoice::Best || choice == KernelChoice::Avx2) && detail::IsAvx2Available())
            return Run<detail::Avx2Kernel>(material, options, shape, progress, "avx2");
#endif
        if (choice == KernelChoice::Amx || choice == KernelChoice::Avx2)
            return Fail(Status::Unsupported, "kernel: %s: this machine or build does not have it",
                        choice == KernelChoice::Amx ? "amx" : "avx2");
        return Run<detail::PortableKernel>(material, options, shape, progress, "portable");
    }

private:
    static constexpr int kMaxThreads = 256;

    template <typename Kernel>
    static Expected<EncodeResult> Run(const Material& material, const EncodeOptions& options,
                                      const LatentShape& shape, const ProgressCallback& progress,
                                      const char* name) {
        const auto run = std::make_unique<detail::EncodeRun<Kernel>>(material, options, shape);
        Expected<EncodeResult> result = run->Run(progress);
        if (result)
            result->kernel = name;
        return result;
    }
};

} // namespace openntc::encode
