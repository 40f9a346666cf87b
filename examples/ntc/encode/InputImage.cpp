// SPDX-License-Identifier: MIT
#include "encode/InputImage.h"

#include "Failure.h"
#include "InputFile.h"
#include "Output.h"
#include "encode/PngReader.h"

#include <algorithm>
#include <cinttypes>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <memory>
#include <span>
#include <string_view>

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_NO_STDIO
#define STBI_NO_PNG
#define STBI_NO_PSD
#define STBI_NO_PIC
#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#endif
#include <stb/stb_image.h>
#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif
#if defined(OPENNTC_TOOL_HAS_EXR)
#include <tinyexr.h>
#endif

namespace openntc::tool {

namespace {

constexpr int kMaxSide = 16384;
// Four floats for each of the most texels, and half a gigabyte of headers and compression that gained
// nothing.
constexpr std::uint64_t kLargestFile = (std::uint64_t{16384} * 16384 * 16) + (std::uint64_t{1} << 29);

[[noreturn]] void FailImage(const std::string& path, const std::string& text) {
    throw CommandError(ExitCode::BadInput, path, "image: " + text);
}

template <typename T>
void Convert(InputImage& image, const T* texels, float maximum) {
    const auto count = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) *
                       static_cast<std::size_t>(image.channels);
    image.texels.resize(count);
    for (std::size_t i = 0; i < count; ++i)
        image.texels[i] = static_cast<float>(texels[i]) / maximum;
}

void CheckSize(const std::string& path, std::int64_t width, std::int64_t height) {
    if (width < 1 || height < 1 || width > kMaxSide || height > kMaxSide)
        FailImage(path, Format("%" PRId64 " x %" PRId64 ": 1 to %d per side", width, height, kMaxSide));
}

#if defined(OPENNTC_TOOL_HAS_EXR)
// tinyexr allocates by the window that the header claims; the size is checked before.
void CheckExrSize(const std::string& path, const unsigned char* bytes, std::size_t size) {
    EXRVersion version;
    if (ParseEXRVersionFromMemory(&version, bytes, size) != TINYEXR_SUCCESS)
        FailImage(path, Format("%zu bytes: the OpenEXR header is damaged", size));
    if (version.multipart != 0)
        FailImage(path, Format("%zu bytes: OpenEXR of several parts is not read", size));
    EXRHeader header;
    InitEXRHeader(&header);
    const char* error = nullptr;
    const bool good = ParseEXRHeaderFromMemory(&header, &version, bytes, size, &error) == TINYEXR_SUCCESS;
    const std::string text = error != nullptr ? error : "unreadable";
    FreeEXRErrorMessage(error);
    const EXRBox2i window = header.data_window;
    FreeEXRHeader(&header);
    if (!good)
        FailImage(path, Format("%zu bytes: ", size) + Printable(text));
    CheckSize(path, std::int64_t{window.max_x} - window.min_x + 1,
              std::int64_t{window.max_y} - window.min_y + 1);
}

InputImage ReadExr(const std::string& path, std::span<const std::byte> file) {
    const auto* bytes = reinterpret_cast<const unsigned char*>(file.data());
    CheckExrSize(path, bytes, file.size());
    float* texels = nullptr;
    const char* error = nullptr;
    InputImage image;
    if (LoadEXRFromMemory(&texels, &image.width, &image.height, bytes, file.size(), &error) !=
        TINYEXR_SUCCESS) {
        const std::string text = error != nullptr ? error : "unreadable";
        FreeEXRErrorMessage(error);
        FailImage(path, Format("%zu bytes: ", file.size()) + Printable(text));
    }
    const std::unique_ptr<float, void (*)(void*)> owner(texels, std::free);
    CheckSize(path, image.width, image.height);
    image.channels = 4; // tinyexr fills missing alpha with 1
    image.bits = 32;
    Convert(image, texels, 1.0f);
    return image;
}
#endif

InputImage ReadPngImage(const std::string& path, std::span<const std::byte> file) {
    const PngImage png = ReadPng(file, path, kMaxSide);
    InputImage image;
    image.width = png.width;
    image.height = png.height;
    image.channels = png.channels;
    image.bits = png.bits;
    if (png.bits == 8) {
        Convert(image, png.samples.data(), 255.0f);
        return image;
    }
    std::vector<std::uint16_t> samples(png.samples.size() / 2);
    for (std::size_t i = 0; i < samples.size(); ++i)
        samples[i] = static_cast<std::uint16_t>(png.samples[2 * i] << 8 | png.samples[2 * i + 1]);
    Convert(image, samples.data(), 65535.0f);
    return image;
}

/// JPEG, TGA, BMP, GIF, PNM and Radiance HDR: formats without checksums.
InputImage ReadWithStb(const std::string& path, std::span<const std::byte> file) {
    if (file.size() > static_cast<std::size_t>(std::numeric_limits<int>::max()))
        FailImage(path, Format("%zu bytes: at most %d of this format", file.size(),
                               std::numeric_limits<int>::max()));
    const auto* bytes = reinterpret_cast<const stbi_uc*>(file.data());
    const int size = static_cast<int>(file.size());
    InputImage image;
    if (stbi_info_from_memory(bytes, size, &image.width, &image.height, &image.channels) == 0)
        FailImage(path, Format("%d bytes: unreadable: %s", size, stbi_failure_reason()));
    CheckSize(path, image.width, image.height);
    const auto read = [&](auto* texels, int bits, float maximum) {
        if (texels == nullptr)
            FailImage(path,
                      Format("%d x %d: unreadable: %s", image.width, image.height, stbi_failure_reason()));
        const std::unique_ptr<void, void (*)(void*)> owner(texels, stbi_image_free);
        image.bits = bits;
        Convert(image, texels, maximum);
    };
    if (stbi_is_hdr_from_memory(bytes, size) != 0)
        read(stbi_loadf_from_memory(bytes, size, &image.width, &image.height, &image.channels, 0), 32, 1.0f);
    else if (stbi_is_16_bit_from_memory(bytes, size) != 0)
        read(stbi_load_16_from_memory(bytes, size, &image.width, &image.height, &image.channels, 0), 16,
             65535.0f);
    else
        read(stbi_load_from_memory(bytes, size, &image.width, &image.height, &image.channels, 0), 8, 255.0f);
    return image;
}

enum class ImageKind { Unknown, Png, OpenExr, Other };

bool StartsWith(std::span<const std::byte> bytes, std::string_view text, std::size_t at = 0) {
    return bytes.size() >= at + text.size() && std::memcmp(bytes.data() + at, text.data(), text.size()) == 0;
}

/// TGA has no signature: a header that makes sense.
bool LooksLikeTga(std::span<const std::byte> bytes) {
    if (bytes.size() < 18)
        return false;
    const auto at = [&](std::size_t i) { return static_cast<int>(bytes[i]); };
    const int type = at(2) & 7, bits = at(16);
    return at(1) <= 1 && at(2) <= 11 && type >= 1 && type <= 3 &&
           (bits == 8 || bits == 15 || bits == 16 || bits == 24 || bits == 32);
}

ImageKind FindKind(std::span<const std::byte> bytes) {
    using namespace std::string_view_literals;
    if (IsPng(bytes))
        return ImageKind::Png;
    if (StartsWith(bytes, "\x76\x2F\x31\x01"sv))
        return ImageKind::OpenExr;
    for (const std::string_view signature : {"\xFF\xD8"sv, "BM"sv, "GIF8"sv, "#?"sv, "P5"sv, "P6"sv}) {
        if (StartsWith(bytes, signature))
            return ImageKind::Other;
    }
    return LooksLikeTga(bytes) ? ImageKind::Other : ImageKind::Unknown;
}

/// Formats that users try, by name.
const char* FindForeignName(std::span<const std::byte> bytes) {
    using namespace std::string_view_literals;
    static constexpr struct {
        std::string_view signature;
        std::size_t at;
        const char* name;
    } kForeign[] = {{"WEBP"sv, 8, "WebP"},          {"II*\0"sv, 0, "TIFF"},    {"MM\0*"sv, 0, "TIFF"},
                    {"DDS "sv, 0, "DDS"},           {"\xABKTX"sv, 0, "KTX"},   {"8BPS"sv, 0, "PSD"},
                    {"NTEX"sv, 0, "a texture set"}, {"ftypavif"sv, 4, "AVIF"}, {"ftypheic"sv, 4, "HEIC"},
                    {"\xFF\x0A"sv, 0, "JPEG XL"}};
    for (const auto& format : kForeign) {
        if (StartsWith(bytes, format.signature, format.at))
            return format.name;
    }
    return "an unknown format";
}

ImageKind RequireKind(const std::string& name, std::span<const std::byte> bytes) {
    if (bytes.empty())
        FailImage(name, "0 bytes: the file is empty");
    const ImageKind kind = FindKind(bytes);
    if (kind == ImageKind::Unknown)
        FailImage(name, Format("%s: PNG, JPEG, TGA, BMP, GIF, PNM, HDR and OpenEXR are read",
                               FindForeignName(bytes)));
    return kind;
}

} // namespace

