// SPDX-License-Identifier: MIT
// What a block encoder makes of an image: its error, by a decoder of its own, and its time.
#pragma once

#include "encode/InputImage.h"
#include "textures/BlockCoding.h"

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace openntc::tool {

/// Squared errors, exact in binary64 for images of up to 2^30 texels.
struct BlockError {
    std::array<double, 4> squares{}; ///< of a channel, in its units
    std::array<std::uint64_t, 4>
        counts{};                  ///< texels that count: of BC1 with alpha those that are opaque in both
    std::array<double, 4> worst{}; ///< largest difference of a channel
    std::uint64_t moved = 0;       ///< BC1: texels on the other side of alpha 128

    BlockError& operator+=(const BlockError& other);
};

struct BlockMeasurement {
    BlockError error;
    double peak =
        255.0;        ///< what an error is measured against: 255, 127, or 31743 (binary16 as a whole number)
    int channels = 4; ///< that the PSNR is of
    std::uint64_t texels = 0;
    std::uint64_t bytes = 0; ///< of blocks
    double seconds = 0.0;    ///< fastest run; of the processor with one thread, else by the clock

    /// Pooled over the channels; infinite without an error.
    double GetPsnr() const;
    double GetPsnr(int channel) const;
    double GetMegapixelsPerSecond() const {
        return seconds > 0.0 ? static_cast<double>(texels) / seconds / 1e6 : 0.0;
    }
    /// Errors, texels, bytes and seconds are added.
    void Pool(const BlockMeasurement& other);
};

/// An image as the encoder of a format takes it, and the judge of blocks that stand for it: BC1 to BC3 and
/// BC7 as 8 bits, BC4 and BC5 by the exact fractions of their palettes, BC6H by the bits of halves as whole
/// numbers with a sign.
class BlockSource {
public:
    /// `firstChannel`: what one-channel formats take of the image.
    BlockSource(const InputImage& image, bc::BlockFormat format, int firstChannel = 0);

    const TextureFormat& GetFormat() const { return format_; }
    /// As EncodeTexelBlocks takes them, row by row.
    std::span<const std::byte> GetTexels() const { return texels_; }
    /// Its peak, channels and number of texels; no error yet.
    BlockMeasurement MakeMeasurement() const;
    /// Adds the error of rows of blocks from the texel row `top` on, a multiple of 4.
    void Judge(std::span<const std::byte> blocks, std::size_t top, BlockError& error) const;
    /// Adds that of another image of the same size, before any block compression.
    void Judge(const BlockSource& other, BlockError& error) const;

private:
    void AddTexel(const int* got, double scale, std::size_t texel, BlockError& error) const;

    TextureFormat format_;
    std::size_t width_, height_;
    std::vector<std::byte> texels_;
    std::vector<int> numbers_; // 4 a texel: 0 … 255, -127 … 127 or ordinals of halves
};

/// Work for a thread: enough that it is not over before others have begun.
inline constexpr std::size_t kTexelsPerThread = 1 << 15;

/// A clock: of the processor where one thread works, so that others' load does not count; else of the wall.
double GetEncodingSeconds(bool isOneThread);

struct BlockRequest {
    bc::BlockFormat format = bc::BlockFormat::Bc7;
    BlockEffort effort = BlockEffort::Normal;
    int threads = 1; ///< 0: all
    int repeat = 3;
    int channel = 0;     ///< that one-channel formats take
    bool hinted = false; ///< BC7: encode with the hints of a search at best, which is not timed
};

/// The formats that suit an image, of those that have an encoder: of floats BC6H, else BC1, BC4 and BC7, with
/// two channels and more BC5, with alpha BC2 and BC3.
std::vector<bc::BlockFormat> ListBlockFormats(const InputImage& image);

/// Encodes, and judges as BlockSource does. `advance` is called with texels done and may throw. Errors name
/// `subject`.
BlockMeasurement MeasureBlocks(const InputImage& image, const BlockRequest& request,
                               const std::string& subject, const std::function<void(std::uint64_t)>& advance);

} // namespace openntc::tool
