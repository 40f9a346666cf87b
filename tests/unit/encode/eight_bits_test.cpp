// SPDX-License-Identifier: MIT
// FP8 networks in training: kernels have the outputs of the portable one, whose arithmetic is the decoder's, and its gradients.
#include "RandomNetwork.h"

#include "openntc/encode/Kernels.h"
#include "openntc/encode/detail/Fp8Kernel.h"
#include "openntc/encode/detail/TrainingSet.h"
#include "openntc/encode/detail/blocked/Avx2.h"
#include "openntc/encode/detail/blocked/Avx512.h"
#include "openntc/encode/detail/blocked/Neon.h"

#include <doctest/doctest.h>

#include <cmath>
#include <memory>
#include <string>

using namespace openntc;
using namespace openntc::encode;
using namespace openntc::encode::detail;

namespace {

constexpr int kHeadWidth = 40, kHeadHeight = 20, kHeadScale = 4;

/// A network, latents and references of a mip of 40 x 20: tiles at its edges are partly outside.
struct HeadCase {
    NetworkShape shape;
    LatentPlanes grids[2];
    MipGeometry mip;
    NetworkState network;
    std::vector<std::uint16_t> reference;
    KernelContext context;

    HeadCase(const LatentShape& latents, int networkVersion)
        : shape(MakeTrainerShape(latents, networkVersion).network), network(shape) {
        RandomStream random(11);
        const GridSize sizes[2] = {{10, 5}, shape.blended ? GridSize{5, 2} : GridSize{5, 3}};
        const int bits[2] = {latents.highResQuantBits, latents.lowResQuantBits};
        const int features[2] = {shape.highFeatures, shape.lowFeatures};
        for (std::size_t n = 0; n < 2; ++n) {
            const LatentQuantiser q = shape.blended ? MakeBlendedQuantiser() : MakeLatentQuantiser(bits[n]);
            grids[n].Create(sizes[n], features[n], q);
            for (std::size_t i = 0; i < grids[n].values.size(); ++i) {
                const auto levels = static_cast<std::uint32_t>(q.highestLevel - q.lowestLevel + 1);
                const int level = q.lowestLevel + static_cast<int>(random.NextBits() % levels);
                grids[n].values[i] = static_cast<float>(level) / q.scale;
            }
        }
        mip = shape.blended ? MakeBlendedMipGeometry(kHeadWidth, kHeadHeight, 0, sizes[0], sizes[1])
                            : MakeMipGeometry(kHeadWidth, kHeadHeight, 0, 0, sizes[0], sizes[1]);
        network.eightBitFloat = true;
        openntc_tests::FillNetwork(network, shape, 4.0f, random);
        reference = openntc_tests::FillContext(context, shape, network, random);
    }
};

/// What a kernel makes of all tiles: outputs, and the sums of gradients.
struct Trained {
    std::vector<float> outputs;
    GradientSums sums;
};

template <typename Kernel>
Trained TrainAll(HeadCase& set) {
    Trained trained;
    trained.sums.weights.Resize(static_cast<std::size_t>(set.shape.WeightCount()));
    for (int column = 0; column < NetworkState::kColumns; ++column)
        set.network.PackColumn<Kernel>(column, true);
    const auto kernel = std::make_unique<Kernel>(set.shape);
    for (int top = 0; top < kHeadHeight; top += kTileHeight) {
        for (int left = 0; left < kHeadWidth; left += kTileWidth) {
            TileTask task =
                openntc_tests::MakeTile(set.mip, left, top, kHeadWidth, kHeadHeight, set.reference);
            AlignedBuffer<float> memory[2];
            LocalGrid* locals[2] = {&task.high, &task.low};
            for (std::size_t n = 0; n < 2; ++n) {
                memory[n].Resize(
                    static_cast<std::size_t>(set.grids[n].features * locals[n]->rows * locals[n]->pitch));
                locals[n]->values = memory[n].data();
                set.grids[n].CopyOut<Kernel>(*locals[n], LatentMode::Round, 0);
            }
            const float* outputs = kernel->Infer(set.context, &task, 1);
            for (int o = 0; o < kOutputs; ++o) {
                for (int y = 0; y < task.height; ++y) {
                    const float* row = outputs + o * Kernel::kTexels + y * kTileWidth;
                    trained.outputs.insert(trained.outputs.end(), row, row + task.width);
                }
            }
            kernel->Train(set.context, &task, 1, trained.sums);
        }
    }
    return trained;
}

/// Length of a difference, as a part of what it is a difference to.
double GetDistance(const float* a, const float* b, std::size_t count) {
    double difference = 0.0, length = 0.0;
    for (std::size_t i = 0; i < count; ++i) {
        difference += std::pow(static_cast<double>(a[i]) - static_cast<double>(b[i]), 2.0);
        length += std::pow(static_cast<double>(b[i]), 2.0);
    }
    REQUIRE(length > 0.0);
    return std::sqrt(difference / length);
}

/// `precision`: of the kernel's operands; 0 for binary32.
template <typename Kernel>
void CheckHead(KernelChoice choice, double precision) {
    if (!IsKernelAvailable(choice)) {
        MESSAGE("SKIP: kernel: " << std::string(KernelToString(choice))
                                 << ": this machine or build does not have it");
        return;
    }
    CAPTURE(std::string(KernelToString(choice)));
    const LatentShape medium{.gridSizeScale = kHeadScale,
                             .highResFeatures = 8,
                             .lowResFeatures = 16,
                             .highResQuantBits = 4,
                             .lowResQuantBits = 2},
        xlarge{.gridSizeScale = kHeadScale,
               .highResFeatures = 16,
               .lowResFeatures = 4,
               .highResQuantBits = 1,
               .lowResQuantBits = 8};
    const std::pair<LatentShape, int> cases[] = {
        {medium, NTC_NETWORK_MEDIUM},
        {xlarge, NTC_NETWORK_XLARGE},
        {MakeLayeredShape(kHeadScale, 8), NTC_NETWORK_GENERATION_3},
        {MakeLayeredShape(kHeadScale, 16), NTC_NETWORK_GENERATION_3}};
    for (const auto& entry : cases) {
        const int networkVersion = entry.second;
        CAPTURE(networkVersion);
        HeadCase set(entry.first, networkVersion);
        const Trained wanted = TrainAll<Fp8Kernel>(set), trained = TrainAll<Kernel>(set);
        REQUIRE(trained.outputs.size() == wanted.outputs.size());
        std::size_t differing = 0;
        for (std::size_t i = 0; i < wanted.outputs.size(); ++i)
            differing += trained.outputs[i] == wanted.outputs[i] ? 0 : 1;
        // Products of E4M3 are exact, and sums of them that need 24 bits or fewer: those have one value in any order. A sum that
        // needs more may change in its last bit, which rounding to binary16 loses but for one in 2^12.
        if (precision == 0.0 && !set.shape.blended)
            CHECK(differing == 0);
        CHECK(static_cast<double>(differing) <= 0.01 * static_cast<double>(wanted.outputs.size()));
        // As in blended_test: an operand's roundings in each of seven products, and those of sums in binary32.
        const double tolerance = 7.0 * precision + (kTileTexels + 3.0 * kHidden) * std::ldexp(1.0, -24);
        for (int layer = 0; layer < kLayers; ++layer) {
            CAPTURE(layer);
            const auto at = static_cast<std::size_t>(set.shape.WeightOffset(layer));
            const auto count =
                static_cast<std::size_t>(set.shape.LayerInputs(layer) * set.shape.LayerOutputs(layer));
            // Gradients of the slots of padding are no part of it.
            const std::size_t used =
                layer == 0 ? static_cast<std::size_t>(set.shape.Inputs() / 16 * 16 * kHidden) : count;
            CHECK(GetDistance(trained.sums.weights.data() + at, wanted.sums.weights.data() + at, used) <=
                  tolerance);
        }
        float biases[2][NetworkShape::kBiases] = {};
        for (int row = 0; row < NetworkShape::kBiases; ++row) {
            for (int lane = 0; lane < 16; ++lane) {
                biases[0][row] += trained.sums.biases[row][lane];
                biases[1][row] += wanted.sums.biases[row][lane];
            }
        }
        CHECK(GetDistance(biases[0], biases[1], NetworkShape::kBiases) <= tolerance);
    }
}

} // namespace

TEST_CASE("kernels of FP8 networks have the portable one's outputs and gradients") {
    [[maybe_unused]] constexpr double kBfloat16 = 1.0 / 512.0;
#if OPENNTC_FAST_X86
    CheckHead<avx2::HeadKernel>(KernelChoice::Avx2, 0.0);
    CheckHead<avx512::fma::HeadKernel>(KernelChoice::Avx512, 0.0);
    CheckHead<avx512::bf16::HeadKernel>(KernelChoice::Avx512Bf16, kBfloat16);
#elif OPENNTC_FAST_NEON
    CheckHead<neon::fma::HeadKernel>(KernelChoice::Neon, 0.0);
#if OPENNTC_FAST_NEON_BF16
    CheckHead<neon::bf16::HeadKernel>(KernelChoice::NeonBf16, kBfloat16);
#endif
#else
    MESSAGE("SKIP: this build has the portable kernel only");
#endif
}
