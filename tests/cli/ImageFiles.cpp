// SPDX-License-Identifier: MIT
#include "cli/ImageFiles.h"

#include <doctest/doctest.h>
#include <png.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#include <stb/stb_image_write.h>
#if defined(OPENNTC_TOOL_HAS_EXR)
#include <tinyexr.h>
#endif

namespace openntc_tests {

namespace {

template <typename T>
std::vector<T> Quantise(const TestImage& image, float maximum) {
    std::vector<T> samples;
    for (float value : image.samples)
        samples.push_back(static_cast<T>(std::lround(std::clamp(value, 0.0f, 1.0f) * maximum)));
    return samples;
}

void WritePng16(const std::string& path, const TestImage& image) {
    std::FILE* file = std::fopen(path.c_str(), "wb");
    REQUIRE(file != nullptr);
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
    png_infop info = png_create_info_struct(png);
    png_init_io(png, file);
    static constexpr int kTypes[] = {PNG_COLOR_TYPE_GRAY, PNG_COLOR_TYPE_GRAY_ALPHA, PNG_COLOR_TYPE_RGB,
                                     PNG_COLOR_TYPE_RGBA};
    png_set_IHDR(png, info, static_cast<png_uint_32>(image.width), static_cast<png_uint_32>(image.height), 16,
                 kTypes[image.channels - 1], PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    png_write_info(png, info);
    png_set_swap(png);
    auto samples = Quantise<std::uint16_t>(image, 65535.0f);
    for (int y = 0; y < image.height; ++y)
        png_write_row(png, reinterpret_cast<png_bytep>(samples.data() + static_cast<std::ptrdiff_t>(y) *
                                                                            image.width * image.channels));
    png_write_end(png, info);
    png_destroy_write_struct(&png, &info);
    std::fclose(file);
}

} // namespace

TestImage MakeImage(int width, int height, int channels,
                    const std::function<float(float, float, int)>& sample) {
    TestImage image{width, height, channels, {}};
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            for (int c = 0; c < channels; ++c)
                image.samples.push_back(sample(static_cast<float>(x) / static_cast<float>(width),
                                               static_cast<float>(y) / static_cast<float>(height), c));
        }
    }
    return image;
}

void WriteImage(const std::filesystem::path& path, const TestImage& image, int bits) {
    const std::string name = path.string(), extension = path.extension().string();
    const int w = image.width, h = image.height, c = image.channels;
    const auto bytes = Quantise<std::uint8_t>(image, 255.0f);
    if (extension == ".png" && bits == 16)
        WritePng16(name, image);
    else if (extension == ".png")
        REQUIRE(stbi_write_png(name.c_str(), w, h, c, bytes.data(), w * c) != 0);
    else if (extension == ".jpg")
        REQUIRE(stbi_write_jpg(name.c_str(), w, h, c, bytes.data(), 95) != 0);
    else if (extension == ".tga")
        REQUIRE(stbi_write_tga(name.c_str(), w, h, c, bytes.data()) != 0);
    else if (extension == ".bmp")
        REQUIRE(stbi_write_bmp(name.c_str(), w, h, c, bytes.data()) != 0);
    else if (extension == ".hdr")
        REQUIRE(stbi_write_hdr(name.c_str(), w, h, c, image.samples.data()) != 0);
#if defined(OPENNTC_TOOL_HAS_EXR)
    else if (extension == ".exr")
        REQUIRE(SaveEXR(image.samples.data(), w, h, c, 0, name.c_str(), nullptr) == TINYEXR_SUCCESS);
#endif
    else
        FAIL("unknown format ", extension);
}

TestImage ReadPngImage(const std::filesystem::path& path) {
    png_image png = {};
    png.version = PNG_IMAGE_VERSION;
    REQUIRE(png_image_begin_read_from_file(&png, path.string().c_str()) != 0);
    const int channels = static_cast<int>(PNG_IMAGE_SAMPLE_CHANNELS(png.format));
    png.format = channels == 1   ? PNG_FORMAT_GRAY
                 : channels == 2 ? PNG_FORMAT_GA
                 : channels == 3 ? PNG_FORMAT_RGB
                                 : PNG_FORMAT_RGBA;
    std::vector<unsigned char> samples(PNG_IMAGE_SIZE(png));
    REQUIRE(png_image_finish_read(&png, nullptr, samples.data(), 0, nullptr) != 0);
    TestImage image{static_cast<int>(png.width), static_cast<int>(png.height), channels, {}};
    for (unsigned char sample : samples)
        image.samples.push_back(static_cast<float>(sample) / 255.0f);
    return image;
}

} // namespace openntc_tests
