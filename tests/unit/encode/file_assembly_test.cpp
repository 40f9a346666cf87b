// SPDX-License-Identifier: MIT
// What of a trained network and its latents gets into the file, and the measure of discarded texels.
#include "openntc/encode/Material.h"
#include "openntc/encode/UsefulSteps.h"
#include "openntc/encode/detail/FileAssembly.h"
#include "openntc/encode/detail/PortableKernel.h"
#include "openntc/encode/detail/Schedule.h"

#include <doctest/doctest.h>

#include <cmath>

using namespace openntc;
using namespace openntc::encode;
using namespace openntc::encode::detail;

namespace {

/// 16 channels with ranges and minima of all sizes.
Material MakeRanges() {
    Material material = *Material::Create(16, 8);
    for (int c = 0; c < 16; ++c) {
        std::vector<float> texels;
        for (int i = 0; i < 128; ++i)
            texels.push_back(0.37f * static_cast<float>(c - 7) +
                             std::ldexp(static_cast<float>(i) / 127.0f, c % 5 - 3));
        REQUIRE(material.AddTexture({.name = std::to_string(c), .firstChannel = c, .channels = 1}, texels));
    }
    material.GenerateMips(1);
    return material;
}

TrainingSet MakeSet(const Material& material, int mask = -1, bool discard = false) {
    const std::array<float, 16> scales = {1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1};
    return TrainingSet::Make(
        material.GetWidth(), material.GetHeight(), material.GetMipCount(),
        [&](int mip, int channel) { return material.GetPlane(mip, channel); }, material.GetDeclaredChannels(),
        mask, discard, scales);
}

TrainerShape MakeAssemblyShape() {
    return {{.highFeatures = 4, .lowFeatures = 4, .highSlots = 4}, 2, 2, 4};
}

} // namespace

TEST_CASE("biases of outputs are rounded to the nearest integer of their scale") {
    const Material material = MakeRanges();
    const TrainingSet set = MakeSet(material);
    ThreadTeam team(1);
    Trainer<PortableKernel> trainer(set, MakeAssemblyShape(), 1, 4, team);
    trainer.PackNetwork();
    const NetworkState& network = trainer.GetNetwork();
    int beyondHalf = 0;
    for (int c = 0; c < 16; ++c) {
        CAPTURE(c);
        const QuantisedRow row = MakeOutputRow(network, set, c);
        std::int64_t sum = 0;
        for (const std::int8_t weight : row.weights)
            sum += weight;
        const ChannelPlan& plan = set.GetChannel(c);
        const auto scale = static_cast<double>(row.scale);
        // What the row adds in stored values: the network's bias, and the channel's minimum.
        const double wanted =
            static_cast<double>(network.packed.bias[NetworkShape::BiasOffset(3) + c]) * scale +
            static_cast<double>(plan.minimum);
        const double difference = static_cast<double>(row.bias - 113 * sum) - wanted / scale;
        CHECK(std::fabs(difference) <= 0.5 + 1e-6);
        // Cutting would be off by the fraction itself.
        beyondHalf += std::fabs(std::trunc(wanted / scale) - wanted / scale) > 0.5 ? 1 : 0;
    }
    CHECK(beyondHalf > 0);
}

