// SPDX-License-Identifier: MIT
#include "gltf/GltfMaterials.h"

#include "Failure.h"
#include "Output.h"
#include "gltf/GltfFile.h"

#include <algorithm>
#include <map>
#include <set>

namespace openntc::tool {

namespace {

using Value = GltfFile::Value;

/// JSON pointers of texture references whose KHR_texture_transform is animated, with what moves it.
using Animations = std::map<std::string, std::string>;

/// Animations are of no other use here: malformed ones move nothing.
Animations FindAnimations(const GltfFile& file) {
    Animations animations;
    const auto member = [](const Value& value, const char* name) -> const Value* {
        if (!value.IsObject())
            return nullptr;
        const auto found = value.FindMember(name);
        return found == value.MemberEnd() ? nullptr : &found->value;
    };
    const auto visit = [&](unsigned animation, const Value& channel) {
        const Value* at = member(channel, "target");
        for (const char* name : {"extensions", "KHR_animation_pointer", "pointer"})
            at = at == nullptr ? nullptr : member(*at, name);
        const Value* sampler = member(channel, "sampler");
        if (at == nullptr || !at->IsString() || sampler == nullptr || !sampler->IsUint())
            return;
        const std::string pointer = at->GetString();
        const std::size_t transform = pointer.find("/extensions/KHR_texture_transform/");
        if (pointer.compare(0, 11, "/materials/") == 0 && transform != std::string::npos)
            animations[pointer.substr(0, transform)] += Format("%u,%u:%s;", animation, sampler->GetUint(),
                                                               pointer.substr(pointer.rfind('/')).c_str());
    };
    const Value* list = member(file.GetRoot(), "animations");
    for (rapidjson::SizeType i = 0; list != nullptr && list->IsArray() && i < list->Size(); ++i) {
        const Value* channels = member((*list)[i], "channels");
        for (rapidjson::SizeType k = 0; channels != nullptr && channels->IsArray() && k < channels->Size();
             ++k)
            visit(i, (*channels)[k]);
    }
    return animations;
}

/// What a texture of a material means.
struct Slot {
    const char* field;
    const char* name;
    int firstChannel;
    const char* swizzle;
    bool isSrgb;
    BlockCompressedFormat bcFormat;
    bool hasMask = false;     ///< alpha is a mask
    bool alphaIsData = false; ///< alpha is glossiness
};

class MaterialReader {
public:
    MaterialReader(GltfFile& file, const Animations& animations, const Value& value, unsigned index)
        : file_(file), animations_(animations), value_(value), index_(index) {
        material_.where = Format("materials[%u]", index);
        material_.name = Format("material%u", index);
    }

    GltfMaterial Read() {
        try {
            ReadSlots();
            if (material_.errors.empty())
                ListDropped(value_, "", 0);
        } catch (const CommandError& error) {
            Remember(error);
        }
        return std::move(material_);
    }

private:
    void Remember(const CommandError& error) {
        const std::string prefix = error.GetSubject() == file_.GetPath() ? "" : error.GetSubject() + ": ";
        material_.errors.push_back(prefix + error.what());
    }

    void ReadSlots() {
        const std::string& where = material_.where;
        if (!value_.IsObject())
            file_.Fail(where, "must be an object");
        if (const std::string name = file_.GetString(value_, "name", where); !name.empty())
            material_.name = name;
        const std::string alphaMode = file_.GetString(value_, "alphaMode", where);
        if (!alphaMode.empty() && alphaMode != "OPAQUE" && alphaMode != "BLEND" && alphaMode != "MASK")
            file_.Fail(where + ".alphaMode", alphaMode + ": OPAQUE, MASK or BLEND");
        const bool isOpaque = alphaMode.empty() || alphaMode == "OPAQUE", isMask = alphaMode == "MASK";
        const char* color = isOpaque ? "RGB" : "RGBA";
        constexpr auto kBc4 = BlockCompressedFormat::BC4, kBc5 = BlockCompressedFormat::BC5,
                       kBc7 = BlockCompressedFormat::BC7;
        const Value& extensions = file_.GetObject(value_, "extensions", where + ".extensions");
        const char* gloss = "KHR_materials_pbrSpecularGlossiness";
        if (extensions.HasMember(gloss)) {
            Enter(extensions, std::string("extensions/") + gloss, gloss);
            ReadCoverage("diffuseFactor", isMask);
            Add({"diffuseTexture", "Diffuse", 0, color, true, kBc7, isMask});
            Add({"specularGlossinessTexture", "SpecularGlossiness", 4, "RGBA", true, kBc7, false, true});
        } else {
            Enter(value_, "pbrMetallicRoughness", "pbrMetallicRoughness");
            ReadCoverage("baseColorFactor", isMask);
            Add({"baseColorTexture", "BaseColor", 0, color, true, kBc7, isMask});
            Add({"metallicRoughnessTexture", "MetallicRoughness", 4, "BG", false, kBc5});
        }
        parent_ = &value_;
        parentPointer_.clear();
        Add({"normalTexture", "Normal", 8, "RGB", false, kBc7});
        Add({"occlusionTexture", "Occlusion", 11, "R", false, kBc4});
        Add({"emissiveTexture", "Emissive", 12, "RGB", true, kBc7});
        Enter(extensions, "extensions/KHR_materials_transmission", "KHR_materials_transmission");
        Add({"transmissionTexture", "Transmission", 15, "R", false, kBc4});
    }

