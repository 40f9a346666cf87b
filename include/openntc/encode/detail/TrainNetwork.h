// SPDX-License-Identifier: MIT
// Stability: internal
// The network in training: shapes, the order of inputs inside the trainer, packed weights and gradient sums.
#pragma once

#include "openntc/encode/detail/Geometry.h"
#include "openntc/format/NetworkDescription.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>

#include "openntc/core/HideMacros.h"

namespace openntc::encode::detail {

inline constexpr int kLayers = kNetworkLayers;
inline constexpr int kHidden = kHiddenChannels;
inline constexpr int kOutputs = kMaxChannels;
inline constexpr int kWaveInputs = kWaveSlots + 2; ///< with the lod twice
inline constexpr float kInputUnit = 1.0f / 127.5f;
inline constexpr float kHiddenUnit = 0.0125f; ///< step of the hidden quantiser
inline constexpr float kHiddenSteps = 80.0f;  ///< of it in 1
inline constexpr int kTaper = 16;             ///< hidden channels that each layer of generation 3 has less
/// The activation's 1 / 3 in generation 3, and inputs of latents below which codes of 0 lie.
inline constexpr float kBlendedThird = 0.333333f;
inline constexpr float kBlendedOffset = 128.0f;
inline constexpr float kHalfThird = 0.333251953125f; ///< 1 / 3 in binary16, of FP8 networks

/// A block of memory for SIMD and tile loads, zeroed.
template <typename T>
class AlignedBuffer {
public:
    AlignedBuffer() = default;
    explicit AlignedBuffer(std::size_t count) { Resize(count); }
    void Resize(std::size_t count) {
        data_.reset(static_cast<T*>(::operator new[](count * sizeof(T), std::align_val_t(64))));
        size_ = count;
        for (std::size_t i = 0; i < count; ++i)
            data_[i] = T{};
    }
    T* data() { return data_.get(); }
    const T* data() const { return data_.get(); }
    std::size_t size() const { return size_; }
    T& operator[](std::size_t i) { return data_[i]; }
    const T& operator[](std::size_t i) const { return data_[i]; }

private:
    struct Release {
        void operator()(T* p) const { ::operator delete[](p, std::align_val_t(64)); }
    };
    std::unique_ptr<T[], Release> data_;
    std::size_t size_ = 0;
};

/// Sizes of the trained network. Inside the trainer only slots that a decoder fills are kept, densely:
/// generation 1: 4 corners x high-res features, low-res features, waves, lod; generation 3: features of the
/// even latent mip of a pair ("high"), of the odd one ("low"), waves, lod.
struct NetworkShape {
    int highFeatures = 4, lowFeatures = 4;
    int highSlots = 4; ///< of the file's network: 4, 8, 12 or 16 at each corner
    /// Generation 3: both latent mips are blended, wrap around, and the hidden layers taper.
    bool blended = false;

    /// Of either grid's features.
    int HighInputs() const { return blended ? highFeatures : 4 * highFeatures; }
    int LatentInputs() const { return HighInputs() + lowFeatures; }
    int Inputs() const { return LatentInputs() + kWaveInputs; }
    int PaddedInputs() const { return (Inputs() + 31) / 32 * 32; }
    int LayerInputs(int layer) const { return layer == 0 ? PaddedInputs() : LayerOutputs(layer - 1); }
    int LayerOutputs(int layer) const {
        return layer == 3 ? kOutputs : kHidden - (blended ? kTaper * layer : 0);
    }

