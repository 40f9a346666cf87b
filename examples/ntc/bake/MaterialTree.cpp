// SPDX-License-Identifier: MIT
#include "bake/MaterialTree.h"

#include "InputFile.h"
#include "Interrupt.h"
#include "Output.h"
#include "Text.h"
#include "bake/ImageGroups.h"
#include "encode/ContentKey.h"

#include <rapidjson/document.h>

#include <algorithm>
#include <filesystem>

namespace openntc::tool {

namespace {

namespace fs = std::filesystem;

/// A manifest, model or folder of images, and the name that it gives to materials.
struct Source {
    fs::path path;
    std::string name;
    std::string root;
    bool isSure = true; ///< false: JSON, which may be something else than a manifest
};

bool IsModelName(const fs::path& path) {
    const std::string extension = ToLower(path.extension().string());
    return extension == ".gltf" || extension == ".glb";
}
bool IsManifestName(const fs::path& path) {
    return ToLower(path.extension().string()) == ".json";
}

/// Trees hold JSON of all kinds. A manifest has textures; one that is malformed has at least their `fileName`.
bool LooksLikeManifest(const fs::path& path) {
    constexpr std::uint64_t kLargest = 1u << 24;
    std::error_code error;
    if (fs::file_size(path, error) > kLargest || error)
        return false;
    const std::string text = ReadAllText(path.string());
    rapidjson::Document json;
    json.Parse<rapidjson::kParseIterativeFlag>(text.c_str(), text.size());
    if (json.HasParseError())
        return text.find("\"fileName\"") != std::string::npos;
    return json.IsObject() && json.HasMember("textures");
}

/// Without the extension, and without ".manifest" of manifests that `convert-gltf` kept.
std::string StripExtension(const std::string& name, bool isManifest) {
    std::string stem = name.substr(0, name.rfind('.'));
    constexpr std::string_view kKept = ".manifest";
    if (isManifest && stem.size() > kKept.size() && stem.ends_with(kKept))
        stem.resize(stem.size() - kKept.size());
    return stem;
}

std::string GetIdentity(const fs::path& path) {
    std::error_code error;
    const fs::path canonical = fs::weakly_canonical(path, error);
    return (error ? fs::absolute(path).lexically_normal() : canonical).string();
}

/// The sets of a model; two materials with the same images of the same names share one, without a look at their bytes.
struct ModelSets {
    std::vector<ConvertedMaterial> materials;
    GltfSetPlanner planner;
};
ModelSets ReadModelSets(const std::string& path, bool strict) {
    const auto makeKey = [&path](const Manifest& manifest) {
        EncodeJob job;
        job.inputs.paths = {path};
        job.inputs.manifest = manifest;
        return MakeContentKey(job, [](const ManifestTexture& texture) { return texture.path; });
    };
    ModelSets sets{{}, GltfSetPlanner(strict, makeKey)};
    for (GltfMaterial& material : ReadGltfMaterials(path))
        sets.materials.push_back({std::move(material), {}});
    for (ConvertedMaterial& material : sets.materials)
        sets.planner.Add(material);
    return sets;
}

class TreeReader {
public:
    explicit TreeReader(const TreeOptions& options) : options_(options) {}

    MaterialTree Read() {
        for (const std::string& input : options_.inputs)
            AddInput(input);
        const bool needsAll = options_.wanted.empty() || !IsWantedAmongFiles();
        for (const Source& source : manifests_) {
            if ((needsAll || IsWanted(source.name, false)) &&
                (source.isSure || LooksLikeManifest(source.path)))
                AddManifest(source);
        }
        for (const Source& source : models_) {
            if (needsAll || IsWanted(source.name, true))
                AddModel(source);
        }
        if (needsAll)
            AddImages();
        Sort();
        return std::move(tree_);
    }

private:
    void AddInput(const std::string& input) {
        std::error_code error;
        const fs::path path = input;
        if (fs::is_directory(path, error)) {
            Walk(path);
        } else if (!fs::is_regular_file(path, error)) {
            throw CommandError(ExitCode::BadInput, input, "input: no such folder, manifest or model");
        } else if (IsModelName(path)) {
            models_.push_back({path, StripExtension(path.filename().string(), false), input});
        } else if (IsManifestName(path)) {
            manifests_.push_back({path, StripExtension(path.filename().string(), true), input});
        } else {
            throw CommandError(ExitCode::Usage, input,
                               "input: must be a folder, a manifest (.json) or a model (.gltf, .glb)");
        }
    }