    /// What is tested is the texture's alpha times the factor's.
    void ReadCoverage(const char* factorField, bool isMask) {
        if (!isMask)
            return;
        double cutoff = 0.5, factor[4] = {1, 1, 1, 1};
        if (value_.HasMember("alphaCutoff") && value_["alphaCutoff"].IsNumber())
            cutoff = value_["alphaCutoff"].GetDouble();
        ReadNumbers(*parent_, factorField, material_.where, factor, 4);
        const double threshold = cutoff / factor[3];
        if (threshold > 0.0 && threshold <= 1.0)
            material_.keepCoverage = static_cast<float>(threshold);
    }

    void Enter(const Value& parent, const std::string& pointer, const char* name) {
        parent_ = &file_.GetObject(parent, name, material_.where + "." + name);
        parentPointer_ = pointer + "/";
    }

    void Add(const Slot& slot) {
        if (!parent_->HasMember(slot.field))
            return;
        // Every fault of a material in one run, not one a run.
        try {
            material_.textures.push_back(ReadTexture(slot));
        } catch (const CommandError& error) {
            Remember(error);
        }
    }
    GltfTexture ReadTexture(const Slot& slot) {
        const std::string pointer = parentPointer_ + slot.field;
        converted_.insert(pointer);
        GltfTexture texture;
        texture.slot = material_.where + "." + slot.field;
        const Value& reference = file_.GetObject(*parent_, slot.field, texture.slot);
        const Value& object = file_.Follow(reference, "index", "textures", texture.slot);
        const GltfImage image = file_.GetImage(object, texture.slot);
        texture.image = image.label;
        texture.source.path = image.path;
        texture.source.bytes = image.bytes;
        texture.source.name = slot.name;
        texture.source.firstChannel = slot.firstChannel;
        texture.source.swizzle = slot.swizzle;
        texture.source.isSrgb = slot.isSrgb;
        texture.source.bcFormat = slot.bcFormat;
        texture.source.maskLetter = slot.hasMask ? 'A' : '\0';
        texture.source.alphaIsData = slot.alphaIsData;
        ReadAddressing(texture, reference, object);
        const auto animation = animations_.find(Format("/materials/%u/%s", index_, pointer.c_str()));
        if (animation != animations_.end())
            texture.addressing.animation = animation->second;
        return texture;
    }

