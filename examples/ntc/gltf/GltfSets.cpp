// SPDX-License-Identifier: MIT
#include "gltf/GltfSets.h"

#include "openntc/core/FileStream.h"

namespace openntc::tool {

void GltfSetPlanner::Add(ConvertedMaterial& converted) {
    GltfMaterial& material = converted.material;
    converted.files.assign(material.textures.size(), std::nullopt);
    for (const DroppedTexture& texture : material.notConverted)
        warnings_.push_back(material.where + "." + texture.slot + ": not converted: " + texture.reason);
    CheckImages(material);
    std::vector<std::size_t> groups; // of textures, by their first one
    for (std::size_t i = 0; i < material.textures.size(); ++i)
        groups.push_back(FindGroup(material, i));
    if (!material.errors.empty()) {
        code_ = code_.value_or(ExitCode::BadInput);
        return;
    }
    for (std::size_t first = 0; first < groups.size(); ++first) {
        if (groups[first] != first)
            continue;
        const GltfTexture& texture = material.textures[first];
        Manifest manifest;
        for (std::size_t i = first; i < groups.size(); ++i) {
            if (groups[i] == first)
                AddTexture(manifest, material, material.textures[i]);
        }
        // The first file has the material's name, others add that of their first texture.
        const std::size_t index = AddSet(
            std::move(manifest), first == 0 ? material.name : material.name + "_" + texture.source.name);
        for (std::size_t i = first; i < groups.size(); ++i) {
            if (groups[i] == first)
                converted.files[i] = index;
        }
        if (first > 0)
            warnings_.push_back(texture.slot + ": " +
                                DescribeDifference(texture.addressing, material.textures[0].addressing) +
                                " (" + material.textures[0].source.name + "): in a file of its own, " +
                                sets_[index].name + ".ntc");
    }
}

/// All that are missing, not only the first.
void GltfSetPlanner::CheckImages(GltfMaterial& material) {
    for (const GltfTexture& texture : material.textures) {
        if (texture.source.bytes.buffer != nullptr)
            continue;
        if (const auto file = FileReader::Open(texture.source.path); !file)
            material.errors.push_back(texture.slot + ": " + texture.image + ": " + file.error().GetText());
    }
}

/// The first texture that texture `index` can share a file with. With --strict a second group is an error.
std::size_t GltfSetPlanner::FindGroup(GltfMaterial& material, std::size_t index) {
    const GltfTexture& texture = material.textures[index];
    if (!texture.addressing.animation.empty())
        warnings_.push_back(texture.slot + ": KHR_texture_transform: an animation moves it");
    for (std::size_t i = 0; i < index; ++i) {
        if (DescribeDifference(texture.addressing, material.textures[i].addressing).empty())
            return i;
    }
    if (index > 0 && strict_) {
        material.errors.push_back(texture.slot + ": " +
                                  DescribeDifference(texture.addressing, material.textures[0].addressing) +
                                  ": cannot share a file with " + material.textures[0].source.name);
        code_ = code_.value_or(ExitCode::Failed);
    }
    return index;
}

std::size_t GltfSetPlanner::AddSet(Manifest manifest, const std::string& name) {
    std::string key = makeKey_(manifest);
    const auto [found, isNew] = byKey_.emplace(key, sets_.size());
    if (isNew)
        sets_.push_back({names_.Add(name), std::move(key), std::move(manifest)});
    return found->second;
}

} // namespace openntc::tool
