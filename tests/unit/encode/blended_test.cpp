// SPDX-License-Identifier: MIT
// Generation 3 in training: the kernels' forward pass computes the decoder's integers, and their backward pass the gradients of
// a model in binary64; both straight from the format specification.
#include "RandomNetwork.h"

#include "openntc/encode/Kernels.h"
#include "openntc/encode/detail/LatentStore.h"
#include "openntc/encode/detail/PortableKernel.h"
#include "openntc/encode/detail/TrainingSet.h"
#include "openntc/encode/detail/blocked/Avx2.h"
#include "openntc/encode/detail/blocked/Avx512.h"
#include "openntc/encode/detail/blocked/Neon.h"

#include <doctest/doctest.h>

#include <cmath>
#include <string>

using namespace openntc;
using namespace openntc::encode;
using namespace openntc::encode::detail;

namespace {

constexpr int kFeatures = 8, kSetWidth = 24, kSetHeight = 20, kScale = 3;

/// A network, latents and one tile of a set of 24 x 20 with grids of 8 x 6 and 4 x 3, where a tile reads around both edges.
struct BlendedSet {
    NetworkShape shape =
        MakeTrainerShape(MakeLayeredShape(kScale, kFeatures), NTC_NETWORK_GENERATION_3).network;
    NetworkState network{shape};
    LatentPlanes grids[2];
    MipGeometry mip;
    std::vector<std::uint16_t> reference;
    KernelContext context;

    BlendedSet() {
        RandomStream random(7);
        for (std::size_t n = 0; n < 2; ++n) {
            grids[n].Create({8 >> n, 6 >> n}, kFeatures, MakeBlendedQuantiser());
            for (std::size_t i = 0; i < grids[n].values.size(); ++i)
                grids[n].values[i] = static_cast<float>(random.NextBits() % 16) / 15.0f;
        }
        mip = MakeBlendedMipGeometry(kSetWidth, kSetHeight, 0, grids[0].size, grids[1].size);
        openntc_tests::FillNetwork(network, shape, 2.0f, random);
        reference = openntc_tests::FillContext(context, shape, network, random);
    }

