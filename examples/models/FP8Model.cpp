// SPDX-License-Identifier: MIT
#include "ModelInputs.h"

namespace openntc::models {

std::array<ModelLayer, 4> GetModelLayers(const ModelSource& source) {
    const NtcTextureSetConstants& c = *source.constants;
    const std::size_t inputs = 32 + 16 * static_cast<std::size_t>(source.networkVersion);
    return {{{static_cast<std::size_t>(c.networkWeightOffset0), inputs, 64},
             {static_cast<std::size_t>(c.networkWeightOffset1), 64, 64},
             {static_cast<std::size_t>(c.networkWeightOffset2), 64, 64},
             {static_cast<std::size_t>(c.networkWeightOffset3), 64, 16}}};
}

std::vector<double> GetFP8ModelInputs(const ModelSource& source, int mip, int x, int y) {
    const auto latent = [](int code, int bits) {
        const double levels = bits == 8 ? 127.5 : std::ldexp(1.0, bits - 1) + 0.5;
        const double step = ToBinary32(1 / levels);
        const double bias = ToBinary32((1.5 - levels) * step);
        return ToHalf(ToHalf(code * ToHalf(step)) + ToHalf(bias));
    };
    return GetModelInputs(source, mip, x, y, latent, ToHalf, ToHalf);
}

std::array<double, 16> EvaluateFP8OutputLayer(const ModelSource& source, std::span<const int> bytes) {
    const ModelLayer layer = GetModelLayers(source)[3];
    const std::size_t scales = static_cast<std::size_t>(source.constants->networkScaleBiasOffset) + 384;
    std::array<double, 16> outputs{};
    for (std::size_t row = 0; row < 16; ++row) {
        std::int64_t sum = LoadAt<std::int32_t>(source.weights, scales + 64 + 4 * row);
        for (std::size_t i = 0; i < 64; ++i)
            sum += ModelInt8Weight(source, layer, row, i) * bytes[i];
        const double scale = static_cast<double>(LoadAt<float>(source.weights, scales + 4 * row));
        outputs[row] = ToBinary32(ToBinary32(static_cast<double>(sum)) * scale);
    }
    return outputs;
}

std::array<double, 16> DecodeFP8Model(const ModelSource& source, int mip, int x, int y) {
    std::vector<double> inputs = GetFP8ModelInputs(source, mip, x, y);
    for (double& input : inputs)
        input = ToE4M3(input);
    std::vector<int> bytes;
    std::size_t biases = static_cast<std::size_t>(source.constants->networkScaleBiasOffset);
    for (std::size_t l = 0; l < 3; ++l) {
        const ModelLayer layer = GetModelLayers(source)[l];
        std::vector<double> next;
        for (std::size_t row = 0; row < 64; ++row) {
            double sum = HalfValue(LoadAt<std::uint16_t>(source.weights, biases + 2 * row));
            for (std::size_t i = 0; i < layer.inputs; ++i)
                sum = ToBinary32(sum + E4M3Value(source.weights[layer.weights + row * layer.inputs + i]) *
                                           inputs[i]);
            const double y16 = ModelActivationHalf(ToHalf(sum));
            next.push_back(ToE4M3(y16));
            if (l == 2)
                bytes.push_back(ModelQuantizeHalf(y16));
        }
        inputs = next;
        biases += 128;
    }
    return EvaluateFP8OutputLayer(source, bytes);
}

} // namespace openntc::models
