// SPDX-License-Identifier: MIT
// A glTF 2.0 scene as the renderer draws it: flat lists, instances in world space, every number checked.
#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace openntc::renderer {

/// What a texture means to the shading model; the order of MaterialTexture in Material::textures.
enum class TextureSlot {
    BaseColor,          ///< or diffuse; RGB sRGB, A linear
    MetallicRoughness,  ///< G roughness, B metallic
    SpecularGlossiness, ///< RGB specular sRGB, A glossiness
    Normal,
    Occlusion,
    Emissive,
    Transmission,
    Count,
};

inline constexpr std::size_t kTextureSlotCount = static_cast<std::size_t>(TextureSlot::Count);

enum class AlphaMode { Opaque, Mask, Blend };

enum class Wrap { Repeat, Mirror, Clamp };

/// KHR_texture_transform as two rows: uv' = (dot(row0, (u, v, 1)), dot(row1, (u, v, 1))).
struct UvTransform {
    glm::vec3 row0{1.0f, 0.0f, 0.0f};
    glm::vec3 row1{0.0f, 1.0f, 0.0f};

    bool operator==(const UvTransform&) const = default;
};

/// How a texture is addressed. Textures of one texture set share it (`ntc convert-gltf` sees to that).
struct TextureAddress {
    int uvSet = 0;
    UvTransform transform;
    Wrap wrapS = Wrap::Repeat;
    Wrap wrapT = Wrap::Repeat;

    bool operator==(const TextureAddress&) const = default;
};

/// A texture of a material: where its texels are in the source images, and in a texture set if there is one.
struct MaterialTexture {
    int image = -1; ///< index in Scene::images; -1: the material has no such texture
    TextureAddress address;
    int textureSet = -1; ///< index in Scene::textureSets; -1: in none
    /// In the texture set, of the slot's first channel; of MetallicRoughness that is metallic, roughness
    /// follows.
    int firstChannel = -1;
    int channels = 0; ///< that the set holds of it
};

/// Metallic-roughness or, with `specularGlossiness`, KHR_materials_pbrSpecularGlossiness.
struct Material {
    std::string name;
    bool specularGlossiness = false;
    std::array<MaterialTexture, kTextureSlotCount> textures{};
    glm::vec4 baseColorFactor{1.0f}; ///< diffuseFactor
    float metallicFactor = 1.0f;
    float roughnessFactor = 1.0f;
    glm::vec3 specularFactor{1.0f};
    float glossinessFactor = 1.0f;
    float normalScale = 1.0f;
    float occlusionStrength = 1.0f;
    glm::vec3 emissiveFactor{0.0f}; ///< times KHR_materials_emissive_strength
    float transmissionFactor = 0.0f;
    AlphaMode alphaMode = AlphaMode::Opaque;
    float alphaCutoff = 0.5f;
    /// Mips of the colour's alpha keep the share of texels that have this or more, as `ntc convert-gltf` has it; 0: none.
    float keptCoverage = 0.0f;
    bool doubleSided = false;
};

/// As it lies in the vertex buffer. `tangent.w` 0: none; the shader uses the derivative frame.
struct Vertex {
    glm::vec3 position{0.0f};
    glm::vec3 normal{0.0f}; ///< 0: flat, from derivatives
    glm::vec4 tangent{0.0f};
    glm::vec2 uv[2] = {};
    glm::vec4 color{1.0f}; ///< COLOR_0, linear
};

/// One primitive: a range of Scene::indices (triangles, offsets already added).
struct Primitive {
    std::uint32_t firstIndex = 0;
    std::uint32_t indexCount = 0;
    int material = -1; ///< index in Scene::materials, never -1 after loading: a default material is added
    glm::vec3 center{0.0f}; ///< of its bounds, in the mesh's space
    bool hasTangents = false;
    bool hasNormals = false;
};

/// A primitive in the world, in draw order.
struct Instance {
    int primitive = 0;
    glm::mat4 toWorld{1.0f};
    bool flipped = false; ///< negative determinant: front faces are clockwise
};

struct Camera {
    std::string name;
    glm::mat4 toWorld{1.0f}; ///< rotation and translation only
    bool perspective = true;
    float yfov = 0.7f;   ///< radians
    float aspect = 0.0f; ///< 0: the viewport's
    float xmag = 1.0f, ymag = 1.0f;
    float znear = 0.01f;
    float zfar = 0.0f; ///< 0: infinite
};

/// A source image, decoded to 8-bit RGBA (16-bit sources are rounded), rows top to bottom.
struct SourceImage {
    std::string label;
    std::string error; ///< not empty: it could not be read; `texels` are then one grey texel
    int width = 0, height = 0;
    std::vector<std::uint8_t> texels; ///< width * height * 4
    /// Colours above 1: width * height * 3 linear numbers, of which texels are sRGB, clamped. Mostly empty.
    std::vector<float> radiance;
};

/// A file with a texture set. `error` not empty: it could not be used; its materials fall back to source
/// images.
struct TextureSetFile {
    std::string path;
    std::string error;
};

struct Bounds {
    glm::vec3 low{0.0f}, high{0.0f};
};

struct Scene {
    std::string name;
    std::vector<Vertex> vertices;
    std::vector<std::uint32_t> indices;
    std::vector<Primitive> primitives;
    std::vector<Instance> instances;
    std::vector<Material> materials;
    std::vector<SourceImage> images;
    std::vector<TextureSetFile> textureSets;
    std::vector<Camera> cameras; ///< of the file; may be empty (MakeOrbitCamera)
    Bounds bounds;               ///< of all instances, in the world
    std::vector<std::string> warnings;
};

} // namespace openntc::renderer
