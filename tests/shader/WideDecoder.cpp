// SPDX-License-Identifier: MIT
// Compiled by itself and optimised (tests.cmake): loops over texels are innermost, so that a compiler makes them vectors.
#include "shader/WideDecoder.h"

#include "openntc/Inference.h"
#include "openntc/MathModes.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace openntc_tests {

namespace {

class WideDecoder {
public:
    WideDecoder(const openntc::DecodeSource& source, int math) : source_(source), math_(math) {}

    void Decode(int mip, openntc::Rect rect, std::span<float> outputs) {
        const std::size_t texels = static_cast<std::size_t>(rect.width * rect.height);
        for (std::size_t first = 0; first < texels; first += kTexels) {
            const std::size_t count = std::min(kTexels, texels - first);
            for (std::size_t t = 0; t < count; ++t) {
                const int index = static_cast<int>(first + t);
                PrepareInputs(mip, {rect.left + index % rect.width, rect.top + index / rect.width}, t);
            }
            EvaluateNetwork();
            for (std::size_t t = 0; t < count; ++t) {
                for (std::size_t c = 0; c < 16; ++c)
                    outputs[16 * (first + t) + c] = outputs_[c][t];
            }
        }
    }

private:
    static constexpr std::size_t kTexels = 16;
    using Lanes = std::array<float, kTexels>;
    using Vector = std::array<Lanes, NTC_MAX_INPUTS>;

    template <typename T>
    T Load(std::size_t offset) const {
        T value;
        std::memcpy(&value, source_.weights.data() + offset, sizeof value);
        return value;
    }

    void PrepareInputs(int mip, openntc::shader::int2 texel, std::size_t lane) {
        float inputs[NTC_MAX_INPUTS];
        openntc::shader::NtcPrepareRealInputsFrom(
            source_.networkVersion, math_, openntc::shader::NtcGetMip(*source_.constants, mip),
            {source_.latents.data(), source_.latents.size()}, 0, texel, inputs);
        for (std::size_t i = 0; i < GetInputs(0); ++i)
            x_[i][lane] = inputs[i];
    }

    std::size_t GetInputs(int layer) const {
        return layer == 0 ? 4 * openntc::shader::NtcGetInputWords(source_.networkVersion) : 64;
    }

    void EvaluateNetwork() {
        for (int layer = 0; layer < 3; ++layer) {
            for (std::size_t row = 0; row < 64; ++row) {
                Lanes z = math_ == NTC_MATH_FP8 ? EvaluateE4M3Row(layer, row) : EvaluateRow(layer, row);
                for (float& value : z)
                    value = Activate(value, layer);
                y_[row] = z;
            }
            x_ = y_;
        }
        for (std::size_t row = 0; row < 16; ++row)
            outputs_[row] = math_ == NTC_MATH_FP8 ? EvaluateByteRow(row) : EvaluateRow(3, row);
    }

    /// What the next layer reads; behind the FP8 network's layer 2 a signed integer.
    float Activate(float z, int layer) const {
        using namespace openntc::shader;
        if (math_ == NTC_MATH_FP32)
            return NtcMultiply(NtcApplyActivation(NtcGetThird(source_.networkVersion), z), 80.0f);
        if (math_ == NTC_MATH_FP8 && layer == 2)
            return static_cast<float>(static_cast<std::int8_t>(NtcActivateHalf(z)));
        const float y = NtcApplyActivationHalf(z);
        return math_ == NTC_MATH_FP8 ? NtcRoundToE4M3(y) : y;
    }

    std::size_t GetWeightOffset(int layer) const {
        const openntc::NtcTextureSetConstants& c = *source_.constants;
        const int offsets[] = {c.networkWeightOffset0, c.networkWeightOffset1, c.networkWeightOffset2,
                               c.networkWeightOffset3};
        return static_cast<std::size_t>(offsets[layer]);
    }

    std::size_t GetScaleOffset() const {
        return static_cast<std::size_t>(source_.constants->networkScaleBiasOffset);
    }

