// SPDX-License-Identifier: MIT
#include "Programs.h"

namespace opengl_example {

const char* const kTexelsMain = R"(
uniform int mip;
layout(location = 0) out vec4 a;
layout(location = 1) out vec4 b;
layout(location = 2) out vec4 c;
layout(location = 3) out vec4 d;
void main() {
    float channels[16];
    if (!SAMPLE(ivec2(gl_FragCoord.xy), mip, channels))
        discard;
    a = vec4(channels[0], channels[1], channels[2], channels[3]);
    b = vec4(channels[4], channels[5], channels[6], channels[7]);
    c = vec4(channels[8], channels[9], channels[10], channels[11]);
    d = vec4(channels[12], channels[13], channels[14], channels[15]);
}
)";

namespace {

// The texture is laid twice around the sphere. Mip by the size of a pixel in texels at the centre, nearest texel: docs/filtering.md
// has what a renderer would do.
constexpr const char* kSphere = R"(
uniform float size;
layout(location = 0) out vec4 color;
vec3 ToLinear(vec3 x) { return mix(x / 12.92, pow((x + 0.055) / 1.055, vec3(2.4)), step(0.04045, x)); }
vec3 ToSrgb(vec3 x) { return mix(12.92 * x, 1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, x)); }
void main() {
    vec2 p = (gl_FragCoord.xy / size * 2.0 - 1.0) * 1.08;
    float r2 = dot(p, p);
    vec3 sky = mix(vec3(0.05, 0.06, 0.08), vec3(0.22, 0.26, 0.32), p.y * 0.5 + 0.5);
    color = vec4(ToSrgb(sky), 1.0);
    if (r2 >= 1.0)
        return;
    vec3 n = vec3(p, sqrt(1.0 - r2));
    vec2 uv = vec2(atan(n.x, n.z) / 3.14159265, 0.5 - asin(n.y) / 3.14159265) * vec2(1.5, 1.5) + 2.0;
    float texelsPerPixel = 1.5 * float(WIDTH) / (3.14159265 * 0.5 * size);
    int mip = int(clamp(log2(max(texelsPerPixel, 1.0)) + 0.5, 0.0, float(MIPS - 1)));
    ivec2 extent = max(ivec2(WIDTH, HEIGHT) >> mip, ivec2(1));
    float channels[16];
    SAMPLE(ivec2(fract(uv) * vec2(extent)), mip, channels);
    vec3 albedo = HAS_BASE_COLOR ? ToLinear(vec3(channels[BASE_COLOR], channels[BASE_COLOR + 1], channels[BASE_COLOR + 2])) : vec3(0.7);
    float rough = HAS_ROUGHNESS ? clamp(channels[ROUGHNESS], 0.05, 1.0) : 0.6;
    if (HAS_NORMAL) {
        vec2 bump = vec2(channels[NORMAL], channels[NORMAL + 1]) * 2.0 - 1.0;
        vec3 east = normalize(vec3(n.z, 0.0, -n.x));
        vec3 south = cross(n, east) * -1.0;
        n = normalize(n * sqrt(max(1.0 - dot(bump, bump), 0.05)) + east * bump.x - south * bump.y);
    }
    vec3 light = normalize(vec3(0.5, 0.7, 0.8));
    vec3 halfway = normalize(light + vec3(0.0, 0.0, 1.0));
    float shininess = 2.0 / (rough * rough * rough * rough) - 2.0;
    float gloss = pow(max(dot(n, halfway), 0.0), max(shininess, 0.1)) * (shininess + 2.0) / 8.0;
    vec3 lit = albedo * (max(dot(n, light), 0.0) * 2.2 + mix(0.12, 0.4, n.y * 0.5 + 0.5)) +
               0.04 * gloss * max(dot(n, light), 0.0) * 3.0;
    color = vec4(ToSrgb(lit / (1.0 + 0.25 * lit)), 1.0);
}
)";

std::string Define(const std::string& name, int value) {
    return "#define " + name + " " + std::to_string(value) + "\n";
}

/// The first channel of a texture, or 0 where there is none: an index must not be negative, also where nothing reads it.
std::string DefineTexture(const std::string& name, int firstChannel) {
    return Define(name, firstChannel < 0 ? 0 : firstChannel) + "#define HAS_" + name +
           (firstChannel < 0 ? " false\n" : " true\n");
}

} // namespace

std::string MakeSphereMain(const Material& material) {
    return Define("WIDTH", material.width) + Define("HEIGHT", material.height) +
           Define("MIPS", material.mips) + DefineTexture("BASE_COLOR", material.baseColor) +
           DefineTexture("NORMAL", material.normal) + DefineTexture("ROUGHNESS", material.roughness) +
           kSphere;
}

} // namespace opengl_example
