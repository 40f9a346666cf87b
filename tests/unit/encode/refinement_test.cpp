// SPDX-License-Identifier: MIT
// Refinement of latents: exact, never worse, whatever the size.
#include "openntc/encode/Material.h"
#include "openntc/encode/detail/LatentRefiner.h"
#include "openntc/encode/detail/PortableKernel.h"
#include "openntc/encode/detail/Schedule.h"

#include <doctest/doctest.h>

using namespace openntc;
using namespace openntc::encode;
using namespace openntc::encode::detail;

namespace {

/// Waves in two channels and a disc in a third.
Material MakeWaves(int width, int height) {
    Material material = *Material::Create(width, height);
    std::vector<float> texels;
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const auto u = static_cast<float>(x), v = static_cast<float>(y);
            texels.push_back(0.5f + 0.5f * std::sin(0.7f * u + 0.1f * v));
            texels.push_back(0.5f + 0.3f * std::sin(0.2f * u - 0.9f * v) * std::sin(0.05f * v));
            texels.push_back(std::hypot(u - 9.0f, v - 9.0f) < 7.0f ? 1.0f : 0.0f);
        }
    }
    REQUIRE(material.AddTexture({.name = "A", .firstChannel = 0, .channels = 3}, texels));
    material.GenerateMips();
    return material;
}

struct RefinementCase {
    int width, height;
    TrainerShape shape;
    bool discardMasked;
};

TrainerShape MakeShape(int scale, int highBits, int lowBits) {
    return {{.highFeatures = 4, .lowFeatures = 4, .highSlots = 4}, scale, highBits, lowBits};
}

TrainerShape MakeBlendedShape(int scale) {
    return MakeTrainerShape(MakeLayeredShape(scale, 4), NTC_NETWORK_GENERATION_3);
}

} // namespace

TEST_CASE("a kept move lowers the loss by exactly what was measured, and no move raises it") {
    const RefinementCase cases[] = {
        {94, 94, MakeShape(2, 2, 4), false},  {1, 40, MakeShape(2, 2, 4), false},
        {40, 1, MakeShape(4, 1, 2), false},   {33, 20, MakeShape(4, 4, 8), true},
        {5, 3, MakeShape(4, 2, 4), false},    {64, 32, MakeShape(2, 8, 1), true},
        {94, 94, MakeBlendedShape(2), false}, {33, 21, MakeBlendedShape(3), true},
        {1, 40, MakeBlendedShape(1), false},  {64, 32, MakeBlendedShape(4), false}};
    std::uint64_t kept = 0;
    for (const RefinementCase& c : cases) {
        CAPTURE(c.width);
        CAPTURE(c.height);
        const Material material = MakeWaves(c.width, c.height);
        const std::array<float, 16> scales = {1, 0.5f, 1};
        const TrainingSet set = TrainingSet::Make(
            c.width, c.height, material.GetMipCount(),
            [&](int mip, int channel) { return material.GetPlane(mip, channel); }, 7u, 2, c.discardMasked,
            scales);
        ThreadTeam team(2);
        Trainer<PortableKernel> trainer(set, c.shape, 1, 8, team);
        const Schedule schedule = Schedule::Make(20.0);
        for (int step = 0; step < 20; ++step)
            trainer.Step(schedule.At(step / 20.0));
        trainer.FreezeLatents();
        LatentRefiner<PortableKernel> refiner(trainer);
        refiner.Measure(64.0f);
        double loss = refiner.GetLoss();
        const auto moves = static_cast<std::uint64_t>(LatentMove::CountOfSweep(c.shape.network));
        for (std::uint64_t i = 0; i < 8;
             ++i) { // every class in both directions, of every feature, in several sweeps
            const std::uint64_t now =
                refiner.Try(LatentMove::Get(c.shape.network, i * 9 % moves + i * moves));
            const double composed = refiner.GetLoss();
            CHECK((now > 0 ? composed < loss : composed == loss));
            loss = composed;
            kept += now;
        }
        refiner.Measure(64.0f); // by a forward pass over the new latents
        CHECK(refiner.GetLoss() == loss);
    }
    CHECK(kept > 100); // of some thousands of latents; images of a few texels may keep none in eight moves
}

TEST_CASE("footprints are the texels whose taps read a pixel") {
    for (int texels : {1, 2, 5, 37, 94}) {
        for (int latents : {1, 2, 9, 47, 94}) {
            CAPTURE(texels);
            CAPTURE(latents);
            const AxisTaps taps = MakeAxisTaps(texels, latents);
            const AxisFootprints footprints = AxisFootprints::Make(taps, latents);
            for (int pixel = 0; pixel < latents; ++pixel) {
                const auto p = static_cast<std::size_t>(pixel);
                for (int t = 0; t < texels; ++t) {
                    const auto at = static_cast<std::size_t>(t);
                    const bool reads = taps.first[at] == pixel || taps.second[at] == pixel;
                    const bool inside = t >= footprints.begin[p] && t < footprints.end[p];
                    CHECK(reads == inside);
                }
            }
        }
    }
}

TEST_CASE("refinement gets its share of training, for small and for huge images") {
    constexpr double kTexels512 = 512.0 * 512.0 * 4.0 / 3.0, kNormal = 360000.0 * 4096.0;
    const RefinementPlan normal = RefinementPlan::Make(kNormal, kTexels512, 96);
    CHECK(normal.GetPasses() == 12 * 96); // all that there is
    CHECK(normal.GetDue(0, 0.9) == 0.9);
    CHECK(normal.GetDue(normal.rounds - 1, 0.9) < RefinementPlan::kLastRound);
    const RefinementPlan huge = RefinementPlan::Make(kNormal, 64.0 * kTexels512, 96);
    CHECK(huge.GetPasses() > 0);
    CHECK(static_cast<double>(huge.GetPasses()) * 64.0 * kTexels512 * RefinementPlan::kForwardCost <=
          RefinementPlan::kLargestShare * kNormal);
    CHECK(RefinementPlan::Make(4096.0, 1e9, 96).GetPasses() == 0);
}
