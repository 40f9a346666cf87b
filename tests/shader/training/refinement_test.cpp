// SPDX-License-Identifier: MIT
// Refinement on a device: the losses of texels are those of the portable kernel, whose integers it so has, and moves change
// them by exactly what was measured.
#include "shader/TestDevice.h"
#include "shader/training/TrainingCase.h"
#include "vulkan_harness/TrainingQueue.h"

#include "openntc/encode/detail/DeviceRefiner.h"

#include <numeric>

using namespace openntc;
using namespace openntc::encode;
using namespace openntc::encode::detail;
using namespace openntc::test;

namespace {

/// Losses of all texels as the portable kernel has them, [tile][128], in the device's units.
std::vector<float> MeasureOnProcessor(Trainer<PortableKernel>& trainer, float maskPush) {
    KernelContext context = trainer.GetContext();
    context.maskPush = maskPush;
    const float largest = *std::max_element(context.gain, context.gain + context.channels);
    const TrainingSet& set = trainer.GetSet();
    const int tiles = set.GetFirstTile(set.GetMipCount());
    std::vector<float> losses(static_cast<std::size_t>(tiles) * kTileTexels);
    trainer.PackNetwork();
    trainer.InferTiles(
        0, tiles, [](TileTask&) {},
        [&](int, int tile, const TileTask& task, const float* outputs) {
            float texels[kTileTexels];
            WriteTexelLosses(context, task, outputs, PortableKernel::kTexels, texels, kTileWidth);
            for (int t = 0; t < kTileTexels; ++t) {
                if (t % kTileWidth < task.width && t / kTileWidth < task.height)
                    losses[static_cast<std::size_t>(tile * kTileTexels + t)] =
                        texels[t] / largest * DeviceTables::kGain;
            }
        });
    return losses;
}

struct RefinementCase {
    int width, height;
    TrainerShape shape;
    int mask;
    bool discards;
};

} // namespace

TEST_CASE(
    "a device's losses are the portable kernel's, and a kept move lowers them by exactly what was measured") {
    OPENNTC_REQUIRE_DEVICE(context);
    const RefinementCase cases[] = {{48, 40, MakeShape(4, 4, 4, 2, 4), -1, false},
                                    {33, 21, MakeShape(4, 8, 2, 4, 8), 2, false},
                                    {40, 1, MakeShape(4, 4, 4, 1, 2), 2, true},
                                    {33, 21, MakeLayeredTrainer(4, 2), 2, false},
                                    {40, 1, MakeLayeredTrainer(8, 4), 2, true}};
    std::uint64_t kept = 0;
    for (const RefinementCase& c : cases) {
        CAPTURE(c.width);
        constexpr float kPush = 8.0f;
        const Material material = MakeWaves(c.width, c.height);
        const TrainingSet set = MakeSet(material, c.mask, c.discards);
        ThreadTeam team(1);
        Trainer<PortableKernel> expected(set, c.shape, 1, 8, team);
        expected.FreezeLatents();
        auto queue = harness::MakeTrainingQueue(*context);
        REQUIRE(queue);
        WithoutUpdates device(**queue);
        Trainer<DeviceKernel<PortableKernel>> trainer(set, c.shape, 1, 8, team);
        REQUIRE(trainer.Attach(device));
        trainer.FreezeLatents();
        LatentRefiner<DeviceKernel<PortableKernel>> refiner(trainer);
        refiner.Measure(kPush);
        REQUIRE(trainer.GetStatus());

        const std::vector<float> wanted = MeasureOnProcessor(expected, kPush);
        const std::vector<float> before = ReadAll<float>(device, device.plan, TrainingBuffer::Kept);
        REQUIRE(before.size() >= wanted.size());
        // Terms are not negative: a few roundings of each, and of their sum.
        constexpr float kRoundings = 16.0f / 16777216.0f;
        for (std::size_t i = 0; i < wanted.size(); ++i) {
            if (!(std::fabs(before[i] - wanted[i]) <= kRoundings * wanted[i])) {
                CAPTURE(i);
                CHECK(before[i] == wanted[i]);
                break;
            }
        }

        constexpr int kStride = 5; // of the sweep: all classes, both directions and grids
        const auto sweep = static_cast<std::uint64_t>(LatentMove::CountOfSweep(c.shape.network));
        for (std::uint64_t move = 0; move < sweep; move += kStride) // one of many sweeps
            kept += refiner.Try(LatentMove::Get(c.shape.network, 5 * sweep + move));
        REQUIRE(trainer.GetStatus());
        const std::vector<float> after = ReadAll<float>(device, device.plan, TrainingBuffer::Kept);
        CHECK(std::accumulate(after.begin(), after.end(), 0.0) <=
              std::accumulate(before.begin(), before.end(), 0.0));
        refiner.Measure(kPush); // with the latents as they are now
        CHECK(ReadAll<float>(device, device.plan, TrainingBuffer::Kept) == after);
        // And so they are on the processor.
        for (std::size_t n = 0; n < trainer.GetHighGrids().size(); ++n) {
            expected.GetHighGrids()[n].values = std::move(trainer.GetHighGrids()[n].values);
            expected.GetLowGrids()[n].values = std::move(trainer.GetLowGrids()[n].values);
        }
        const std::vector<float> refined = MeasureOnProcessor(expected, kPush);
        std::size_t different = 0;
        for (std::size_t i = 0; i < refined.size(); ++i)
            different += std::fabs(after[i] - refined[i]) <= kRoundings * refined[i] ? 0u : 1u;
        CHECK(different == 0);
    }
    CHECK(kept > 100);
}