    void ReadAddressing(GltfTexture& texture, const Value& reference, const Value& object) const {
        TextureAddressing& addressing = texture.addressing;
        addressing.texCoord = GetSmall(reference, "texCoord", texture.slot, 0);
        const std::string at = texture.slot + ".extensions";
        const Value& transform = file_.GetObject(file_.GetObject(reference, "extensions", at),
                                                 "KHR_texture_transform", at + ".KHR_texture_transform");
        const std::string where = at + ".KHR_texture_transform";
        addressing.texCoord = GetSmall(transform, "texCoord", where, addressing.texCoord);
        ReadNumbers(transform, "offset", where, addressing.transform.offset.data(), 2);
        ReadNumbers(transform, "rotation", where, &addressing.transform.rotation, 1);
        ReadNumbers(transform, "scale", where, addressing.transform.scale.data(), 2);
        if (!object.HasMember("sampler"))
            return;
        const Value& sampler = file_.Follow(object, "sampler", "samplers", texture.slot + ".texture");
        TextureSampler& own = addressing.sampler;
        own.wrapS = GetSamplerNumber(sampler, "wrapS", texture.slot, {10497, 33071, 33648});
        own.wrapT = GetSamplerNumber(sampler, "wrapT", texture.slot, {10497, 33071, 33648});
        own.magFilter = GetSamplerNumber(sampler, "magFilter", texture.slot, {9728, 9729});
        own.minFilter =
            GetSamplerNumber(sampler, "minFilter", texture.slot, {9728, 9729, 9984, 9985, 9986, 9987});
    }
    int GetSmall(const Value& parent, const char* name, const std::string& where, int fallback) const {
        constexpr unsigned kLimit = 1000;
        const auto member = parent.FindMember(name);
        if (member == parent.MemberEnd())
            return fallback;
        if (!member->value.IsUint() || member->value.GetUint() >= kLimit)
            file_.Fail(where + "." + name, Format("must be an integer below %u", kLimit));
        return static_cast<int>(member->value.GetUint());
    }
    int GetSamplerNumber(const Value& sampler, const char* name, const std::string& where,
                         const std::set<int>& allowed) const {
        const auto member = sampler.FindMember(name);
        if (member == sampler.MemberEnd())
            return 0;
        if (!member->value.IsInt() || allowed.count(member->value.GetInt()) == 0)
            file_.Fail(where + ".texture.sampler." + name, "no such mode");
        return member->value.GetInt();
    }
    void ReadNumbers(const Value& parent, const char* name, const std::string& where, double* numbers,
                     unsigned count) const {
        const auto member = parent.FindMember(name);
        if (member == parent.MemberEnd())
            return;
        const Value& value = member->value;
        const auto isFinite = [](const Value& number) { return number.IsNumber(); }; // JSON has no others
        if (count == 1 ? !isFinite(value)
                       : !value.IsArray() || value.Size() != count ||
                             !std::all_of(value.Begin(), value.End(), isFinite))
            file_.Fail(where + "." + name, Format("must be %u numbers", count));
        for (unsigned i = 0; i < count; ++i)
            numbers[i] = count == 1 ? value.GetDouble() : value[i].GetDouble();
    }

    /// References to textures, wherever in the material, that no slot has taken. `pointer` ends in '/'.
    void ListDropped(const Value& parent, const std::string& pointer, int depth) {
        constexpr int kMaxDepth = 16; // known extensions nest four deep
        if (depth > kMaxDepth)
            return;
        for (const auto& member : parent.GetObject()) {
            const std::string name(member.name.GetString(), member.name.GetStringLength());
            const std::string own = pointer + name;
            if (!member.value.IsObject() || name == "extras" || converted_.count(own) != 0)
                continue;
            const bool isTexture =
                member.value.HasMember("index") && name.find("exture") != std::string::npos;
            if (isTexture)
                Drop(own);
            else
                ListDropped(member.value, own + "/", depth + 1);
        }
    }
    void Drop(std::string pointer) {
        const bool isReplaced = pointer.compare(0, 21, "pbrMetallicRoughness/") == 0;
        std::replace(pointer.begin(), pointer.end(), '/', '.');
        material_.notConverted.push_back({pointer, isReplaced
                                                       ? "KHR_materials_pbrSpecularGlossiness is used instead"
                                                       : "the layout of the channels has no place for it"});
    }

    GltfFile& file_;
    const Animations& animations_;
    const Value& value_;
    unsigned index_;
    GltfMaterial material_;
    const Value* parent_ = nullptr;
    std::string parentPointer_;
    std::set<std::string> converted_; ///< pointers inside the material
};

} // namespace

std::vector<GltfMaterial> ReadGltfMaterials(GltfFile& file) {
    const Animations animations = FindAnimations(file);
    std::vector<GltfMaterial> materials;
    const Value* list = file.FindArray("materials");
    for (rapidjson::SizeType i = 0; list != nullptr && i < list->Size(); ++i)
        materials.push_back(MaterialReader(file, animations, (*list)[i], i).Read());
    return materials;
}

std::vector<GltfMaterial> ReadGltfMaterials(const std::string& path) {
    GltfFile file(path);
    std::vector<GltfMaterial> materials = ReadGltfMaterials(file);
    if (materials.empty())
        file.Fail("materials", "none");
    return materials;
}

void AddTexture(Manifest& manifest, const GltfMaterial& material, const GltfTexture& texture) {
    manifest.textures.push_back(texture.source);
    if (texture.source.maskLetter != 0)
        manifest.keepCoverage = material.keepCoverage;
}

bool HasAlpha(const Manifest& manifest) {
    return std::any_of(manifest.textures.begin(), manifest.textures.end(),
                       [](const ManifestTexture& texture) {
                           return !texture.alphaIsData && texture.isSrgb.value_or(false) &&
                                  texture.swizzle.find('A') != std::string::npos;
                       });
}

Manifest MakeManifest(const GltfMaterial& material) {
    Manifest manifest;
    for (const GltfTexture& texture : material.textures)
        AddTexture(manifest, material, texture);
    return manifest;
}

} // namespace openntc::tool
