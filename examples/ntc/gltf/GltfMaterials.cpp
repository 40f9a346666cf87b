// SPDX-License-Identifier: MIT
#include "gltf/GltfMaterials.h"

#include "Failure.h"
#include "Output.h"

#include <rapidjson/document.h>
#include <rapidjson/error/en.h>

#include <cctype>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace openntc::tool {

namespace {

class GltfReader {
public:
    explicit GltfReader(const std::string& path) : path_(path) {}

    std::vector<GltfMaterial> Read() {
        std::ifstream file(path_, std::ios::binary);
        const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
        if (!file || text.empty())
            FailField("glTF", "cannot be read");
        if (text.compare(0, 4, "glTF") == 0)
            FailField("glTF", "binary (.glb): only .gltf with separate images is read");
        document_.Parse<rapidjson::kParseIterativeFlag>(text.c_str(), text.size());
        if (document_.HasParseError())
            FailField("glTF", Format("byte %zu: %s", document_.GetErrorOffset(),
                                     rapidjson::GetParseError_En(document_.GetParseError())));
        if (!document_.IsObject())
            FailField("glTF", "not an object");
        const std::string version = GetString(GetObject(document_, "asset", "asset"), "version", "asset");
        if (version.compare(0, 2, "2.") != 0)
            FailField("asset.version", version + ": 2.x is needed");
        std::vector<GltfMaterial> materials;
        const Value* list = FindArray("materials");
        for (rapidjson::SizeType i = 0; list != nullptr && i < list->Size(); ++i)
            materials.push_back(ReadMaterial((*list)[i], i));
        if (materials.empty())
            FailField("materials", "none");
        return materials;
    }

private:
    using Value = rapidjson::Value;

    [[noreturn]] void FailField(const std::string& field, const std::string& text) const {
        throw CommandError(ExitCode::BadInput, path_, field + ": " + text);
    }

    /// A member that is an object, or an empty object.
    const Value& GetObject(const Value& parent, const char* name, const std::string& where) const {
        static const Value kEmpty(rapidjson::kObjectType);
        const auto member = parent.FindMember(name);
        if (member == parent.MemberEnd())
            return kEmpty;
        if (!member->value.IsObject())
            FailField(where, "must be an object");
        return member->value;
    }
    std::string GetString(const Value& parent, const char* name, const std::string& where) const {
        const auto member = parent.FindMember(name);
        if (member == parent.MemberEnd())
            return {};
        if (!member->value.IsString())
            FailField(where + "." + name, "must be a string");
        return {member->value.GetString(), member->value.GetStringLength()};
    }
    const Value* FindArray(const char* name) const {
        const auto member = document_.FindMember(name);
        if (member == document_.MemberEnd())
            return nullptr;
        if (!member->value.IsArray())
            FailField(name, "must be an array");
        return &member->value;
    }
    /// The object that `parent`.`name` points to in one of the root's arrays.
    const Value& Follow(const Value& parent, const char* name, const char* array,
                        const std::string& where) const {
        const auto index = parent.FindMember(name);
        if (index == parent.MemberEnd())
            FailField(where + "." + name, "missing");
        const Value* list = FindArray(array);
        const rapidjson::SizeType count = list == nullptr ? 0 : list->Size();
        if (!index->value.IsUint() || index->value.GetUint() >= count)
            FailField(where + "." + name, Format("must be an index below the %u %s", count, array));
        const Value& element = (*list)[index->value.GetUint()];
        if (!element.IsObject())
            FailField(Format("%s[%u]", array, index->value.GetUint()), "must be an object");
        return element;
    }

