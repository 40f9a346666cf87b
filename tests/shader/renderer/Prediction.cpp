// SPDX-License-Identifier: MIT
#include "shader/renderer/Prediction.h"

#include "Decoder.h"
#include "renderer/scene/EnvironmentTable.h"
#include "renderer/scene/Lights.h"
#include "renderer/shaders/ToneMap.h"

#include "openntc/image/ColorEncoding.h"

#include <doctest/doctest.h>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <optional>

namespace openntc_tests {

using namespace openntc;
using namespace openntc::renderer;

namespace {

constexpr float kEdge = 1e-4f;  // barycentric coordinates nearer to an edge hang on rounding
constexpr float kTexel = 1e-3f; // so do places in texels nearer to the next one
constexpr glm::vec3 kToEye(0.0f, 0.0f, 1.0f);

/// A triangle over a pixel's centre.
struct Hit {
    float depth = 0.0f; // z in the world
    std::size_t instance = 0;
    std::uint32_t firstIndex = 0;
    glm::vec3 at{0.0f}, alongX{0.0f}, alongY{0.0f}; // barycentric, and its steps to the right and down
    bool isBack = false;
    bool isKnown = true;
};

struct Shaded {
    glm::vec4 color{0.0f};
    bool isKnown = true;
};

float Cross(glm::vec2 a, glm::vec2 b) {
    return a.x * b.y - a.y * b.x;
}

int WrapTexel(int texel, int size, Wrap wrap) {
    if (wrap == Wrap::Clamp)
        return std::clamp(texel, 0, size - 1);
    const int period = wrap == Wrap::Mirror ? 2 * size : size;
    const int rest = (texel % period + period) % period;
    return rest < size ? rest : period - 1 - rest;
}

template <typename T>
T Mix(const glm::vec3& weights, const T& a, const T& b, const T& c) {
    return a * weights.x + b * weights.y + c * weights.z;
}

class Painter {
public:
    Painter(const Scene& scene, const Camera& camera, int width, int height, const ReadTexel& texels)
        : scene_(scene), camera_(camera), width_(width), height_(height), texels_(texels),
          hits_(static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {}

    Prediction Paint(float exposure) {
        for (std::size_t i = 0; i < scene_.instances.size(); ++i)
            Rasterise(i);
        Prediction prediction;
        for (std::vector<Hit>& hits : hits_) {
            std::sort(hits.begin(), hits.end(), [](const Hit& a, const Hit& b) {
                return a.depth != b.depth ? a.depth > b.depth : a.instance < b.instance;
            });
            bool isKnown = true;
            const glm::vec3 color = Compose(hits, isKnown);
            prediction.isKnown.push_back(isKnown);
            prediction.covered += hits.empty() ? 0 : 1;
            prediction.known += isKnown && !hits.empty() ? 1 : 0;
            const std::uint32_t pixel =
                shader::NtcrMakePixel(glm::max(color, glm::vec3(0.0f)), exposure, NTCR_TONE_NONE);
            for (int shift = 0; shift < 32; shift += 8)
                prediction.picture.push_back(static_cast<std::uint8_t>(pixel >> shift));
        }
        return prediction;
    }

private:
    const Primitive& GetPrimitive(std::size_t instance) const {
        return scene_.primitives[static_cast<std::size_t>(scene_.instances[instance].primitive)];
    }
    const Material& GetMaterial(std::size_t instance) const {
        return scene_.materials[static_cast<std::size_t>(GetPrimitive(instance).material)];
    }

    void Rasterise(std::size_t index) {
        const Instance& instance = scene_.instances[index];
        const Primitive& primitive = GetPrimitive(index);
        const glm::vec2 scale(static_cast<float>(width_) / (2.0f * camera_.xmag),
                              -static_cast<float>(height_) / (2.0f * camera_.ymag));
        const glm::vec2 origin(camera_.toWorld[3].x - camera_.xmag, camera_.toWorld[3].y + camera_.ymag);
        for (std::uint32_t first = 0; first < primitive.indexCount; first += 3) {
            std::array<glm::vec3, 3> world;
            std::array<glm::vec2, 3> screen;
            for (std::uint32_t k = 0; k < 3; ++k) {
                const Vertex& vertex = scene_.vertices[scene_.indices[primitive.firstIndex + first + k]];
                world[k] = glm::vec3(instance.toWorld * glm::vec4(vertex.position, 1.0f));
                screen[k] = (glm::vec2(world[k]) - origin) * scale;
            }
            // y points down: what turns counter-clockwise in the world turns clockwise on the screen.
            const float area = Cross(screen[1] - screen[0], screen[2] - screen[0]);
            const bool isBack = (area > 0.0f) != (glm::determinant(glm::mat3(instance.toWorld)) < 0.0f);
            if (area == 0.0f || (isBack && !GetMaterial(index).doubleSided))
                continue;
            Hit hit;
            hit.instance = index;
            hit.firstIndex = primitive.firstIndex + first;
            hit.isBack = isBack;
            AddHits(hit, world, screen, area);
        }
    }

    void AddHits(Hit hit, const std::array<glm::vec3, 3>& world, const std::array<glm::vec2, 3>& screen,
                 float area) {
        const glm::vec2 low = glm::min(glm::min(screen[0], screen[1]), screen[2]),
                        high = glm::max(glm::max(screen[0], screen[1]), screen[2]);
        for (std::size_t k = 0; k < 3; ++k) {
            const glm::vec2 edge = screen[(k + 2) % 3] - screen[(k + 1) % 3];
            hit.alongX[static_cast<int>(k)] = -edge.y / area;
            hit.alongY[static_cast<int>(k)] = edge.x / area;
        }
        const int left = std::max(static_cast<int>(std::floor(low.x)) - 1, 0),
                  top = std::max(static_cast<int>(std::floor(low.y)) - 1, 0);
        for (int y = top; y < height_ && static_cast<float>(y) <= high.y + 1.0f; ++y) {
            for (int x = left; x < width_ && static_cast<float>(x) <= high.x + 1.0f; ++x) {
                const glm::vec2 p(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
                for (int k = 0; k < 3; ++k)
                    hit.at[k] = Cross(screen[static_cast<std::size_t>(k + 2) % 3] -
                                          screen[static_cast<std::size_t>(k + 1) % 3],
                                      p - screen[static_cast<std::size_t>(k + 1) % 3]) /
                                area;
                const float least = std::min({hit.at.x, hit.at.y, hit.at.z});
                if (least < -kEdge)
                    continue;
                hit.isKnown = least > kEdge;
                // Of a surface at one depth that depth, so that equal ones are.
                hit.depth =
                    world[0].z + hit.at.y * (world[1].z - world[0].z) + hit.at.z * (world[2].z - world[0].z);
                hits_[static_cast<std::size_t>(y * width_ + x)].push_back(hit);
            }
        }
    }

    /// From the nearest to the first opaque one; what is blended lies over it.
    glm::vec3 Compose(const std::vector<Hit>& hits, bool& isKnown) const {
        glm::vec3 color(0.0f);
        float rest = 1.0f;
        for (const Hit& hit : hits) {
            const Material& material = GetMaterial(hit.instance);
            const Shaded shaded = Shade(hit);
            isKnown = isKnown && shaded.isKnown;
            if (material.alphaMode == AlphaMode::Mask) {
                isKnown = isKnown && std::fabs(shaded.color.w - material.alphaCutoff) > 1e-5f;
                if (shaded.color.w < material.alphaCutoff)
                    continue;
            }
            const float share = material.alphaMode == AlphaMode::Blend ? shaded.color.w : 1.0f;
            color += glm::vec3(shaded.color) * (rest * share);
            rest *= 1.0f - share;
            if (share == 1.0f)
                return color;
        }
        return color + rest * shader::NtcrGetSky(lights_, -kToEye);
    }

    /// Where a slot's texture is read; 1 where the material has none.
    glm::vec4 Read(const Hit& hit, TextureSlot slot, bool& isKnown) const {
        const int index = GetPrimitive(hit.instance).material;
        const MaterialTexture& texture =
            scene_.materials[static_cast<std::size_t>(index)].textures[static_cast<std::size_t>(slot)];
        if (texture.image < 0)
            return glm::vec4(1.0f);
        const SourceImage& image = scene_.images[static_cast<std::size_t>(texture.image)];
        const glm::vec2 size(image.width, image.height);
        std::array<glm::vec2, 3> uv;
        for (std::uint32_t k = 0; k < 3; ++k) {
            const glm::vec3 p(scene_.vertices[scene_.indices[hit.firstIndex + k]].uv[texture.address.uvSet],
                              1.0f);
            uv[k] = glm::vec2(glm::dot(texture.address.transform.row0, p),
                              glm::dot(texture.address.transform.row1, p)) *
                    size;
        }
        const glm::vec2 place = Mix(hit.at, uv[0], uv[1], uv[2]);
        const float widest = std::max(glm::length(Mix(hit.alongX, uv[0], uv[1], uv[2])),
                                      glm::length(Mix(hit.alongY, uv[0], uv[1], uv[2])));
        const auto wrap = [&](glm::vec2 at) {
            return glm::ivec2(
                WrapTexel(static_cast<int>(std::floor(at.x)), image.width, texture.address.wrapS),
                WrapTexel(static_cast<int>(std::floor(at.y)), image.height, texture.address.wrapT));
        };
        isKnown = isKnown && widest <= 1.0001f && wrap(place - kTexel) == wrap(place + kTexel);
        return texels_(index, slot, wrap(place));
    }

    glm::vec3 GetNormal(const Hit& hit, bool& isKnown) const {
        const Instance& instance = scene_.instances[hit.instance];
        const Primitive& primitive = GetPrimitive(hit.instance);
        const Material& material = GetMaterial(hit.instance);
        const glm::mat3 turn(instance.toWorld), ofNormals = glm::transpose(glm::inverse(turn));
        std::array<Vertex, 3> corners;
        for (std::uint32_t k = 0; k < 3; ++k)
            corners[k] = scene_.vertices[scene_.indices[hit.firstIndex + k]];
        const glm::vec3 e1 = corners[1].position - corners[0].position,
                        e2 = corners[2].position - corners[0].position;
        glm::vec3 normal = glm::normalize(ofNormals * glm::cross(e1, e2));
        if (primitive.hasNormals)
            normal = Mix(hit.at, glm::normalize(ofNormals * corners[0].normal),
                         glm::normalize(ofNormals * corners[1].normal),
                         glm::normalize(ofNormals * corners[2].normal));
        const MaterialTexture& map = material.textures[static_cast<std::size_t>(TextureSlot::Normal)];
        if (map.image >= 0) {
            const glm::vec3 bent = shader::NtcrUnpackNormal(
                glm::vec3(Read(hit, TextureSlot::Normal, isKnown)), material.normalScale);
            if (primitive.hasTangents && primitive.hasNormals) {
                std::array<glm::vec3, 3> tangents;
                for (std::size_t k = 0; k < 3; ++k)
                    tangents[k] = glm::normalize(turn * glm::vec3(corners[k].tangent));
                const float side = corners[0].tangent.w * glm::determinant(turn) < 0.0f ? -1.0f : 1.0f;
                normal = shader::NtcrBendByTangents(
                    bent, normal, glm::vec4(Mix(hit.at, tangents[0], tangents[1], tangents[2]), side));
            } else {
                shader::NtcrDerivatives d;
                d.positionX =
                    turn * Mix(hit.alongX, corners[0].position, corners[1].position, corners[2].position);
                d.positionY =
                    turn * Mix(hit.alongY, corners[0].position, corners[1].position, corners[2].position);
                const int set = map.address.uvSet;
                const auto turnUv = [&](const glm::vec3& weights) {
                    const glm::vec3 uv(
                        Mix(weights, corners[0].uv[set], corners[1].uv[set], corners[2].uv[set]), 0.0f);
                    return glm::vec2(glm::dot(map.address.transform.row0, uv),
                                     glm::dot(map.address.transform.row1, uv));
                };
                d.uvX = turnUv(hit.alongX);
                d.uvY = turnUv(hit.alongY);
                normal = shader::NtcrBendByDerivatives(bent, glm::normalize(normal), d);
            }
        }
        return glm::normalize(normal) * (hit.isBack ? -1.0f : 1.0f);
    }

    Shaded Shade(const Hit& hit) const {
        const Material& material = GetMaterial(hit.instance);
        Shaded shaded;
        shaded.isKnown = hit.isKnown;
        bool& isKnown = shaded.isKnown;
        std::array<glm::vec4, 3> colors;
        for (std::uint32_t k = 0; k < 3; ++k)
            colors[k] = scene_.vertices[scene_.indices[hit.firstIndex + k]].color;
        const glm::vec4 base = Read(hit, TextureSlot::BaseColor, isKnown) * material.baseColorFactor *
                               Mix(hit.at, colors[0], colors[1], colors[2]);
        shader::NtcrSurface surface;
        if (material.specularGlossiness) {
            const glm::vec4 gloss = Read(hit, TextureSlot::SpecularGlossiness, isKnown) *
                                    glm::vec4(material.specularFactor, material.glossinessFactor);
            surface = shader::NtcrMakeSpecularGlossiness(glm::vec3(base), glm::vec3(gloss), gloss.w);
        } else {
            const glm::vec4 rough = Read(hit, TextureSlot::MetallicRoughness, isKnown);
            surface = shader::NtcrMakeMetallicRoughness(glm::vec3(base), rough.y * material.metallicFactor,
                                                        rough.x * material.roughnessFactor);
        }
        const glm::vec3 n = GetNormal(hit, isKnown);
        const shader::NtcrEnvironmentTaps taps =
            shader::NtcrGetEnvironmentTaps(surface.roughness, glm::dot(n, kToEye));
        const glm::vec2* cells = GetEnvironmentTable().data() + taps.first;
        const glm::vec2 environment = shader::NtcrMixEnvironment(
            taps, cells[0], cells[1], cells[NTCR_ENVIRONMENT_SIZE], cells[NTCR_ENVIRONMENT_SIZE + 1]);
        const float occlusion = shader::NtcrGetOcclusion(Read(hit, TextureSlot::Occlusion, isKnown).x,
                                                         material.occlusionStrength);
        const shader::NtcrReflection reflection =
            shader::NtcrReflectLights(lights_, surface, n, kToEye, environment, occlusion, 1.0f);
        glm::vec3 radiance = shader::NtcrGetRadiance(reflection);
        if (material.transmissionFactor > 0.0f)
            radiance = shader::NtcrGetTransmittedRadiance(
                lights_, surface, reflection, kToEye, environment,
                material.transmissionFactor * Read(hit, TextureSlot::Transmission, isKnown).x);
        if (material.emissiveFactor != glm::vec3(0.0f))
            radiance += material.emissiveFactor * glm::vec3(Read(hit, TextureSlot::Emissive, isKnown));
        shaded.color = glm::vec4(radiance, base.w);
        return shaded;
    }

    const Scene& scene_;
    const Camera& camera_;
    int width_, height_;
    const ReadTexel& texels_;
    const shader::NtcrLights lights_ = MakeLights();
    std::vector<std::vector<Hit>> hits_;
};

/// One of the scene's texture sets, all texels of mip 0.
struct DecodedSet {
    int width = 0;
    std::vector<float> texels; // 16 channels each
};

DecodedSet DecodeSet(const std::string& path, DecodeMath math) {
    tool::TextureSet set = tool::LoadTextureSet(path);
    const tool::DecodeData data = tool::LoadDecodeData(set, math);
    auto decoder = tool::MakeDecoder(data, {});
    REQUIRE(decoder.has_value());
    const TextureSetDesc& desc = set.metadata.GetDesc();
    DecodedSet decoded;
    decoded.width = desc.width;
    decoded.texels.resize(static_cast<std::size_t>(desc.width) * static_cast<std::size_t>(desc.height) * 16);
    DecodeOptions options;
    options.math = math;
    options.convertToLinear = true;
    REQUIRE((*decoder)->Decode(0, {0, 0, desc.width, desc.height}, options, decoded.texels).has_value());
    return decoded;
}

float Round(float value, ColorSpace space) {
    const float stored = std::clamp(image::EncodeColor(space, value), 0.0f, 1.0f);
    return image::DecodeColor(space, static_cast<float>(std::lround(255.0f * stored)) / 255.0f);
}

} // namespace

Camera MakeFrontCamera(glm::vec2 center, float unitsPerPixel, int width, int height) {
    Camera camera;
    camera.name = "test";
    camera.perspective = false;
    camera.xmag = 0.5f * unitsPerPixel * static_cast<float>(width);
    camera.ymag = 0.5f * unitsPerPixel * static_cast<float>(height);
    camera.znear = 1.0f;
    camera.zfar = 100.0f;
    camera.toWorld[3] = glm::vec4(center, 50.0f, 1.0f);
    return camera;
}

ReadTexel MakeImageSource(const Scene& scene) {
    return [&scene](int material, TextureSlot slot, glm::ivec2 at) {
        const MaterialTexture& texture =
            scene.materials[static_cast<std::size_t>(material)].textures[static_cast<std::size_t>(slot)];
        const SourceImage& image = scene.images[static_cast<std::size_t>(texture.image)];
        const auto texel = static_cast<std::size_t>(at.y * image.width + at.x);
        glm::vec4 value;
        for (std::size_t c = 0; c < 4; ++c) {
            const float stored = static_cast<float>(image.texels[4 * texel + c]) / 255.0f;
            const bool isColor = c < 3 && HoldsColors(static_cast<std::size_t>(slot));
            value[static_cast<int>(c)] =
                image::DecodeColor(isColor ? ColorSpace::sRGB : ColorSpace::Linear, stored);
        }
        if (HoldsColors(static_cast<std::size_t>(slot)) && !image.radiance.empty())
            value = glm::vec4(image.radiance[3 * texel], image.radiance[3 * texel + 1],
                              image.radiance[3 * texel + 2], value.w);
        return slot == TextureSlot::MetallicRoughness ? glm::vec4(value.y, value.z, 0.0f, 0.0f) : value;
    };
}

ReadTexel MakeSetSource(const Scene& scene, DecodeMath math, bool rounds) {
    auto sets = std::make_shared<std::map<int, DecodedSet>>();
    const ReadTexel images = MakeImageSource(scene);
    return [&scene, math, rounds, sets, images](int material, TextureSlot slot, glm::ivec2 at) {
        const MaterialTexture& texture =
            scene.materials[static_cast<std::size_t>(material)].textures[static_cast<std::size_t>(slot)];
        if (texture.textureSet < 0)
            return images(material, slot, at);
        const auto [known, isNew] = sets->try_emplace(texture.textureSet);
        DecodedSet& set = known->second;
        if (isNew)
            set = DecodeSet(scene.textureSets[static_cast<std::size_t>(texture.textureSet)].path, math);
        const auto first = static_cast<std::size_t>(at.y * set.width + at.x) * 16 +
                           static_cast<std::size_t>(texture.firstChannel);
        const bool isColor = HoldsColors(static_cast<std::size_t>(slot));
        glm::vec4 value(1.0f);
        for (int c = 0; c < texture.channels; ++c) {
            value[c] = set.texels[first + static_cast<std::size_t>(c)];
            if (rounds && slot != TextureSlot::Emissive) // light is stored in floats
                value[c] = Round(value[c], isColor && c < 3 ? ColorSpace::sRGB : ColorSpace::Linear);
        }
        if (slot == TextureSlot::Normal)
            return value; // what bends is not clamped
        value = slot == TextureSlot::Emissive ? glm::max(value, glm::vec4(0.0f))
                                              : glm::clamp(value, glm::vec4(0.0f), glm::vec4(1.0f));
        return slot == TextureSlot::MetallicRoughness ? glm::vec4(value.y, value.x, 0.0f, 0.0f) : value;
    };
}

Prediction Predict(const Scene& scene, const Camera& camera, int width, int height, float exposure,
                   const ReadTexel& texels) {
    return Painter(scene, camera, width, height, texels).Paint(exposure);
}

int GetLargestDifference(const Prediction& prediction, const Picture& picture) {
    if (prediction.picture.size() != picture.size())
        return 256;
    int largest = 0;
    for (std::size_t i = 0; i < picture.size(); ++i) {
        if (prediction.isKnown[i / 4])
            largest = std::max(
                largest, std::abs(static_cast<int>(prediction.picture[i]) - static_cast<int>(picture[i])));
    }
    return largest;
}

} // namespace openntc_tests
