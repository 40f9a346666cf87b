// SPDX-License-Identifier: MIT
// Small sets to train on, and a kernel of the processor that tells what it computed.
#pragma once

#include "vulkan_harness/ForwardingDevice.h"

#include "openntc/encode/Material.h"
#include "openntc/encode/detail/DeviceTrainer.h"
#include "openntc/encode/detail/PortableKernel.h"

#include <doctest/doctest.h>

#include <cmath>
#include <vector>

namespace openntc::test {

/// Waves in two channels and a disc in a third, which may be a mask.
inline encode::Material MakeWaves(int width, int height, float scale = 1.0f) {
    encode::Material material = *encode::Material::Create(width, height);
    std::vector<float> texels;
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const auto u = static_cast<float>(x), v = static_cast<float>(y);
            texels.push_back(scale * (0.5f + 0.5f * std::sin(0.7f * u + 0.1f * v)));
            texels.push_back(0.5f + 0.3f * std::sin(0.2f * u - 0.9f * v) * std::sin(0.05f * v));
            texels.push_back(std::hypot(u - 9.0f, v - 9.0f) < 7.0f ? 1.0f : 0.0f);
        }
    }
    REQUIRE(material.AddTexture({.name = "A", .firstChannel = 0, .channels = 3}, texels));
    material.GenerateMips();
    return material;
}

inline encode::detail::TrainingSet MakeSet(const encode::Material& material, int maskChannel,
                                           bool discardMasked) {
    const std::array<float, 16> scales = {1, 0.5f, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1};
    return encode::detail::TrainingSet::Make(
        material.GetWidth(), material.GetHeight(), material.GetMipCount(),
        [&](int mip, int channel) { return material.GetPlane(mip, channel); }, material.GetDeclaredChannels(),
        maskChannel, discardMasked, scales);
}

inline encode::detail::TrainerShape MakeShape(int highFeatures, int lowFeatures, int scale, int highBits,
                                              int lowBits) {
    return {{.highFeatures = highFeatures, .lowFeatures = lowFeatures, .highSlots = highFeatures},
            scale,
            highBits,
            lowBits};
}

/// Of generation 3.
inline encode::detail::TrainerShape MakeLayeredTrainer(int features, int scale) {
    return encode::detail::MakeTrainerShape(MakeLayeredShape(scale, features), NTC_NETWORK_GENERATION_3);
}

/// Sums over a step.
struct ToldGradients {
    std::vector<double> weights = {}, biases = {};
    std::vector<double> latents[2] = {}; ///< of all grids of a resolution, one after the other
    std::vector<std::size_t> firsts[2] = {};
    std::vector<encode::detail::GridSize> sizes[2] = {};
};

/// The portable kernel, which also adds up the gradients of all that it is given. For one thread.
class TellingKernel : public encode::detail::PortableKernel {
public:
    using PortableKernel::PortableKernel;

    static inline ToldGradients told;

    static void Begin(std::span<const encode::detail::LatentPlanes> high,
                      std::span<const encode::detail::LatentPlanes> low) {
        told = ToldGradients();
        for (int side = 0; side < 2; ++side) {
            for (const encode::detail::LatentPlanes& grid : side == 0 ? high : low) {
                told.firsts[side].push_back(told.latents[side].size());
                told.sizes[side].push_back(grid.size);
                told.latents[side].resize(told.latents[side].size() + grid.values.size());
            }
        }
    }
    void Begin() {}

    void Train(const encode::detail::KernelContext& context, encode::detail::TileTask* tiles, int count,
               encode::detail::GradientSums& sums) {
        encode::detail::GradientSums mine;
        mine.weights.Resize(sums.weights.size());
        PortableKernel::Train(context, tiles, count, mine);
        told.weights.resize(mine.weights.size());
        told.biases.resize(encode::detail::NetworkShape::kBiases);
        for (std::size_t i = 0; i < mine.weights.size(); ++i)
            told.weights[i] += static_cast<double>(mine.weights[i]);
        for (std::size_t i = 0; i < told.biases.size(); ++i)
            told.biases[i] += static_cast<double>(mine.biases[i][0]);
        for (int i = 0; i < count; ++i) {
            AddLatents(0, tiles[i].high, context.shape.highFeatures, tiles[i].mip->neuralMip);
            AddLatents(1, tiles[i].low, context.shape.lowFeatures, tiles[i].mip->neuralMip);
        }
    }

private:
    static void AddLatents(int side, const encode::detail::LocalGrid& grid, int features, int neuralMip) {
        const auto n = static_cast<std::size_t>(neuralMip);
        const encode::detail::GridSize size = told.sizes[side][n];
        for (int f = 0; f < features; ++f) {
            for (int y = 0; y < grid.rows; ++y) {
                for (int x = 0; x < grid.width; ++x) {
                    const int column = encode::detail::WrapLatent(grid.originX + x, size.width),
                              row = encode::detail::WrapLatent(grid.originY + y, size.height);
                    told.latents[side]
                                [told.firsts[side][n] +
                                 static_cast<std::size_t>((f * size.height + row) * size.width + column)] +=
                        static_cast<double>(grid.gradients[(f * grid.rows + y) * grid.pitch + x]);
                }
            }
        }
    }
};

/// Makes no steps of the optimiser.
class WithoutUpdates final : public harness::ForwardingDevice {
public:
    using harness::ForwardingDevice::ForwardingDevice;
    Expected<void> Submit(std::span<const std::uint32_t> batch, std::span<const std::uint16_t> references,
                          std::span<const encode::TrainingDispatch> dispatches) override {
        std::vector<encode::TrainingDispatch> kept;
        for (const encode::TrainingDispatch& dispatch : dispatches) {
            if (dispatch.pass != encode::TrainingPass::TrainUpdate)
                kept.push_back(dispatch);
        }
        return ForwardingDevice::Submit(batch, references, kept);
    }
};

/// Has smaller buffers, and no memory for the first plans that it is asked for.
class SmallDevice final : public harness::ForwardingDevice {
public:
    SmallDevice(encode::TrainingDevice& device, std::uint64_t largestBuffer, int refusals)
        : harness::ForwardingDevice(device), largestBuffer_(largestBuffer), refusals_(refusals) {}
    std::uint64_t GetLargestBuffer() const override { return largestBuffer_; }
    Expected<void> Create(const encode::TrainingPlan& wanted) override {
        if (refusals_-- > 0)
            return Fail(Status::OutOfMemory, "memory: as was asked for");
        return ForwardingDevice::Create(wanted);
    }

private:
    std::uint64_t largestBuffer_;
    int refusals_;
};

/// All of a buffer.
template <typename T>
std::vector<T> ReadAll(encode::TrainingDevice& device, const encode::TrainingPlan& plan,
                       encode::TrainingBuffer buffer) {
    std::vector<T> values(plan.bytes[static_cast<std::size_t>(buffer)] / sizeof(T));
    REQUIRE(device.Read(buffer, 0, std::as_writable_bytes(std::span(values))));
    return values;
}

} // namespace openntc::test
