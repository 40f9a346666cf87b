// SPDX-License-Identifier: MIT
#include "Images.h"

#include "StbImageWrite.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>

namespace materials {

Image MakeNormals(const Image& height, float depth) {
    Image normals(height.size, 3);
    for (int y = 0; y < height.size; ++y) {
        for (int x = 0; x < height.size; ++x) {
            const float dx = (height.At(x + 1, y) - height.At(x - 1, y)) * 0.5f * depth;
            const float dy = (height.At(x, y + 1) - height.At(x, y - 1)) * 0.5f * depth;
            const float length = std::sqrt(dx * dx + dy * dy + 1.0f);
            normals.At(x, y, 0) = 0.5f - 0.5f * dx / length;
            normals.At(x, y, 1) = 0.5f + 0.5f * dy / length;
            normals.At(x, y, 2) = 0.5f + 0.5f / length;
        }
    }
    return normals;
}

Image MakeOcclusion(const Image& height, float depth) {
    constexpr int kDirections = 8, kSteps = 6;
    constexpr float kPi = 3.14159265f;
    Image occlusion(height.size, 1);
    for (int y = 0; y < height.size; ++y) {
        for (int x = 0; x < height.size; ++x) {
            float open = 0.0f;
            for (int d = 0; d < kDirections; ++d) {
                const float angle = 2.0f * kPi * static_cast<float>(d) / kDirections;
                float slope = 0.0f;
                for (int s = 1; s <= kSteps; ++s) {
                    const float distance = static_cast<float>(s * s) * 0.5f + 0.5f;
                    const int px = x + static_cast<int>(std::lround(std::cos(angle) * distance));
                    const int py = y + static_cast<int>(std::lround(std::sin(angle) * distance));
                    slope = std::max(slope, (height.At(px, py) - height.At(x, y)) * depth / distance);
                }
                open += 1.0f - slope / std::sqrt(1.0f + slope * slope);
            }
            occlusion.At(x, y) = open / kDirections;
        }
    }
    return occlusion;
}

std::vector<std::uint8_t> MakeBytes(const Image& image, bool encodeSrgb) {
    std::vector<std::uint8_t> bytes(image.texels.size());
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        float value = std::clamp(image.texels[i], 0.0f, 1.0f);
        if (encodeSrgb && static_cast<int>(i) % image.channels < 3)
            value = value <= 0.0031308f ? 12.92f * value : 1.055f * std::pow(value, 1.0f / 2.4f) - 0.055f;
        bytes[i] = static_cast<std::uint8_t>(std::lround(value * 255.0f));
    }
    return bytes;
}

bool WritePng(const std::filesystem::path& path, const Image& image, bool encodeSrgb) {
    const std::vector<std::uint8_t> bytes = MakeBytes(image, encodeSrgb);
    return stbi_write_png(path.string().c_str(), image.size, image.size, image.channels, bytes.data(),
                          image.size * image.channels) != 0;
}

bool WriteHdr(const std::filesystem::path& path, const Image& image) {
    return stbi_write_hdr(path.string().c_str(), image.size, image.size, image.channels,
                          image.texels.data()) != 0;
}

bool WriteText(const std::filesystem::path& path, const char* text) {
    std::ofstream file(path, std::ios::binary);
    file << text;
    return file.good();
}

} // namespace materials
