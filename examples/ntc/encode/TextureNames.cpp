// SPDX-License-Identifier: MIT
#include "encode/TextureNames.h"

#include "Output.h"

#include <filesystem>

namespace openntc::tool {

namespace {

std::string GetFileName(const ManifestTexture& texture) {
    return std::filesystem::path(texture.path).filename().string();
}

const std::string& GetTextureName(const std::string& name) {
    return name;
}
const std::string& GetTextureName(const NamedNumber& number) {
    return number.name;
}

/// `visit(option, list)` for every list whose elements name textures.
template <typename Inputs, typename Training, typename Visit>
void VisitNames(Inputs& inputs, Training& training, const Visit& visit) {
    visit("--srgb", inputs.srgb);
    visit("--linear", inputs.linear);
    visit("--normal-map", inputs.normalMaps);
    visit("--weight", inputs.weights);
    visit("--target-psnr", training.textureTargets);
}

} // namespace

bool IsNamed(const ManifestTexture& texture, const std::string& name) {
    return name == texture.name || name == texture.path || name == GetFileName(texture);
}

void KeepOwnNames(EncodeJob& job) {
    TextureNames own;
    own.Add(*job.inputs.manifest);
    VisitNames(job.inputs, job.training, [&own](const char*, auto& list) {
        std::erase_if(list, [&own](const auto& entry) { return !own.Has(GetTextureName(entry)); });
    });
}

void TextureNames::Add(const Manifest& manifest) {
    for (const ManifestTexture& texture : manifest.textures)
        Add(texture);
}

void TextureNames::Add(const ManifestTexture& texture) {
    names_.insert(texture.name);
    accepted_.insert({texture.name, texture.path, GetFileName(texture)});
}

void TextureNames::Add(const std::string& name) {
    names_.insert(name);
    accepted_.insert(name);
}

std::optional<CommandError> TextureNames::FindUnknown(const InputOptions& inputs,
                                                      const TrainingChoices& training) const {
    std::optional<CommandError> error;
    VisitNames(inputs, training, [&](const char* option, const auto& list) {
        for (const auto& entry : list) {
            if (!error && !Has(GetTextureName(entry)))
                error = MakeError(option, GetTextureName(entry));
        }
    });
    return error;
}

CommandError TextureNames::MakeError(const std::string& option, const std::string& name) const {
    constexpr std::size_t kMost = 16; // a project has thousands
    std::string text = name + ": no texture has this name";
    std::size_t count = 0;
    for (const std::string& known : names_) {
        if (count == kMost)
            return CommandError(ExitCode::Usage, option,
                                text + Format(", and %zu more", names_.size() - kMost));
        text += (count++ == 0 ? ": " : ", ") + known;
    }
    return CommandError(ExitCode::Usage, option, text);
}

} // namespace openntc::tool