    std::string GetImagePath(const Value& reference, const std::string& where) const {
        const Value& texture = Follow(reference, "index", "textures", where);
        const Value& image = Follow(texture, "source", "images", where + ".texture");
        const std::string uri = Unescape(GetString(image, "uri", where + ".image"));
        if (uri.empty() || uri.compare(0, 5, "data:") == 0)
            FailField(where, "the image is embedded: only separate image files are read");
        const std::filesystem::path file(uri);
        if (file.is_absolute() || uri.find("://") != std::string::npos || uri.find('\0') != std::string::npos)
            FailField(where, uri + ": must be a relative path");
        return (std::filesystem::path(path_).parent_path() / file).string();
    }
    static std::string Unescape(const std::string& uri) {
        std::string text;
        for (std::size_t i = 0; i < uri.size(); ++i) {
            const auto isDigit = [&](std::size_t at) {
                return at < uri.size() && std::isxdigit(static_cast<unsigned char>(uri[at])) != 0;
            };
            if (uri[i] == '%' && isDigit(i + 1) && isDigit(i + 2)) {
                text += static_cast<char>(std::stoi(uri.substr(i + 1, 2), nullptr, 16));
                i += 2;
            } else {
                text += uri[i];
            }
        }
        return text;
    }

    struct Slot {
        const char* field;
        const char* name;
        int firstChannel;
        const char* swizzle;
        bool isSrgb;
    };

    void Add(GltfMaterial& material, const Value& parent, const Slot& slot, const std::string& where) const {
        if (parent.FindMember(slot.field) == parent.MemberEnd())
            return;
        const std::string at = where + "." + slot.field;
        ManifestTexture texture;
        texture.path = GetImagePath(GetObject(parent, slot.field, at), at);
        texture.name = slot.name;
        texture.firstChannel = slot.firstChannel;
        texture.swizzle = slot.swizzle;
        texture.isSrgb = slot.isSrgb;
        material.manifest.textures.push_back(texture);
    }

    GltfMaterial ReadMaterial(const Value& value, unsigned index) const {
        const std::string where = Format("materials[%u]", index);
        if (!value.IsObject())
            FailField(where, "must be an object");
        GltfMaterial material;
        material.name = GetString(value, "name", where);
        if (material.name.empty())
            material.name = Format("material%u", index);
        const std::string alphaMode = GetString(value, "alphaMode", where);
        const Value& extensions = GetObject(value, "extensions", where + ".extensions");
        const Value& gloss =
            GetObject(extensions, "KHR_materials_pbrSpecularGlossiness", where + ".extensions");
        const Value& metal = GetObject(value, "pbrMetallicRoughness", where + ".pbrMetallicRoughness");
        const char* color = alphaMode.empty() || alphaMode == "OPAQUE" ? "RGB" : "";
        if (gloss.MemberCount() > 0) {
            Add(material, gloss, {"diffuseTexture", "Diffuse", 0, color, true}, where);
            SetAlpha(material, alphaMode);
            Add(material, gloss, {"specularGlossinessTexture", "SpecularGlossiness", 4, "", true}, where);
            if (!material.manifest.textures.empty())
                material.manifest.textures.back().keepAlpha = true; // glossiness 1 is not "no glossiness"
        } else {
            Add(material, metal, {"baseColorTexture", "BaseColor", 0, color, true}, where);
            SetAlpha(material, alphaMode);
            Add(material, metal, {"metallicRoughnessTexture", "MetallicRoughness", 4, "BG", false}, where);
        }
        Add(material, value, {"normalTexture", "Normal", 8, "RGB", false}, where);
        Add(material, value, {"occlusionTexture", "Occlusion", 11, "R", false}, where);
        Add(material, value, {"emissiveTexture", "Emissive", 12, "RGB", true}, where);
        Add(material, GetObject(extensions, "KHR_materials_transmission", where + ".extensions"),
            {"transmissionTexture", "Transmission", 15, "R", false}, where);
        return material;
    }
    static void SetAlpha(GltfMaterial& material, const std::string& alphaMode) {
        if (alphaMode == "MASK" && !material.manifest.textures.empty())
            material.manifest.textures.back().maskLetter = 'A';
    }

    const std::string& path_;
    rapidjson::Document document_;
};

} // namespace

std::vector<GltfMaterial> ReadGltfMaterials(const std::string& path) {
    return GltfReader(path).Read();
}

} // namespace openntc::tool
