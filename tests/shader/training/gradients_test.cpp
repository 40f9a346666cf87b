// SPDX-License-Identifier: MIT
// The passes of the encoder on a device against the portable kernel: the same integers forward, the same gradients but for
// the rounding of binary16 backward.
#include "shader/TestDevice.h"
#include "shader/training/TrainingCase.h"
#include "vulkan_harness/TrainingQueue.h"

using namespace openntc;
using namespace openntc::encode;
using namespace openntc::encode::detail;
using namespace openntc::test;

namespace {

/// Each layer rounds the gradients of its sums to binary16, once.
const double kGradientLimit = kLayers * std::ldexp(1.0, -11);

struct Difference {
    double squares = 0.0, of = 0.0;
    void Add(double device, double expected) {
        squares += (device - expected) * (device - expected);
        of += expected * expected;
    }
    double Get() const { return std::sqrt(squares / of); }
};

double GetNorm(std::span<const double> values) {
    double squares = 0.0;
    for (const double value : values)
        squares += value * value;
    return std::sqrt(squares);
}

/// Numbers after the first step of Adam, which is the rate in the gradient's direction: the same where the gradient is larger
/// than the difference between all gradients may be. Each of some sixteen operations rounds once.
struct StepComparison {
    std::size_t all = 0, compared = 0, different = 0; ///< with a gradient, of them with a large one, of all

    void Add(std::span<const double> gradients, const AlignedBuffer<float>& device,
             const AlignedBuffer<float>& expected, double norm) {
        constexpr double kRounding = 16.0 / 16777216.0;
        for (std::size_t i = 0; i < expected.size(); ++i) {
            const double gradient = std::fabs(gradients[i]);
            all += gradient > 0.0 ? 1 : 0;
            if (gradient > 0.0 && gradient <= kGradientLimit * norm)
                continue;
            compared += gradient > 0.0 ? 1 : 0;
            const auto got = static_cast<double>(device[i]), wanted = static_cast<double>(expected[i]);
            different += std::fabs(got - wanted) <= kRounding * std::max(std::fabs(wanted), 1e-3) ? 0 : 1;
        }
    }
};

struct GradientCase {
    int width, height;
    TrainerShape shape;
    int mask;
    bool discards;
};

} // namespace

TEST_CASE("gradients of a device are those of the portable kernel") {
    OPENNTC_REQUIRE_DEVICE(context);
    const GradientCase cases[] = {
        {48, 40, MakeShape(4, 4, 4, 2, 4), -1, false}, {33, 21, MakeShape(8, 8, 2, 4, 8), 2, false},
        {40, 1, MakeShape(16, 16, 4, 1, 2), 2, true},  {33, 21, MakeLayeredTrainer(16, 2), 2, false},
        {48, 40, MakeLayeredTrainer(8, 4), -1, false}, {40, 1, MakeLayeredTrainer(12, 4), 2, true},
        {21, 12, MakeLayeredTrainer(4, 1), -1, false}};
    for (const GradientCase& c : cases) {
        CAPTURE(c.width);
        const Material material = MakeWaves(c.width, c.height);
        const TrainingSet set = MakeSet(material, c.mask, c.discards);
        ThreadTeam team(1);
        constexpr int kTiles = 8;
        StepSettings settings;
        settings.networkRate = settings.latentRate = 1e-3f;
        settings.latentMode = LatentMode::Round;
        settings.maskPush = 2.0f;

        Trainer<TellingKernel> expected(set, c.shape, 1, kTiles, team);
        TellingKernel::Begin(expected.GetHighGrids(), expected.GetLowGrids());
        expected.Step(settings);
        const ToldGradients& told = TellingKernel::told;

        auto queue = harness::MakeTrainingQueue(*context);
        REQUIRE(queue);
        WithoutUpdates device(**queue);
        Trainer<DeviceKernel<PortableKernel>> trainer(set, c.shape, 1, kTiles, team);
        REQUIRE(trainer.Attach(device));
        trainer.Step(settings);
        std::vector<std::byte> ignored;
        trainer.Save(ignored);
        REQUIRE(trainer.GetStatus());

        const auto partials = ReadAll<float>(device, device.plan, TrainingBuffer::Partials);
        const auto rows = ReadAll<float>(device, device.plan, TrainingBuffer::Rows);
        const auto latents = ReadAll<std::int32_t>(device, device.plan, TrainingBuffer::LatentGradients);
        const std::size_t weights = told.weights.size(), size = weights + NTC_TRAIN_TAIL;
        float largest = 0.0f;
        for (int i = 0; i < expected.GetContext().channels; ++i)
            largest = std::max(largest, expected.GetContext().gain[i]);
        const double gain = static_cast<double>(DeviceTables::kGain) / static_cast<double>(largest);
        const auto sum = [&](std::size_t at) {
            double total = 0.0;
            for (; at < partials.size(); at += size)
                total += static_cast<double>(partials[at]);
            return total;
        };
        Difference weightDifference, biasDifference, latentDifference;
        const NetworkShape& shape = c.shape.network;
        for (int layer = 0; layer < kLayers; ++layer) {
            const int outputs = shape.LayerOutputs(layer);
            for (int i = 0; i < shape.LayerInputs(layer); ++i) {
                for (int o = 0; o < outputs; ++o) {
                    const auto at =
                        static_cast<std::size_t>(shape.WeightOffset(layer) + WeightIndex(outputs, i, o));
                    const auto row = static_cast<std::size_t>(2 * NTC_TRAIN_ROWS + layer * 64 + o);
                    weightDifference.Add(sum(at) / static_cast<double>(rows[row]), told.weights[at] * gain);
                }
            }
        }
        for (std::size_t i = 0; i < NTC_TRAIN_ROWS; ++i)
            biasDifference.Add(sum(weights + i), told.biases[i] * gain);
        for (std::size_t i = 0; i < told.latents[0].size() + told.latents[1].size(); ++i) {
            const double wanted =
                i < told.latents[0].size() ? told.latents[0][i] : told.latents[1][i - told.latents[0].size()];
            latentDifference.Add(static_cast<double>(latents[i]) / NTC_TRAIN_LATENT_UNIT, wanted * gain);
        }
        CHECK(weightDifference.Get() < kGradientLimit);
        CHECK(biasDifference.Get() < kGradientLimit);
        CHECK(latentDifference.Get() < kGradientLimit);
    }
}

