// SPDX-License-Identifier: MIT
// Stability: internal
// Training steps of one texture set: batches of tiles, gradients in fixed slices, optimiser. The result
// depends on the seed and the number of steps only, not on the number of threads.
#pragma once

#include "openntc/core/ThreadTeam.h"
#include "openntc/encode/UsefulSteps.h"
#include "openntc/encode/detail/CurveWatch.h"
#include "openntc/encode/detail/LatentStore.h"
#include "openntc/encode/detail/TrainerTypes.h"
#include "openntc/encode/detail/TrainingSet.h"

#include <array>
#include <cstring>
#include <memory>
#include <numeric>
#include <type_traits>

#include "openntc/core/HideMacros.h"

namespace openntc::encode::detail {

class PortableKernel;

template <typename Kernel>
class Trainer {
public:
    /// `set` outlives the trainer.
    Trainer(const TrainingSet& set, const TrainerShape& shape, std::uint32_t seed, int batchTiles,
            ThreadTeam& team)
        : set_(set), seed_(seed), batchTiles_(batchTiles), team_(team), network_(shape.network) {
        CreateGeometry(shape);
        for (int c : set.GetTrainedChannels()) {
            const ChannelPlan& plan = set.GetChannel(c);
            network_.smallestScale[c] = std::fabs(plan.minimum) / plan.range / NetworkState::kLargestBias;
        }
        Initialise();
        slices_.resize(kSlices);
        for (GradientSums& slice : slices_)
            slice.weights.Resize(static_cast<std::size_t>(shape.network.WeightCount()));
        for (int i = 0; i < team.GetThreadCount(); ++i)
            kernels_.push_back(std::make_unique<Kernel>(shape.network));
        context_.shape = shape.network;
        context_.packed = &network_.packed;
        set.FillContext(context_, batchTiles * kTileTexels);
        CreateBatchMemory();
        for (int mip = 0; mip < set.GetMipCount(); ++mip) {
            for (int repeat = 0; repeat < set.GetTileRepeats(mip); ++repeat) {
                for (int tile = set.GetFirstTile(mip); tile < set.GetFirstTile(mip + 1); ++tile)
                    order_.push_back(tile);
            }
        }
        cursor_ = order_.size();
    }

    static constexpr int kSlices = 8;                     ///< independent gradient sums of a batch
    static constexpr std::uint64_t kSnapshotSteps = 2000; ///< between states to return to after divergence

    /// Passes over the set that `steps` steps make.
    double GetPasses(double steps) const { return steps * batchTiles_ / static_cast<double>(order_.size()); }
    /// `blended`: generation 3, whose network gains most from more and smaller steps (docs/encoder.md).
    static int ChooseBatchTexels(int wanted, double, bool blended) {
        return wanted > 0 ? wanted : static_cast<int>(blended ? kTexelsPerStep / 4 : kTexelsPerStep);
    }
    int GetBatchTexels() const { return batchTiles_ * kTileTexels; }
    std::uint64_t GetStep() const { return step_; }
    NetworkState& GetNetwork() { return network_; }
    const NetworkShape& GetNetworkShape() const { return network_.GetShape(); }
    std::vector<LatentPlanes>& GetHighGrids() { return high_; }
    std::vector<LatentPlanes>& GetLowGrids() { return low_; }
    const std::vector<MipGeometry>& GetMips() const { return mips_; }
    const TrainingSet& GetSet() const { return set_; }
    const KernelContext& GetContext() const { return context_; }
    ThreadTeam& GetTeam() { return team_; }
    /// Part of the state: how much refinement of the latents was done.
    RefinementCounts& GetRefinement() { return refinement_; }
    /// Likewise: how quality has grown.
    CurveWatch& GetWatch() { return watch_; }
    const CurveWatch& GetWatch() const { return watch_; }

    std::size_t GetLatentCount() const {
        std::size_t count = 0;
        for (const auto* grids : {&high_, &low_}) {
            for (const LatentPlanes& grid : *grids)
                count += grid.values.size();
        }
        return count;
    }

    /// Makes the decoder's network of the trained one.
    void PackNetwork() {
        for (int column = 0; column < NetworkState::kColumns; ++column)
            network_.template PackColumn<Kernel>(column, true);
    }

