// SPDX-License-Identifier: MIT
#include "gltf/MaterialList.h"

#include "Json.h"
#include "TextureSet.h"

#include "openntc/core/Crc32.h"

#include <rapidjson/document.h>

#include <algorithm>
#include <filesystem>

namespace openntc::tool {

namespace {

void WriteFile(JsonWriter& json, std::span<const OutputFile> files, std::optional<std::size_t> index) {
    json.Key("file");
    if (index && files[*index].finished)
        json.Value(std::string_view(files[*index].name));
    else
        json.Null();
}

void WriteMaterial(JsonWriter& json, const ConvertedMaterial& converted, std::span<const OutputFile> files) {
    const GltfMaterial& material = converted.material;
    json.BeginObject();
    json.Member("name", std::string_view(material.name));
    json.Key("textures");
    json.BeginArray();
    for (std::size_t i = 0; i < material.textures.size(); ++i) {
        const GltfTexture& texture = material.textures[i];
        json.BeginObject();
        json.Member("name", std::string_view(texture.source.name));
        WriteFile(json, files, converted.files[i]);
        json.Member("firstChannel", texture.source.firstChannel);
        json.Member("channels", static_cast<int>(texture.source.swizzle.size()));
        WriteAddressing(json, texture.addressing);
        json.EndObject();
    }
    json.EndArray();
    json.Key("notConverted");
    json.BeginArray();
    for (const DroppedTexture& texture : material.notConverted) {
        json.BeginObject();
        json.Member("slot", std::string_view(texture.slot));
        json.Member("reason", std::string_view(texture.reason));
        json.EndObject();
    }
    json.EndArray();
    json.Key("errors");
    json.BeginArray();
    for (const std::string& error : material.errors)
        json.Value(std::string_view(error));
    json.EndArray();
    json.EndObject();
}

double GetNumber(const rapidjson::Value& entry, const char* name) {
    const auto member = entry.FindMember(name);
    return member != entry.MemberEnd() && member->value.IsNumber() ? member->value.GetDouble() : 0.0;
}

/// True if `list` has the file as it is now.
bool FindFinished(const rapidjson::Document& list, OutputFile& file, const std::vector<std::byte>& bytes) {
    if (list.HasParseError() || !list.IsObject() || !list.HasMember("files") || !list["files"].IsArray())
        return false;
    for (const rapidjson::Value& entry : list["files"].GetArray()) {
        if (!entry.IsObject() || !entry.HasMember("key") || !entry["key"].IsString() ||
            file.key != entry["key"].GetString())
            continue;
        file.psnr = GetNumber(entry, "psnr");
        file.bitsPerPixel = GetNumber(entry, "bitsPerPixel");
        return entry.HasMember("file") && entry["file"].IsString() &&
               file.name == entry["file"].GetString() &&
               GetNumber(entry, "bytes") == static_cast<double>(bytes.size()) &&
               GetNumber(entry, "crc32") == static_cast<double>(Crc32(bytes));
    }
    return false;
}

} // namespace

std::string GetRelativePath(const std::string& path, const std::string& folder) {
    std::error_code error;
    const std::filesystem::path relative = std::filesystem::proximate(path, folder, error);
    return (error ? std::filesystem::absolute(path) : relative).generic_string();
}

std::string MakeMaterialList(const std::string& model, std::span<const ConvertedMaterial> materials,
                             std::span<const OutputFile> files) {
    JsonWriter json;
    json.BeginObject();
    json.Member("model", std::string_view(model));
    json.Key("materials");
    json.BeginArray();
    for (const ConvertedMaterial& material : materials)
        WriteMaterial(json, material, files);
    json.EndArray();
    json.Key("files");
    json.BeginArray();
    for (const OutputFile& file : files) {
        if (!file.finished)
            continue;
        json.BeginObject();
        json.Member("file", std::string_view(file.name));
        json.Member("key", std::string_view(file.key));
        json.Member("bytes", file.bytes);
        json.Member("crc32", file.crc);
        json.Member("bitsPerPixel", file.bitsPerPixel);
        json.Member("psnr", file.psnr);
        json.Member("kept", file.kept);
        json.EndObject();
    }
    json.EndArray();
    json.EndObject();
    return json.Take();
}

void KeepFinishedFiles(const std::string& folder, std::span<OutputFile> files, bool keepsAll) {
    std::error_code error;
    const std::string path = (std::filesystem::path(folder) / kMaterialListName).string();
    rapidjson::Document list;
    if (std::filesystem::is_regular_file(path, error)) {
        const std::vector<std::byte> text = ReadAll(path);
        list.Parse<rapidjson::kParseIterativeFlag>(reinterpret_cast<const char*>(text.data()), text.size());
    }
    for (OutputFile& file : files) {
        if (!std::filesystem::is_regular_file(file.job.output, error))
            continue;
        const std::vector<std::byte> bytes = ReadAll(file.job.output);
        const bool isSame = FindFinished(list, file, bytes);
        if (!isSame && !keepsAll)
            continue;
        file.kept = file.finished = true;
        file.bytes = bytes.size();
        file.crc = Crc32(bytes);
        if (!isSame)
            file.key.clear(); // unknown: made from something else
    }
}

} // namespace openntc::tool
