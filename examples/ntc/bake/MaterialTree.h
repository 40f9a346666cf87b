// SPDX-License-Identifier: MIT
// Every material under the folders, manifests and models that a bake is given, with the name of its file.
#pragma once

#include "Failure.h"
#include "gltf/GltfSets.h"

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace openntc::tool {

struct BakeMaterial {
    std::string name;   ///< `props/wall`, of DIR/props/wall.ntc; separators are slashes
    std::string root;   ///< the input under which it was found
    std::string origin; ///< the manifest, model or folder that it is from
    std::string set;    ///< of a model: name of the set
    Manifest manifest;  ///< without the bytes of embedded images
    std::map<std::string, std::string> embedded; ///< digests of embedded images, by the paths in the manifest
    std::optional<CommandError> error;           ///< why it cannot be made
};

struct BakeModel {
    std::string name; ///< its sets are NAME/SET, its list DIR/NAME/materials.json
    std::string path;
    std::vector<ConvertedMaterial> materials; ///< `files` index `sets`; without the bytes of embedded images
    std::vector<std::string> sets;
};

struct MaterialTree {
    std::vector<BakeMaterial> materials; ///< by name
    std::vector<BakeModel> models;
    std::vector<std::string> warnings;
    std::vector<std::string> folders; ///< that were looked through: a new entry in one may be a new material
    bool isWhole = true;              ///< false: a folder could not be read
};

struct TreeOptions {
    std::vector<std::string> inputs; ///< folders, manifests and models
    std::string output;              ///< folder that is left out, where it lies in another
    bool strict = false;             ///< textures of a model that need a second file are an error
    /// Only these materials; empty: all. Of images then only manifests and models beside them and above are asked whether
    /// they name them.
    std::set<std::string> wanted = {};
};

/// Throws CommandError: BadInput for inputs that are not there, Usage for two materials of one name and for names in
/// `wanted` that no material has. What concerns one material stands in its `error`.
MaterialTree FindMaterials(const TreeOptions& options);

/// The manifest with the bytes of embedded images, which are read again. Throws CommandError(BadInput).
Manifest LoadManifest(const BakeMaterial& material, bool strict);

/// Without `..` and a slash at the end, links as they are.
std::string GetAbsolutePath(const std::string& path);

/// Files that a material is made of: manifest or model, and images.
std::vector<std::string> ListSources(const BakeMaterial& material);

} // namespace openntc::tool