    /// One step on the next tiles of a random order of all tiles. Returns the squared errors seen.
    LossSums Step(const StepSettings& settings) {
        for (TileTask& task : tasks_)
            task = PlaceTile(NextTile());
        context_.maskPush = settings.maskPush;
        const std::uint32_t noise = GetNoise();
        team_.Run(kSlices, [&](int slice, int thread) { RunSlice(slice, thread, settings, noise); });
        const OptimiserSteps optimiser = MakeOptimiserSteps(settings);
        const int columns = settings.networkRate > 0.0f ? NetworkState::kColumns : 0;
        const int bands = settings.latentRate > 0.0f ? kBands : 0;
        team_.Run(columns + bands, [&](int job, int) {
            if (job < bands)
                UpdateLatents(job, optimiser.latents);
            else
                network_.template UpdateColumn<Kernel>(job - bands, slices_, optimiser.network,
                                                       settings.quantiseWeights);
        });
        ++step_;
        LossSums loss;
        for (const GradientSums& slice : slices_) {
            for (std::size_t o = 0; o < kOutputs; ++o) {
                for (float value : slice.loss[o])
                    loss.perOutput[o] += static_cast<double>(value);
            }
        }
        for (const TileTask& task : tasks_)
            loss.texels += task.width * task.height;
        return loss;
    }

    /// Squared errors of one mip as a decoder of the quantised file sees it.
    LossSums Evaluate(int mip) {
        PackNetwork();
        std::array<LossSums, kInferJobs> partial;
        InferTiles(
            set_.GetFirstTile(mip), set_.GetFirstTile(mip + 1), [](TileTask&) {},
            [&](int job, int, const TileTask& task, const float* outputs) {
                set_.AddErrors(task, outputs, Kernel::kTexels, partial[static_cast<std::size_t>(job)]);
            });
        LossSums total;
        for (const LossSums& sums : partial)
            total.Add(sums);
        return total;
    }

    /// Network outputs of tiles [begin, end) from rounded latents, in jobs that run in parallel: calls
    /// change(task) when a tile's latents have been copied, then visit(job, tile, task, outputs), job 0 ...
    /// kInferJobs - 1, outputs [16][Kernel::kTexels].
    static constexpr int kInferJobs = 64;
    template <typename Change, typename Visit>
    void InferTiles(int begin, int end, const Change& change, const Visit& visit) {
        team_.Run(kInferJobs, [&](int job, int thread) {
            const std::int64_t tiles = end - begin;
            InferJob(begin + static_cast<int>(tiles * job / kInferJobs),
                     begin + static_cast<int>(tiles * (job + 1) / kInferJobs), job, thread, change, visit);
        });
    }

    /// Everything that further steps depend on.
    void Save(std::vector<std::byte>& state) {
        state.clear();
        VisitState([&](void* data, std::size_t bytes) {
            const auto* from = static_cast<const std::byte*>(data);
            state.insert(state.end(), from, from + bytes);
        });
    }
    /// Restores what Save gave for a trainer of the same set and shape. Returns false, having changed
    /// nothing, for states of another size or of other texels. Damaged numbers train badly, but safely.
    bool Load(std::span<const std::byte> state) {
        std::size_t size = 0;
        VisitState([&](void*, std::size_t bytes) { size += bytes; });
        std::uint64_t fingerprint = 0;
        if (size != state.size() || size < sizeof(fingerprint))
            return false;
        std::memcpy(&fingerprint, state.data(), sizeof(fingerprint));
        if (fingerprint != GetFingerprint())
            return false;
        std::size_t at = 0;
        VisitState([&](void* data, std::size_t bytes) {
            std::memcpy(data, state.data() + at, bytes);
            at += bytes;
        });
        const int tiles = set_.GetFirstTile(set_.GetMipCount());
        cursor_ = std::min(cursor_, order_.size());
        for (int& tile : order_)
            tile = std::clamp(tile, 0, tiles - 1);
        for (auto* grids : {&high_, &low_}) {
            for (LatentPlanes& grid : *grids) {
                for (std::size_t i = 0; i < grid.values.size(); ++i) {
                    const float value = grid.values[i];
                    grid.values[i] = value == value
                                         ? std::clamp(value, grid.quantiser.minimum, grid.quantiser.maximum)
                                         : 0.0f;
                }
            }
        }
        PackNetwork();
        return true;
    }