InputImage ReadImage(const std::string& path) {
    // Before the rest is read, which may be endless.
    const auto accept = [&](std::span<const std::byte> beginning, InputBound&) {
        RequireKind(path, beginning);
    };
    return ReadImage(path, ReadAll(path, {{kLargestFile}, accept}));
}

InputImage ReadImage(const std::string& name, std::span<const std::byte> bytes) {
    switch (RequireKind(name, bytes)) {
    case ImageKind::Png:
        return ReadPngImage(name, bytes);
    case ImageKind::OpenExr:
#if defined(OPENNTC_TOOL_HAS_EXR)
        return ReadExr(name, bytes);
#else
        FailImage(name, "OpenEXR: this build has no tinyexr");
#endif
    default:
        return ReadWithStb(name, bytes);
    }
}

InputImage ResizeImage(const InputImage& image, int width, int height) {
    InputImage result = image;
    result.width = width;
    result.height = height;
    result.texels.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
                             static_cast<std::size_t>(image.channels),
                         0.0f);
    const auto at = [&](int x, int y, int c) {
        x = std::clamp(x, 0, image.width - 1);
        y = std::clamp(y, 0, image.height - 1);
        return image.texels[(static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) +
                             static_cast<std::size_t>(x)) *
                                static_cast<std::size_t>(image.channels) +
                            static_cast<std::size_t>(c)];
    };
    std::size_t i = 0;
    for (int y = 0; y < height; ++y) {
        const float py =
            (static_cast<float>(y) + 0.5f) * static_cast<float>(image.height) / static_cast<float>(height) -
            0.5f;
        const int y0 = static_cast<int>(std::floor(py));
        const float fy = py - static_cast<float>(y0);
        for (int x = 0; x < width; ++x) {
            const float px =
                (static_cast<float>(x) + 0.5f) * static_cast<float>(image.width) / static_cast<float>(width) -
                0.5f;
            const int x0 = static_cast<int>(std::floor(px));
            const float fx = px - static_cast<float>(x0);
            for (int c = 0; c < image.channels; ++c, ++i)
                result.texels[i] = (at(x0, y0, c) * (1.0f - fx) + at(x0 + 1, y0, c) * fx) * (1.0f - fy) +
                                   (at(x0, y0 + 1, c) * (1.0f - fx) + at(x0 + 1, y0 + 1, c) * fx) * fy;
        }
    }
    return result;
}

} // namespace openntc::tool
