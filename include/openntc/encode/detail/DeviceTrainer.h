// SPDX-License-Identifier: MIT
// Stability: internal
// The trainer whose steps are made by a device. It has a trainer of the processor, which chooses the
// batches and holds the state between calls; what the device does to it is read back when somebody wants to
// see it.
#pragma once

#include "openntc/encode/TrainingDevice.h"
#include "openntc/encode/UsefulSteps.h"
#include "openntc/encode/detail/DeviceTables.h"
#include "openntc/encode/detail/LatentRefiner.h"
#include "openntc/encode/detail/SubmissionPace.h"

#include <deque>

#include "openntc/core/HideMacros.h"

namespace openntc::encode::detail {

/// Names the trainer of a device. Mirror: kernel of the processor that evaluates what was trained.
template <typename Mirror>
struct DeviceKernel {};

template <typename Mirror>
class Trainer<DeviceKernel<Mirror>> {
public:
    /// As of every trainer; Attach comes before anything else.
    Trainer(const TrainingSet& set, const TrainerShape& shape, std::uint32_t seed, int batchTiles,
            ThreadTeam& team)
        : mirror_(set, shape, seed, batchTiles, team) {}

    /// `device` outlives the trainer. Errors: those of the device.
    Expected<void> Attach(TrainingDevice& device) {
        device_ = &device;
        const TrainingSet& set = mirror_.set_;
        tables_ = DeviceTables::Make(set, mirror_.context_, mirror_.network_.smallestScale, mirror_.mips_,
                                     mirror_.high_, mirror_.low_);
        const auto strips = static_cast<std::uint32_t>(mirror_.batchTiles_ * NTC_TRAIN_STRIPS_OF_TILE);
        groups_ = std::min(strips, kMostGroups);
        while (strips % groups_ != 0)
            --groups_;
        streams_ = set.GetReferences().size_bytes() > device.GetLargestBuffer();
        Expected<void> created = device.Create(MakePlan());
        if (!created && created.error().GetStatus() == Status::OutOfMemory && !streams_) {
            streams_ = true;
            created = device.Create(MakePlan());
        }
        OPENNTC_CHECK(created);
        const auto write = [&](TrainingBuffer buffer, const auto& list) {
            return device.Write(buffer, 0, std::as_bytes(std::span(list)));
        };
        OPENNTC_CHECK(
            device.Write(TrainingBuffer::Constants, 0, std::as_bytes(std::span(&tables_.constants, 1))));
        OPENNTC_CHECK(write(TrainingBuffer::Mips, tables_.mips));
        OPENNTC_CHECK(write(TrainingBuffer::Taps, tables_.taps));
        OPENNTC_CHECK(write(TrainingBuffer::Tiles, tables_.tiles));
        OPENNTC_CHECK(write(TrainingBuffer::Ranges, tables_.ranges));
        if (!streams_)
            OPENNTC_CHECK(write(TrainingBuffer::References, set.GetReferences()));
        packed_ = DeviceNetwork::Make(mirror_.network_);
        return PushAll();
    }
    /// Of the device; nothing that was trained after it counts.
    const Expected<void>& GetStatus() const { return status_; }

    static constexpr std::uint64_t kSnapshotSteps =
        20000; ///< reading a state back takes as long as hundreds of steps

    double GetPasses(double steps) const { return mirror_.GetPasses(steps); }
    static int ChooseBatchTexels(int wanted, double texels, bool) {
        return wanted > 0 ? wanted : GetDeviceBatchTexels(texels);
    }
    int GetBatchTexels() const { return mirror_.batchTiles_ * kTileTexels; }
    std::uint64_t GetStep() const { return mirror_.GetStep(); }
    NetworkState& GetNetwork() {
        Pull();
        return mirror_.GetNetwork();
    }
    const NetworkShape& GetNetworkShape() const { return mirror_.GetNetworkShape(); }
    std::vector<LatentPlanes>& GetHighGrids() { return Synchronised().GetHighGrids(); }
    std::vector<LatentPlanes>& GetLowGrids() { return Synchronised().GetLowGrids(); }
    const std::vector<MipGeometry>& GetMips() const { return mirror_.GetMips(); }
    const TrainingSet& GetSet() const { return mirror_.GetSet(); }
    const char* GetKernelName() const { return device_->GetKernelName(); }
    CurveWatch& GetWatch() { return mirror_.GetWatch(); }
    const CurveWatch& GetWatch() const { return mirror_.GetWatch(); }
    RefinementCounts& GetRefinement() { return mirror_.GetRefinement(); }
    std::size_t GetLatentCount() const { return mirror_.GetLatentCount(); }
    /// With the state as it is on the device. Latents that are changed in it are taken up by the next step.
    Trainer<Mirror>& Synchronised() {
        Pull();
        changed_ = true;
        return mirror_;
    }
    LossSums Evaluate(int mip) {
        Pull();
        return mirror_.Evaluate(mip);
    }
    /// Of the mirror, for what comes after training.
    void PackNetwork() {
        Pull();
        mirror_.PackNetwork();
    }
    void FreezeLatents() { Synchronised().FreezeLatents(); }