    /// Takes over a trained network, to continue it as an FP8 network, and its frozen latents.
    void StartFrom(const NetworkState& network, std::vector<LatentPlanes>& high,
                   std::vector<LatentPlanes>& low) {
        for (std::size_t i = 0; i < network.weights.size(); ++i)
            network_.weights[i] = network.weights[i];
        std::copy(std::begin(network.biases), std::end(network.biases), std::begin(network_.biases));
        for (std::size_t n = 0; n < high.size(); ++n) {
            high_[n].values = std::move(high[n].values);
            low_[n].values = std::move(low[n].values);
        }
        network_.eightBitFloat = true;
        PackNetwork();
    }

    /// Replaces every latent by the value its code decodes to.
    void FreezeLatents() {
        for (auto* grids : {&high_, &low_}) {
            for (LatentPlanes& grid : *grids) {
                const LatentQuantiser& q = grid.quantiser;
                for (std::size_t i = 0; i < grid.values.size(); ++i) {
                    const float level =
                        std::clamp(std::floor(grid.values[i] * q.scale + 0.5f),
                                   static_cast<float>(q.lowestLevel), static_cast<float>(q.highestLevel));
                    grid.values[i] = level / q.scale;
                }
            }
        }
    }

private:
    template <typename>
    friend class Trainer; // that of a device, which has one of the processor

    static constexpr int kBands = 8; ///< independent parts of the latents

    /// Of the texels, and of whether the kernel gives everyone's bytes, which takes states of its own.
    std::uint64_t GetFingerprint() const {
        constexpr std::uint64_t kPortable = std::is_same_v<Kernel, PortableKernel> ? 1 : 0;
        return set_.GetFingerprint() + kPortable;
    }
    template <typename Visit>
    void VisitState(const Visit& visit) {
        const auto buffer = [&](auto& array) { visit(array.data(), array.size() * sizeof(array[0])); };
        std::uint64_t fingerprint = GetFingerprint();
        visit(&fingerprint, sizeof(fingerprint));
        visit(&step_, sizeof(step_));
        visit(&pass_, sizeof(pass_));
        visit(&cursor_, sizeof(cursor_));
        visit(&refinement_, sizeof(refinement_));
        visit(&watch_, sizeof(watch_));
        buffer(order_);
        buffer(network_.weights);
        buffer(network_.first);
        buffer(network_.second);
        visit(network_.biases, sizeof(network_.biases));
        visit(network_.firstBias, sizeof(network_.firstBias));
        visit(network_.secondBias, sizeof(network_.secondBias));
        for (auto* grids : {&high_, &low_}) {
            for (LatentPlanes& grid : *grids) {
                buffer(grid.values);
                buffer(grid.first);
                buffer(grid.second);
            }
        }
    }

    void CreateGeometry(const TrainerShape& shape) {
        const TextureSetDesc desc{set_.GetWidth(), set_.GetHeight(), kMaxChannels, set_.GetMipCount()};
        if (shape.network.blended)
            return CreatePairs(shape, desc);
        const int count = GetNeuralMipCount(desc, shape.gridScale);
        high_.resize(static_cast<std::size_t>(count));
        low_.resize(static_cast<std::size_t>(count));
        for (int n = 0; n < count; ++n) {
            const auto at = static_cast<std::size_t>(n);
            const auto size = [&](int scale) {
                return GridSize{GetLatentGridDimension(desc.width, scale, n),
                                GetLatentGridDimension(desc.height, scale, n)};
            };
            high_[at].Create(size(shape.gridScale), shape.network.highFeatures,
                             MakeLatentQuantiser(shape.highBits));
            low_[at].Create(size(2 * shape.gridScale), shape.network.lowFeatures,
                            MakeLatentQuantiser(shape.lowBits));
        }
        for (int mip = 0; mip < set_.GetMipCount(); ++mip) {
            const int n = GetNeuralMipForColorMip(mip, shape.gridScale, count);
            const auto at = static_cast<std::size_t>(n);
            mips_.push_back(
                MakeMipGeometry(set_.GetWidth(), set_.GetHeight(), mip, n, high_[at].size, low_[at].size));
        }
    }

