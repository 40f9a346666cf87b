// SPDX-License-Identifier: MIT
#include "renderer/scene/SceneMaterials.h"

#include "renderer/scene/GltfFields.h"

#include "Output.h"
#include "gltf/GltfMaterials.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string_view>
#include <utility>

namespace openntc::renderer {

namespace {

using Value = tool::GltfFile::Value;

constexpr FloatRange kUnit{0.0f, 1.0f}, kAny{-1e30f, 1e30f}, kPositive{0.0f, 1e30f};

Wrap GetWrap(int number) {
    constexpr int kClampToEdge = 33071, kMirroredRepeat = 33648;
    return number == kClampToEdge ? Wrap::Clamp : number == kMirroredRepeat ? Wrap::Mirror : Wrap::Repeat;
}

TextureAddress MakeAddress(const tool::TextureAddressing& source) {
    TextureAddress address;
    address.uvSet = source.texCoord;
    address.wrapS = GetWrap(source.sampler.wrapS);
    address.wrapT = GetWrap(source.sampler.wrapT);
    const tool::TextureTransform& t = source.transform;
    const double c = std::cos(t.rotation), s = std::sin(t.rotation);
    address.transform.row0 = glm::vec3(t.scale[0] * c, -t.scale[1] * s, t.offset[0]);
    address.transform.row1 = glm::vec3(t.scale[0] * s, t.scale[1] * c, t.offset[1]);
    return address;
}

class FactorReader {
public:
    FactorReader(const tool::GltfFile& file, const Value& value, std::string where, Material& material)
        : file_(file), value_(value), where_(std::move(where)), material_(material) {}

    void Read() {
        const Value& extensions = file_.GetObject(value_, "extensions", where_ + ".extensions");
        if (extensions.HasMember(kGloss))
            ReadGloss(extensions);
        else
            ReadMetallicRoughness();
        const std::string normal = where_ + ".normalTexture", occlusion = where_ + ".occlusionTexture";
        const Value& normalTexture = file_.GetObject(value_, "normalTexture", normal);
        material_.normalScale = ReadFloat(file_, normalTexture, "scale", normal, 1.0f, kAny);
        const Value& occlusionTexture = file_.GetObject(value_, "occlusionTexture", occlusion);
        material_.occlusionStrength = ReadFloat(file_, occlusionTexture, "strength", occlusion, 1.0f, kUnit);
        ReadEmission(extensions);
        const Value& transmission = file_.GetObject(extensions, kTransmission, where_ + "." + kTransmission);
        material_.transmissionFactor =
            ReadFloat(file_, transmission, "transmissionFactor", where_ + "." + kTransmission, 0.0f, kUnit);
        ReadAlpha();
    }

private:
    static constexpr const char* kGloss = "KHR_materials_pbrSpecularGlossiness";
    static constexpr const char* kTransmission = "KHR_materials_transmission";

