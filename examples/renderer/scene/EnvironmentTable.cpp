// SPDX-License-Identifier: MIT
#include "renderer/scene/EnvironmentTable.h"

#include "renderer/shaders/Lighting.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace openntc::renderer {

glm::vec2 IntegrateEnvironment(float roughness, float nDotV, int samples) {
    const float alpha = shader::NtcrGetAlpha(roughness);
    const glm::vec3 v(std::sqrt(std::max(1.0f - nDotV * nDotV, 0.0f)), 0.0f, nDotV);
    const float step = 1.0f / static_cast<float>(samples);
    double scale = 0.0, bias = 0.0;
    for (int j = 0; j < samples; ++j) {
        // Half the circle: the other is its mirror image.
        const float cosPhi = std::cos(NTCR_PI * (static_cast<float>(j) + 0.5f) * step);
        for (int i = 0; i < samples; ++i) {
            // A microfacet, drawn with the probability that its distribution gives it: by a uniform 1 - t².
            // Evenly spaced t put more samples where microfacets are steep, of which few count much.
            const float t = (static_cast<float>(i) + 0.5f) * step;
            const float cosine = t / std::sqrt(1.0f + (alpha * alpha - 1.0f) * (1.0f - t * t));
            const float vDotH =
                v.x * std::sqrt(std::max(1.0f - cosine * cosine, 0.0f)) * cosPhi + v.z * cosine;
            const float nDotL = 2.0f * vDotH * cosine - nDotV;
            if (nDotL <= 0.0f || vDotH <= 0.0f)
                continue;
            const float visibility = shader::NtcrGetVisibility(alpha, nDotL, nDotV);
            const double weight = static_cast<double>(2.0f * t * 4.0f * visibility * nDotL * vDotH / cosine);
            const double fresnel = static_cast<double>(shader::NtcrGetFresnelWeight(vDotH));
            scale += weight * (1.0 - fresnel);
            bias += weight * fresnel;
        }
    }
    const double mean = static_cast<double>(step) * static_cast<double>(step);
    return {static_cast<float>(scale * mean), static_cast<float>(bias * mean)};
}

std::vector<glm::vec2> MakeEnvironmentTable() {
    constexpr int kSize = NTCR_ENVIRONMENT_SIZE, kSamples = 64;
    std::vector<glm::vec2> table;
    table.reserve(static_cast<std::size_t>(kSize) * kSize);
    const auto place = [](int i) { return static_cast<float>(i * i) / ((kSize - 1) * (kSize - 1)); };
    for (int row = 0; row < kSize; ++row) {
        for (int column = 0; column < kSize; ++column)
            table.push_back(IntegrateEnvironment(place(row), place(column), kSamples));
    }
    return table;
}

const std::vector<glm::vec2>& GetEnvironmentTable() {
    static const std::vector<glm::vec2> kTable = MakeEnvironmentTable();
    return kTable;
}

} // namespace openntc::renderer
