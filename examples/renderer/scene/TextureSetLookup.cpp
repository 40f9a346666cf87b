// SPDX-License-Identifier: MIT
#include "renderer/scene/TextureSetLookup.h"

#include "renderer/scene/SceneMaterials.h"

#include "Failure.h"
#include "FileNames.h"
#include "InputFile.h"
#include "Output.h"
#include "TextureSet.h"
#include "gltf/MaterialList.h"

#include <rapidjson/document.h>

#include <algorithm>
#include <exception>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

namespace openntc::renderer {

namespace {

namespace fs = std::filesystem;

/// A texture of a material as a texture set has it.
struct StoredTexture {
    TextureSlot slot = TextureSlot::Count;
    int firstChannel = 0, channels = 0;
};

const rapidjson::Value* FindMember(const rapidjson::Value& value, const char* name) {
    if (!value.IsObject())
        return nullptr;
    const auto member = value.FindMember(name);
    return member == value.MemberEnd() ? nullptr : &member->value;
}

class SetFinder {
public:
    SetFinder(std::string folder, Scene& scene) : folder_(std::move(folder)), scene_(scene) {}

    void Run() {
        const std::vector<const rapidjson::Value*> listed = ReadList();
        for (std::size_t i = 0; i < scene_.materials.size(); ++i) {
            if (i < listed.size() && listed[i] != nullptr)
                AttachListed(scene_.materials[i], *listed[i]);
            else
                AttachNamed(scene_.materials[i]);
        }
    }

    /// Textures by their names in the set.
    void AttachFile(Material& material, const std::string& path) {
        const OpenSet& open = Open(path);
        if (!open.set)
            return;
        std::vector<StoredTexture> stored;
        const std::span<const Texture> textures = open.set->metadata.GetTextures();
        for (std::size_t i = 0; i < textures.size(); ++i) {
            const Texture& texture = textures[i];
            const TextureSlot slot = FindTextureSlot(texture.name);
            if (slot != TextureSlot::Count)
                stored.push_back({slot, texture.firstChannel, texture.numChannels});
            else if (texture.name == "Metalness" && i + 1 < textures.size() &&
                     textures[i + 1].name == "Roughness" &&
                     textures[i + 1].firstChannel == texture.firstChannel + 1)
                stored.push_back({TextureSlot::MetallicRoughness, texture.firstChannel, 2});
        }
        Attach(material, open, stored);
    }

private:
    struct OpenSet {
        int index = -1;                      ///< in Scene::textureSets
        std::optional<tool::TextureSet> set; ///< empty: it could not be opened
    };

    void Warn(const std::string& text) { scene_.warnings.push_back(text); }

    /// The entries of materials.json, in the order of Scene::materials.
    std::vector<const rapidjson::Value*> ReadList() {
        std::vector<const rapidjson::Value*> entries;
        std::error_code error;
        const std::string path = (fs::path(folder_) / tool::kMaterialListName).string();
        if (!fs::is_regular_file(path, error))
            return entries;
        try {
            const std::string text = tool::ReadAllText(path);
            list_.Parse<rapidjson::kParseIterativeFlag>(text.data(), text.size());
        } catch (const tool::CommandError& failure) {
            Warn(path + ": " + failure.what());
            return entries;
        }
        const rapidjson::Value* materials = list_.HasParseError() ? nullptr : FindMember(list_, "materials");
        if (materials == nullptr || !materials->IsArray()) {
            Warn(path + ": materials: must be an array: the list is ignored");
            return entries;
        }
        for (std::size_t i = 0; i < scene_.materials.size(); ++i) {
            const auto index = static_cast<rapidjson::SizeType>(i);
            const rapidjson::Value* entry = index < materials->Size() ? &(*materials)[index] : nullptr;
            const rapidjson::Value* name = entry == nullptr ? nullptr : FindMember(*entry, "name");
            if (name == nullptr || !name->IsString() || scene_.materials[i].name != name->GetString())
                entry = nullptr; // of another model
            entries.push_back(entry);
        }
        return entries;
    }