    /// Links to folders are not followed: they may lead back.
    void Walk(const fs::path& root) {
        const std::string output = GetIdentity(options_.output);
        std::error_code error;
        tree_.folders.push_back(root.string());
        fs::recursive_directory_iterator entry(root, error);
        for (const fs::recursive_directory_iterator end; !error && entry != end; entry.increment(error)) {
            ThrowIfInterrupted();
            std::error_code ignored;
            const fs::path& path = entry->path();
            const std::string name = path.filename().string();
            if (entry->is_directory(ignored) && !entry->is_symlink(ignored)) {
                // `mips` holds mips of the images beside it.
                if (name.front() == '.' || name == "mips" || GetIdentity(path) == output ||
                    !MayHoldWanted(path.lexically_relative(root).generic_string()))
                    entry.disable_recursion_pending();
                else
                    tree_.folders.push_back(path.string());
            } else if (name.front() != '.' && entry->is_regular_file(ignored)) {
                AddFile(root, path);
            }
        }
        if (error) {
            tree_.isWhole = false;
            tree_.warnings.push_back(root.string() +
                                     ": folder: cannot be read to its end: " + error.message());
        }
    }

    void AddFile(const fs::path& root, const fs::path& path) {
        const std::string relative = path.lexically_relative(root).generic_string();
        if (IsModelName(path))
            models_.push_back({path, StripExtension(relative, false), root.string()});
        else if (IsManifestName(path))
            manifests_.push_back({path, StripExtension(relative, true), root.string(), false});
        else if (IsImageName(path))
            images_[path.parent_path()].push_back(path);
        roots_.emplace(path.parent_path(), root);
    }

    bool IsWanted(const std::string& name, bool isModel) const {
        const auto at = options_.wanted.lower_bound(isModel ? name + "/" : name);
        return at != options_.wanted.end() && (isModel ? at->starts_with(name + "/") : *at == name);
    }
    /// Names say where materials are: for a few of them most of a large tree need not be looked through.
    bool MayHoldWanted(const std::string& folder) const {
        return options_.wanted.empty() || IsWanted(folder, false) || IsWanted(folder, true);
    }
    /// Images are a material of their own only where no manifest and no model names them, so that these must be read.
    bool IsWantedAmongFiles() const {
        std::size_t found = 0;
        for (const Source& source : manifests_)
            found += options_.wanted.count(source.name);
        for (const std::string& name : options_.wanted)
            found += std::any_of(models_.begin(), models_.end(),
                                 [&](const Source& model) { return name.starts_with(model.name + "/"); })
                         ? 1u
                         : 0u;
        return found >= options_.wanted.size();
    }

    void Claim(const fs::path& owner, const Manifest& manifest) {
        owned_.insert(GetIdentity(owner.parent_path()));
        for (const ManifestTexture& texture : manifest.textures) {
            if (texture.bytes.buffer == nullptr)
                claimed_.insert(GetIdentity(texture.path));
        }
    }

    /// What a manifest or model that is broken names nevertheless, so that its images are no material of their own
    /// meanwhile: every `"MEMBER": "PATH"` of its text.
    void ClaimNamed(const fs::path& owner, const std::string& member) {
        owned_.insert(GetIdentity(owner.parent_path()));
        const std::string text = ReadAllText(owner.string()), name = '"' + member + '"';
        for (std::size_t at = text.find(name); at != std::string::npos; at = text.find(name, at)) {
            at = text.find_first_not_of(" \t\r\n:", at + name.size());
            if (at == std::string::npos || text[at] != '"')
                continue;
            const std::size_t end = text.find_first_of("\"\n", at + 1);
            if (end == std::string::npos)
                return;
            claimed_.insert(GetIdentity(owner.parent_path() / text.substr(at + 1, end - at - 1)));
        }
    }

    void AddManifest(const Source& source) {
        BakeMaterial material{source.name, source.root, source.path.string(), {}, {}, {}, {}};
        try {
            material.manifest = ReadManifest(source.path.string());
        } catch (const CommandError& error) {
            material.error = error;
            ClaimNamed(source.path, "fileName");
        }
        Claim(source.path, material.manifest);
        tree_.materials.push_back(std::move(material));
    }

    void AddModel(const Source& source) {
        const std::string path = source.path.string();
        BakeModel model{source.name, path, {}, {}};
        owned_.insert(GetIdentity(source.path.parent_path()));
        try {
            ModelSets sets = ReadModelSets(path, options_.strict);
            for (const std::string& warning : sets.planner.GetWarnings())
                tree_.warnings.push_back(std::string(path).append(": ").append(warning));
            for (GltfSet& set : sets.planner.GetSets()) {
                BakeMaterial material{source.name + "/" + set.name, source.root, path, set.name,
                                      std::move(set.manifest),      {},          {}};
                Claim(source.path, material.manifest);
                for (ManifestTexture& texture : material.manifest.textures)
                    Release(texture, material.embedded);
                model.sets.push_back(set.name);
                tree_.materials.push_back(std::move(material));
            }
            for (ConvertedMaterial& converted : sets.materials) {
                std::map<std::string, std::string> ignored;
                for (GltfTexture& texture : converted.material.textures)
                    Release(texture.source, ignored);
                for (const std::string& error : converted.material.errors)
                    tree_.materials.push_back({source.name + "/" + converted.material.where,
                                               source.root,
                                               path,
                                               {},
                                               {},
                                               {},
                                               CommandError(ExitCode::BadInput, path, error)});
                model.materials.push_back(std::move(converted));
            }
        } catch (const CommandError& error) {
            tree_.materials.push_back({source.name, source.root, path, {}, {}, {}, error});
            ClaimNamed(source.path, "uri");
            return;
        }
        if (!model.sets.empty())
            tree_.models.push_back(std::move(model));
    }
    /// A tree of models is larger than memory: of images inside them only the digests stay.
    static void Release(ManifestTexture& texture, std::map<std::string, std::string>& digests) {
        if (texture.bytes.buffer == nullptr)
            return;
        if (!digests.contains(texture.path))
            digests[texture.path] = MakeDigest(texture.bytes.Get());
        texture.bytes = {};
    }