    /// shaders/openntc/NetworkFloat.h.
    Lanes EvaluateRow(int layer, std::size_t row) const {
        const std::size_t inputs = GetInputs(layer);
        const std::size_t weights = GetWeightOffset(layer) + inputs * row;
        const std::size_t index = 64 * static_cast<std::size_t>(layer) + row;
        const float scale = Load<float>(GetScaleOffset() + 4 * index);
        std::uint32_t bias = Load<std::uint32_t>(GetScaleOffset() + 4 * (NTC_LAYER_OUTPUTS + index));
        Lanes q[NTC_MAX_INPUTS];
        for (std::size_t i = 0; i < inputs; ++i) {
            const int weight = static_cast<int>(Load<std::int8_t>(weights + i));
            if (layer != 0)
                bias -= 113u * static_cast<std::uint32_t>(weight);
            q[i].fill(static_cast<float>(weight));
        }
        const float shift = static_cast<float>(static_cast<std::int32_t>(bias));
        Lanes sum{};
        if (math_ == NTC_MATH_FP32) {
            for (std::size_t i = 0; i < inputs; ++i) {
                for (std::size_t t = 0; t < kTexels; ++t)
                    sum[t] += q[i][t] * x_[i][t];
            }
            for (float& value : sum)
                value = (value + shift) * scale;
            return sum;
        }
        for (std::size_t block = 0; block < inputs; block += 16) {
            Lanes lanes[4] = {};
            for (std::size_t i = block; i < block + 16; ++i) {
                for (std::size_t t = 0; t < kTexels; ++t)
                    lanes[i % 4][t] = RoundSum(lanes[i % 4][t] + RoundSum(q[i][t] * x_[i][t]));
            }
            for (std::size_t t = 0; t < kTexels; ++t)
                sum[t] = RoundSum(sum[t] + RoundSum(RoundSum(lanes[0][t] + lanes[1][t]) +
                                                    RoundSum(lanes[2][t] + lanes[3][t])));
        }
        using openntc::shader::NtcRoundToHalf;
        const float unit = scale * (layer == 0 ? 128.0f : 80.0f);
        for (float& value : sum)
            value = NtcRoundToHalf(NtcRoundToHalf(value * unit) + NtcRoundToHalf(shift * scale));
        return sum;
    }

    /// Nearest half of a number below 65520. The floats' bits are compared as integers, which vectors of SSE2 can do.
    static float RoundSum(float x) {
        const std::int32_t exponent = std::bit_cast<std::int32_t>(x) & 0x7F800000;
        const float shift = std::bit_cast<float>(std::max(exponent, 0x38800000) + 0x06C00000);
        return (x + shift) - shift;
    }

    /// shaders/openntc/NetworkFP8.h.
    Lanes EvaluateE4M3Row(int layer, std::size_t row) const {
        using namespace openntc::shader;
        const std::size_t inputs = GetInputs(layer);
        const std::size_t weights = GetWeightOffset(layer) + inputs * row;
        const std::size_t bias = GetScaleOffset() + 128 * static_cast<std::size_t>(layer) + 2 * row;
        Lanes sum;
        sum.fill(NtcWidenHalf(Load<std::uint16_t>(bias)));
        for (std::size_t i = 0; i < inputs; ++i) {
            const float weight = NtcWidenE4M3(Load<std::uint8_t>(weights + i), 0);
            for (std::size_t t = 0; t < kTexels; ++t)
                sum[t] += weight * x_[i][t];
        }
        for (float& value : sum)
            value = NtcRoundToHalf(value);
        return sum;
    }

    /// The FP8 network's last layer: exact in float but for one rounding, as |sum| < 2^24 without the bias.
    Lanes EvaluateByteRow(std::size_t row) const {
        const std::size_t scales = GetScaleOffset() + 384;
        const float scale = Load<float>(scales + 4 * row);
        const std::int32_t bias = Load<std::int32_t>(scales + 64 + 4 * row);
        Lanes sum{};
        for (std::size_t i = 0; i < 64; ++i) {
            const float weight = static_cast<float>(Load<std::int8_t>(GetWeightOffset(3) + 64 * row + i));
            for (std::size_t t = 0; t < kTexels; ++t)
                sum[t] += weight * x_[i][t];
        }
        for (float& value : sum)
            value = static_cast<float>(bias + static_cast<std::int32_t>(value)) * scale;
        return sum;
    }

    openntc::DecodeSource source_;
    int math_;
    Vector x_{};
    Vector y_{};
    std::array<Lanes, 16> outputs_{};
};

} // namespace

void DecodeWide(const openntc::DecodeSource& source, int math, int mip, openntc::Rect rect,
                std::span<float> outputs) {
    WideDecoder(source, math).Decode(mip, rect, outputs);
}

} // namespace openntc_tests