    int GetCode(int grid, int feature, int x, int y) const {
        const LatentPlanes& g = grids[grid];
        const int wx = (x % g.size.width + g.size.width) % g.size.width,
                  wy = (y % g.size.height + g.size.height) % g.size.height;
        const auto at = static_cast<std::size_t>((feature * g.size.height + wy) * g.size.width + wx);
        return static_cast<int>(std::lround(g.values[at] * 15.0f));
    }
};

/// Cell and weight of the second tap in 1/256 (docs of the decoders' filter).
struct Tap {
    int cell, weight;
};
Tap GetTap(int texel, int texels, int latents) {
    const float u = (static_cast<float>(texel) + 0.5f) / static_cast<float>(texels);
    const float p = u * static_cast<float>(latents) - 0.5f, cell = std::floor(p);
    const float shifted = (p - cell) * 256.0f + 0.5f; // rounded in binary32, as the decoders do
    return {static_cast<int>(cell), static_cast<int>(shifted)};
}

/// The network's integers of one texel: inputs of all layers, and its outputs.
struct Evaluation {
    std::vector<int> inputs[kLayers];
    std::vector<float> sums[kLayers]; ///< z
};

int GetSawtoothInput(float t) {
    return static_cast<int>((2.0f * (t - std::floor(t)) - 1.0f) * 127.5f);
}

Evaluation Evaluate(const BlendedSet& set, int x, int y) {
    Evaluation e;
    for (int grid = 0; grid < 2; ++grid) {
        const GridSize size = set.grids[grid].size;
        const Tap tx = GetTap(x, kSetWidth, size.width), ty = GetTap(y, kSetHeight, size.height);
        for (int f = 0; f < kFeatures; ++f) {
            int sum = 0;
            for (int c = 0; c < 4; ++c) {
                const int wx = c % 2 == 0 ? 256 - tx.weight : tx.weight,
                          wy = c / 2 == 0 ? 256 - ty.weight : ty.weight;
                sum += set.GetCode(grid, f, tx.cell + c % 2, ty.cell + c / 2) * wx * wy;
            }
            e.inputs[0].push_back(((17 * sum) >> 16) - 128);
        }
    }
    const float scale = 0.5f * std::max(8.0f / kSetWidth, 6.0f / kSetHeight);
    for (int wave = 0; wave < 3; ++wave) {
        const float px = static_cast<float>(x) * scale * static_cast<float>(1 << wave),
                    py = static_cast<float>(y) * scale * static_cast<float>(1 << wave);
        for (const float t : {px, py, px + 0.25f, py + 0.25f})
            e.inputs[0].push_back(GetSawtoothInput(t));
    }
    const int lod = static_cast<int>(127.5f * (0.25f * std::log2(scale)));
    e.inputs[0].insert(e.inputs[0].end(), {lod, lod});
    const PackedNetwork& packed = set.network.packed;
    for (int layer = 0; layer < kLayers; ++layer) {
        const auto columns = static_cast<std::size_t>(set.shape.LayerInputs(layer));
        e.inputs[layer].resize(columns);
        for (int o = 0; o < set.shape.LayerOutputs(layer); ++o) {
            const int row = NetworkShape::BiasOffset(layer) + o;
            std::int64_t sum = std::llround(packed.bias[row]);
            for (std::size_t i = 0; i < columns; ++i)
                sum += std::llround(packed.integers[static_cast<std::size_t>(set.shape.WeightOffset(layer)) +
                                                    static_cast<std::size_t>(o) * columns + i]) *
                       e.inputs[layer][i];
            const float z = static_cast<float>(sum) * packed.scale[row];
            e.sums[layer].push_back(z);
            if (layer == 3)
                continue;
            // y = min(z, 3) saturate(0.333333 z + 0.5), rint(80 y): 0 ... 240, what - 113 is stored with.
            const float third = z * 0.333333f, gate = std::min(std::max(third + 0.5f, 0.0f), 1.0f);
            e.inputs[layer + 1].push_back(static_cast<int>(std::nearbyint(std::min(z, 3.0f) * gate * 80.0f)));
        }
    }
    return e;
}

/// A sum and the sum of its terms' magnitudes, of which rounding errors are a part.
struct Bounded {
    double value = 0.0, magnitude = 0.0;
    void Add(const Bounded& factor, double other) {
        value += factor.value * other;
        magnitude += factor.magnitude * std::fabs(other);
    }
};

double GetSlope(double z) {
    const double gate = z / 3.0 + 0.5;
    return gate <= 0.0 ? 0.0 : gate < 1.0 ? 2.0 * gate - 0.5 : z <= 3.0 ? 1.0 : 0.0;
}

struct Gradients {
    std::vector<Bounded> weights[kLayers]; ///< [output][input]
    std::vector<Bounded> biases[kLayers];
    std::vector<Bounded> latents[2];
};

Gradients MakeGradients(const BlendedSet& set) {
    Gradients g;
    for (int layer = 0; layer < kLayers; ++layer) {
        const auto outputs = static_cast<std::size_t>(set.shape.LayerOutputs(layer));
        g.biases[layer].resize(outputs);
        g.weights[layer].resize(outputs * static_cast<std::size_t>(set.shape.LayerInputs(layer)));
    }
    for (std::size_t n = 0; n < 2; ++n)
        g.latents[n].resize(set.grids[n].values.size());
    return g;
}

void AddLatentGradients(const BlendedSet& set, int x, int y, const std::vector<Bounded>& inputs,
                        Gradients& g) {
    for (int grid = 0; grid < 2; ++grid) {
        const GridSize size = set.grids[grid].size;
        const Tap tx = GetTap(x, kSetWidth, size.width), ty = GetTap(y, kSetHeight, size.height);
        for (int f = 0; f < kFeatures; ++f) {
            for (int c = 0; c < 4; ++c) {
                const int wx = c % 2 == 0 ? 256 - tx.weight : tx.weight,
                          wy = c / 2 == 0 ? 256 - ty.weight : ty.weight;
                const int cx = (tx.cell + c % 2 + size.width) % size.width,
                          cy = (ty.cell + c / 2 + size.height) % size.height;
                const auto at = static_cast<std::size_t>((f * size.height + cy) * size.width + cx);
                g.latents[grid][at].Add(inputs[static_cast<std::size_t>(grid * kFeatures + f)],
                                        wx * wy / 65536.0);
            }
        }
    }
}

/// Adds those of a texel: derivatives that pass roundings as if there were none.
void AddTexel(const BlendedSet& set, int x, int y, int tileX, int tileY, Gradients& g) {
    const Evaluation e = Evaluate(set, x, y);
    std::vector<Bounded> now(kOutputs);
    for (int c = 0; c < set.context.channels; ++c) {
        const auto texel = static_cast<std::size_t>(c * kTileTexels + (y - tileY) * kTileWidth + x - tileX);
        const auto o = static_cast<std::size_t>(set.context.outputOf[c]);
        const double wanted = static_cast<double>(set.reference[texel]) / 65535.0,
                     gain = static_cast<double>(set.context.gain[c]);
        const auto output = static_cast<double>(e.sums[3][o]);
        now[o] = {(output - wanted) * gain, (std::fabs(output) + wanted) * gain};
    }
    for (int layer = 3; layer >= 0; --layer) {
        const auto inputs = static_cast<std::size_t>(set.shape.LayerInputs(layer));
        std::vector<Bounded> below(inputs);
        for (std::size_t o = 0; o < now.size(); ++o) {
            g.biases[layer][o].Add(now[o], 1.0);
            const float* reals =
                set.network.packed.integers.data() + set.shape.WeightOffset(layer) + o * inputs;
            const auto row =
                static_cast<double>(
                    set.network.packed.scale[static_cast<std::size_t>(NetworkShape::BiasOffset(layer)) + o]) /
                static_cast<double>(layer == 0 ? kInputUnit : kHiddenUnit);
            for (std::size_t i = 0; i < inputs; ++i) {
                g.weights[layer][o * inputs + i].Add(now[o], e.inputs[layer][i]);
                below[i].Add(now[o], static_cast<double>(reals[i]) * row);
            }
        }
        if (layer == 0) {
            AddLatentGradients(set, x, y, below, g);
            break;
        }
        now.assign(below.begin(), below.end());
        for (std::size_t i = 0; i < inputs; ++i) {
            const double slope = GetSlope(static_cast<double>(e.sums[layer - 1][i]));
            now[i] = {below[i].value * slope, below[i].magnitude * std::fabs(slope)};
        }
    }
}

/// `precision`: of the kernel's operands.
template <typename Kernel>
void CheckKernel(const char* name, double precision) {
    CAPTURE(std::string(name));
    BlendedSet set;
    for (int column = 0; column < NetworkState::kColumns; ++column)
        set.network.PackColumn<Kernel>(column, true);
    const auto kernel = std::make_unique<Kernel>(set.shape);
    for (const auto& [left, top] : {std::pair{0, 0}, std::pair{16, 16}}) {
        TileTask task = openntc_tests::MakeTile(set.mip, left, top, kSetWidth, kSetHeight, set.reference);
        AlignedBuffer<float> memory[4];
        LocalGrid* locals[2] = {&task.high, &task.low};
        for (std::size_t n = 0; n < 2; ++n) {
            const auto size = static_cast<std::size_t>(kFeatures * locals[n]->rows * locals[n]->pitch);
            memory[n].Resize(size);
            memory[n + 2].Resize(size);
            locals[n]->values = memory[n].data();
            locals[n]->gradients = memory[n + 2].data();
            set.grids[n].CopyOut<Kernel>(*locals[n], LatentMode::Round, 0);
        }
        const float* outputs = kernel->Infer(set.context, &task, 1);
        Gradients wanted = MakeGradients(set);
        for (int y = 0; y < task.height; ++y) {
            for (int x = 0; x < task.width; ++x) {
                const Evaluation e = Evaluate(set, left + x, top + y);
                for (int o = 0; o < kOutputs; ++o)
                    REQUIRE(outputs[o * Kernel::kTexels + y * kTileWidth + x] ==
                            e.sums[3][static_cast<std::size_t>(o)]);
                AddTexel(set, left + x, top + y, left, top, wanted);
            }
        }
        GradientSums sums;
        sums.weights.Resize(static_cast<std::size_t>(set.shape.WeightCount()));
        kernel->Train(set.context, &task, 1, sums);
        // Roundings of an operand: of the errors once, of the real weights and of the gradients in each of three layers. And
        // those of sums of as many terms as texels, or channels a layer, in binary32.
        const double tolerance = 7.0 * precision + (kTileTexels + 3.0 * kHidden) * std::ldexp(1.0, -24);
        const auto isNear = [&](double value, const Bounded& bounded) {
            return std::fabs(value - bounded.value) <= tolerance * bounded.magnitude;
        };
        std::size_t large = 0;
        for (int layer = 0; layer < kLayers; ++layer) {
            const int columns = set.shape.LayerOutputs(layer),
                      inputs = layer == 0 ? set.shape.Inputs() : set.shape.LayerInputs(layer);
            for (int o = 0; o < columns; ++o) {
                double bias = 0.0;
                for (const float lane : sums.biases[NetworkShape::BiasOffset(layer) + o])
                    bias += static_cast<double>(lane);
                CHECK(isNear(bias, wanted.biases[layer][static_cast<std::size_t>(o)]));
                for (int i = 0; i < inputs; ++i) {
                    const float value = sums.weights[static_cast<std::size_t>(set.shape.WeightOffset(layer) +
                                                                              WeightIndex(columns, i, o))];
                    const Bounded& bounded =
                        wanted.weights[layer][static_cast<std::size_t>(o * set.shape.LayerInputs(layer) + i)];
                    REQUIRE(isNear(static_cast<double>(value), bounded));
                    large += std::fabs(bounded.value) > 10.0 * tolerance * bounded.magnitude ? 1 : 0;
                }
            }
        }
        CHECK(large > 200); // gradients whose size the tolerance does not hide
        for (std::size_t n = 0; n < 2; ++n) {
            LatentPlanes& grid = set.grids[n];
            for (std::size_t i = 0; i < grid.gradients.size(); ++i)
                grid.gradients[i] = 0.0f;
            grid.AddGradients(*locals[n], 0, grid.size.height / 2);
            grid.AddGradients(*locals[n], grid.size.height / 2, grid.size.height);
            for (std::size_t i = 0; i < grid.gradients.size(); ++i)
                CHECK(isNear(static_cast<double>(grid.gradients[i]), wanted.latents[n][i]));
        }
    }
}

} // namespace

