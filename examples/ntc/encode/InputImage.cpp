// SPDX-License-Identifier: MIT
#include "encode/InputImage.h"

#include "Failure.h"
#include "Output.h"
#include "TextureSet.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <memory>

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
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

bool HasExtension(const std::string& path, const char* extension) {
    const std::string wanted = extension;
    return path.size() >= wanted.size() &&
           std::equal(
               wanted.begin(), wanted.end(), path.end() - static_cast<std::ptrdiff_t>(wanted.size()),
               [](char a, char b) { return a == (b >= 'A' && b <= 'Z' ? static_cast<char>(b + 32) : b); });
}

void CheckSize(const std::string& path, int width, int height) {
    if (width < 1 || height < 1 || width > kMaxSide || height > kMaxSide)
        FailImage(path, Format("%d x %d: 1 to %d per side", width, height, kMaxSide));
}

#if defined(OPENNTC_TOOL_HAS_EXR)
InputImage ReadExr(const std::string& path) {
    float* texels = nullptr;
    const char* error = nullptr;
    InputImage image;
    if (LoadEXR(&texels, &image.width, &image.height, path.c_str(), &error) != TINYEXR_SUCCESS) {
        const std::string text = error != nullptr ? error : "unreadable";
        FreeEXRErrorMessage(error);
        FailImage(path, text);
    }
    const std::unique_ptr<float, void (*)(void*)> owner(texels, std::free);
    CheckSize(path, image.width, image.height);
    image.channels = 4; // tinyexr fills missing alpha with 1
    image.bits = 32;
    Convert(image, texels, 1.0f);
    return image;
}
#endif

} // namespace

InputImage ReadImage(const std::string& path) {
    if (HasExtension(path, ".exr")) {
#if defined(OPENNTC_TOOL_HAS_EXR)
        return ReadExr(path);
#else
        FailImage(path, "OpenEXR: this build has no tinyexr");
#endif
    }
    return ReadImage(path, ReadAll(path));
}

InputImage ReadImage(const std::string& name, std::span<const std::byte> bytes) {
    const auto* data = reinterpret_cast<const stbi_uc*>(bytes.data());
    if (bytes.size() > static_cast<std::size_t>(std::numeric_limits<int>::max()))
        FailImage(name, Format("%zu bytes: fewer than 2 GiB are read", bytes.size()));
    const int size = static_cast<int>(bytes.size());
    InputImage image;
    const auto read = [&](auto* texels, int bits, float maximum) {
        if (texels == nullptr)
            FailImage(name, std::string("unreadable: ") + stbi_failure_reason());
        const std::unique_ptr<void, void (*)(void*)> owner(texels, stbi_image_free);
        image.bits = bits;
        Convert(image, texels, maximum);
    };
    if (stbi_info_from_memory(data, size, &image.width, &image.height, &image.channels) == 0)
        FailImage(name, std::string("unreadable: ") + stbi_failure_reason());
    CheckSize(name, image.width, image.height);
    if (stbi_is_hdr_from_memory(data, size) != 0)
        read(stbi_loadf_from_memory(data, size, &image.width, &image.height, &image.channels, 0), 32, 1.0f);
    else if (stbi_is_16_bit_from_memory(data, size) != 0)
        read(stbi_load_16_from_memory(data, size, &image.width, &image.height, &image.channels, 0), 16,
             65535.0f);
    else
        read(stbi_load_from_memory(data, size, &image.width, &image.height, &image.channels, 0), 8, 255.0f);
    return image;
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
