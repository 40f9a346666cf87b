// SPDX-License-Identifier: MIT
// The renderer's shader maths as C++: values of the specification, sections 1, 3 and 4.
#include "renderer/scene/EnvironmentTable.h"
#include "renderer/shaders/Lighting.h"
#include "renderer/shaders/ToneMap.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

using namespace openntc;
using namespace openntc::shader;

namespace {

/// Half a unit of the last printed digit, and the rounding of a dozen binary32 operations.
void CheckShade(float3 value, float x, float y, float z, float half = 1.5e-6f) {
    CHECK(std::fabs(value.x - x) <= half);
    CHECK(std::fabs(value.y - y) <= half);
    CHECK(std::fabs(value.z - z) <= half);
}

float3 Brdf(const NtcrSurface& surface, float3 v, float3 l) {
    return NtcrGetRadiance(NtcrEvaluateBrdf(surface, {0, 0, 1}, normalize(v), normalize(l)));
}

NtcrLights MakeTestLights(float a, float b, float c) {
    return {{0, 1, 0, 0}, {3, 2, 1, 0}, float4(a), float4(b), float4(c)};
}

float2 LookUpEnvironment(const std::vector<glm::vec2>& table, float roughness, float nDotV) {
    const NtcrEnvironmentTaps taps = NtcrGetEnvironmentTaps(roughness, nDotV);
    const glm::vec2* cells = table.data() + taps.first;
    return NtcrMixEnvironment(taps, cells[0], cells[1], cells[NTCR_ENVIRONMENT_SIZE],
                              cells[NTCR_ENVIRONMENT_SIZE + 1]);
}

} // namespace

TEST_CASE("renderer shading: the metallic-roughness model's values") {
    CheckShade(Brdf(NtcrMakeMetallicRoughness({0.8f, 0.4f, 0.2f}, 0, 0.5f), {0, 0, 1}, {0, 1, 1}), 0.251403f,
               0.129173f, 0.068057f);
    CheckShade(Brdf(NtcrMakeMetallicRoughness({0.8f, 0.4f, 0.2f}, 1, 0.5f), {0, 0, 1}, {0, 1, 1}), 0.138829f,
               0.069415f, 0.034708f);
    CheckShade(Brdf(NtcrMakeMetallicRoughness(NtcrGray(0.5f), 0.5f, 0.25f), {1, 0, 1}, {-1, 0.2f, 1}),
               0.983452f, 0.983452f, 0.983452f);
    CheckShade(Brdf(NtcrMakeMetallicRoughness(NtcrGray(0.9f), 0, 1), {1, 2, 0.5f}, {-1, 0, 3}), 0.280273f,
               0.280273f, 0.280273f);
    const float3 dark = Brdf(NtcrMakeMetallicRoughness(NtcrGray(1), 0, 1), {0, 0, 1}, {0, 1, -0.01f});
    CHECK(dark == float3(0, 0, 0));
}

TEST_CASE("renderer shading: both models agree where they describe the same surface") {
    std::mt19937 random(1); // seed 1
    std::uniform_real_distribution<float> unit;
    for (int i = 0; i < 200; ++i) {
        const float3 color(unit(random), unit(random), unit(random));
        const float roughness = unit(random);
        const float3 v(unit(random) - 0.5f, unit(random) - 0.5f, unit(random)), l(0.3f, -0.2f, 0.9f);
        // A dielectric reflects 4 % and has the rest for its colour; a metal has no diffuse part.
        const float3 dielectric = Brdf(NtcrMakeMetallicRoughness(color, 0, roughness), v, l);
        const float3 same =
            Brdf(NtcrMakeSpecularGlossiness(color / 0.96f, NtcrGray(0.04f), 1 - roughness), v, l);
        const float3 metal = Brdf(NtcrMakeMetallicRoughness(color, 1, roughness), v, l);
        const float3 mirror = Brdf(NtcrMakeSpecularGlossiness(NtcrGray(0), color, 1 - roughness), v, l);
        for (int c = 0; c < 3; ++c) {
            // 1 - (1 - x) is x but for 2^-24, of which alpha^-4 can make (1 + 2^-24 / x)^4.
            CHECK(std::fabs(dielectric[c] - same[c]) <= 1e-4f * (dielectric[c] + 1));
            CHECK(std::fabs(metal[c] - mirror[c]) <= 1e-4f * (metal[c] + 1));
        }
    }
}

