// SPDX-License-Identifier: MIT
// Image files as floats: PNG of 1 to 16 bits, JPEG, TGA, BMP, GIF (its first picture), PNM, Radiance HDR and
// OpenEXR. What a file is follows from its bytes, not from its name.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace openntc::tool {

struct InputImage {
    int width = 0;
    int height = 0;
    int channels = 0;          ///< of the file: 1 to 4
    int bits = 8;              ///< per channel of the file: 8, 16 or 32 (float)
    std::vector<float> texels; ///< interleaved; integers divided by their maximum, floats as they are

    bool IsFloat() const { return bits == 32; }
};

/// Reads a file, a pipe, or standard input for "-". Throws CommandError(BadInput) naming the file, and its
/// size in texels as soon as that is known.
InputImage ReadImage(const std::string& path);

/// An image in memory; `name` says which in errors. Throws CommandError(BadInput).
InputImage ReadImage(const std::string& name, std::span<const std::byte> bytes);

/// Bilinear resampling at texel centres, edges clamped.
InputImage ResizeImage(const InputImage& image, int width, int height);

} // namespace openntc::tool
