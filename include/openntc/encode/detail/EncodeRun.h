// SPDX-License-Identifier: MIT
// Stability: internal
// One run of the encoder: phases of training, refinement of the latents between them, progress, and the file
// at the end.
#pragma once

#include "openntc/core/Stream.h"
#include "openntc/core/ThreadTeam.h"
#include "openntc/encode/EncodeOptions.h"
#include "openntc/encode/Kernels.h"
#include "openntc/encode/Material.h"
#include "openntc/encode/detail/FileAssembly.h"
#include "openntc/encode/detail/LastGoodState.h"
#include "openntc/encode/detail/LatentRefiner.h"
#include "openntc/encode/detail/RunClock.h"
#include "openntc/encode/detail/Schedule.h"
#include "openntc/encode/detail/StateSaver.h"
#include "openntc/encode/detail/TrainingPhase.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <type_traits>
#include <vector>

#include "openntc/core/HideMacros.h"

namespace openntc::encode::detail {

/// One training, from texels to bytes. Kernel: of latents and Int8 network; HeadKernel: of the FP8 network.
template <typename Kernel, typename HeadKernel>
class EncodeRun {
public:
    /// `options` and their kernel are those of this run.
    EncodeRun(const Material& material, const EncodeOptions& options, const LatentShape& shape)
        : material_(material), options_(options), shape_(shape), texels_(CountTexels(material)),
          clock_(options.seconds,
                 RefinementPlan::kForwardCost * texels_ *
                     (HasFp8Network(options) ? 2.0 : 1.0)), // both are evaluated
          team_(GetThreads(options)),
          set_(TrainingSet::Make(
              material.GetWidth(), material.GetHeight(), material.GetMipCount(),
              [&](int mip, int channel) { return material.GetPlane(mip, channel); },
              material.GetDeclaredChannels(), options.maskChannel, options.discardMasked,
              options.lossScales)) {
        MakeTrainer(trainer_);
    }

    /// Before Run. Errors: the device's.
    template <typename Device>
    Expected<void> Attach(Device& device) {
        kernel_ = device.GetKernelName();
        return trainer_->Attach(device);
    }

    Expected<EncodeResult> Run(const ProgressCallback& progress) {
        progress_ = &progress;
        timed_ = options_.steps == 0 && options_.seconds > 0.0;
        watches_ = options_.steps == 0 && !timed_;
        const auto steps = options_.steps > 0
                               ? options_.steps
                               : GetEffortSteps(options_.effort, texels_, set_.GetDeclaredCount());
        if (!options_.resumeState.empty() && !trainer_->Load(options_.resumeState))
            return Fail(Status::FileIncompatible,
                        "state: %zu bytes: of another material, shape, network or kernel",
                        options_.resumeState.size());
        EncodeResult& result = result_;
        result.latentShape = shape_;
        if (timed_ && trainer_->GetStep() > 0)
            resumed_ = std::clamp(options_.resumeFraction, 0.0, 1.0);
        std::uint64_t headSteps = 0;
        if (HasFp8Network(options_))
            headSteps = std::clamp<std::uint64_t>(steps / 10, 1, kMostHeadSteps);
        const std::uint64_t firstSteps = std::max(steps, headSteps + 1) - headSteps;
        double split = 1.0;
        if (HasFp8Network(options_))
            split = timed_ ? 1.0 - kHeadShare : static_cast<double>(firstSteps) / static_cast<double>(steps);
        OPENNTC_ASSIGN(bool finished, RunPhase(*trainer_, {0.0, split, firstSteps, true}));
        if (!finished) {
            trainer_->Save(result.state);
            return Finish();
        }
        trainer_->FreezeLatents();
        Measure();
        OPENNTC_ASSIGN(TrainedParts parts, CollectParts(*trainer_, set_, options_.networkVersion));
        if (HasFp8Network(options_)) {
            OPENNTC_ASSIGN(finished, TrainHead(parts, {split, 1.0, headSteps, false}));
            if (!finished)
                return Finish();
        }
        MemoryStream stream;
        OPENNTC_CHECK(WriteTextureSet(parts, set_, material_, shape_, options_.compress, stream));
        const auto bytes = stream.GetBytes();
        result.file.assign(bytes.begin(), bytes.end());
        return Finish();
    }

private:
    static constexpr int kStepTexels = 4096; ///< that steps are counted in, and of a step of the FP8 network
    static constexpr double kSurestFraction = 0.005; ///< before it the pace is not known
    /// Of the time that an FP8 network gets; of the steps a tenth, up to kMostHeadSteps: more end no better
    /// (docs/encoder.md).
    static constexpr double kHeadShare = 0.05;
    static constexpr std::uint64_t kMostHeadSteps = 1000;
    static constexpr int kMaxRestarts = 8;
    static constexpr double kFewMoves =
        0.005; ///< of the latents: a last round that keeps fewer moves per sweep ends
    static constexpr std::uint64_t kRefined = ~std::uint64_t{0}; ///< number of rounds after the last

