// SPDX-License-Identifier: MIT
#include "gltf/KeptManifest.h"

#include "Failure.h"
#include "Json.h"
#include "TextureSet.h"
#include "encode/StateFile.h"
#include "gltf/MaterialList.h"

#include <filesystem>
#include <span>

namespace openntc::tool {

namespace {

/// Path of the image relative to the folder, written there first where it has no file of its own.
std::string KeepImage(const ManifestTexture& texture, const std::string& folder, const std::string& name) {
    if (texture.bytes.buffer == nullptr)
        return GetRelativePath(texture.path, folder);
    const std::filesystem::path images = std::filesystem::path(folder) / "images";
    std::error_code error;
    std::filesystem::create_directories(images, error);
    if (error)
        throw CommandError(ExitCode::Failed, images.string(), "folder: cannot be made: " + error.message());
    const std::span<const std::byte> bytes = texture.bytes.Get();
    const bool isJpeg = bytes.size() > 1 && bytes[0] == std::byte{0xff} && bytes[1] == std::byte{0xd8};
    const std::string file = name + "." + texture.name + (isJpeg ? ".jpg" : ".png");
    WriteWholeFile((images / file).string(), {bytes});
    return "images/" + file;
}

} // namespace

void KeepManifest(const Manifest& manifest, const std::string& folder, const std::string& name) {
    JsonWriter json;
    json.BeginObject();
    if (manifest.keepCoverage > 0.0f)
        json.Member("keepCoverage", static_cast<double>(manifest.keepCoverage));
    json.Key("textures");
    json.BeginArray();
    for (const ManifestTexture& texture : manifest.textures) {
        json.BeginObject();
        json.Member("fileName", std::string_view(KeepImage(texture, folder, name)));
        json.Member("name", std::string_view(texture.name));
        json.Member("channelSwizzle", std::string_view(texture.swizzle));
        json.Member("firstChannel", texture.firstChannel);
        json.Member("isSRGB", texture.isSrgb.value_or(false));
        json.Member("bcFormat", GetName(texture.bcFormat));
        if (texture.maskLetter != 0 || texture.alphaIsData) {
            json.Key("semantics");
            json.BeginObject();
            if (texture.maskLetter != 0)
                json.Member("AlphaMask", std::string_view(&texture.maskLetter, 1));
            if (texture.alphaIsData)
                json.Member("Glossiness", "A");
            json.EndObject();
        }
        json.EndObject();
    }
    json.EndArray();
    json.EndObject();
    const std::string text = json.Take();
    WriteWholeFile((std::filesystem::path(folder) / (name + ".manifest.json")).string(),
                   {std::as_bytes(std::span(text))});
}

} // namespace openntc::tool
