// SPDX-License-Identifier: MIT
#include "encode/Manifest.h"

#include "Failure.h"
#include "InputFile.h"
#include "Output.h"
#include "Text.h"
#include "encode/ColorGuess.h"

#include <rapidjson/document.h>
#include <rapidjson/error/en.h>

#include <algorithm>
#include <filesystem>
#include <iterator>

namespace openntc::tool {

namespace {

constexpr std::uint64_t kLargestManifest = 1u << 24;

constexpr std::string_view kRootFields[] = {"$schema", "textures",     "width",    "height",
                                            "mipWrap", "keepCoverage", "mipFilter"};
constexpr std::string_view kTextureFields[] = {
    "fileName",   "name",      "channelSwizzle",    "firstChannel", "isSRGB",
    "bcFormat",   "mipLevel",  "lossFunctionScale", "verticalFlip", "semantics",
    "targetPsnr", "mipFilter", "normalMap"};

/// Reads one manifest; every failure names the texture and the field.
class ManifestReader {
public:
    explicit ManifestReader(const std::string& path) : path_(path) {}

    Manifest Read() {
        const std::string text = ReadAllText(path_, {{kLargestManifest}});
        rapidjson::Document document;
        document.Parse<rapidjson::kParseIterativeFlag>(text.c_str(), text.size());
        if (document.HasParseError())
            Fail(Format("manifest: byte %zu: %s", document.GetErrorOffset(),
                        rapidjson::GetParseError_En(document.GetParseError())));
        if (!document.IsObject())
            Fail("manifest: must be an object");
        where_ = "";
        CheckFields(document, kRootFields);
        if (!document.HasMember("textures") || !document["textures"].IsArray())
            Fail("textures: missing: an array is required");
        Manifest manifest;
        manifest.width = ReadInt(document, "width", 0, 1, 16384);
        manifest.height = ReadInt(document, "height", 0, 1, 16384);
        manifest.keepCoverage = ReadThreshold(document);
        manifest.mips.filter =
            ReadName<image::MipFilter>(document, "mipFilter", kMipFilterNames).value_or(manifest.mips.filter);
        manifest.mips.wrap =
            ReadName<image::MipWrap>(document, "mipWrap", kMipWrapNames).value_or(manifest.mips.wrap);
        int index = 0;
        for (const rapidjson::Value& value : document["textures"].GetArray()) {
            where_ = Format("textures[%d].", index++);
            if (!value.IsObject())
                Fail(where_ + " an object is required");
            CheckFields(value, kTextureFields);
            manifest.textures.push_back(ReadTexture(value));
        }
        if (manifest.textures.empty())
            Fail("textures: empty: at least one is required");
        return manifest;
    }

private:
    using Value = rapidjson::Value;

    [[noreturn]] void Fail(const std::string& text) const {
        throw CommandError(ExitCode::BadInput, path_, text);
    }
    [[noreturn]] void FailField(const char* field, const std::string& text) const {
        Fail(where_ + field + ": " + text);
    }

