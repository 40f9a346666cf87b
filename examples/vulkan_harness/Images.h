// SPDX-License-Identifier: MIT
// Images that compute shaders read and write as storage images.
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
};

/// Bytes of a texel.
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
    /// Of all texels, rows one after the other.
    std::size_t GetBytes() const noexcept;
    Impl* GetImpl() const noexcept { return impl_.get(); }

private:
    std::unique_ptr<Impl> impl_;
};

} // namespace openntc::harness
