// SPDX-License-Identifier: MIT
#include "gltf/GltfFile.h"

#include "Failure.h"
#include "Output.h"
#include "TextureSet.h"
#include "gltf/Uri.h"

#include <rapidjson/error/en.h>

#include <algorithm>
#include <array>
#include <cinttypes>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <optional>
#include <utility>

namespace openntc::tool {

namespace {

// What a model may insist on although only its materials are read. Three kinds: geometry, scenes and animation, which
// say nothing about textures; materials, whose textures are converted or listed as not converted; encodings of
// textures, which are refused one by one where no fallback is given.
constexpr std::array kKnownExtensions = {
    "EXT_lights_ies",
    "EXT_lights_image_based",
    "EXT_mesh_features",
    "EXT_mesh_gpu_instancing",
    "EXT_mesh_manifold",
    "EXT_meshopt_compression",
    "EXT_instance_features",
    "EXT_structural_metadata",
    "KHR_animation_pointer",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "KHR_node_visibility",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "MSFT_lod",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_materials_volume_scatter",
    "KHR_texture_transform",
    "EXT_texture_astc",
    "EXT_texture_avif",
    "EXT_texture_webp",
    "KHR_texture_basisu",
    "MSFT_texture_dds",
};

struct Version {
    unsigned major = 0, minor = 0;
};

std::optional<Version> ParseVersion(const std::string& text) {
    const std::size_t dot = text.find('.');
    const auto isNumber = [](const std::string& digits) {
        return !digits.empty() && digits.size() <= 4 &&
               digits.find_first_not_of("0123456789") == std::string::npos;
    };
    if (dot == std::string::npos || !isNumber(text.substr(0, dot)) || !isNumber(text.substr(dot + 1)))
        return std::nullopt;
    return Version{static_cast<unsigned>(std::stoul(text.substr(0, dot))),
                   static_cast<unsigned>(std::stoul(text.substr(dot + 1)))};
}

std::uint32_t ReadWord(const std::vector<std::byte>& bytes, std::size_t offset) {
    std::uint32_t word = 0;
    for (std::size_t i = 4; i-- > 0;)
        word = word << 8 | std::to_integer<std::uint32_t>(bytes[offset + i]);
    return word;
}

bool StartsWith(const std::vector<std::byte>& bytes, const char* text) {
    const std::size_t length = std::strlen(text);
    return bytes.size() >= length && std::memcmp(bytes.data(), text, length) == 0;
}

} // namespace

GltfFile::GltfFile(const std::string& path) : path_(path) {
    ReadDocument(ReadAll(path));
    if (!document_.IsObject())
        Fail("glTF", "not an object");
    CheckAsset();
    CheckExtensions();
}

void GltfFile::Fail(const std::string& field, const std::string& text) const {
    throw CommandError(ExitCode::BadInput, path_, field + ": " + text);
}

void GltfFile::ReadDocument(std::vector<std::byte>&& file) {
    if (file.empty())
        Fail("glTF", "0 bytes");
    isBinary_ = StartsWith(file, "glTF");
    std::size_t begin = 0, size = file.size();
    const auto owner = std::make_shared<const std::vector<std::byte>>(std::move(file));
    if (isBinary_) {
        binaryChunk_.buffer = owner;
        begin = FindJsonChunk(*owner, size);
    }
    document_.Parse<rapidjson::kParseIterativeFlag>(reinterpret_cast<const char*>(owner->data()) + begin,
                                                    size);
    if (document_.HasParseError())
        Fail("glTF", Format("byte %zu: %s", begin + document_.GetErrorOffset(),
                            rapidjson::GetParseError_En(document_.GetParseError())));
}

/// Checks the chunks (specification, section 4.4) and notes where the binary one is. Returns where the JSON starts.
std::size_t GltfFile::FindJsonChunk(const std::vector<std::byte>& file, std::size_t& size) {
    constexpr std::uint32_t kJson = 0x4E4F534A, kBinary = 0x004E4942;
    constexpr std::size_t kHeader = 12, kChunkHeader = 8;
    if (file.size() < kHeader + kChunkHeader)
        Fail("glb", Format("%zu bytes: header and JSON chunk need more", file.size()));
    if (ReadWord(file, 4) != 2)
        Fail("glb.version", Format("%" PRIu32 ": 2 is needed", ReadWord(file, 4)));
    const std::size_t length = ReadWord(file, 8);
    if (length > file.size() || length < kHeader + kChunkHeader)
        Fail("glb.length", Format("%zu: the file has %zu bytes", length, file.size()));
    std::size_t json = 0;
    int index = 0;
    for (std::size_t at = kHeader; at + kChunkHeader <= length; ++index) {
        const std::size_t chunk = ReadWord(file, at);
        const std::uint32_t type = ReadWord(file, at + 4);
        at += kChunkHeader;
        if (chunk > length - at)
            Fail(Format("glb.chunks[%d].length", index),
                 Format("%zu: %zu bytes are left", chunk, length - at));
        if (index == 0 && type != kJson)
            Fail("glb.chunks[0].type", Format("0x%08" PRIx32 ": JSON is needed", type));
        if (index == 0) {
            json = at;
            size = chunk;
        } else if (index == 1 && type == kBinary) {
            binaryChunk_.offset = at;
            binaryChunk_.size = chunk;
        }
        at += chunk;
    }
    return json;
}

void GltfFile::CheckAsset() const {
    if (document_.FindMember("asset") == document_.MemberEnd())
        Fail("asset", "missing");
    const Value& asset = GetObject(document_, "asset", "asset");
    const std::string minimum = GetString(asset, "minVersion", "asset");
    if (asset.HasMember("minVersion")) {
        const std::optional<Version> version = ParseVersion(minimum);
        if (!version)
            Fail("asset.minVersion", minimum + ": must be MAJOR.MINOR");
        if (version->major != 2 || version->minor > 0)
            Fail("asset.minVersion", minimum + ": 2.0 is what is read");
    }
    if (!asset.HasMember("version"))
        Fail("asset.version", "missing");
    const std::string text = GetString(asset, "version", "asset");
    const std::optional<Version> version = ParseVersion(text);
    if (!version || version->major != 2)
        Fail("asset.version", text + ": 2.x is needed");
}

void GltfFile::CheckExtensions() const {
    const Value* required = FindArray("extensionsRequired");
    std::string unknown;
    for (rapidjson::SizeType i = 0; required != nullptr && i < required->Size(); ++i) {
        const Value& name = (*required)[i];
        if (!name.IsString())
            Fail(Format("extensionsRequired[%u]", i), "must be a string");
        if (std::find(kKnownExtensions.begin(), kKnownExtensions.end(), std::string_view(name.GetString())) ==
            kKnownExtensions.end())
            unknown += (unknown.empty() ? "" : ", ") + std::string(name.GetString());
    }
    if (!unknown.empty())
        Fail("extensionsRequired", unknown + ": not supported");
}

const GltfFile::Value& GltfFile::GetObject(const Value& parent, const char* name,
                                           const std::string& where) const {
    static const Value kEmpty(rapidjson::kObjectType);
    const auto member = parent.FindMember(name);
    if (member == parent.MemberEnd())
        return kEmpty;
    if (!member->value.IsObject())
        Fail(where, "must be an object");
    return member->value;
}

std::string GltfFile::GetString(const Value& parent, const char* name, const std::string& where) const {
    const auto member = parent.FindMember(name);
    if (member == parent.MemberEnd())
        return {};
    if (!member->value.IsString())
        Fail(where + "." + name, "must be a string");
    return {member->value.GetString(), member->value.GetStringLength()};
}

const GltfFile::Value* GltfFile::FindArray(const char* name) const {
    const auto member = document_.FindMember(name);
    if (member == document_.MemberEnd())
        return nullptr;
    if (!member->value.IsArray())
        Fail(name, "must be an array");
    return &member->value;
}

const GltfFile::Value& GltfFile::Follow(const Value& parent, const char* name, const char* array,
                                        const std::string& where) const {
    const auto index = parent.FindMember(name);
    if (index == parent.MemberEnd())
        Fail(where + "." + name, "missing");
    const Value* list = FindArray(array);
    const rapidjson::SizeType count = list == nullptr ? 0 : list->Size();
    if (!index->value.IsUint() || index->value.GetUint() >= count)
        Fail(where + "." + name, Format("must be an index below the %u %s", count, array));
    const Value& element = (*list)[index->value.GetUint()];
    if (!element.IsObject())
        Fail(Format("%s[%u]", array, index->value.GetUint()), "must be an object");
    return element;
}

GltfImage GltfFile::GetImage(const Value& texture, const std::string& where) {
    if (!texture.HasMember("source")) {
        const Value& extensions = GetObject(texture, "extensions", where + ".texture.extensions");
        for (const auto& extension : extensions.GetObject()) {
            if (extension.value.IsObject() && extension.value.HasMember("source"))
                Fail(where,
                     std::string(extension.name.GetString()) + ": not read; add a PNG or JPEG fallback");
        }
    }
    const Value& image = Follow(texture, "source", "images", where + ".texture");
    GltfImage result;
    result.label = Format("images[%u]", texture["source"].GetUint());
    result.path = path_ + ": " + result.label;
    std::string mediaType = GetString(image, "mimeType", where + ".image");
    const std::string uri = GetString(image, "uri", where + ".image");
    if (!uri.empty() && !IsDataUri(uri)) {
        result.label = UnescapeUri(uri);
        result.path = GetReferencedPath(uri, where);
        return result;
    }
    if (!uri.empty()) {
        std::string own;
        const auto decoded = Decode(image["uri"], where + ": " + result.label, own);
        if (mediaType.empty())
            mediaType = own;
        result.bytes = {decoded, 0, decoded->size()};
    } else if (image.HasMember("bufferView")) {
        result.bytes = GetView(image, where + "." + result.label);
    } else {
        Fail(where, result.label + ": neither uri nor bufferView");
    }
    if (mediaType.compare(0, 6, "image/") == 0 && mediaType != "image/png" && mediaType != "image/jpeg")
        Fail(where, result.label + ": " + mediaType + ": not read; PNG or JPEG is needed");
    if (result.bytes.size == 0)
        Fail(where, result.label + ": 0 bytes");
    return result;
}

/// A file beside the model. URIs with a scheme or an absolute path are refused, and so is what is no regular file: a
/// device may have no end.
std::string GltfFile::GetReferencedPath(const std::string& uri, const std::string& where) const {
    const std::string name = UnescapeUri(uri);
    const std::filesystem::path relative(name);
    if (relative.is_absolute() || name.find("://") != std::string::npos ||
        name.find('\0') != std::string::npos)
        Fail(where, name + ": must be a relative path");
    const std::filesystem::path path = std::filesystem::path(path_).parent_path() / relative;
    std::error_code error;
    const bool exists = std::filesystem::exists(path, error);
    if (!exists && name.find('\\') != std::string::npos)
        Fail(where, name + ": no such file; folders in a URI are separated by /, not by a backslash");
    if (exists && !std::filesystem::is_regular_file(path, error))
        Fail(where, name + ": not a regular file");
    return path.string();
}

ImageBytes GltfFile::GetView(const Value& parent, const std::string& where) {
    const Value& view = Follow(parent, "bufferView", "bufferViews", where);
    const std::string at = Format("bufferViews[%u]", parent["bufferView"].GetUint());
    const auto number = [&](const char* name, bool isRequired) -> std::uint64_t {
        const auto member = view.FindMember(name);
        if (member == view.MemberEnd() && !isRequired)
            return 0;
        if (member == view.MemberEnd())
            Fail(at + "." + name, "missing");
        if (!member->value.IsUint64())
            Fail(at + "." + name, "must be a number of bytes");
        return member->value.GetUint64();
    };
    const Value& buffer = Follow(view, "buffer", "buffers", at);
    const ImageBytes whole = GetBuffer(buffer, view["buffer"].GetUint(), at);
    const std::uint64_t offset = number("byteOffset", false), length = number("byteLength", true);
    if (offset > whole.size || length > whole.size - offset)
        Fail(at, Format("%" PRIu64 " bytes at %" PRIu64 ": its buffer has %zu", length, offset, whole.size));
    return {whole.buffer, whole.offset + static_cast<std::size_t>(offset), static_cast<std::size_t>(length)};
}

ImageBytes GltfFile::GetBuffer(const Value& buffer, unsigned index, const std::string& where) {
    const std::string at = Format("buffers[%u]", index);
    const auto length = buffer.FindMember("byteLength");
    if (length == buffer.MemberEnd() || !length->value.IsUint64())
        Fail(at + ".byteLength", "must be a number of bytes");
    const std::string uri = GetString(buffer, "uri", at);
    ImageBytes bytes;
    if (uri.empty()) {
        if (!isBinary_ || index != 0)
            Fail(at + ".uri", "missing: only the first buffer of a .glb has none");
        bytes = binaryChunk_;
    } else if (IsDataUri(uri)) {
        std::string mediaType;
        const auto decoded = Decode(buffer["uri"], at, mediaType);
        bytes = {decoded, 0, decoded->size()};
    } else {
        const std::string path = GetReferencedPath(uri, where + ": " + at);
        auto& file = files_[path];
        if (file == nullptr)
            file = std::make_shared<const std::vector<std::byte>>(ReadAll(path));
        bytes = {file, 0, file->size()};
    }
    // The last chunk of a .glb may be padded, never cut.
    if (length->value.GetUint64() > bytes.size)
        Fail(at + ".byteLength",
             Format("%" PRIu64 ": there are %zu bytes", length->value.GetUint64(), bytes.size));
    bytes.size = static_cast<std::size_t>(length->value.GetUint64());
    return bytes;
}

std::shared_ptr<const std::vector<std::byte>> GltfFile::Decode(const Value& uri, const std::string& where,
                                                               std::string& mediaType) {
    auto& [type, bytes] = decoded_[&uri];
    if (bytes == nullptr) {
        std::string error;
        std::optional<DataUri> data = ParseDataUri({uri.GetString(), uri.GetStringLength()}, error);
        if (!data)
            Fail(where, error);
        type = data->mediaType;
        bytes = std::make_shared<const std::vector<std::byte>>(std::move(data->bytes));
    }
    mediaType = type;
    return bytes;
}

} // namespace openntc::tool