    /// Of generation 3: colour mips read an even latent mip, and the odd one after it.
    void CreatePairs(const TrainerShape& shape, const TextureSetDesc& desc) {
        const int count = GetLatentMipCount(desc, shape.gridScale);
        for (int n = 0; n < count; ++n) {
            auto& grids = n % 2 == 0 ? high_ : low_;
            const GridSize size{GetLatentMipDimension(desc.width, shape.gridScale, n),
                                GetLatentMipDimension(desc.height, shape.gridScale, n)};
            grids.emplace_back().Create(size, shape.network.highFeatures, MakeBlendedQuantiser());
        }
        for (int mip = 0; mip < desc.mips; ++mip) {
            const int pair = GetLatentMipForColorMip(mip, shape.gridScale, count) / 2;
            const auto at = static_cast<std::size_t>(pair);
            mips_.push_back(MakeBlendedMipGeometry(GetMipDimension(desc.width, mip),
                                                   GetMipDimension(desc.height, mip), pair, high_[at].size,
                                                   low_[at].size));
        }
    }

    void Initialise() {
        RandomStream random(seed_ * 2u + 1u);
        for (auto* grids : {&high_, &low_}) {
            for (LatentPlanes& grid : *grids) {
                const float sigma = 0.5f / std::sqrt(static_cast<float>(network_.GetShape().lowFeatures));
                for (std::size_t i = 0; i < grid.values.size(); ++i)
                    grid.values[i] = std::clamp(grid.quantiser.start + random.NextNormal() * sigma,
                                                grid.quantiser.minimum, grid.quantiser.maximum);
            }
        }
        const NetworkShape& shape = network_.GetShape();
        for (int layer = 0; layer < kLayers; ++layer) {
            const int inputs = layer == 0 ? shape.Inputs() : shape.LayerInputs(layer);
            const int outputs = shape.LayerOutputs(layer);
            const float sigma = std::sqrt(2.0f / static_cast<float>(inputs));
            for (int i = 0; i < inputs; ++i) {
                for (int o = 0; o < outputs; ++o) {
                    const int index = shape.WeightOffset(layer) + WeightIndex(outputs, i, o);
                    network_.weights[static_cast<std::size_t>(index)] = random.NextNormal() * sigma;
                }
            }
        }
        PackNetwork();
    }

    void CreateBatchMemory() {
        std::size_t largest = 0;
        for (int tile = 0; tile < set_.GetFirstTile(set_.GetMipCount()); ++tile) {
            TileTask task = PlaceTile(tile);
            largest = std::max(largest, LocalSize(task.high, high_[0].features) +
                                            LocalSize(task.low, low_[0].features));
        }
        tasks_.resize(static_cast<std::size_t>(batchTiles_));
        batchGradients_.Resize(largest * static_cast<std::size_t>(batchTiles_));
        threadValues_.resize(kernels_.size());
        for (auto& values : threadValues_)
            values.Resize(largest * Kernel::kTiles);
        localSize_ = largest;
    }
    static std::size_t LocalSize(const LocalGrid& grid, int features) {
        return static_cast<std::size_t>(grid.rows * grid.pitch) * static_cast<std::size_t>(features);
    }

    TileTask PlaceTile(int index) const {
        const TileRecord& record = set_.GetTile(index);
        const MipGeometry& mip = mips_[static_cast<std::size_t>(record.mip)];
        TileTask task;
        task.mip = &mip;
        task.x = record.x;
        task.y = record.y;
        task.width = std::min(kTileWidth, mip.width - record.x);
        task.height = std::min(kTileHeight, mip.height - record.y);
        task.reference = set_.GetReference(index);
        PlaceLocalGrid(task.high, mip.highX, mip.highY, task.x, task.y, task.width, task.height);
        PlaceLocalGrid(task.low, mip.lowX, mip.lowY, task.x, task.y, task.width, task.height);
        return task;
    }
    void AttachMemory(TileTask& task, float* values, float* gradients) const {
        const std::size_t high = LocalSize(task.high, high_[0].features);
        task.high.values = values;
        task.low.values = values + high;
        task.high.gradients = gradients;
        task.low.gradients = gradients == nullptr ? nullptr : gradients + high;
    }

    /// The next one of a random order of all tiles.
    int NextTile() {
        if (cursor_ >= order_.size()) {
            RandomStream random(seed_ + 0x9e3779b9u * static_cast<std::uint32_t>(++pass_));
            for (std::size_t i = order_.size(); i > 1; --i)
                std::swap(order_[i - 1], order_[random.NextBits() % i]);
            cursor_ = 0;
        }
        return order_[cursor_++];
    }
    /// Seed of a step's noise.
    std::uint32_t GetNoise() const { return Hash(seed_ ^ static_cast<std::uint32_t>(step_ * 2654435761u)); }
    OptimiserSteps MakeOptimiserSteps(const StepSettings& settings) const {
        const double t = static_cast<double>(step_) + 1.0;
        return {AdamStep::Make(settings.networkRate, t, settings.networkBeta2),
                AdamStep::Make(settings.latentRate, GetPasses(t) * 2.0 + 1.0, settings.latentBeta2)};
    }