    void AttachListed(Material& material, const rapidjson::Value& entry) {
        const rapidjson::Value* textures = FindMember(entry, "textures");
        if (textures == nullptr || !textures->IsArray())
            return;
        std::vector<std::pair<std::string, std::vector<StoredTexture>>> files; // in the order of the list
        for (const rapidjson::Value& texture : textures->GetArray()) {
            const rapidjson::Value* name = FindMember(texture, "name");
            const rapidjson::Value* file = FindMember(texture, "file");
            const rapidjson::Value* first = FindMember(texture, "firstChannel");
            const rapidjson::Value* channels = FindMember(texture, "channels");
            if (file == nullptr || file->IsNull())
                continue; // not converted
            if (name == nullptr || !name->IsString() || !file->IsString() || first == nullptr ||
                !first->IsUint() || channels == nullptr || !channels->IsUint() || first->GetUint() > 15 ||
                channels->GetUint() > 4) {
                Warn(std::string(tool::kMaterialListName) + ": " + material.name +
                     ": a texture is malformed");
                continue;
            }
            const StoredTexture stored{FindTextureSlot(name->GetString()), static_cast<int>(first->GetUint()),
                                       static_cast<int>(channels->GetUint())};
            const auto known = std::find_if(files.begin(), files.end(), [&](const auto& other) {
                return other.first == file->GetString();
            });
            auto& own = known == files.end() ? files.emplace_back(file->GetString(), 0) : *known;
            own.second.push_back(stored);
        }
        for (const auto& [file, stored] : files) {
            if (fs::path(file).is_absolute()) {
                Warn(std::string(tool::kMaterialListName) + ": " + file + ": must be a relative path");
                continue;
            }
            Attach(material, Open((fs::path(folder_) / file).string()), stored);
        }
    }

    void AttachNamed(Material& material) {
        std::error_code error;
        const std::string path =
            (fs::path(folder_) / (tool::FileNames().Add(material.name) + ".ntc")).string();
        if (fs::exists(path, error))
            AttachFile(material, path);
    }

    const OpenSet& Open(const std::string& path) {
        const auto [entry, isNew] = open_.try_emplace(path);
        OpenSet& open = entry->second;
        if (!isNew)
            return open;
        open.index = static_cast<int>(scene_.textureSets.size());
        TextureSetFile& file = scene_.textureSets.emplace_back();
        file.path = path;
        try {
            open.set.emplace(tool::LoadTextureSet(path));
        } catch (const std::exception& failure) {
            file.error = failure.what();
            Warn(path + ": " + file.error + ": its materials keep their source images");
        }
        return open;
    }

    static int GetChannelCount(TextureSlot slot) {
        switch (slot) {
        case TextureSlot::Occlusion:
        case TextureSlot::Transmission:
            return 1;
        case TextureSlot::MetallicRoughness:
            return 2;
        case TextureSlot::SpecularGlossiness:
            return 4;
        default:
            return 3;
        }
    }

    void Attach(Material& material, const OpenSet& open, const std::vector<StoredTexture>& stored) {
        if (!open.set)
            return;
        const std::string& path = scene_.textureSets[static_cast<std::size_t>(open.index)].path;
        const std::uint32_t valid = open.set->metadata.GetValidChannelMask();
        const MaterialTexture* first = nullptr;
        for (const StoredTexture& source : stored) {
            if (source.slot == TextureSlot::Count)
                continue;
            MaterialTexture& texture = material.textures[static_cast<std::size_t>(source.slot)];
            const std::uint32_t mask = ((1u << source.channels) - 1u) << source.firstChannel;
            if (texture.image < 0)
                continue;
            if (source.channels < GetChannelCount(source.slot) || (valid & mask) != mask) {
                Warn(path + tool::Format(": %s: %d channels from %d: not what the slot needs",
                                         material.name.c_str(), source.channels, source.firstChannel));
                continue;
            }
            if (first != nullptr && texture.address != first->address) {
                Warn(path + ": " + material.name +
                     ": textures of one set are addressed differently: some keep their "
                     "source images");
                continue;
            }
            texture.textureSet = open.index;
            texture.firstChannel = source.firstChannel;
            texture.channels = source.channels;
            first = &texture;
        }
    }

    std::string folder_;
    Scene& scene_;
    rapidjson::Document list_;
    std::map<std::string, OpenSet> open_;
};

} // namespace

void AttachTextureSets(const std::string& modelPath, const std::string& materialDir, Scene& scene) {
    const std::string folder =
        materialDir.empty() ? std::filesystem::path(modelPath).parent_path().string() : materialDir;
    SetFinder(folder, scene).Run();
}

void AttachTextureSet(const std::string& path, Material& material, Scene& scene) {
    SetFinder({}, scene).AttachFile(material, path);
}

} // namespace openntc::renderer
