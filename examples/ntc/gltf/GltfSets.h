// SPDX-License-Identifier: MIT
// Which texture sets a model's materials become: one for each way in which a material's textures are addressed.
#pragma once

#include "Failure.h"
#include "FileNames.h"
#include "gltf/MaterialList.h"

#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace openntc::tool {

struct GltfSet {
    std::string name; ///< safe as a file name, without extension; no two of a model are alike
    std::string key;
    Manifest manifest;
};

/// Sorts the materials of one model into sets. Those whose key is equal are one.
class GltfSetPlanner {
public:
    /// `makeKey`: equal texts for manifests that need only one file; may throw. `strict`: a second set of a material is
    /// an error of the material.
    GltfSetPlanner(bool strict, std::function<std::string(const Manifest&)> makeKey)
        : strict_(strict), makeKey_(std::move(makeKey)) {}

    /// Sets `converted.files` to indices of sets, or adds to its material's errors.
    void Add(ConvertedMaterial& converted);

    std::vector<GltfSet>& GetSets() { return sets_; }
    std::span<const std::string> GetWarnings() const { return warnings_; }
    /// Of the first error of a material.
    std::optional<ExitCode> GetCode() const { return code_; }

private:
    void CheckImages(GltfMaterial& material);
    std::size_t FindGroup(GltfMaterial& material, std::size_t index);
    std::size_t AddSet(Manifest manifest, const std::string& name);

    bool strict_;
    std::function<std::string(const Manifest&)> makeKey_;
    std::vector<GltfSet> sets_;
    std::map<std::string, std::size_t> byKey_;
    FileNames names_;
    std::vector<std::string> warnings_;
    std::optional<ExitCode> code_;
};

} // namespace openntc::tool