    /// Column of the file's layer 0 that belongs to the trainer's input `slot`; -1 for padding.
    int FileSlot(int slot) const {
        const int highColumns = blended ? highSlots : 4 * highSlots;
        if (slot < HighInputs())
            return slot / highFeatures * highSlots + slot % highFeatures;
        slot -= HighInputs();
        if (slot < lowFeatures)
            return highColumns + slot;
        slot -= lowFeatures;
        return slot < kWaveInputs ? highColumns + kLowResSlots + slot : -1;
    }
    /// First parameter of a layer in arrays that hold all weights.
    int WeightOffset(int layer) const {
        int offset = 0;
        for (int l = 0; l < layer; ++l)
            offset += LayerInputs(l) * LayerOutputs(l);
        return offset;
    }
    /// What a hidden layer's packed scale is of its row's: generation 1 counts in steps of the quantiser.
    float HiddenScale() const { return blended ? 1.0f : kHiddenSteps; }
    /// First bias of a layer in arrays that hold all of them, with room for kHidden a layer.
    int WeightCount() const { return WeightOffset(3) + LayerInputs(3) * kOutputs; }
    static int BiasOffset(int layer) { return layer * kHidden; }
    static constexpr int kBiases = 3 * kHidden + kOutputs;
};

// Weights, their moments and their gradients lie in tiles of 16 inputs x 16 outputs, output fastest:
// [input / 16][output / 16][input % 16][output % 16]. It is what the matrix kernels write.
inline int WeightIndex(int outputs, int input, int output) {
    return ((input / 16) * (outputs / 16) + output / 16) * 256 + (input % 16) * 16 + output % 16;
}

/// Working weights of one step, as the kernels read them. Each kernel fills what it reads.
struct PackedNetwork {
    AlignedBuffer<float>
        integers; ///< per layer [output][input], integer-valued when quantised, or E4M3: what files hold
    AlignedBuffer<float> reals; ///< portable kernels: the same times the row's weight scale
    AlignedBuffer<std::uint16_t>
        forward; ///< tiles, bfloat16: integers, per layer [output / 16][input / 32][output % 16][input % 32]
    AlignedBuffer<std::uint16_t>
        backward; ///< tiles, bfloat16: reals, per layer [input / 16][output / 32][input % 16][output % 32]
    AlignedBuffer<float> columns; ///< blocked kernels: integers, per layer units [input][output]
    AlignedBuffer<float> rows;    ///< blocked kernels: reals, per layer units [output][input]
    /// Layers 0-2: NetworkShape::HiddenScale x row scale; layer 3: row scale.
    alignas(64) float scale[NetworkShape::kBiases] = {};
    alignas(64) float bias[NetworkShape::kBiases] = {}; ///< bias / row scale, integer when quantised

    static int ForwardOffset(const NetworkShape& shape, int layer) { return shape.WeightOffset(layer); }
    /// Layer 3 is padded to 32 outputs.
    static int BackwardOffset(const NetworkShape& shape, int layer) { return shape.WeightOffset(layer); }
    static std::size_t BackwardSize(const NetworkShape& shape) {
        return static_cast<std::size_t>(shape.WeightOffset(3)) + std::size_t{kHidden} * 32;
    }
};

/// Loss of an alpha mask whose reference is exactly 0 or 1, trained to outputs of 0 and 1 that lie beyond the
/// range of stored values: none on the far side, and a steeper one for errors that come near the range.
struct MaskLoss {
    static constexpr float kLow = 0.05f,
                           kHigh = 0.95f; ///< references below and above are exact: others are 0.1 ... 0.9
    static constexpr float kKnee = 0.03f; ///< errors above are pushed; an error of 0.1 is a violation