TEST_CASE("generation 3: kernels compute the decoder's integers, and the gradients of a model in binary64") {
    constexpr double kExact = 0.0;
    [[maybe_unused]] constexpr double kBfloat16 = 1.0 / 512.0;
    CheckKernel<PortableKernel>("portable", kExact);
    [[maybe_unused]] const auto has = [](KernelChoice kernel) {
        if (!IsKernelAvailable(kernel))
            MESSAGE("SKIP: kernel: " << std::string(KernelToString(kernel))
                                     << ": this machine or build does not have it");
        return IsKernelAvailable(kernel);
    };
#if OPENNTC_FAST_X86
    if (has(KernelChoice::Avx2))
        CheckKernel<avx2::Kernel>("avx2", kExact);
    if (has(KernelChoice::Avx512))
        CheckKernel<avx512::fma::Kernel>("avx512", kExact);
    if (has(KernelChoice::Avx512Bf16))
        CheckKernel<avx512::bf16::Kernel>("avx512-bf16", kBfloat16);
#elif OPENNTC_FAST_NEON
    if (has(KernelChoice::Neon))
        CheckKernel<neon::fma::Kernel>("neon", kExact);
#if OPENNTC_FAST_NEON_BF16
    if (has(KernelChoice::NeonBf16))
        CheckKernel<neon::bf16::Kernel>("neon-bf16", kBfloat16);
#endif
#endif
}