    /// What no manifest and no model names. Where one lies in the folder or names images of it, images of which nobody
    /// knows what they belong to are left out, and so is the rest of a material of which it names some.
    void AddImages() {
        for (const auto& [folder, images] : images_) {
            const fs::path root = roots_[folder];
            const std::string name = folder == root ? "" : folder.lexically_relative(root).generic_string();
            const bool isOwned = owned_.contains(GetIdentity(folder)) || CountClaimed(images) > 0;
            std::size_t leftOut = 0;
            for (const auto& [base, paths] : GroupImages(images)) {
                const std::size_t claimed = CountClaimed(paths);
                if (claimed > 0 || (isOwned && base.empty())) {
                    leftOut += paths.size() - claimed;
                    continue;
                }
                const std::string own = name.empty() ? fs::path(GetIdentity(root)).filename().string() : name;
                const std::string inside = name.empty() ? base : std::string(name).append("/").append(base);
                const std::string& material = base.empty() ? own : inside;
                if (options_.wanted.empty() || options_.wanted.contains(material))
                    tree_.materials.push_back(
                        {material, root.string(), folder.string(), {}, MakeManifest(paths), {}, {}});
            }
            if (leftOut > 0)
                tree_.warnings.push_back(
                    folder.string() +
                    Format(": images: %zu that no manifest or model names: left out", leftOut));
        }
    }
    template <typename Paths>
    std::size_t CountClaimed(const Paths& images) const {
        if (claimed_.empty())
            return 0;
        return static_cast<std::size_t>(
            std::count_if(images.begin(), images.end(),
                          [this](const fs::path& image) { return claimed_.contains(GetIdentity(image)); }));
    }

    void Sort() {
        std::sort(tree_.materials.begin(), tree_.materials.end(),
                  [](const BakeMaterial& a, const BakeMaterial& b) { return a.name < b.name; });
        std::map<std::string, const BakeMaterial*>
            names; // file systems that do not tell cases apart are many
        for (const BakeMaterial& material : tree_.materials) {
            const auto [other, isNew] = names.emplace(ToLower(material.name), &material);
            if (!isNew && !material.error)
                throw CommandError(ExitCode::Usage, material.origin,
                                   "name: " + material.name + ".ntc is also that of " +
                                       other->second->origin);
        }
        if (options_.wanted.empty())
            return;
        std::erase_if(tree_.materials,
                      [this](const BakeMaterial& m) { return !options_.wanted.contains(m.name); });
        for (const std::string& name : options_.wanted) {
            if (!std::any_of(tree_.materials.begin(), tree_.materials.end(),
                             [&](const BakeMaterial& material) { return material.name == name; }))
                throw CommandError(ExitCode::Usage, "--material", name + ": no material of these inputs");
        }
    }

    const TreeOptions& options_;
    MaterialTree tree_;
    std::vector<Source> manifests_, models_;
    std::map<fs::path, std::vector<fs::path>> images_; // by folder
    std::map<fs::path, fs::path> roots_;               // of folders
    std::set<std::string> claimed_, owned_;            // images that have a manifest; folders that hold one
};

} // namespace

MaterialTree FindMaterials(const TreeOptions& options) {
    return TreeReader(options).Read();
}

Manifest LoadManifest(const BakeMaterial& material, bool strict) {
    if (material.embedded.empty())
        return material.manifest;
    ModelSets sets = ReadModelSets(material.origin, strict);
    for (GltfSet& set : sets.planner.GetSets()) {
        if (set.name == material.set)
            return std::move(set.manifest);
    }
    throw CommandError(ExitCode::BadInput, material.origin,
                       "material: " + material.set + ": no longer there");
}

std::string GetAbsolutePath(const std::string& path) {
    const fs::path whole = fs::absolute(path).lexically_normal();
    return (whole.has_filename() ? whole : whole.parent_path()).string();
}

std::vector<std::string> ListSources(const BakeMaterial& material) {
    std::set<std::string> paths;
    std::error_code error;
    if (!fs::is_directory(material.origin, error))
        paths.insert(material.origin);
    for (const ManifestTexture& texture : material.manifest.textures) {
        if (!material.embedded.contains(texture.path))
            paths.insert(texture.path);
    }
    return {paths.begin(), paths.end()};
}

} // namespace openntc::tool
