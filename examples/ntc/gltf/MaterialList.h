// SPDX-License-Identifier: MIT
// materials.json: which texture of which material is in which file, at which channels, addressed how.
#pragma once

#include "encode/EncodeJob.h"
#include "gltf/GltfMaterials.h"

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace openntc::tool {

/// One texture set to make, for one or more materials.
struct OutputFile {
    std::string name; ///< inside the folder
    std::string key;
    EncodeJob job;
    bool finished = false;
    bool kept = false; ///< of an earlier run
    double psnr = 0.0;
    double bitsPerPixel = 0.0;
    std::uint64_t bytes = 0;
    std::uint32_t crc = 0;
};

/// A material and the files that its textures went to.
struct ConvertedMaterial {
    GltfMaterial material;
    std::vector<std::optional<std::size_t>> files; ///< per texture: index of an OutputFile
};

inline constexpr const char* kMaterialListName = "materials.json";

/// `model` as a path relative to `folder`, so that both can move together; absolute where there is no such path.
std::string GetRelativePath(const std::string& path, const std::string& folder);

std::string MakeMaterialList(const std::string& model, std::span<const ConvertedMaterial> materials,
                             std::span<const OutputFile> files);

/// Files that the list of an earlier run in `folder` has under the same key, unchanged since, are finished; so are all
/// that exist, with `keepsAll`.
void KeepFinishedFiles(const std::string& folder, std::span<OutputFile> files, bool keepsAll);

} // namespace openntc::tool
