// SPDX-License-Identifier: MIT
#include "textures/BlockMeasurement.h"

#include "TextureImage.h"

#include "openntc/bc/BlockDecoder.h"
#include "openntc/bc/BlockHints.h"
#include "openntc/core/Half.h"
#include "openntc/core/ThreadTeam.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <limits>
#include <utility>

namespace openntc::tool {

namespace {

using bc::BlockFormat;

bool IsHdr(BlockFormat format) {
    return format == BlockFormat::Bc6Unsigned || format == BlockFormat::Bc6Signed;
}

bool IsSigned(BlockFormat format) {
    return format == BlockFormat::Bc4Signed || format == BlockFormat::Bc5Signed ||
           format == BlockFormat::Bc6Signed;
}

/// A half as a whole number that grows with it: neighbours differ by 1.
int GetOrdinal(std::uint16_t half) {
    const int magnitude = half & 0x7FFF;
    return (half & 0x8000) != 0 ? -magnitude : magnitude;
}

TextureFormat MakeFormat(const InputImage& image, BlockFormat block) {
    TextureFormat format;
    format.block = block;
    format.channels = bc::GetBlockChannels(block);
    format.number = IsHdr(block)      ? TexelNumber::Half
                    : IsSigned(block) ? TexelNumber::Snorm8
                                      : TexelNumber::Unorm8;
    format.hasAlpha = image.channels % 2 == 0;
    return format;
}

float GetSample(const InputImage& image, std::size_t texel, int channel) {
    const auto channels = static_cast<std::size_t>(image.channels);
    const bool hasAlpha = channels % 2 == 0;
    if (channel == 3)
        return hasAlpha ? image.texels[texel * channels + channels - 1] : 1.0f;
    // Gray counts as R, G and B alike.
    return image.texels[texel * channels + (channels < 3 ? 0 : static_cast<std::size_t>(channel))];
}

/// The texels of one block in units of `scale` to a number of the source.
double DecodeBlock(BlockFormat format, const std::byte* block, int (&texels)[64]) {
    if (IsHdr(format)) {
        std::uint16_t halves[64];
        bc::DecodeBlockHalves(format, block, halves);
        std::transform(std::begin(halves), std::end(halves), texels, GetOrdinal);
        return 1.0;
    }
    const bool isExact = bc::GetBlockChannels(format) < 3;
    if (isExact) {
        std::int32_t exact[64];
        bc::DecodeBlockExact(format, block, exact);
        std::copy(std::begin(exact), std::end(exact), texels);
        return static_cast<double>(bc::GetExactOne(format)) / (IsSigned(format) ? 127.0 : 255.0);
    }
    std::uint8_t bytes[64];
    bc::DecodeBlockBytes(format, block, bytes);
    std::copy(std::begin(bytes), std::end(bytes), texels);
    return 1.0;
}

double ToPsnr(double squares, std::uint64_t count, double peak) {
    if (count == 0 || squares == 0.0)
        return std::numeric_limits<double>::infinity();
    return 10.0 * std::log10(peak * peak * static_cast<double>(count) / squares);
}

} // namespace

double GetEncodingSeconds(bool isOneThread) {
    if (isOneThread)
        return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

BlockError& BlockError::operator+=(const BlockError& other) {
    for (std::size_t c = 0; c < 4; ++c) {
        squares[c] += other.squares[c];
        counts[c] += other.counts[c];
        worst[c] = std::max(worst[c], other.worst[c]);
    }
    moved += other.moved;
    return *this;
}

double BlockMeasurement::GetPsnr() const {
    double squares = 0.0;
    std::uint64_t count = 0;
    for (std::size_t c = 0; c < static_cast<std::size_t>(channels); ++c) {
        squares += error.squares[c];
        count += error.counts[c];
    }
    return ToPsnr(squares, count, peak);
}

double BlockMeasurement::GetPsnr(int channel) const {
    const auto c = static_cast<std::size_t>(channel);
    return ToPsnr(error.squares[c], error.counts[c], peak);
}

void BlockMeasurement::Pool(const BlockMeasurement& other) {
    error += other.error;
    texels += other.texels;
    bytes += other.bytes;
    seconds += other.seconds;
}

BlockSource::BlockSource(const InputImage& image, BlockFormat format, int firstChannel)
    : format_(MakeFormat(image, format)), width_(static_cast<std::size_t>(image.width)),
      height_(static_cast<std::size_t>(image.height)) {
    numbers_.reserve(width_ * height_ * 4);
    for (std::size_t i = 0; i < width_ * height_; ++i) {
        for (int c = 0; c < 4; ++c) {
            if (c >= format_.channels) {
                numbers_.push_back(0);
                continue;
            }
            const float value = GetSample(image, i, format_.channels == 1 ? firstChannel : c);
            if (format_.number == TexelNumber::Half) {
                const std::uint16_t half = FloatToHalf(value);
                texels_.push_back(static_cast<std::byte>(half & 0xFFU));
                texels_.push_back(static_cast<std::byte>(half >> 8));
                // What the formats cannot hold is not their encoder's error: NaN is 0, infinity the largest
                // number, and unsigned blocks hold nothing below 0.
                const bool isNan = (half & 0x7FFF) > 0x7C00;
                const int ordinal = isNan ? 0 : std::clamp(GetOrdinal(half), -0x7BFF, 0x7BFF);
                numbers_.push_back(IsSigned(format) ? ordinal : std::max(ordinal, 0));
            } else if (format_.number == TexelNumber::Snorm8) {
                const int number =
                    static_cast<int>(std::lround(2.0f * QuantiseUnorm(value, 255) / 255.0f * 127.0f)) - 127;
                texels_.push_back(static_cast<std::byte>(number & 0xFF));
                numbers_.push_back(number);
            } else {
                const int number = QuantiseUnorm(value, 255);
                texels_.push_back(static_cast<std::byte>(number));
                numbers_.push_back(number);
            }
        }
    }
}

BlockMeasurement BlockSource::MakeMeasurement() const {
    BlockMeasurement measurement;
    const bool isColor = format_.channels == 4;
    measurement.channels =
        isColor && (!format_.hasAlpha || *format_.block == BlockFormat::Bc1) ? 3 : format_.channels;
    measurement.peak = IsHdr(*format_.block) ? 31743.0 : IsSigned(*format_.block) ? 127.0 : 255.0;
    measurement.texels = width_ * height_;
    return measurement;
}

void BlockSource::Judge(std::span<const std::byte> blocks, std::size_t top, BlockError& error) const {
    const std::size_t columns = (width_ + 3) / 4, unit = GetUnitBytes(format_);
    for (std::size_t i = 0; i < blocks.size() / unit; ++i) {
        int texels[64];
        const double scale = DecodeBlock(*format_.block, blocks.data() + i * unit, texels);
        for (std::size_t t = 0; t < 16; ++t) {
            const std::size_t x = i % columns * 4 + t % 4, y = top + i / columns * 4 + t / 4;
            if (x < width_ && y < height_)
                AddTexel(texels + t * 4, scale, y * width_ + x, error);
        }
    }
}

void BlockSource::Judge(const BlockSource& other, BlockError& error) const {
    for (std::size_t i = 0; i < width_ * height_; ++i)
        AddTexel(other.numbers_.data() + 4 * i, 1.0, i, error);
}

void BlockSource::AddTexel(const int* got, double scale, std::size_t texel, BlockError& error) const {
    const int* wanted = numbers_.data() + texel * 4;
    if (*format_.block == BlockFormat::Bc1 && format_.hasAlpha) {
        const bool isOpaque = wanted[3] >= kBc1OpaqueAlpha;
        if (isOpaque != (got[3] >= kBc1OpaqueAlpha))
            ++error.moved;
        if (!isOpaque || got[3] < kBc1OpaqueAlpha)
            return; // nobody sees its colour
    }
    for (std::size_t c = 0; c < static_cast<std::size_t>(format_.channels); ++c) {
        const double difference = std::fabs(static_cast<double>(got[c]) / scale - wanted[c]);
        error.squares[c] += difference * difference;
        ++error.counts[c];
        error.worst[c] = std::max(error.worst[c], difference);
    }
}

std::vector<BlockFormat> ListBlockFormats(const InputImage& image) {
    std::vector<BlockFormat> formats;
    const auto add = [&](BlockFormat format) {
        if (HasBlockEncoder(format))
            formats.push_back(format);
    };
    if (image.IsFloat()) {
        add(BlockFormat::Bc6Unsigned);
        add(BlockFormat::Bc6Signed);
        return formats;
    }
    const bool hasAlpha = image.channels % 2 == 0;
    add(BlockFormat::Bc1);
    if (hasAlpha) {
        add(BlockFormat::Bc2);
        add(BlockFormat::Bc3);
    }
    add(BlockFormat::Bc4Unsigned);
    if (image.channels >= 3)
        add(BlockFormat::Bc5Unsigned);
    add(BlockFormat::Bc7);
    return formats;
}

BlockMeasurement MeasureBlocks(const InputImage& image, const BlockRequest& request,
                               const std::string& subject,
                               const std::function<void(std::uint64_t)>& advance) {
    const BlockSource source(image, request.format, request.channel);
    BlockMeasurement measurement = source.MakeMeasurement();
    const auto width = static_cast<std::size_t>(image.width), height = static_cast<std::size_t>(image.height);
    const std::size_t rowBytes = source.GetTexels().size() / height;

    // Bands of some thousand blocks for each thread: a search for the best blocks can be stopped between
    // them.
    const int threads = request.threads > 0 ? request.threads : CountHardwareThreads();
    const std::size_t bandTexels = kTexelsPerThread * static_cast<std::size_t>(std::max(threads, 2));
    const std::size_t bandRows = std::max<std::size_t>(4, bandTexels / width / 4 * 4);
    std::vector<double> seconds(static_cast<std::size_t>(request.repeat), 0.0);
    std::vector<std::byte> blocks;
    std::vector<std::int32_t> hints;
    for (std::size_t top = 0; top < height; top += bandRows) {
        const std::size_t rows = std::min(bandRows, height - top);
        const TexelRows band{source.GetTexels().subspan(top * rowBytes, rows * rowBytes),
                             static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(rows)};
        if (request.hinted) {
            EncodeTexelBlocks(source.GetFormat(), BlockEffort::Best, band, request.threads, subject, blocks);
            hints.clear();
            for (std::size_t at = 0; at < blocks.size(); at += GetUnitBytes(source.GetFormat()))
                hints.push_back(bc::GetBlockHint(blocks.data() + at));
        }
        for (double& run : seconds) {
            const double start = GetEncodingSeconds(request.threads == 1);
            EncodeTexelBlocks(source.GetFormat(), request.effort, band, request.threads, subject, blocks,
                              hints);
            run += GetEncodingSeconds(request.threads == 1) - start;
            advance(rows * width);
        }
        source.Judge(blocks, top, measurement.error);
        measurement.bytes += blocks.size();
    }
    measurement.seconds = *std::min_element(seconds.begin(), seconds.end());
    return measurement;
}

} // namespace openntc::tool