TEST_CASE("renderer shading: a smooth surface's highlight keeps its energy") {
    // The integral of D (n·h) over the hemisphere is 1, also where 1 - cosine² has no digits.
    for (const float roughness : {0.0f, 0.1f, 0.5f, 1.0f}) {
        const float alpha = NtcrGetAlpha(roughness);
        double sum = 0.0;
        constexpr int kSteps = 20000;
        for (int i = 0; i < kSteps; ++i) {
            const double angle = 1.5707963267948966 * std::pow((i + 0.5) / kSteps, 3); // dense near 0
            const double width = 1.5707963267948966 * 3 * std::pow((i + 0.5) / kSteps, 2) / kSteps;
            const float3 h(static_cast<float>(std::sin(angle)), 0, static_cast<float>(std::cos(angle)));
            sum += static_cast<double>(NtcrGetDistribution(alpha, {0, 0, 1}, h)) * std::cos(angle) *
                   std::sin(angle) * 6.283185307179586 * width;
        }
        CHECK(std::fabs(sum - 1.0) <= 1e-4);
    }
}

TEST_CASE("renderer shading: occlusion, normals and texture transforms") {
    CHECK(NtcrGetOcclusion(0.25f, 1) == 0.25f);
    CHECK(NtcrGetOcclusion(0.25f, 0.5f) == 0.625f);
    CHECK(NtcrGetOcclusion(0.25f, 0) == 1.0f);
    CheckShade(NtcrUnpackNormal({1, 0.5f, 0.5f}, 1), 1, 0, 0);
    CheckShade(NtcrUnpackNormal({1, 0.5f, 1}, 1), std::sqrt(0.5f), 0, std::sqrt(0.5f));
    CheckShade(NtcrUnpackNormal({1, 0.5f, 1}, 0), 0, 0, 1);
    // The example of the extension: T * R * S, where the sign of the rotation is easily got wrong.
    const float c = std::cos(0.5f), s = std::sin(0.5f);
    const float2 uv = NtcrTransformUv({0.25f, 0.75f}, {2 * c, -3 * s, 0.1f}, {2 * s, 3 * c, 0.2f});
    CHECK(std::fabs(uv.x + 0.539916f) <= 1e-6f);
    CHECK(std::fabs(uv.y - 2.414274f) <= 1e-6f);
}

TEST_CASE("renderer shading: tangents and derivatives give one frame, from any side, mirrored or not") {
    const float3 bent = NtcrUnpackNormal({0.7f, 0.4f, 0.9f}, 1), n(0, 0, 1);
    for (const float turn : {0.0f, 0.7f, 2.5f, 4.0f}) {
        for (const float handed : {1.0f, -1.0f}) {
            for (const float yDirection : {1.0f, -1.0f}) {
                const float3 t(std::cos(turn), std::sin(turn), 0);
                const float3 b = cross(n, t) * handed;
                const float3 byTangents = NtcrBendByTangents(bent, n, float4(t, handed));
                NtcrDerivatives d;
                d.positionX = {0.02f, 0, 0};
                d.positionY = {0, 0.02f * yDirection, 0};
                d.uvX = {dot(d.positionX, t), -dot(d.positionX, b)}; // v falls along b
                d.uvY = {dot(d.positionY, t), -dot(d.positionY, b)};
                const float3 byDerivatives = NtcrBendByDerivatives(bent, n, d);
                CheckShade(byDerivatives, byTangents.x, byTangents.y, byTangents.z);
                CheckShade(byTangents, dot(float3(1, 0, 0), t * bent.x + b * bent.y),
                           dot(float3(0, 1, 0), t * bent.x + b * bent.y), bent.z);
            }
        }
    }
    // Degenerate coordinates: the frame has no direction, and the normal is still one.
    const NtcrDerivatives none{{0.01f, 0, 0}, {0, 0.01f, 0}, {0, 0}, {0, 0}};
    CheckShade(NtcrBendByDerivatives({0, 0, 1}, n, none), 0, 0, 1);
}

TEST_CASE("renderer light: the sky's closed forms agree with sums over directions") {
    std::mt19937 random(7); // seed 7
    std::uniform_real_distribution<float> unit;
    const NtcrLights lights = MakeTestLights(0.7f, 0.4f, -0.3f);
    // Irradiance: a mean over cosine-distributed directions; a standard error is below 0.4 / sqrt(count).
    constexpr int kCount = 100000;
    for (const float height : {1.0f, 0.3f, -0.8f}) {
        const float3 n(std::sqrt(1 - height * height), height, 0), t = cross(n, float3(0, 0, 1));
        double sum = 0.0;
        for (int i = 0; i < kCount; ++i) {
            const float u = unit(random), phi = 6.2831853f * unit(random), r = std::sqrt(u);
            sum += static_cast<double>(NtcrGetSky(lights, n * std::sqrt(1 - u) + t * (r * std::cos(phi)) +
                                                              float3(0, 0, 1) * (r * std::sin(phi)))
                                           .x);
        }
        const double expected = static_cast<double>(NtcrGetSkyIrradiance(lights, n).x);
        CHECK(std::fabs(sum / kCount - expected) <= 5 * 0.4 / std::sqrt(kCount));
    }
}