TEST_CASE("a step of a device moves latents and weights of generation 3 as the portable kernel's does") {
    OPENNTC_REQUIRE_DEVICE(context);
    const Material material = MakeWaves(65, 42); // latents of odd sizes, some of one pixel
    const TrainingSet set = MakeSet(material, -1, false);
    const TrainerShape shape = MakeLayeredTrainer(16, 2);
    ThreadTeam team(1);
    StepSettings settings;
    settings.networkRate = settings.latentRate = 1e-3f;
    settings.latentMode = LatentMode::Round;
    auto queue = harness::MakeTrainingQueue(*context);
    REQUIRE(queue);
    // Of a batch of one tile no other tile steps the latents beyond an edge.
    for (const auto& run : {std::pair(1u, 8), std::pair(1u, 1), std::pair(2u, 1), std::pair(3u, 1)}) {
        const unsigned seed = run.first;
        const int tiles = run.second;
        CAPTURE(seed);
        CAPTURE(tiles);
        Trainer<TellingKernel> telling(set, shape, seed, tiles, team);
        TellingKernel::Begin(telling.GetHighGrids(), telling.GetLowGrids());
        telling.Step(settings);
        Trainer<PortableKernel> expected(set, shape, seed, tiles, team);
        expected.Step(settings);
        Trainer<DeviceKernel<PortableKernel>> trainer(set, shape, seed, tiles, team);
        REQUIRE(trainer.Attach(**queue));
        trainer.Step(settings);

        const ToldGradients& told = TellingKernel::told;
        const double norm = std::hypot(GetNorm(told.latents[0]), GetNorm(told.latents[1]));
        StepComparison latents, weights;
        for (std::size_t n = 0; n < expected.GetHighGrids().size(); ++n) {
            latents.Add(std::span(told.latents[0]).subspan(told.firsts[0][n]),
                        trainer.GetHighGrids()[n].values, expected.GetHighGrids()[n].values, norm);
            latents.Add(std::span(told.latents[1]).subspan(told.firsts[1][n]),
                        trainer.GetLowGrids()[n].values, expected.GetLowGrids()[n].values, norm);
        }
        weights.Add(told.weights, trainer.GetNetwork().weights, expected.GetNetwork().weights,
                    GetNorm(told.weights));
        REQUIRE(trainer.GetStatus());
        CHECK(latents.different == 0);
        CHECK(weights.different == 0);
        CHECK(4 * latents.compared > latents.all);
        CHECK(4 * weights.compared > weights.all);
    }
}
