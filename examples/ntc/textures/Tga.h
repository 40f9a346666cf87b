// SPDX-License-Identifier: MIT
// Truevision TGA files of 8 bits a channel, uncompressed, written row by row from the top.
#pragma once

#include "openntc/core/FileStream.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace openntc::tool {

inline constexpr int kTgaMaxSide = 65535; ///< 16 bits in the header

/// Writes one image to `path`, under another name until Finish; errors name `subject`. `channels`: 1 gray, 3 RGB, 4 RGBA.
/// Throws CommandError(Failed).
class TgaWriter {
public:
    TgaWriter(const std::filesystem::path& path, std::string subject, int width, int height, int channels);

    /// One row: width * channels samples of 0 … 255, R first.
    void WriteRow(std::span<const std::uint16_t> samples);

    /// After the last row. Without it there is no file.
    void Finish();

private:
    void Write(std::span<const std::byte> bytes);

    std::string subject_;
    std::size_t channels_;
    FileWriter file_;
    std::vector<std::byte> row_;
};

} // namespace openntc::tool