TEST_CASE("latents of 1, 2, 4 and 8 bits are packed from the lowest bit of each byte on") {
    for (const int bits : {1, 2, 4, 8}) {
        CAPTURE(bits);
        LatentPlanes grid;
        grid.Create({5, 3}, 3, MakeLatentQuantiser(bits));
        const LatentQuantiser& q = grid.quantiser;
        const auto codeOf = [&](std::size_t pixel, std::size_t feature) {
            return static_cast<unsigned>(pixel * 7 + feature * 5 + pixel * pixel) % (1u << bits);
        };
        for (std::size_t pixel = 0; pixel < 15; ++pixel) {
            for (std::size_t f = 0; f < 3; ++f)
                grid.values[f * 15 + pixel] =
                    static_cast<float>(static_cast<int>(codeOf(pixel, f)) + q.lowestLevel) / q.scale;
        }
        const std::vector<std::byte> bytes = PackLatents(grid);
        CHECK(bytes.size() == static_cast<std::size_t>((45 * bits + 31) / 32 * 4));
        // Element n, features of a pixel together, has bits n * bits and up; bit 0 of a byte is its lowest.
        for (std::size_t n = 0; n < 45; ++n) {
            unsigned code = 0;
            for (int b = 0; b < bits; ++b) {
                const std::size_t bit = n * static_cast<std::size_t>(bits) + static_cast<std::size_t>(b);
                code |= (static_cast<unsigned>(bytes[bit / 8]) >> (bit % 8) & 1u) << b;
            }
            REQUIRE(code == codeOf(n / 3, n % 3));
        }
    }
}

TEST_CASE("discarded texels count for the mask alone") {
    // Channel 0 is a mask that is 0 in half of the texels, channel 1 a ramp.
    Material material = *Material::Create(16, 8);
    std::vector<float> texels;
    for (int i = 0; i < 128; ++i) {
        texels.push_back(i % 16 < 8 ? 0.0f : 1.0f);
        texels.push_back(static_cast<float>(i) / 127.0f);
    }
    REQUIRE(material.AddTexture({.name = "A", .firstChannel = 0, .channels = 2}, texels));
    material.GenerateMips(1);
    // Outputs that are wrong by 1/4 everywhere, and wildly wrong where the mask is 0.
    constexpr float kOff = 0.25f, kWild = 5.0f;
    for (const bool discard : {false, true}) {
        CAPTURE(discard);
        const TrainingSet set = MakeSet(material, 0, discard);
        std::vector<float> outputs(16 * kTileTexels);
        const ChannelPlan &mask = set.GetChannel(0), &ramp = set.GetChannel(1);
        for (std::size_t i = 0; i < 128; ++i) {
            outputs[i] = (texels[2 * i] - mask.minimum) / mask.range;
            outputs[kTileTexels + i] =
                (texels[2 * i + 1] + (i % 16 < 8 ? kWild : kOff) - ramp.minimum) / ramp.range;
        }
        TileTask tile;
        tile.width = 16;
        tile.height = 8;
        tile.reference = set.GetReference(0);
        LossSums sums;
        set.AddErrors(tile, outputs.data(), kTileTexels, sums);
        // References have 16 bits: 1e-4 of each error.
        const double seen = 64.0 * kOff * kOff, hidden = 64.0 * kWild * kWild;
        const double counted = discard ? seen : seen + hidden, samples = discard ? 128.0 + 64.0 : 256.0;
        CHECK(sums.Psnr(2) == doctest::Approx(-10.0 * std::log10(counted / samples)).epsilon(1e-3));
        CHECK(sums.ChannelPsnr(1) ==
              doctest::Approx(-10.0 * std::log10(counted / (discard ? 64.0 : 128.0))).epsilon(1e-3));
        CHECK(sums.ChannelPsnr(0) > 80.0);
    }
}

TEST_CASE("useful steps: twenty visits of a texel, and a least number") {
    // As Schedule has it: the settling tenth as long as the memory of the second moment, and a latent's way.
    const double memory = 1.0 / (1.0 - static_cast<double>(Schedule::kNetworkBeta2));
    CHECK(std::lround(memory / (1.0 - Schedule{}.freeze)) == 1000);
    CHECK(std::lround(1.0f / (0.5f * Schedule{}.latentRate)) == 20);
    CHECK(GetUsefulSteps(1.0) == 1000);
    CHECK(GetUsefulSteps(4096.0 * 50.0) == 1000);
    CHECK(GetUsefulSteps(4096.0 * 100.0) == 2000);
    CHECK(GetUsefulSteps(4096.0 * 100.0 + 1.0) == 2001);
}
