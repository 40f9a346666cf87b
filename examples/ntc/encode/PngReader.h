// SPDX-License-Identifier: MIT
// PNG files through libpng, with every checksum of the file verified.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace openntc::tool {

/// Samples as the file has them; palettes and keyed transparency become channels, 1, 2 and 4 bits become 8.
/// Gamma, profiles and significant bits are not applied.
struct PngImage {
    int width = 0, height = 0;
    int channels = 0;                  ///< 1 gray, 2 gray and alpha, 3 RGB, 4 RGBA
    int bits = 8;                      ///< 8 or 16
    std::vector<std::uint8_t> samples; ///< rows, channels interleaved, 16 bits big-endian
};

/// True if `bytes` begin as a PNG file does.
bool IsPng(std::span<const std::byte> bytes);

/// Reads an image of at most `maximumSide` texels a side. Throws CommandError(BadInput) about `subject`,
/// `image: CHUNK: value: limit`, for a CRC-32 of any chunk or a check value of the compressed texels that
/// differs, and for all that libpng refuses.
PngImage ReadPng(std::span<const std::byte> bytes, const std::string& subject, int maximumSide);

} // namespace openntc::tool