TEST_CASE("renderer light: the prefiltered sky has the weights of the table") {
    const float p1[] = {1, .9987f, .9876f, .9603f, .9182f, .8674f, .8151f, .7667f, .7255f, .6923f, .6667f};
    const float p2[] = {1, .9962f, .9653f, .8917f, .7842f, .6624f, .5447f, .4425f, .3601f, .2969f, .25f};
    for (int i = 0; i <= 10; ++i) {
        const float2 p = NtcrGetPrefilter(static_cast<float>(i) / 10);
        CHECK(std::fabs(p.x - p1[i]) <= 1e-6f);
        CHECK(std::fabs(p.y - p2[i]) <= 1e-6f);
    }
    CHECK(std::fabs(NtcrGetPrefilter(0.55f).x - 0.5f * (p1[5] + p1[6])) <= 1e-6f);
    const NtcrLights lights = MakeTestLights(0.7f, 0.4f, -0.3f);
    const float3 up(0, 1, 0);
    // Smooth, it is the sky; rough, towards the zenith, what a white surface that faces it receives.
    CHECK(std::fabs(NtcrGetPrefilteredSky(lights, up, 0).x - NtcrGetSky(lights, up).x) <= 1e-6f);
    CHECK(std::fabs(NtcrGetPrefilteredSky(lights, up, 1).x - NtcrGetSkyIrradiance(lights, up).x) <= 2e-5f);
    // The weights are means over microfacets: n = v = r, l = the reflection, weighted by n·l.
    for (const float roughness : {0.3f, 0.6f, 0.9f}) {
        const double alpha = static_cast<double>(NtcrGetAlpha(roughness));
        double sum = 0.0, linear = 0.0, quadratic = 0.0;
        for (int i = 0; i < 20000; ++i) {
            const double u = (i + 0.5) / 20000;
            const double cosine2 = (1 - u) / (1 + (alpha * alpha - 1) * u), l = 2 * cosine2 - 1;
            if (l <= 0)
                continue;
            sum += l;
            linear += l * l;
            quadratic += l * (1.5 * l * l - 0.5);
        }
        CHECK(std::fabs(static_cast<double>(NtcrGetPrefilter(roughness).x) - linear / sum) <= 1e-4);
        CHECK(std::fabs(static_cast<double>(NtcrGetPrefilter(roughness).y) - quadratic / sum) <= 1e-4);
    }
}

TEST_CASE("renderer light: the environment table") {
    const std::vector<glm::vec2> table = renderer::MakeEnvironmentTable();
    REQUIRE(table.size() == NTCR_ENVIRONMENT_SIZE * NTCR_ENVIRONMENT_SIZE);
    struct Row {
        float roughness, nDotV, a, b;
    };
    const Row rows[] = {{.1f, .5f, .9684f, .0314f}, {.25f, .25f, .7572f, .2036f}, {.5f, .05f, .7657f, .1644f},
                        {.5f, .5f, .8350f, .0223f}, {.75f, .25f, .7164f, .0279f}, {1, .25f, .5868f, .0109f},
                        {1, 1, .3068f, 0}};
    for (const Row& row : rows) {
        const float2 value = LookUpEnvironment(table, row.roughness, row.nDotV);
        INFO(row.roughness << " " << row.nDotV);
        CHECK(std::fabs(value.x - row.a) <= 0.005f);
        CHECK(std::fabs(value.y - row.b) <= 0.002f);
    }
    // Between the cells, against integrals of four times the samples, whose own error is near 0.001.
    float largest = 0;
    for (int i = 0; i < 200; ++i) {
        const float roughness = static_cast<float>((i * 37) % 200) / 200, nDotV = static_cast<float>(i) / 200;
        const float2 error = LookUpEnvironment(table, roughness, nDotV) -
                             renderer::IntegrateEnvironment(roughness, nDotV, 128);
        largest = std::max({largest, std::fabs(error.x), std::fabs(error.y)});
    }
    MESSAGE("measure: environment table: largest error " << largest);
    CHECK(largest <= 0.006f);
    // Reciprocity has no say in it, energy has: nothing reflects more than it receives.
    for (const glm::vec2& cell : table)
        CHECK((cell.x >= 0 && cell.y >= 0 && cell.x + cell.y <= 1.01f));
}

