// SPDX-License-Identifier: MIT
#include "ModelInputs.h"

#include <algorithm>

namespace openntc::models {

BoundedOutputs DecodeFP32Model(const ModelSource& source, int mip, int x, int y) {
    constexpr double kUnit = 1.01 * 0x1p-24;
    const auto square = [](double value) { return value * value; };
    // The sum of the absolute terms is the sample of the absolute levels.
    const auto get = [&](auto level) {
        return GetModelInputs(
            source, mip, x, y, level, [](double value) { return value; },
            [](double e) { return 127.5 * ClampToOne(e); });
    };
    std::vector<double> inputs = get(ModelLevel);
    std::vector<double> errors = get([](int code, int bits) { return std::fabs(ModelLevel(code, bits)); });
    std::vector<double> variances;
    for (std::size_t i = 0; i < errors.size(); ++i) {
        const bool isLatent = i + 16 < errors.size();
        variances.push_back((isLatent ? 7 : 4) * square(kUnit * errors[i]));
        errors[i] = isLatent ? 7 * kUnit * errors[i] : 4 * kUnit * 127.5;
    }
    for (std::size_t l = 0;; ++l) {
        const ModelLayer layer = GetModelLayers(source)[l];
        std::vector<double> next, nextErrors, nextVariances;
        for (std::size_t row = 0; row < layer.rows; ++row) {
            const double bias = GetUnfoldedBias(source, l, row);
            const double scale = GetInt8Scale(source, l, row);
            double sum = 0;
            double magnitude = std::fabs(bias);
            double error = 0;
            double variance = 0;
            for (std::size_t i = 0; i < layer.inputs; ++i) {
                const double q = ModelInt8Weight(source, layer, row, i);
                sum += q * inputs[i];
                magnitude += std::fabs(q * inputs[i]);
                error += std::fabs(q) * errors[i];
                variance += square(q) * variances[i] + square(kUnit * q * inputs[i]) + square(kUnit * sum);
            }
            sum += bias;
            error += static_cast<double>(layer.inputs + 2) * kUnit * magnitude;
            variance += square(kUnit * bias) + 2 * square(kUnit * sum);
            next.push_back(sum * scale);
            nextErrors.push_back(1.01 * (error * std::fabs(scale) + 2 * kUnit * std::fabs(sum * scale)));
            nextVariances.push_back(variance * square(scale));
        }
        if (l == 3) {
            BoundedOutputs result{};
            std::copy(next.begin(), next.end(), result.values.begin());
            std::copy(nextErrors.begin(), nextErrors.end(), result.bounds.begin());
            for (std::size_t i = 0; i < 16; ++i)
                result.deviations[i] = std::sqrt(nextVariances[i]);
            return result;
        }
        for (std::size_t i = 0; i < next.size(); ++i) {
            const double z = next[i];
            const double gate = z / 3 + 0.5;
            next[i] = 80 * (z < 3 ? z : 3) * (gate < 0 ? 0 : gate > 1 ? 1 : gate);
            nextErrors[i] = 80 * (1.5 * nextErrors[i] + 9 * kUnit) + 240 * kUnit;
            nextVariances[i] = square(80.0) * (square(1.5) * nextVariances[i] + 9 * square(kUnit * 3));
        }
        inputs = next;
        errors = nextErrors;
        variances = nextVariances;
    }
}

} // namespace openntc::models