    void FillTask(TileTask& task, float* values, float* gradients, LatentMode mode, std::uint32_t seed) {
        AttachMemory(task, values, gradients);
        const auto n = static_cast<std::size_t>(task.mip->neuralMip);
        high_[n].template CopyOut<Kernel>(task.high, mode, seed);
        low_[n].template CopyOut<Kernel>(task.low, mode, seed + 0x40000000u);
    }

    void RunSlice(int slice, int thread, const StepSettings& settings, std::uint32_t noise) {
        const int begin = batchTiles_ * slice / kSlices, end = batchTiles_ * (slice + 1) / kSlices;
        GradientSums& sums = slices_[static_cast<std::size_t>(slice)];
        sums.Clear();
        Kernel& kernel = *kernels_[static_cast<std::size_t>(thread)];
        float* values = threadValues_[static_cast<std::size_t>(thread)].data();
        kernel.Begin();
        for (int tile = begin; tile < end; tile += Kernel::kTiles) {
            const int count = std::min(Kernel::kTiles, end - tile);
            for (int i = 0; i < count; ++i) {
                const auto at = static_cast<std::size_t>(tile) + static_cast<std::size_t>(i);
                FillTask(tasks_[at], values + static_cast<std::size_t>(i) * localSize_,
                         batchGradients_.data() + at * localSize_, settings.latentMode,
                         Hash(noise + static_cast<std::uint32_t>(at)));
            }
            kernel.Train(context_, &tasks_[static_cast<std::size_t>(tile)], count, sums);
        }
        kernel.End();
    }

    void UpdateLatents(int band, const AdamStep& step) {
        for (int pass = 0; pass < 2; ++pass) {
            for (const TileTask& task : tasks_) {
                const auto n = static_cast<std::size_t>(task.mip->neuralMip);
                for (auto [grid, local] :
                     {std::pair{&high_[n], &task.high}, std::pair{&low_[n], &task.low}}) {
                    const int begin = grid->size.height * band / kBands,
                              end = grid->size.height * (band + 1) / kBands;
                    if (pass == 0)
                        grid->AddGradients(*local, begin, end);
                    else
                        grid->template Update<Kernel>(*local, begin, end, step);
                }
            }
        }
    }

    template <typename Change, typename Visit>
    void InferJob(int begin, int end, int job, int thread, const Change& change, const Visit& visit) {
        Kernel& kernel = *kernels_[static_cast<std::size_t>(thread)];
        float* values = threadValues_[static_cast<std::size_t>(thread)].data();
        kernel.Begin();
        TileTask tasks[Kernel::kTiles];
        for (int tile = begin; tile < end; tile += Kernel::kTiles) {
            const int count = std::min(Kernel::kTiles, end - tile);
            for (int i = 0; i < count; ++i) {
                tasks[i] = PlaceTile(tile + i);
                FillTask(tasks[i], values + static_cast<std::size_t>(i) * localSize_, nullptr,
                         LatentMode::Round, 0);
                change(tasks[i]);
            }
            const float* outputs = kernel.Infer(context_, tasks, count);
            for (int i = 0; i < count; ++i)
                visit(job, tile + i, tasks[i], outputs + i * kTileTexels);
        }
        kernel.End();
    }

    const TrainingSet& set_;
    std::uint32_t seed_;
    int batchTiles_;
    ThreadTeam& team_;
    NetworkState network_;
    std::vector<LatentPlanes> high_, low_;
    std::vector<MipGeometry> mips_;
    KernelContext context_;
    std::vector<GradientSums> slices_;
    std::vector<std::unique_ptr<Kernel>> kernels_;
    std::vector<TileTask> tasks_;
    AlignedBuffer<float> batchGradients_;
    std::vector<AlignedBuffer<float>> threadValues_;
    std::size_t localSize_ = 0;
    std::vector<int> order_;
    std::size_t cursor_ = 0;
    std::uint64_t pass_ = 0, step_ = 0;
    RefinementCounts refinement_;
    CurveWatch watch_;
};

} // namespace openntc::encode::detail

#include "openntc/core/RestoreMacros.h"