    template <typename AnyKernel>
    void MakeTrainer(std::unique_ptr<Trainer<AnyKernel>>& trainer) {
        const TrainerShape shape = MakeTrainerShape(shape_, options_.networkVersion);
        const int wanted = std::is_same_v<AnyKernel, Kernel> ? options_.batchTexels : kStepTexels;
        const int texels = Trainer<AnyKernel>::ChooseBatchTexels(wanted, texels_, shape.network.blended);
        result_.batchTexels = std::is_same_v<AnyKernel, Kernel> ? texels : result_.batchTexels;
        trainer =
            std::make_unique<Trainer<AnyKernel>>(set_, shape, options_.seed, texels / kTileTexels, team_);
    }

    /// Trains to the end of the phase; false when cancelled.
    template <typename AnyKernel>
    Expected<bool> RunPhase(Trainer<AnyKernel>& trainer, const TrainingPhase& phase) {
        if (set_.GetTrainedChannels().empty()) // constants need no training
            return true;
        LastGoodState good;
        good.Take(trainer, GetWhole(trainer, phase), saver_);
        float caution = options_.rateScale;
        bool frozen = !phase.latents;
        curve_ = {};
        PlanRefinement(phase, static_cast<double>(phase.steps));
        clock_.BeginTraining();
        if (phase.begin == 0.0)
            firstWork_ = timed_ ? resumed_ : phase.end * GetWork(trainer, GetFraction(trainer, phase));
        for (;;) {
            const double fraction = GetFraction(trainer, phase);
            if (fraction >= 1.0)
                break;
            const double planned =
                timed_ ? (GetSteps(trainer) + GetUnits(trainer)) / std::max(fraction, kSurestFraction)
                       : static_cast<double>(phase.steps);
            if (timed_ && !frozen)
                PlanRefinement(phase, planned);
            const double batches = planned / GetUnits(trainer);
            const Schedule schedule = phase.latents
                                          ? Schedule::Make(batches, trainer.GetNetworkShape().blended)
                                          : Schedule::MakeNetworkOnly(batches);
            StepSettings settings = schedule.At(fraction);
            settings.networkRate *= caution;
            settings.latentRate *= caution;
            if (settings.latentRate == 0.0f && !frozen) {
                trainer.FreezeLatents();
                frozen = true;
            }
            const std::uint64_t round = trainer.GetRefinement().rounds;
            if (phase.latents && frozen && round < plan_.rounds &&
                fraction >= plan_.GetDue(round, schedule.freeze)) {
                good.Take(trainer, GetWhole(trainer, phase), saver_);
                if (!Refine(trainer, phase, plan_.passesPerRound)) {
                    good.Restore(trainer);
                    return Cancel(trainer, phase);
                }
                continue; // time has passed
            }
            const LossSums loss = trainer.Step(settings);
            OPENNTC_CHECK(good.CheckDevice(trainer, options_, saver_));
            clock_.CountTexels(trainer.GetBatchTexels());
            if (loss.texels > 0.0) { // a device tells later
                const double psnr = loss.Psnr(set_.GetDeclaredCount());
                if (watches_ && !frozen)
                    trainer.GetWatch().Add(std::min(psnr, QualityCurve::kHighest), fraction, batches);
                curve_.Add(psnr);
            }
            if (curve_.HasDiverged()) {
                if (++result_.restarts > kMaxRestarts)
                    return Fail(Status::InternalError, "training: diverged %d times: gives up",
                                result_.restarts);
                caution *= 0.25f;
                curve_.begun = false;
                frozen = !phase.latents;
                good.Restore(trainer);
                continue;
            }
            if (trainer.GetStep() % Trainer<AnyKernel>::kSnapshotSteps == 0 && curve_.IsGood())
                good.Take(trainer, GetWhole(trainer, phase), saver_);
            if (!Report(trainer, phase))
                return Cancel(trainer, phase);
            if (phase.latents) // the FP8 network's training is short and has no state
                saver_.SaveWhenDue(trainer, clock_.GetElapsed(), phase.GetWhole(fraction));
        }
        if (phase.latents && trainer.GetRefinement().rounds != kRefined) {
            trainer.FreezeLatents();
            good.Take(trainer, GetWhole(trainer, phase), saver_);
            if (!Refine(trainer, phase, plan_.lastPasses)) {
                good.Restore(trainer);
                return Cancel(trainer, phase);
            }
            OPENNTC_CHECK(good.CheckDevice(trainer, options_, saver_));
            trainer.GetRefinement().rounds = kRefined;
        }
        result_.steps += static_cast<std::uint64_t>(GetSteps(trainer));
        return true;
    }

