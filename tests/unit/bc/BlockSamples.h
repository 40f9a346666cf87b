// SPDX-License-Identifier: MIT
// Made images for tests of block encoders, and what their blocks decode to.
#pragma once

#include "openntc/bc/BlockDecoder.h"
#include "openntc/bc/BlockEncoder.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

namespace openntc_tests {

/// RGBA, 8 bits a channel (signed formats: two's complement), sides multiples of 4.
struct SampleImage {
    std::uint32_t width = 0, height = 0;
    std::vector<std::uint8_t> texels;

    SampleImage(std::uint32_t w, std::uint32_t h)
        : width(w), height(h), texels(std::size_t{4} * w * h, 255) {}
    std::uint8_t& At(std::uint32_t x, std::uint32_t y, std::uint32_t c) {
        return texels[4 * (std::size_t{y} * width + x) + c];
    }
};

inline std::vector<std::byte> EncodeSample(openntc::bc::BlockFormat format, const SampleImage& image,
                                           const openntc::bc::BlockOptions& options) {
    using namespace openntc::bc;
    const bool isSigned = format == BlockFormat::Bc4Signed || format == BlockFormat::Bc5Signed;
    const BlockImage view{std::as_bytes(std::span(image.texels)),
                          image.width,
                          image.height,
                          0,
                          4,
                          isSigned ? TexelType::Signed8 : TexelType::Unsigned8};
    const BlockRect rect{0, 0, CountBlocks(image.width), CountBlocks(image.height)};
    std::vector<std::byte> blocks(GetBytesPerBlock(format) * rect.width * rect.height);
    const auto done = EncodeBlocks(format, view, rect, options, blocks);
    REQUIRE_MESSAGE(done.has_value(), std::string(done ? "" : done.error().GetText()));
    return blocks;
}

/// Squared error of the first `channels` channels, in steps of a byte, without rounding; the mean over texels and
/// channels.
inline double GetSampleError(openntc::bc::BlockFormat format, const SampleImage& image,
                             std::span<const std::byte> blocks, std::uint32_t channels) {
    using namespace openntc::bc;
    const bool isSigned = format == BlockFormat::Bc4Signed || format == BlockFormat::Bc5Signed;
    const std::uint32_t columns = image.width / 4;
    double sum = 0;
    for (std::uint32_t b = 0; b < columns * (image.height / 4); ++b) {
        std::int32_t exact[64];
        DecodeBlockExact(format, blocks.data() + b * GetBytesPerBlock(format), exact);
        for (std::uint32_t t = 0; t < 16; ++t) {
            const std::size_t texel =
                std::size_t{b / columns * 4 + t / 4} * image.width + b % columns * 4 + t % 4;
            for (std::uint32_t c = 0; c < channels; ++c) {
                const std::uint8_t byte = image.texels[4 * texel + c];
                const int wanted = isSigned ? std::max<int>(static_cast<std::int8_t>(byte), -127) : byte;
                const double error = exact[4 * t + c] / 210.0 - wanted;
                sum += error * error;
            }
        }
    }
    return sum / (double(image.width) * image.height * channels);
}

inline double ToPsnr(double meanSquare) {
    return 10 * std::log10(255.0 * 255.0 / std::max(meanSquare, 1e-12));
}

} // namespace openntc_tests