    /// Hands a step to the device. Returns the squared errors of the step kLag steps before, or no texels.
    LossSums Step(const StepSettings& settings) {
        if (changed_)
            Check(PushLatents());
        if (status_)
            Record(settings);
        if (status_ && pending_.size() >= pace_.GetSteps() * kPassesPerStep)
            Submit();
        if (!status_ || losses_.size() <= kLag)
            return {};
        while (status_ && !losses_.front().known)
            Collect();
        const LossSums loss = losses_.front().sums;
        losses_.pop_front();
        return loss;
    }

    /// An empty state after an error. The device's working weights are part of the state: the processor's
    /// might differ from them in a rounding.
    void Save(std::vector<std::byte>& state) {
        Pull();
        state.clear();
        if (!status_)
            return;
        mirror_.Save(state);
        KeptLosses kept = MakeKept();
        for (const Loss& loss : losses_)
            kept.sums[kept.count++] = loss.sums;
        for (const auto bytes : {std::as_bytes(std::span(packed_.weights)),
                                 std::as_bytes(std::span(packed_.rows)), std::as_bytes(std::span(&kept, 1))})
            state.insert(state.end(), bytes.begin(), bytes.end());
    }
    bool Load(std::span<const std::byte> state) {
        KeptLosses kept{};
        const auto weights = std::as_writable_bytes(std::span(packed_.weights)),
                   rows = std::as_writable_bytes(std::span(packed_.rows));
        const std::size_t tail = weights.size() + rows.size() + sizeof(kept);
        if (state.size() < tail)
            return false;
        std::memcpy(&kept, state.data() + state.size() - sizeof(kept), sizeof(kept));
        if (kept.count > kLag || std::memcmp(kept.kernel, MakeKept().kernel, sizeof(kept.kernel)) != 0)
            return false;
        Finish();
        if (!mirror_.Load(state.first(state.size() - tail)))
            return false;
        std::memcpy(weights.data(), state.data() + state.size() - tail, weights.size());
        std::memcpy(rows.data(), state.data() + state.size() - tail + weights.size(), rows.size());
        stale_ = false;
        losses_.clear();
        for (std::size_t i = 0; i < kept.count; ++i)
            losses_.push_back({kept.sums[i], 0, true});
        Check(PushAll());
        return true;
    }

private:
    friend class LatentRefiner<DeviceKernel<Mirror>>;

    std::uint32_t GetStreaming() const { return streams_ ? NTC_TRAIN_STREAMED : 0u; }

    static constexpr std::uint32_t kRefinedTiles = 8192; ///< of a dispatch of refinement: a million texels
    static constexpr std::uint32_t kMostGroups = 128;    ///< more leave more sums to add, and gain nothing
    /// Steps whose errors are not waited for, whatever the device's pace, so that it does not matter for
    /// the result.
    static constexpr std::size_t kLag = 64;
    static constexpr std::size_t kMostSteps = kLag / 2; ///< of a submission

    struct Loss {
        LossSums sums;          ///< perOutput is missing until it is known
        std::uint32_t slot = 0; ///< of TrainingBuffer::Losses
        bool known = false;
    };
    /// End of a state.
    struct KeptLosses {
        char kernel[16] = {}; ///< that made it
        std::uint64_t count = 0;
        LossSums sums[kLag]{};
    };

    void Check(const Expected<void>& result) {
        if (status_ && !result)
            status_ = result;
    }

    KeptLosses MakeKept() const {
        KeptLosses kept{};
        std::strncpy(kept.kernel, device_->GetKernelName(), sizeof(kept.kernel) - 1);
        return kept;
    }

