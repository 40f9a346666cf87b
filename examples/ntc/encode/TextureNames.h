// SPDX-License-Identifier: MIT
// Options that say something of textures by their names: --srgb, --linear, --normal-map, --weight, --target-psnr.
#pragma once

#include "Failure.h"
#include "encode/EncodeJob.h"

#include <optional>
#include <set>
#include <string>

namespace openntc::tool {

/// True if the name in an option means the texture: its own, or that of its file with or without the folder.
bool IsNamed(const ManifestTexture& texture, const std::string& name);

/// Drops what the job's options say of textures that its manifest, which must be there, does not have: of a material among
/// many only what is said of its own textures decides its file.
void KeepOwnNames(EncodeJob& job);

/// The textures of all materials that share one command line.
class TextureNames {
public:
    void Add(const Manifest& manifest);
    void Add(const ManifestTexture& texture);
    /// A texture without a file.
    void Add(const std::string& name);
    bool Has(const std::string& name) const { return accepted_.contains(name); }

    /// The first name in the options that no texture has, as a usage error that lists those there are.
    std::optional<CommandError> FindUnknown(const InputOptions& inputs,
                                            const TrainingChoices& training) const;

    /// That error.
    CommandError MakeError(const std::string& option, const std::string& name) const;

private:
    std::set<std::string> names_;    ///< of textures
    std::set<std::string> accepted_; ///< and of their files
};

} // namespace openntc::tool