    /// A misspelt field must not go unnoticed: the texture would be encoded as something else.
    void CheckFields(const Value& object, std::span<const std::string_view> known) const {
        for (const auto& member : object.GetObject()) {
            const std::string name(member.name.GetString(), member.name.GetStringLength());
            if (std::find(known.begin(), known.end(), name) != known.end())
                continue;
            std::string text = "not a field of a manifest";
            for (const std::string_view field : known) {
                if (ToLower(field) == ToLower(name))
                    text += ": " + std::string(field) + "?";
            }
            FailField(name.c_str(), text);
        }
    }
    float ReadThreshold(const Value& object) const {
        const auto member = object.FindMember("keepCoverage");
        if (member == object.MemberEnd())
            return 0.0f;
        if (!member->value.IsNumber() ||
            !(member->value.GetFloat() > 0.0f && member->value.GetFloat() <= 1.0f))
            FailField("keepCoverage", "must be a number above 0, at most 1");
        return member->value.GetFloat();
    }
    int ReadInt(const Value& object, const char* field, int fallback, int lowest, int highest) const {
        const auto member = object.FindMember(field);
        if (member == object.MemberEnd())
            return fallback;
        if (!member->value.IsInt() || member->value.GetInt() < lowest || member->value.GetInt() > highest)
            FailField(field, Format("must be an integer %d to %d", lowest, highest));
        return member->value.GetInt();
    }
    std::string ReadString(const Value& object, const char* field, const char* fallback) const {
        const auto member = object.FindMember(field);
        if (member == object.MemberEnd())
            return fallback;
        if (!member->value.IsString())
            FailField(field, "must be a string");
        return {member->value.GetString(), member->value.GetStringLength()};
    }
    /// The value whose name the field holds: values of T count from 0.
    template <typename T>
    std::optional<T> ReadName(const Value& object, const char* field,
                              std::span<const char* const> names) const {
        if (!object.HasMember(field))
            return std::nullopt;
        const std::string text = ReadString(object, field, "");
        const auto found = std::find(names.begin(), names.end(), text);
        if (found == names.end()) {
            std::string all;
            for (const char* name : names)
                all += (all.empty() ? "" : " or ") + std::string(name);
            FailField(field, text + ": " + all);
        }
        return static_cast<T>(found - names.begin());
    }
    double ReadTarget(const Value& object) const {
        const auto member = object.FindMember("targetPsnr");
        if (member == object.MemberEnd())
            return 0.0;
        if (!member->value.IsNumber() || !(member->value.GetDouble() > 0.0))
            FailField("targetPsnr", "must be a number above 0");
        return member->value.GetDouble();
    }
    std::optional<bool> ReadBool(const Value& object, const char* field) const {
        const auto member = object.FindMember(field);
        if (member == object.MemberEnd())
            return std::nullopt;
        if (!member->value.IsBool())
            FailField(field, "must be true or false");
        return member->value.GetBool();
    }

    ManifestTexture ReadTexture(const Value& value) const {
        ManifestTexture texture;
        const std::string file = ReadString(value, "fileName", "");
        if (file.empty())
            FailField("fileName", "missing: a string is required");
        texture.path = (std::filesystem::path(path_).parent_path() / file).string();
        texture.name = ReadString(value, "name", std::filesystem::path(file).stem().string().c_str());
        texture.swizzle = ReadString(value, "channelSwizzle", "");
        if (texture.swizzle.size() > 4 || texture.swizzle.find_first_not_of("RGBA") != std::string::npos)
            FailField("channelSwizzle", texture.swizzle + ": one to four of RGBA");
        texture.firstChannel = ReadInt(value, "firstChannel", -1, 0, 15);
        const std::optional<bool> isSrgb = ReadBool(value, "isSRGB");
        texture.isSrgb = isSrgb.value_or(false);
        texture.colorReason = isSrgb ? "isSRGB in the manifest" : "the manifest has no isSRGB";
        texture.mipLevel = ReadInt(value, "mipLevel", 0, 0, 15);
        texture.verticalFlip = ReadBool(value, "verticalFlip").value_or(false);
        texture.bcFormat = ReadBlockFormat(ReadString(value, "bcFormat", "none"));
        texture.targetPsnr = ReadTarget(value);
        texture.mipFilter = ReadName<image::MipFilter>(value, "mipFilter", kMipFilterNames);
        texture.normalMap = ReadBool(value, "normalMap").value_or(false);
        ReadLossScales(value, texture);
        ReadSemantics(value, texture);
        return texture;
    }
    BlockCompressedFormat ReadBlockFormat(const std::string& name) const {
        const std::string lower = ToLower(name);
        if (lower == "none")
            return BlockCompressedFormat::None;
        if (lower.size() == 3 && lower.compare(0, 2, "bc") == 0 && lower[2] >= '1' && lower[2] <= '7')
            return static_cast<BlockCompressedFormat>(lower[2] - '0');
        FailField("bcFormat", name + ": none or BC1 to BC7");
    }
    void ReadLossScales(const Value& value, ManifestTexture& texture) const {
        const auto member = value.FindMember("lossFunctionScale");
        if (member == value.MemberEnd())
            return;
        const auto add = [&](const Value& number) {
            if (!number.IsNumber() || !(number.GetFloat() >= 0.0f))
                FailField("lossFunctionScale", "must be numbers of at least 0");
            texture.lossScales.push_back(number.GetFloat());
        };
        if (member->value.IsArray()) {
            for (const Value& number : member->value.GetArray())
                add(number);
        } else {
            add(member->value);
        }
    }
    void ReadSemantics(const Value& value, ManifestTexture& texture) const {
        const auto member = value.FindMember("semantics");
        if (member == value.MemberEnd())
            return;
        if (!member->value.IsObject())
            FailField("semantics", "must be an object");
        static constexpr const char* kLabels[] = {
            "albedo",    "alpha",    "mask",       "alphamask",     "displ",       "displacement",
            "emissive",  "emission", "glossiness", "metalness",     "metallic",    "normal",
            "occlusion", "ao",       "roughness",  "specularcolor", "transmission"};
        for (const auto& entry : member->value.GetObject()) {
            const std::string label = ToLower(entry.name.GetString());
            if (std::find(std::begin(kLabels), std::end(kLabels), label) == std::end(kLabels))
                FailField("semantics", label + ": not a known label");
            const std::string letters = entry.value.IsString() ? entry.value.GetString() : "";
            if (letters.empty() || letters.size() > 4 ||
                letters.find_first_not_of("RGBA") != std::string::npos)
                FailField("semantics", label + ": one to four of RGBA");
            if (label == "alpha" || label == "mask" || label == "alphamask") {
                if (letters.size() != 1)
                    FailField("semantics", label + ": one letter of RGBA");
                texture.maskLetter = letters[0];
                texture.keepAlpha = true;
            } else if (letters == "A") {
                texture.alphaIsData = true;
            }
        }
    }

