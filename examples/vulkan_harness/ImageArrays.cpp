// SPDX-License-Identifier: MIT
// Arrays of layers, and rectangles that are copied into images.
#include "VulkanObjects.h"

#include <algorithm>

namespace openntc::harness {

namespace {

vk::ImageSubresourceLayers GetLayer(const Image::Impl& image, std::uint32_t layer) {
    return {GetAspect(image.format), 0, layer, 1};
}

bool IsInside(const Image::Impl& image, std::uint64_t left, std::uint64_t top, std::uint32_t layer,
              const ImageRegion& size) {
    const std::uint32_t side = IsOfBlocks(image.format) ? 4 : 1;
    return layer < std::max(image.layers, 1u) && size.width > 0 && size.height > 0 && left % side == 0 &&
           top % side == 0 && size.width % side == 0 && size.height % side == 0 &&
           left + size.width <= image.width && top + size.height <= image.height;
}

Expected<void> CheckRegion(const Image& image, const ImageRegion& region) {
    if (image.GetImpl() == nullptr ||
        !IsInside(*image.GetImpl(), region.left, region.top, region.layer, region))
        return Fail(Status::OutOfRange, "image copy: %u x %u at %u, %u of layer %u: not inside the image",
                    region.width, region.height, region.left, region.top, region.layer);
    return {};
}

std::uint64_t GetRegionBytes(ImageFormat format, const ImageRegion& region) {
    const std::uint64_t texels = std::uint64_t{region.width} * region.height;
    return texels / (IsOfBlocks(format) ? 16 : 1) * GetTexelBytes(format);
}

vk::Offset3D ToOffset(std::uint32_t left, std::uint32_t top) {
    return {static_cast<std::int32_t>(left), static_cast<std::int32_t>(top), 0};
}

} // namespace

Expected<Image> Context::CreateImageArray(ImageFormat format, std::uint32_t width, std::uint32_t height,
                                          std::uint32_t layers, std::uint32_t mips) {
    OPENNTC_CHECK(impl_->CheckImage(format, width, height));
    OPENNTC_CHECK(CheckMips(width, height, mips));
    const std::uint32_t most = impl_->physicalDevice.getProperties().limits.maxImageArrayLayers;
    if (layers < 1 || layers > most)
        return Fail(Status::OutOfRange, "image: %u layers: 1 ... %u", layers, most);
    return Guard("image", [&]() -> Expected<Image> {
        auto image = std::make_unique<Image::Impl>();
        image->format = format;
        image->width = width;
        image->height = height;
        image->layers = layers;
        image->mips = mips;
        impl_->MakeImage(*image);
        return Image(std::move(image));
    });
}

Expected<void> Context::Copy(const Buffer& buffer, const Image& image,
                             std::span<const BufferToImage> regions) {
    std::vector<vk::BufferImageCopy> copies;
    for (const BufferToImage& region : regions) {
        OPENNTC_CHECK(CheckRegion(image, region.to));
        const Image::Impl& target = *image.GetImpl();
        const std::uint64_t bytes = GetRegionBytes(target.format, region.to);
        if (region.offset % std::max<std::size_t>(GetTexelBytes(target.format), 4) != 0 ||
            bytes > buffer.GetSize() || region.offset > buffer.GetSize() - bytes)
            return Fail(Status::OutOfRange, "image copy: %llu bytes from %llu on: the buffer has %llu",
                        static_cast<unsigned long long>(bytes),
                        static_cast<unsigned long long>(region.offset),
                        static_cast<unsigned long long>(buffer.GetSize()));
        copies.emplace_back(region.offset, 0, 0, GetLayer(target, region.to.layer),
                            ToOffset(region.to.left, region.to.top),
                            vk::Extent3D(region.to.width, region.to.height, 1));
    }
    if (copies.empty())
        return {};
    return Guard("image copy", [&]() -> Expected<void> {
        impl_->Submit([&](const vk::raii::CommandBuffer& target) {
            RecordCopies(target, [&] {
                target.copyBufferToImage(*buffer.GetImpl()->buffer, *image.GetImpl()->image,
                                         vk::ImageLayout::eGeneral, copies);
            });
        });
        return {};
    });
}

Expected<void> Context::Copy(const Image& from, const Image& image, std::span<const ImageToImage> regions) {
    std::vector<vk::ImageCopy> copies;
    for (const ImageToImage& region : regions) {
        OPENNTC_CHECK(CheckRegion(image, region.to));
        OPENNTC_CHECK(
            CheckRegion(from, {region.left, region.top, region.layer, region.to.width, region.to.height}));
        if (from.GetImpl()->format != image.GetImpl()->format)
            return Fail(Status::InvalidArgument, "image copy: images of two formats");
        copies.emplace_back(GetLayer(*from.GetImpl(), region.layer), ToOffset(region.left, region.top),
                            GetLayer(*image.GetImpl(), region.to.layer),
                            ToOffset(region.to.left, region.to.top),
                            vk::Extent3D(region.to.width, region.to.height, 1));
    }
    if (copies.empty())
        return {};
    return Guard("image copy", [&]() -> Expected<void> {
        impl_->Submit([&](const vk::raii::CommandBuffer& target) {
            RecordCopies(target, [&] {
                target.copyImage(*from.GetImpl()->image, vk::ImageLayout::eGeneral, *image.GetImpl()->image,
                                 vk::ImageLayout::eGeneral, copies);
            });
        });
        return {};
    });
}

} // namespace openntc::harness