    void ReadGloss(const Value& extensions) {
        const std::string at = where_ + "." + kGloss;
        const Value& gloss = file_.GetObject(extensions, kGloss, at);
        material_.specularGlossiness = true;
        ReadFloats(file_, gloss, "diffuseFactor", at, {&material_.baseColorFactor.x, 4});
        ReadFloats(file_, gloss, "specularFactor", at, {&material_.specularFactor.x, 3});
        material_.glossinessFactor = ReadFloat(file_, gloss, "glossinessFactor", at, 1.0f, kUnit);
    }
    void ReadMetallicRoughness() {
        const std::string at = where_ + ".pbrMetallicRoughness";
        const Value& pbr = file_.GetObject(value_, "pbrMetallicRoughness", at);
        ReadFloats(file_, pbr, "baseColorFactor", at, {&material_.baseColorFactor.x, 4});
        material_.metallicFactor = ReadFloat(file_, pbr, "metallicFactor", at, 1.0f, kUnit);
        material_.roughnessFactor = ReadFloat(file_, pbr, "roughnessFactor", at, 1.0f, kUnit);
    }
    void ReadEmission(const Value& extensions) {
        ReadFloats(file_, value_, "emissiveFactor", where_, {&material_.emissiveFactor.x, 3});
        const std::string at = where_ + ".KHR_materials_emissive_strength";
        const Value& strength = file_.GetObject(extensions, "KHR_materials_emissive_strength", at);
        material_.emissiveFactor *= ReadFloat(file_, strength, "emissiveStrength", at, 1.0f, kPositive);
    }
    void ReadAlpha() {
        const std::string mode = file_.GetString(value_, "alphaMode", where_);
        if (!mode.empty() && mode != "OPAQUE" && mode != "MASK" && mode != "BLEND")
            file_.Fail(where_ + ".alphaMode", mode + ": OPAQUE, MASK or BLEND");
        material_.alphaMode = mode == "MASK"    ? AlphaMode::Mask
                              : mode == "BLEND" ? AlphaMode::Blend
                                                : AlphaMode::Opaque;
        material_.alphaCutoff = ReadFloat(file_, value_, "alphaCutoff", where_, 0.5f, kPositive);
        const float threshold = material_.alphaCutoff / material_.baseColorFactor.w;
        if (material_.alphaMode == AlphaMode::Mask && threshold > 0.0f && threshold <= 1.0f)
            material_.keptCoverage = threshold;
        if (const auto member = value_.FindMember("doubleSided"); member != value_.MemberEnd()) {
            if (!member->value.IsBool())
                file_.Fail(where_ + ".doubleSided", "must be true or false");
            material_.doubleSided = member->value.GetBool();
        }
    }

    const tool::GltfFile& file_;
    const Value& value_;
    std::string where_;
    Material& material_;
};

} // namespace

TextureSlot FindTextureSlot(std::string_view name) {
    constexpr std::pair<std::string_view, TextureSlot> kSlots[] = {
        {"BaseColor", TextureSlot::BaseColor},
        {"Diffuse", TextureSlot::BaseColor},
        {"MetallicRoughness", TextureSlot::MetallicRoughness},
        {"SpecularGlossiness", TextureSlot::SpecularGlossiness},
        {"Normal", TextureSlot::Normal},
        {"Occlusion", TextureSlot::Occlusion},
        {"Emissive", TextureSlot::Emissive},
        {"Transmission", TextureSlot::Transmission}};
    for (const auto& [own, slot] : kSlots) {
        if (own == name)
            return slot;
    }
    return TextureSlot::Count;
}

void ReadSceneMaterials(tool::GltfFile& file, Scene& scene, ImageSources& images) {
    const std::vector<tool::GltfMaterial> materials = tool::ReadGltfMaterials(file);
    const Value* list = file.FindArray("materials");
    std::map<std::string, int> known; // images by path
    for (std::size_t i = 0; i < materials.size(); ++i) {
        const tool::GltfMaterial& source = materials[i];
        const Value& value = (*list)[static_cast<rapidjson::SizeType>(i)];
        if (!value.IsObject())
            file.Fail(source.where, "must be an object");
        Material material;
        material.name = source.name;
        FactorReader(file, value, source.where, material).Read();
        for (const std::string& error : source.errors)
            scene.warnings.push_back(error);
        for (const tool::GltfTexture& texture : source.textures) {
            const TextureSlot slot = FindTextureSlot(texture.source.name);
            MaterialTexture& own = material.textures[static_cast<std::size_t>(slot)];
            if (texture.addressing.texCoord > 1) {
                scene.warnings.push_back(texture.slot + tool::Format(".texCoord: %d: 0 and 1 are drawn",
                                                                     texture.addressing.texCoord));
                continue;
            }
            own.address = MakeAddress(texture.addressing);
            const auto [at, isNew] = known.try_emplace(texture.source.path, static_cast<int>(images.size()));
            if (isNew) {
                images.push_back({texture.source.path, texture.source.bytes});
                scene.images.emplace_back().label = texture.image;
            }
            own.image = at->second;
        }
        if (file.GetObject(value, "extensions", source.where).HasMember("KHR_materials_unlit"))
            scene.warnings.push_back(source.where + ": KHR_materials_unlit: drawn with light");
        scene.materials.push_back(std::move(material));
    }
}

} // namespace openntc::renderer