    const std::string& path_;
    std::string where_;
};

} // namespace

std::span<const std::string_view> GetManifestRootFields() {
    return kRootFields;
}

std::span<const std::string_view> GetManifestTextureFields() {
    return kTextureFields;
}

Manifest ReadManifest(const std::string& path) {
    return ManifestReader(path).Read();
}

bool IsImageName(const std::filesystem::path& path) {
    const std::string extension = ToLower(path.extension().string());
    for (const char* known :
         {".png", ".jpg", ".jpeg", ".tga", ".bmp", ".gif", ".ppm", ".pgm", ".hdr", ".exr"}) {
        if (extension == known)
            return true;
    }
    return false;
}

Manifest MakeManifest(const std::vector<std::string>& paths) {
    std::vector<std::string> images = paths;
    std::error_code error;
    if (paths.size() == 1 && std::filesystem::is_directory(paths[0], error)) {
        images.clear();
        for (const auto& entry : std::filesystem::directory_iterator(paths[0], error)) {
            if (entry.is_regular_file() && IsImageName(entry.path()))
                images.push_back(entry.path().string());
        }
        std::sort(images.begin(), images.end());
        if (images.empty())
            throw CommandError(ExitCode::BadInput, paths[0],
                               "folder: no images: PNG, JPEG, TGA, BMP, GIF, PNM, HDR or EXR");
    }
    Manifest manifest;
    for (const std::string& image : images) {
        const std::filesystem::path path = image;
        ManifestTexture texture;
        texture.path = image;
        texture.name = image == "-" ? "stdin" : path.stem().string();
        const ColorGuess guess = GuessColor(texture.name);
        texture.isSrgb = guess.meaning == ColorMeaning::Color;
        texture.colorReason = guess.reason;
        manifest.textures.push_back(texture);
        for (int mip = 1; mip < 16; ++mip) {
            const std::filesystem::path file =
                path.parent_path() / "mips" /
                (texture.name + Format(".%02d", mip) + path.extension().string());
            if (!std::filesystem::is_regular_file(file, error))
                continue;
            ManifestTexture level = texture;
            level.path = file.string();
            level.mipLevel = mip;
            manifest.textures.push_back(level);
        }
    }
    return manifest;
}

} // namespace openntc::tool
