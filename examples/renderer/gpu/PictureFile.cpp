// SPDX-License-Identifier: MIT
#include "renderer/gpu/PictureFile.h"

#include "Arguments.h"
#include "Failure.h"
#include "OutputFolder.h"
#include "Png.h"
#include "materials/StbImageWrite.h"
#include "textures/Tga.h"

#include <cctype>
#include <filesystem>
#include <vector>

namespace openntc::renderer {

namespace {

namespace fs = std::filesystem;

constexpr int kJpegQuality = 95; // of 100

enum class PictureFormat { Png, Jpeg, Bmp, Tga };

PictureFormat FindFormat(const std::string& option, const std::string& path) {
    std::string extension = fs::path(path).extension().string();
    for (char& c : extension)
        c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    if (extension == ".png")
        return PictureFormat::Png;
    if (extension == ".jpg" || extension == ".jpeg")
        return PictureFormat::Jpeg;
    if (extension == ".bmp")
        return PictureFormat::Bmp;
    if (extension == ".tga")
        return PictureFormat::Tga;
    tool::FailUsage(option, path + ": the extension must be png, jpg, bmp or tga");
}

struct Rgb {
    std::vector<std::uint8_t> bytes;
    int width;
    int height;
};

template <typename Writer>
void WriteRows(Writer& writer, const Rgb& picture) {
    const std::size_t width = 3 * static_cast<std::size_t>(picture.width);
    for (std::size_t at = 0; at < picture.bytes.size(); at += width) {
        const auto begin = picture.bytes.begin() + static_cast<std::ptrdiff_t>(at);
        const std::vector<std::uint16_t> row(begin, begin + static_cast<std::ptrdiff_t>(width));
        writer.WriteRow(row);
    }
    writer.Finish();
}

void WritePng(const std::string& path, const Rgb& picture) {
    const fs::path absolute = fs::absolute(path);
    std::error_code ignored;
    if (!fs::is_directory(absolute.parent_path(), ignored)) // as for the other formats: it is not made
        throw tool::CommandError(tool::ExitCode::Failed, path, "PNG: cannot be created: no such folder");
    tool::OutputFolder folder(absolute.parent_path());
    tool::PngWriter writer(folder.Stage(absolute.filename()), path, {picture.width, picture.height, 3, 8});
    WriteRows(writer, picture);
    folder.Commit();
}

/// By stb_image_write, which hands over pieces of the file.
template <typename Encode>
void WriteByStb(const std::string& path, Encode encode) {
    std::vector<std::byte> file;
    const auto append = [](void* context, void* data, int size) {
        const auto* const bytes = static_cast<const std::byte*>(data);
        auto& all = *static_cast<std::vector<std::byte>*>(context);
        all.insert(all.end(), bytes, bytes + size);
    };
    if (encode(append, &file) == 0)
        throw tool::CommandError(tool::ExitCode::Failed, path, "picture: cannot be encoded");
    tool::WriteBytes(path, file);
}

} // namespace

void CheckPictureName(const std::string& option, const std::string& path) {
    FindFormat(option, path);
}

void WritePicture(const std::string& path, std::span<const std::uint8_t> texels, int width, int height) {
    Rgb picture{{}, width, height};
    picture.bytes.reserve(texels.size() / 4 * 3);
    for (std::size_t i = 0; i < texels.size(); ++i) {
        if (i % 4 != 3)
            picture.bytes.push_back(texels[i]);
    }
    const std::uint8_t* const bytes = picture.bytes.data();
    switch (FindFormat("-o", path)) {
    case PictureFormat::Png:
        return WritePng(path, picture);
    case PictureFormat::Tga: {
        tool::TgaWriter writer(path, path, width, height, 3);
        return WriteRows(writer, picture);
    }
    case PictureFormat::Jpeg:
        return WriteByStb(path, [&](stbi_write_func* write, void* context) {
            return stbi_write_jpg_to_func(write, context, width, height, 3, bytes, kJpegQuality);
        });
    case PictureFormat::Bmp:
        return WriteByStb(path, [&](stbi_write_func* write, void* context) {
            return stbi_write_bmp_to_func(write, context, width, height, 3, bytes);
        });
    }
}

} // namespace openntc::renderer