    TrainingPlan MakePlan() const {
        DeviceNeeds needs;
        needs.network = GetNetworkShape();
        needs.batchTiles = static_cast<std::uint64_t>(mirror_.batchTiles_) * kMostSteps;
        needs.groups = groups_;
        needs.slots = kSlots + 1;
        needs.references =
            streams_
                ? std::max<std::uint64_t>(needs.batchTiles,
                                          std::min<std::uint64_t>(kRefinedTiles, tables_.tiles.size() / 2)) *
                      GetReferences(0, 1).size_bytes()
                : mirror_.set_.GetReferences().size_bytes();
        return needs.MakePlan(tables_);
    }
    /// Of tiles one after the other.
    std::span<const std::uint16_t> GetReferences(std::size_t tile, std::size_t tiles) const {
        const std::span<const std::uint16_t> all = mirror_.set_.GetReferences();
        const std::size_t one = all.size() / (tables_.tiles.size() / 2);
        return all.subspan(tile * one, tiles * one);
    }

    void Record(const StepSettings& settings) {
        NtcTrainStep step{};
        step.firstTile = static_cast<std::uint32_t>(batch_.size());
        step.tiles = static_cast<std::uint32_t>(mirror_.batchTiles_);
        step.groups = groups_;
        step.strips = step.tiles * NTC_TRAIN_STRIPS_OF_TILE / groups_;
        step.lossSlot = nextSlot_;
        nextSlot_ = (nextSlot_ + 1) % kSlots;
        step.noise = mirror_.GetNoise();
        step.flags = (settings.latentMode == LatentMode::Round ? NTC_TRAIN_ROUND : 0u) |
                     (settings.latentRate > 0.0f ? NTC_TRAIN_LATENTS : 0u) |
                     (settings.networkRate > 0.0f ? NTC_TRAIN_NETWORK : 0u) | GetStreaming();
        step.maskPush = settings.maskPush;
        const OptimiserSteps optimiser = mirror_.MakeOptimiserSteps(settings);
        step.networkRate = optimiser.network.rate;
        step.networkSecond = optimiser.network.secondCorrection;
        step.networkBeta2 = optimiser.network.beta2;
        step.latentRate = optimiser.latents.rate;
        step.latentSecond = optimiser.latents.secondCorrection;
        step.latentBeta2 = optimiser.latents.beta2;
        Loss& loss = losses_.emplace_back();
        loss.slot = step.lossSlot;
        for (std::uint32_t i = 0; i < step.tiles; ++i) {
            const int tile = mirror_.NextTile();
            batch_.push_back(static_cast<std::uint32_t>(tile));
            if (streams_) {
                const auto references = GetReferences(static_cast<std::size_t>(tile), 1);
                references_.insert(references_.end(), references.begin(), references.end());
            }
            const TileRecord& record = mirror_.set_.GetTile(tile);
            const MipGeometry& mip = mirror_.mips_[static_cast<std::size_t>(record.mip)];
            loss.sums.texels +=
                std::min(kTileWidth, mip.width - record.x) * std::min(kTileHeight, mip.height - record.y);
        }
        pending_.push_back({TrainingPass::TrainTexels, step, groups_});
        const std::uint32_t tiles = settings.latentRate > 0.0f ? step.tiles : 0u;
        pending_.push_back({TrainingPass::TrainUpdate, step, NTC_TRAIN_COLUMNS + tiles});
        ++mirror_.step_;
        stale_ = true;
    }

    void Submit() {
        if (pending_.empty() || !status_)
            return;
        while (status_ && pace_.CountUnderWay() >= SubmissionPace::kInFlight)
            Collect();
        pace_.Begin(pending_.size() / kPassesPerStep);
        if (status_)
            Check(device_->Submit(batch_, references_, pending_));
        ++submitted_;
        pending_.clear();
        batch_.clear();
        references_.clear();
    }

    /// Waits for the oldest submission and reads its errors.
    void Collect() {
        if (pace_.CountUnderWay() == 0)
            Submit();
        if (pace_.CountUnderWay() == 0 || !status_)
            return;
        const std::size_t steps = pace_.Take();
        Check(device_->Wait(submitted_ - pace_.CountUnderWay()));
        if (!status_)
            return;
        pace_.End();
        auto loss = std::find_if(losses_.begin(), losses_.end(), [](const Loss& l) { return !l.known; });
        for (std::size_t i = 0; i < steps && status_; ++i, ++loss) {
            float sums[kOutputs];
            Check(device_->Read(TrainingBuffer::Losses, std::uint64_t{loss->slot} * sizeof(sums),
                                std::as_writable_bytes(std::span(sums))));
            for (std::size_t o = 0; o < kOutputs; ++o)
                loss->sums.perOutput[o] = static_cast<double>(sums[o]);
            loss->known = true;
        }
    }

    /// Nothing is under way afterwards.
    void Finish() {
        Submit();
        while (status_ && pace_.CountUnderWay() > 0)
            Collect();
    }

