// SPDX-License-Identifier: MIT
#include "ModelInputs.h"

namespace openntc::models {

namespace {

bool ReadsLatentMips(const ModelSource& source) {
    return source.networkVersion >= NTC_NETWORK_GENERATION_2;
}

/// Places of a bilinear sample along an axis of a latent mip, and binary32 weights. Texels wrap, and so do latents.
ModelAxis GetWrappedAxis(int texel, int mipSize, int size) {
    const double u = ToBinary32(((texel % mipSize + mipSize) % mipSize + 0.5) / mipSize);
    const double position = ToBinary32(ToBinary32(u * size) - 0.5);
    const double cell = std::floor(position);
    const double fraction = ToBinary32(position - cell);
    const int first = static_cast<int>(cell);
    return {(first + size) % size, (first + 1) % size, fraction, ToBinary32(1 - fraction)};
}

/// The inputs of latent mip `grid`, from `out` on.
void SampleModelMip(const ModelSource& source, const NtcNeuralMipConstants& grid, int x, int y, int mipWidth,
                    int mipHeight, double* out) {
    const int width = static_cast<int>(grid.imageWidthHeight & 0xFFFF);
    const int height = static_cast<int>(grid.imageWidthHeight >> 16);
    const ModelAxis h = GetWrappedAxis(x, mipWidth, width), v = GetWrappedAxis(y, mipHeight, height);
    const double weights[4] = {ToBinary32(h.opposite * v.opposite), ToBinary32(h.fraction * v.opposite),
                               ToBinary32(h.opposite * v.fraction), ToBinary32(h.fraction * v.fraction)};
    for (int k = 0; k < source.constants->highResEncoding.numFeatures; ++k) {
        double sum = 0;
        for (int corner = 0; corner < 4; ++corner) {
            const int px = (corner & 1) != 0 ? h.second : h.first;
            const int py = (corner & 2) != 0 ? v.second : v.first;
            const int texel = (k / 4 * height + py) * width + px;
            const auto word =
                LoadAt<std::uint16_t>(source.latents, grid.dataOffset + 2 * static_cast<std::size_t>(texel));
            sum = ToBinary32(sum + ToBinary32((word >> (4 * (k % 4)) & 15) * weights[corner]));
        }
        out[k] = ToHalf(ToBinary32(ToBinary32(sum * ToBinary32(2.0 / 15)) - 1));
    }
}

std::vector<double> GetMipModelInputs(const ModelSource& source, int mip, int x, int y) {
    const NtcTextureSetConstants& c = *source.constants;
    const NtcColorMipConstants& color = c.colorMips[mip];
    const int width = c.imageWidth >> mip > 1 ? c.imageWidth >> mip : 1;
    const int height = c.imageHeight >> mip > 1 ? c.imageHeight >> mip : 1;
    std::vector<double> inputs(48, 0.0);
    SampleModelMip(source, c.highResNeuralMips[color.neuralMip], x, y, width, height, &inputs[0]);
    SampleModelMip(source, c.lowResNeuralMips[color.neuralMip], x, y, width, height, &inputs[16]);
    const auto wave = [](double t) { return ToHalf(ToBinary32(2 * ToBinary32(t - std::floor(t)) - 1)); };
    const double qx = ToBinary32(x * static_cast<double>(color.positionScale));
    const double qy = ToBinary32(y * static_cast<double>(color.positionScale));
    for (std::size_t j = 0; j < 3; ++j) {
        const double frequency = std::ldexp(1.0, static_cast<int>(j));
        inputs[32 + 4 * j] = wave(qx * frequency);
        inputs[33 + 4 * j] = wave(qy * frequency);
        inputs[34 + 4 * j] = wave(ToBinary32(qx * frequency + 0.25));
        inputs[35 + 4 * j] = wave(ToBinary32(qy * frequency + 0.25));
    }
    inputs[44] = inputs[45] = ToHalf(static_cast<double>(color.positionLod));
    return inputs;
}

} // namespace

std::array<ModelLayer, 4> GetModelLayers(const ModelSource& source) {
    const NtcTextureSetConstants& c = *source.constants;
    const std::int32_t offsets[4] = {c.networkWeightOffset0, c.networkWeightOffset1, c.networkWeightOffset2,
                                     c.networkWeightOffset3};
    const bool isTapered = source.networkVersion == NTC_NETWORK_GENERATION_3;
    const std::size_t rows[4] = {64, isTapered ? 48u : 64u, isTapered ? 32u : 64u, 16};
    std::array<ModelLayer, 4> layers{};
    std::size_t inputs =
        ReadsLatentMips(source) ? 48 : 32 + 16 * static_cast<std::size_t>(source.networkVersion);
    std::size_t firstRow = 0;
    for (std::size_t l = 0; l < 4; ++l) {
        layers[l] = {static_cast<std::size_t>(offsets[l]), inputs, rows[l], firstRow};
        inputs = rows[l];
        firstRow += rows[l];
    }
    return layers;
}

std::vector<double> GetFP8ModelInputs(const ModelSource& source, int mip, int x, int y) {
    if (ReadsLatentMips(source))
        return GetMipModelInputs(source, mip, x, y);
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
    const std::size_t scales =
        static_cast<std::size_t>(source.constants->networkScaleBiasOffset) + 2 * layer.firstRow;
    std::array<double, 16> outputs{};
    for (std::size_t row = 0; row < 16; ++row) {
        std::int64_t sum = LoadAt<std::int32_t>(source.weights, scales + 64 + 4 * row);
        for (std::size_t i = 0; i < layer.inputs; ++i)
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
    for (std::size_t l = 0; l < 3; ++l) {
        const ModelLayer layer = GetModelLayers(source)[l];
        const std::size_t biases =
            static_cast<std::size_t>(source.constants->networkScaleBiasOffset) + 2 * layer.firstRow;
        std::vector<double> next;
        for (std::size_t row = 0; row < layer.rows; ++row) {
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
    }
    return EvaluateFP8OutputLayer(source, bytes);
}

} // namespace openntc::models
