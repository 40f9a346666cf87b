// SPDX-License-Identifier: MIT
// Pictures as files, read back by the readers of `ntc encode`.
#include "renderer/gpu/PictureFile.h"

#include "Failure.h"
#include "encode/InputImage.h"

#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

namespace {

using namespace openntc::renderer;
namespace fs = std::filesystem;

constexpr int kBlock = 8, kColumns = 3, kRows = 2; // blocks of JPEG's transform, each of one colour

std::uint8_t GetTexel(int x, int y, int channel) {
    const int block = y / kBlock * kColumns + x / kBlock;
    return static_cast<std::uint8_t>((40 * block + 85 * channel + 17) % 256);
}

/// What a JPEG of quality 95 may change, in steps of 255: a block of one colour is its mean, in Y, Cb and Cr without subsampling, times
/// 8, quantised in steps of 2; the reader rounds the three to bytes, and the largest factor of the way back to RGB is 1.772.
constexpr double kJpegError = (2.0 / 2.0 / 8.0 + 0.5) * (1.0 + 1.772) + 0.5;

} // namespace

TEST_CASE("renderer: pictures as PNG, JPEG, BMP and TGA are the same picture") {
    const fs::path folder =
        fs::temp_directory_path() / ("openntc-pictures-" + std::to_string(std::random_device()()));
    fs::create_directories(folder);
    constexpr int width = kColumns * kBlock, height = kRows * kBlock;
    std::vector<std::uint8_t> texels;
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            for (int c = 0; c < 4; ++c)
                texels.push_back(c < 3 ? GetTexel(x, y, c) : 7); // alpha is left out
        }
    }
    for (const char* const name : {"a.png", "a.PNG", "a.jpg", "a.jpeg", "a.bmp", "a.tga"}) {
        const std::string path = (folder / name).string();
        CAPTURE(name);
        WritePicture(path, texels, width, height);
        WritePicture(path, texels, width, height); // replaces it
        const openntc::tool::InputImage image = openntc::tool::ReadImage(path);
        REQUIRE(image.width == width);
        REQUIRE(image.height == height);
        REQUIRE(image.channels == 3);
        double worst = 0.0;
        for (std::size_t i = 0; i < image.texels.size(); ++i) {
            const double expected = texels[i / 3 * 4 + i % 3];
            worst = std::fmax(worst, std::fabs(255.0 * static_cast<double>(image.texels[i]) - expected));
        }
        const bool isJpeg = std::string(name).find(".jp") != std::string::npos;
        CHECK(worst <= (isJpeg ? kJpegError : 1e-4)); // bytes are exact, but for the division by 255
    }
    CHECK(std::distance(fs::directory_iterator(folder), fs::directory_iterator()) == 6); // nothing beside
    CHECK_THROWS_AS(CheckPictureName("-o", "a.gif"), openntc::tool::CommandError);
    for (const char* const name : {"a.png", "a.bmp", "a.tga"}) {
        CHECK_THROWS_AS(WritePicture((folder / "none" / name).string(), texels, width, height),
                        openntc::tool::CommandError);
    }
    CHECK_FALSE(fs::exists(folder / "none"));
    fs::remove_all(folder);
}
