// SPDX-License-Identifier: MIT
// OpenEXR files of 16- or 32-bit floats through tinyexr.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace openntc::tool {

struct ExrFormat {
    int width = 0;
    int height = 0;
    int channels = 0;    ///< 1 Y, 3 RGB, 4 RGBA, more: c00, c01, …
    bool isHalf = false; ///< 16 bits a channel, else 32
};

/// False in builds without tinyexr.
bool IsExrAvailable();

/// Writes one image to `path`; errors name `subject`. The texels are kept until Finish. Throws
/// CommandError(Failed).
class ExrWriter {
public:
    ExrWriter(std::filesystem::path path, std::string subject, const ExrFormat& format);

    /// One row: width * channels samples in linear light.
    void WriteRow(std::span<const float> samples);

    /// After the last row. Without it there is no file.
    void Finish();

private:
    std::filesystem::path path_;
    std::string subject_;
    ExrFormat format_;
    std::vector<std::vector<float>> planes_;
};

} // namespace openntc::tool