    /// Steps of kStepTexels in a step of a trainer, and those that it has made.
    template <typename AnyKernel>
    static double GetUnits(const Trainer<AnyKernel>& trainer) {
        return static_cast<double>(trainer.GetBatchTexels()) / kStepTexels;
    }
    template <typename AnyKernel>
    static double GetSteps(const Trainer<AnyKernel>& trainer) {
        return static_cast<double>(trainer.GetStep()) * GetUnits(trainer);
    }

    template <typename AnyKernel>
    double GetWhole(const Trainer<AnyKernel>& trainer, const TrainingPhase& phase) const {
        return phase.GetWhole(GetFraction(trainer, phase));
    }

    /// Of the phase's schedule, 0 ... 1. Refinement takes time, but is no part of the schedule.
    template <typename AnyKernel>
    double GetFraction(const Trainer<AnyKernel>& trainer, const TrainingPhase& phase) const {
        if (!timed_)
            return (GetSteps(trainer) + trainer.GetWatch().skipped * GetUnits(trainer)) /
                   static_cast<double>(phase.steps);
        const double elapsed = clock_.GetElapsed();
        const double seconds =
            phase.latents ? (elapsed - clock_.GetRefining()) * (1.0 + refineShare_) : elapsed;
        const double whole = resumed_ + (1.0 - resumed_) * seconds / clock_.GetTrainingLimit();
        const double fraction = std::max(0.0, (whole - phase.begin) / (phase.end - phase.begin));
        return phase.latents ? fraction
                             : std::max(fraction, GetSteps(trainer) / static_cast<double>(kMostHeadSteps));
    }
    void PlanRefinement(const TrainingPhase& phase, double steps) {
        plan_ = {};
        refineShare_ = 0.0;
        if (!phase.latents)
            return;
        const double trained = steps * kStepTexels;
        const auto sweep = LatentMove::CountOfSweep(trainer_->GetNetworkShape());
        plan_ = RefinementPlan::Make(trained, texels_, static_cast<std::uint64_t>(sweep));
        refineShare_ =
            static_cast<double>(plan_.GetPasses()) * texels_ * RefinementPlan::kForwardCost / trained;
    }

    template <typename AnyKernel>
    bool Cancel(const Trainer<AnyKernel>& trainer, const TrainingPhase& phase) {
        result_.cancelled = true;
        result_.fraction = GetWhole(trainer, phase);
        result_.steps = static_cast<std::uint64_t>(GetSteps(trainer));
        return false;
    }

    /// FP8 networks take the latents as they are.
    static bool Refine(const Trainer<HeadKernel>&, const TrainingPhase&, std::uint64_t) { return true; }
    /// A round of refinement; false when cancelled within.
    bool Refine(Trainer<Kernel>& trainer, const TrainingPhase& phase, std::uint64_t passes) {
        const double begin = clock_.GetElapsed(), before = clock_.GetRefining();
        RefinementCounts& counts = trainer.GetRefinement();
        const double allowed = GetRefineSeconds(phase, counts.rounds);
        if (!refiner_)
            refiner_.emplace(trainer);
        refiner_->Measure(static_cast<float>(Schedule::kLastMaskPush));
        const NetworkShape& shape = trainer.GetNetworkShape();
        const auto sweep = static_cast<std::uint64_t>(LatentMove::CountOfSweep(shape));
        std::uint64_t kept = 0;
        for (std::uint64_t pass = 0; pass < passes; ++pass) {
            const double spent = clock_.GetElapsed() - begin;
            if (timed_ && before + spent * (1.0 + 1.0 / static_cast<double>(pass + 1)) > allowed)
                break;
            kept += refiner_->Try(LatentMove::Get(shape, counts.passes++));
            clock_.SetRefining(before + (clock_.GetElapsed() - begin));
            if (!Report(trainer, phase))
                return false;
            if ((pass + 1) % sweep == 0) {
                if (static_cast<double>(kept) < kFewMoves * static_cast<double>(trainer.GetLatentCount()))
                    break;
                kept = 0;
            }
        }
        ++counts.rounds;
        return true;
    }
    /// Time that refinement may have taken at the end of a round.
    double GetRefineSeconds(const TrainingPhase& phase, std::uint64_t round) const {
        const double all = clock_.GetTrainingLimit() * (1.0 - resumed_) * (phase.end - phase.begin) *
                           refineShare_ / (1.0 + refineShare_);
        const std::uint64_t passes =
            round >= plan_.rounds ? plan_.GetPasses() : (round + 1) * plan_.passesPerRound;
        return all * static_cast<double>(passes) /
               static_cast<double>(std::max<std::uint64_t>(plan_.GetPasses(), 1));
    }

