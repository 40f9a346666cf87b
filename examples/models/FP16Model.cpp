// SPDX-License-Identifier: MIT
#include "ModelInputs.h"

#include <algorithm>

namespace openntc::models {

std::array<double, 16> DecodeFP16Model(const ModelSource& source, int mip, int x, int y) {
    std::vector<double> inputs = GetModelInputs(
        source, mip, x, y, [](int code, int bits) { return ModelLevel(code, bits) / 128; }, ToHalf,
        [](double e) { return ToHalf(ToBinary32(ClampToOne(e) * (127.5 / 128))); });
    for (std::size_t l = 0;; ++l) {
        const ModelLayer layer = GetModelLayers(source)[l];
        std::vector<double> next;
        for (std::size_t row = 0; row < layer.rows; ++row) {
            double sum = 0;
            for (std::size_t block = 0; block < layer.inputs; block += 16) {
                std::array<double, 4> lanes{};
                for (std::size_t i = block; i < block + 16; ++i)
                    lanes[i % 4] =
                        ToHalf(lanes[i % 4] + ToHalf(ModelInt8Weight(source, layer, row, i) * inputs[i]));
                sum = ToHalf(sum + ToHalf(ToHalf(lanes[0] + lanes[1]) + ToHalf(lanes[2] + lanes[3])));
            }
            const double scale = GetInt8Scale(source, l, row);
            const double unit = l == 0 ? 128 : 80;
            const double product = ToHalf(ToBinary32(sum * ToBinary32(scale * unit)));
            const double shift = ToHalf(ToBinary32(ToBinary32(GetUnfoldedBias(source, l, row)) * scale));
            next.push_back(ToHalf(product + shift));
        }
        if (l == 3) {
            std::array<double, 16> outputs{};
            std::copy(next.begin(), next.end(), outputs.begin());
            return outputs;
        }
        for (double& z : next)
            z = z <= -1.5 ? 0 : ModelActivationHalf(z);
        inputs = next;
    }
}

} // namespace openntc::models