    /// The error without the far side's.
    static float Clip(float error, float wanted) {
        if (wanted < kLow)
            return std::max(error, 0.0f);
        return wanted > kHigh ? std::min(error, 0.0f) : error;
    }
    /// What the gradient is in proportion to, for a clipped error.
    static float Weigh(float error, float wanted, float push) {
        if (wanted < kLow)
            return error + push * std::max(error - kKnee, 0.0f);
        return wanted > kHigh ? error + push * std::min(error + kKnee, 0.0f) : error;
    }
    /// What Weigh is half the derivative of.
    static float Sum(float error, float wanted, float push) {
        const float excess = std::max(std::fabs(error) - kKnee, 0.0f);
        return error * error + (wanted < kLow || wanted > kHigh ? push : 0.0f) * (excess * excess);
    }
};

/// Sums over the texels of one slice of a batch.
struct GradientSums {
    AlignedBuffer<float> weights; ///< WeightIndex order per layer, at WeightOffset
    alignas(64) float biases[NetworkShape::kBiases][16] = {};
    alignas(64) float loss[kOutputs][16] = {}; ///< squared error in stored units
    void Clear() {
        for (std::size_t i = 0; i < weights.size(); ++i)
            weights[i] = 0.0f;
        for (auto& row : biases)
            for (float& value : row)
                value = 0.0f;
        for (auto& row : loss)
            for (float& value : row)
                value = 0.0f;
    }
};

/// Copy of the latents that one tile reads, and the gradients of the same.
struct LocalGrid {
    float* values = nullptr;    ///< [feature][row][pitch], integer network inputs before weighting
    float* gradients = nullptr; ///< same layout; written by the kernel
    int originX = 0, originY = 0;
    int width = 0, rows = 0, pitch = 0; ///< pitch is a multiple of 16
};

/// One tile of colour texels to train on.
struct TileTask {
    const MipGeometry* mip = nullptr;
    int x = 0, y = 0;
    int width = 0, height = 0; ///< texels inside the image, at most 16 x 8
    LocalGrid high, low;
    const std::uint16_t* reference =
        nullptr; ///< [trained channel][128], 0 ... 65535 over the channel's range
};

/// What every kernel call shares.
struct KernelContext {
    NetworkShape shape;
    const PackedNetwork* packed = nullptr;
    int channels = 0; ///< trained channels; network output of each in outputOf
    int outputOf[kMaxChannels] = {};
    float gain[kMaxChannels] = {};         ///< d(loss)/d(output) per unit of output error
    float squaredRange[kMaxChannels] = {}; ///< (channel range)^2: output error to stored error
    int maskIndex = -1;    ///< trained channel that is the alpha mask, when masked texels are discarded
    float maskZero = 0.0f; ///< reference values (0 ... 1) up to this are masked out
    int oneSided = -1;     ///< trained channel that is an alpha mask: MaskLoss applies
    float maskPush = 0.0f; ///< of MaskLoss
};

/// What training descends, texel by texel: weighted squared errors of the tile's outputs ([16][stride]) to
/// rows of 16. Texels of the tile beyond the image get arbitrary numbers.
inline void WriteTexelLosses(const KernelContext& context, const TileTask& tile, const float* outputs,
                             int stride, float* to, std::size_t pitch) {
    constexpr float kUnit = 1.0f / 65535.0f;
    for (int y = 0; y < kTileHeight; ++y, to += pitch) {
        float sums[kTileWidth] = {}, masked[kTileWidth] = {};
        for (int c = 0; c < context.channels; ++c) {
            const float* row = outputs + context.outputOf[c] * stride + y * kTileWidth;
            const std::uint16_t* reference = tile.reference + c * kTileTexels + y * kTileWidth;
            const float gain = context.gain[c];
            if (c == context.oneSided) {
                for (int x = 0; x < kTileWidth; ++x) {
                    const float wanted = static_cast<float>(reference[x]) * kUnit;
                    const float error = MaskLoss::Clip(row[x] - wanted, wanted);
                    masked[x] = MaskLoss::Sum(error, wanted, context.maskPush) * gain;
                }
                continue;
            }
            for (int x = 0; x < kTileWidth; ++x) {
                const float error = row[x] - static_cast<float>(reference[x]) * kUnit;
                sums[x] += error * error * gain;
            }
        }
        if (context.maskIndex >= 0) { // masked texels are discarded
            const std::uint16_t* mask = tile.reference + context.maskIndex * kTileTexels + y * kTileWidth;
            for (int x = 0; x < kTileWidth; ++x)
                sums[x] = static_cast<float>(mask[x]) * kUnit > context.maskZero ? sums[x] : 0.0f;
        }
        for (int x = 0; x < kTileWidth; ++x)
            to[x] = sums[x] + masked[x];
    }
}

} // namespace openntc::encode::detail

#include "openntc/core/RestoreMacros.h"
