// SPDX-License-Identifier: MIT
#include "renderer/scene/GltfScene.h"

#include "renderer/scene/GltfGeometry.h"
#include "renderer/scene/GltfNodes.h"
#include "renderer/scene/SceneImages.h"
#include "renderer/scene/SceneMaterials.h"
#include "renderer/scene/TextureSetLookup.h"

#include "gltf/GltfFile.h"

#include <algorithm>
#include <filesystem>
#include <string_view>

namespace openntc::renderer {

namespace {

/// GltfFile knows extensions that say nothing about materials; of these, some change what is drawn.
void CheckDrawable(const tool::GltfFile& file) {
    constexpr std::string_view kNotDrawn[] = {"EXT_mesh_gpu_instancing", "EXT_meshopt_compression",
                                              "KHR_draco_mesh_compression", "KHR_meshopt_compression"};
    const tool::GltfFile::Value* required = file.FindArray("extensionsRequired");
    for (rapidjson::SizeType i = 0; required != nullptr && i < required->Size(); ++i) {
        const std::string_view name((*required)[i].GetString());
        if (std::find(std::begin(kNotDrawn), std::end(kNotDrawn), name) != std::end(kNotDrawn))
            file.Fail("extensionsRequired", std::string(name) + ": not drawn");
    }
}

} // namespace

Scene LoadGltfScene(const std::string& path, const GltfSceneOptions& options) {
    tool::GltfFile file(path);
    CheckDrawable(file);
    Scene scene;
    scene.name = std::filesystem::path(path).stem().string();
    ImageSources images;
    ReadSceneMaterials(file, scene, images);
    GltfGeometry geometry(file, scene);
    ReadNodes(file, options.scene, geometry, scene);
    if (scene.instances.empty())
        scene.warnings.push_back("the scene draws nothing");
    if (options.readImages)
        DecodeImages(images, scene);
    AttachTextureSets(path, options.materialDir, scene);
    return scene;
}

} // namespace openntc::renderer