TEST_CASE("renderer light: what occlusion dims, what transmission replaces") {
    const NtcrLights lights = MakeTestLights(0.5f, 0.25f, 0);
    const float3 n(0, 1, 0), v(0, 1, 0);
    const float2 environment(0.7f, 0.02f);
    const NtcrSurface surface = NtcrMakeMetallicRoughness({0.8f, 0.4f, 0.2f}, 0, 0.5f);
    const NtcrReflection open = NtcrReflectLights(lights, surface, n, v, environment, 1, 1);
    const NtcrReflection closed = NtcrReflectLights(lights, surface, n, v, environment, 0, 1);
    const NtcrReflection sun = NtcrReflectSun(lights, surface, n, v, 1);
    CHECK(NtcrGetRadiance(closed) == NtcrGetRadiance(sun));
    CHECK(NtcrGetRadiance(NtcrReflectLights(lights, surface, n, v, environment, 0, 0)) == float3(0, 0, 0));
    // Sky: irradiance/π 0.5 + 0.25 * 2/3, F = 0.04 * 0.7 + 0.02; L' = 0.5 + 0.8674 * 0.25.
    const float f = 0.048f, e = 0.5f + 0.5f / 3, reflected = 0.5f + 0.8674f * 0.25f;
    CheckShade(open.diffuse - sun.diffuse, 0.8f * e * (1 - f), 0.4f * e * (1 - f), 0.2f * e * (1 - f));
    CheckShade(open.specular - sun.specular, reflected * f, reflected * f, reflected * f);
    // Transmission: all of it leaves no diffuse part and lets the sky below through; metals have none.
    const float below = 0.5f - 0.8674f * 0.25f;
    const float3 through = NtcrGetTransmittedRadiance(lights, surface, open, v, environment, 1);
    CheckShade(through - open.specular, 0.8f * below * (1 - f), 0.4f * below * (1 - f),
               0.2f * below * (1 - f));
    CheckShade(NtcrGetTransmittedRadiance(lights, surface, open, v, environment, 0) - NtcrGetRadiance(open),
               0, 0, 0);
    const NtcrSurface metal = NtcrMakeMetallicRoughness({0.8f, 0.4f, 0.2f}, 1, 0.5f);
    const NtcrReflection shiny = NtcrReflectLights(lights, metal, n, v, environment, 1, 1);
    CHECK(NtcrGetTransmittedRadiance(lights, metal, shiny, v, environment, 1) == NtcrGetRadiance(shiny));
}

TEST_CASE("renderer tone curves: the table of values") {
    struct Row {
        float3 input, neutral, aces;
    };
    const Row rows[] = {
        {NtcrGray(0.18f), NtcrGray(0.14f), NtcrGray(0.266899f)},
        {NtcrGray(1), NtcrGray(0.869091f), NtcrGray(0.803797f)},
        {NtcrGray(16), NtcrGray(0.996269f), NtcrGray(1)},
        {{0.8f, 0.2f, 0.05f}, {0.765496f, 0.165609f, 0.015637f}, {0.752307f, 0.299550f, 0.044283f}},
        {{4, 1, 0.25f}, {0.983256f, 0.468299f, 0.339560f}, {0.973417f, 0.803797f, 0.374111f}},
        {{0.05f, 0.02f, 0.5f}, {0.0325f, 0.0025f, 0.4825f}, {0.044283f, 0.010499f, 0.616307f}}};
    for (const Row& row : rows) {
        const float3 neutral = NtcrToneMap(row.input, NTCR_TONE_NEUTRAL);
        const float3 aces = NtcrToneMap(row.input, NTCR_TONE_ACES);
        CheckShade(neutral, row.neutral.x, row.neutral.y, row.neutral.z);
        CheckShade(aces, row.aces.x, row.aces.y, row.aces.z);
        const float3 none = NtcrToneMap(row.input, NTCR_TONE_NONE);
        CHECK(none == glm::min(row.input, NtcrGray(1)));
    }
    CHECK(NtcrToneMapNeutral({0, 0, 0}) == float3(0, 0, 0));
    CHECK(NtcrQuantize(0) == 0u);
    CHECK(NtcrQuantize(1) == 255u);
    CHECK(NtcrQuantize(0.5f) == 128u);
    // sRGB: 0.5 is 187.5 of 255 (rounded down: 0.7354 * 255 = 187.52), and the ends stay.
    CHECK(NtcrMakePixel({0.25f, 0.5f, 9}, 2, NTCR_TONE_NONE) == 0xFFFFFFBCu);
    CHECK(NtcrMakePixel({0, 0.001f, 0.5f}, 1, NTCR_TONE_NONE) == 0xFFBC0300u);
}