    /// Share of the phase's work that is done, where refinement counts.
    template <typename AnyKernel>
    double GetWork(Trainer<AnyKernel>& trainer, double fraction) const {
        if (timed_ || plan_.GetPasses() == 0)
            return fraction;
        const double refined =
            static_cast<double>(trainer.GetRefinement().passes) / static_cast<double>(plan_.GetPasses());
        return (fraction + refineShare_ * std::min(refined, 1.0)) / (1.0 + refineShare_);
    }
    /// Calls the progress callback when it is time to; false to cancel.
    template <typename AnyKernel>
    bool Report(Trainer<AnyKernel>& trainer, const TrainingPhase& phase) {
        const double elapsed = clock_.GetElapsed();
        if (!*progress_ || elapsed - lastReport_ < options_.reportSeconds)
            return true;
        lastReport_ = elapsed;
        const double fraction = std::min(GetFraction(trainer, phase), 1.0);
        const double work = phase.begin + (phase.end - phase.begin) * GetWork(trainer, fraction);
        Progress report;
        report.step = static_cast<std::uint64_t>(GetSteps(trainer));
        report.fraction = work;
        report.steps =
            timed_ ? static_cast<std::uint64_t>(GetSteps(trainer) / std::max(fraction, 1e-6))
                   : phase.steps - static_cast<std::uint64_t>(trainer.GetWatch().skipped * GetUnits(trainer));
        report.psnr = curve_.average;
        report.seconds = elapsed;
        report.secondsLeft = timed_ ? options_.seconds - elapsed
                                    : clock_.GetTraining() * (1.0 - work) / std::max(work - firstWork_, 1e-6);
        report.texelsPerSecond = clock_.GetPace();
        report.kernel = kernel_;
        report.threads = team_.GetThreadCount();
        return (*progress_)(report);
    }
    /// The FP8 network: starts from the Int8 network's weights, on latents that stay. A cancelled run keeps
    /// the state before it.
    Expected<bool> TrainHead(TrainedParts& parts, const TrainingPhase& phase) {
        trainer_->Save(result_.state);
        const NetworkState network = std::move(trainer_->GetNetwork());
        auto high = std::move(trainer_->GetHighGrids()), low = std::move(trainer_->GetLowGrids());
        refiner_.reset();
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
            result.channelPsnr[c] = total.ChannelPsnr(static_cast<int>(c));
        result.maskViolations = total.maskViolations;
    }

    EncodeResult Finish() {
        result_.seconds = clock_.GetElapsed();
        result_.texelsPerSecond = clock_.GetPace();
        result_.kernel = kernel_;
        return std::move(result_);
    }

    const Material& material_;
    const EncodeOptions& options_;
    const char* kernel_ = KernelToString(options_.kernel);
    LatentShape shape_;
    double texels_; ///< of all mips
    RunClock clock_;
    ThreadTeam team_;
    TrainingSet set_;
    std::unique_ptr<Trainer<Kernel>> trainer_;
    std::optional<LatentRefiner<Kernel>> refiner_;
    RefinementPlan plan_;
    double refineShare_ = 0.0; ///< planned time of refinement, as a part of the time of training
    QualityCurve curve_;       ///< of recent batches
    double firstWork_ = 0.0;   ///< share of the work that was done before this run
    EncodeResult result_;
    const ProgressCallback* progress_ = nullptr;
    bool timed_ = false;      ///< ends by time
    bool watches_ = false;    ///< ends sooner where quality no longer grows
    double resumed_ = 0.0;    ///< fraction of the schedule that an earlier run did
    double lastReport_ = 0.0; ///< seconds
    StateSaver saver_{options_};
};

} // namespace openntc::encode::detail

#include "openntc/core/RestoreMacros.h"
