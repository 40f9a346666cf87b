// SPDX-License-Identifier: MIT
// PNG files of 8 or 16 bits a channel, written row by row through libpng.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

namespace openntc::tool {

struct PngFormat {
    int width = 0; ///< 1 … kPngMaxSide
    int height = 0;
    int channels = 0; ///< of the file: 1 gray, 3 RGB, 4 RGBA
    int bits = 8;     ///< 8 or 16
};

inline constexpr int kPngMaxSide = 1000000; ///< libpng's own limit

/// Writes one PNG to `path`; errors name `subject`. Throws CommandError(Failed) when the disk is full or the
/// file cannot be created.
class PngWriter {
public:
    PngWriter(const std::filesystem::path& path, const std::string& subject, const PngFormat& format);
    ~PngWriter();
    PngWriter(PngWriter&&) noexcept;
    PngWriter& operator=(PngWriter&&) noexcept;

    /// One row: width * channels samples, of `bits` significant bits each.
    void WriteRow(std::span<const std::uint16_t> samples);

    /// After the last row. Without it the file is incomplete.
    void Finish();

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace openntc::tool
