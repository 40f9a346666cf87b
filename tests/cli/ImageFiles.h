// SPDX-License-Identifier: MIT
// Images that tests of `ntc encode` write, in every format that it reads.
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

namespace openntc_tests {

/// Samples 0 ... 1 (HDR formats: any), channels interleaved.
struct TestImage {
    int width = 0, height = 0, channels = 0;
    std::vector<float> samples;
};

/// sample(u, v, channel) with u and v in [0, 1).
TestImage MakeImage(int width, int height, int channels,
                    const std::function<float(float, float, int)>& sample);

/// The extension says the format: .png (`bits` 8 or 16), .jpg, .tga, .bmp, .hdr, .exr. Samples of integer formats are
/// rounded to nearest.
void WriteImage(const std::filesystem::path& path, const TestImage& image, int bits = 8);

/// Samples of a PNG file as 8 bits.
TestImage ReadPngImage(const std::filesystem::path& path);

} // namespace openntc_tests
