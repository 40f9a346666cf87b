// SPDX-License-Identifier: MIT
// Planes of a material, derived planes (normals, occlusion) and image files.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

namespace materials {

/// Interleaved floats, wrapping at the edges.
struct Image {
    int size = 0; ///< square
    int channels = 0;
    std::vector<float> texels;

    Image(int side, int channelCount)
        : size(side), channels(channelCount),
          texels(static_cast<std::size_t>(side) * static_cast<std::size_t>(side) *
                 static_cast<std::size_t>(channelCount)) {}
    float& At(int x, int y, int c = 0) { return texels[Index(x, y, c)]; }
    float At(int x, int y, int c = 0) const { return texels[Index(x, y, c)]; }

private:
    std::size_t Index(int x, int y, int c) const {
        const auto wrap = [this](int v) { return static_cast<std::size_t>(((v % size) + size) % size); };
        return (wrap(y) * static_cast<std::size_t>(size) + wrap(x)) * static_cast<std::size_t>(channels) +
               static_cast<std::size_t>(c);
    }
};

/// Tangent-space normals (0 ... 1) of a height field; `depth` in texels.
Image MakeNormals(const Image& height, float depth);

/// How open the sky is above each point of a height field: 1 open, 0 buried.
Image MakeOcclusion(const Image& height, float depth);

/// The texels as 8 bits; `encodeSrgb` for linear colour, of which a fourth channel is none.
std::vector<std::uint8_t> MakeBytes(const Image& image, bool encodeSrgb);

/// 8-bit PNG of 1, 3 or 4 channels; `encodeSrgb` for linear colour. Returns false if writing fails.
bool WritePng(const std::filesystem::path& path, const Image& image, bool encodeSrgb);

/// Radiance file of 3 channels.
bool WriteHdr(const std::filesystem::path& path, const Image& image);

bool WriteText(const std::filesystem::path& path, const char* text);

} // namespace materials
