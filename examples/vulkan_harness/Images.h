// SPDX-License-Identifier: MIT
// Images that compute shaders read and write as storage images, block-compressed ones to be sampled, and depth.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

namespace openntc::harness {

/// Formats of storage images. The UNORM and SFLOAT ones are image2D, the UINT ones uimage2D.
enum class ImageFormat {
    R8,
    RG8,
    RGBA8,
    R16,
    RGBA16,
    R16F,
    RGBA16F,
    R32F,
    RGBA32F,
    RG32UI,
    RGBA32UI,
    D32, ///< depth, of Context::Draw only
    /// Four bits a channel, blue in the lowest ones, to be sampled only. BGRA4 is what every device has: blue in the highest
    /// ones, seen through a view that gives its bits the names that they have in ARGB4.
    ARGB4,
    BGRA4,
    BC1, ///< from here on to be sampled only, in the order of openntc::bc::BlockFormat
    BC2,
    BC3,
    BC4,
    BC4S,
    BC5,
    BC5S,
    BC6,
    BC6S,
    BC7,
};

/// Bytes of a texel, or of a block of 4 x 4.
std::size_t GetTexelBytes(ImageFormat format) noexcept;

/// A 2D image of a Context, which must outlive it.
class Image {
public:
    struct Impl;
    Image() noexcept;
    explicit Image(std::unique_ptr<Impl> impl) noexcept;
    Image(Image&&) noexcept;
    Image& operator=(Image&&) noexcept;
    ~Image();

    std::uint32_t GetWidth() const noexcept;
    std::uint32_t GetHeight() const noexcept;
    std::uint32_t GetMips() const noexcept;
    std::uint32_t GetLayers() const noexcept; ///< of an array; 0: no array
    /// Of all texels or blocks of a mip, rows one after the other; of an array those of all layers.
    std::size_t GetBytes(std::uint32_t mip = 0) const noexcept;
    Impl* GetImpl() const noexcept { return impl_.get(); }

private:
    std::unique_ptr<Impl> impl_;
};

/// A rectangle of an image that is filled, in texels; of blocks only whole ones.
struct ImageRegion {
    std::uint32_t left = 0;
    std::uint32_t top = 0;
    std::uint32_t layer = 0; ///< of an array
    std::uint32_t width = 0;
    std::uint32_t height = 0;
};

/// Rows of a buffer, one after the other, that become a rectangle.
struct BufferToImage {
    std::uint64_t offset = 0; ///< bytes; a multiple of those of a texel or block, and of 4
    ImageRegion to;
};

/// A rectangle of an image that becomes one of another image.
struct ImageToImage {
    std::uint32_t left = 0; ///< in the source
    std::uint32_t top = 0;
    std::uint32_t layer = 0;
    ImageRegion to;
};

} // namespace openntc::harness