    /// visit(buffer, offset in bytes, array) for all that changes in training.
    template <typename Visit>
    Expected<void> VisitState(const Visit& visit) {
        OPENNTC_CHECK(VisitLatents(TrainingBuffer::Latents, &LatentPlanes::values, visit));
        OPENNTC_CHECK(VisitLatents(TrainingBuffer::FirstMoments, &LatentPlanes::first, visit));
        OPENNTC_CHECK(VisitLatents(TrainingBuffer::SecondMoments, &LatentPlanes::second, visit));
        NetworkState& network = mirror_.network_;
        std::uint64_t offset = 0;
        for (const std::span<float> part :
             {std::span(network.weights.data(), network.weights.size()),
              std::span(network.first.data(), network.first.size()),
              std::span(network.second.data(), network.second.size()), std::span<float>(network.biases),
              std::span<float>(network.firstBias), std::span<float>(network.secondBias)}) {
            OPENNTC_CHECK(visit(TrainingBuffer::Network, offset, std::as_writable_bytes(part)));
            offset += part.size_bytes();
        }
        OPENNTC_CHECK(visit(TrainingBuffer::Weights, 0, std::as_writable_bytes(std::span(packed_.weights))));
        return visit(TrainingBuffer::Rows, 0, std::as_writable_bytes(std::span(packed_.rows)));
    }
    template <typename Visit>
    Expected<void> VisitLatents(TrainingBuffer buffer, AlignedBuffer<float> LatentPlanes::*member,
                                const Visit& visit) {
        std::uint64_t offset = 0;
        for (auto* grids : {&mirror_.high_, &mirror_.low_}) {
            for (LatentPlanes& grid : *grids) {
                const std::span part((grid.*member).data(), (grid.*member).size());
                OPENNTC_CHECK(visit(buffer, offset, std::as_writable_bytes(part)));
                offset += part.size_bytes();
            }
        }
        return {};
    }
    auto GetWriter() {
        return [this](TrainingBuffer buffer, std::uint64_t offset, std::span<std::byte> part) {
            return device_->Write(buffer, offset, part);
        };
    }

    /// The device's state to the mirror. Nothing is under way afterwards.
    void Pull() {
        Finish();
        if (!stale_ || !status_)
            return;
        Check(VisitState([&](TrainingBuffer buffer, std::uint64_t offset, std::span<std::byte> part) {
            return device_->Read(buffer, offset, part);
        }));
        stale_ = false;
    }
    Expected<void> PushAll() {
        changed_ = false;
        return VisitState(GetWriter());
    }
    Expected<void> PushLatents() {
        changed_ = false;
        return VisitLatents(TrainingBuffer::Latents, &LatentPlanes::values, GetWriter());
    }

    /// The network as the file will have it.
    Expected<void> PushNetwork() {
        PackNetwork();
        packed_ = DeviceNetwork::Make(mirror_.network_);
        OPENNTC_CHECK(device_->Write(TrainingBuffer::Weights, 0, std::as_bytes(std::span(packed_.weights))));
        return device_->Write(TrainingBuffer::Rows, 0, std::as_bytes(std::span(packed_.rows)));
    }
    /// Runs dispatches that read references from `tile` on, with nothing else under way, and waits.
    Expected<void> Run(std::span<const TrainingDispatch> dispatches, std::size_t tile, std::size_t tiles) {
        OPENNTC_CHECK(device_->Submit(
            {}, streams_ ? GetReferences(tile, tiles) : std::span<const std::uint16_t>(), dispatches));
        return device_->Wait(++submitted_);
    }

    static constexpr std::size_t kPassesPerStep = 2;
    static constexpr std::uint32_t kSlots = 4 * kLag; ///< and one for counts

    Trainer<Mirror> mirror_;
    TrainingDevice* device_ = nullptr;
    DeviceTables tables_;
    DeviceNetwork packed_;     ///< as the device has it, where the mirror is not stale
    std::uint32_t groups_ = 1; ///< workgroups of a batch
    Expected<void> status_;
    bool changed_ = false;                  ///< the mirror's latents, since the device has been given them
    bool stale_ = false;                    ///< the mirror, since the device has made steps
    bool streams_ = false;                  ///< references come with each submission
    std::vector<std::uint32_t> batch_;      ///< tiles of the steps in pending_
    std::vector<std::uint16_t> references_; ///< of them, where they are streamed
    std::vector<TrainingDispatch> pending_;
    SubmissionPace pace_{kMostSteps};
    std::uint64_t submitted_ = 0;
    std::deque<Loss> losses_; ///< not yet returned
    std::uint32_t nextSlot_ = 0;
};

} // namespace openntc::encode::detail

#include "openntc/core/RestoreMacros.h"
