// SPDX-License-Identifier: MIT
// Storage images. They stay in the general layout from their creation on.
#include "VulkanObjects.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <iterator>
#include <optional>

namespace openntc::harness {

namespace {

struct FormatRow {
    ImageFormat format;
    vk::Format vulkan;
    std::size_t bytes;
};

constexpr FormatRow kFormats[] = {
    {ImageFormat::R8, vk::Format::eR8Unorm, 1},
    {ImageFormat::RG8, vk::Format::eR8G8Unorm, 2},
    {ImageFormat::RGBA8, vk::Format::eR8G8B8A8Unorm, 4},
    {ImageFormat::R16, vk::Format::eR16Unorm, 2},
    {ImageFormat::RGBA16, vk::Format::eR16G16B16A16Unorm, 8},
    {ImageFormat::R16F, vk::Format::eR16Sfloat, 2},
    {ImageFormat::RGBA16F, vk::Format::eR16G16B16A16Sfloat, 8},
    {ImageFormat::R32F, vk::Format::eR32Sfloat, 4},
    {ImageFormat::RGBA32F, vk::Format::eR32G32B32A32Sfloat, 16},
    {ImageFormat::RG32UI, vk::Format::eR32G32Uint, 8},
    {ImageFormat::RGBA32UI, vk::Format::eR32G32B32A32Uint, 16},
    {ImageFormat::D32, vk::Format::eD32Sfloat, 4},
    {ImageFormat::ARGB4, vk::Format::eA4R4G4B4UnormPack16, 2},
    {ImageFormat::BGRA4, vk::Format::eB4G4R4A4UnormPack16, 2},
    {ImageFormat::BC1, vk::Format::eBc1RgbaUnormBlock, 8},
    {ImageFormat::BC2, vk::Format::eBc2UnormBlock, 16},
    {ImageFormat::BC3, vk::Format::eBc3UnormBlock, 16},
    {ImageFormat::BC4, vk::Format::eBc4UnormBlock, 8},
    {ImageFormat::BC4S, vk::Format::eBc4SnormBlock, 8},
    {ImageFormat::BC5, vk::Format::eBc5UnormBlock, 16},
    {ImageFormat::BC5S, vk::Format::eBc5SnormBlock, 16},
    {ImageFormat::BC6, vk::Format::eBc6HUfloatBlock, 16},
    {ImageFormat::BC6S, vk::Format::eBc6HSfloatBlock, 16},
    {ImageFormat::BC7, vk::Format::eBc7UnormBlock, 16},
};

const FormatRow& GetRow(ImageFormat format) {
    return kFormats[static_cast<std::size_t>(format)];
}

std::uint32_t GetMipSide(std::uint32_t side, std::uint32_t mip) {
    return std::max(side >> mip, 1u);
}

vk::BufferImageCopy MakeCopy(const Image::Impl& image, std::uint32_t mip) {
    return vk::BufferImageCopy(
        0, 0, 0, vk::ImageSubresourceLayers(GetAspect(image.format), mip, 0, std::max(image.layers, 1u)), {},
        {GetMipSide(image.width, mip), GetMipSide(image.height, mip), 1});
}

} // namespace

namespace {

/// Without a storage image's uses.
bool IsSampledOnly(ImageFormat format) {
    return IsOfBlocks(format) || format == ImageFormat::ARGB4 || format == ImageFormat::BGRA4;
}

vk::ComponentMapping GetComponents(ImageFormat format) {
    using Swizzle = vk::ComponentSwizzle;
    if (format == ImageFormat::BGRA4)
        return {Swizzle::eG, Swizzle::eR, Swizzle::eA, Swizzle::eB};
    return {};
}

} // namespace

bool IsOfBlocks(ImageFormat format) {
    return format >= ImageFormat::BC1;
}

vk::ImageAspectFlags GetAspect(ImageFormat format) {
    return format == ImageFormat::D32 ? vk::ImageAspectFlagBits::eDepth : vk::ImageAspectFlagBits::eColor;
}

vk::Format GetVulkanFormat(ImageFormat format) {
    return GetRow(format).vulkan;
}

std::size_t GetTexelBytes(ImageFormat format) noexcept {
    return GetRow(format).bytes;
}

Image::Image() noexcept = default;
Image::Image(std::unique_ptr<Impl> impl) noexcept : impl_(std::move(impl)) {}
Image::Image(Image&&) noexcept = default;
Image& Image::operator=(Image&&) noexcept = default;
Image::~Image() = default;
std::uint32_t Image::GetWidth() const noexcept {
    return impl_ ? impl_->width : 0;
}
std::uint32_t Image::GetHeight() const noexcept {
    return impl_ ? impl_->height : 0;
}
std::uint32_t Image::GetMips() const noexcept {
    return impl_ ? impl_->mips : 0;
}
std::uint32_t Image::GetLayers() const noexcept {
    return impl_ ? impl_->layers : 0;
}
std::size_t Image::GetBytes(std::uint32_t mip) const noexcept {
    if (!impl_ || mip >= impl_->mips)
        return 0;
    const std::size_t side = IsOfBlocks(impl_->format) ? 4 : 1;
    return std::max(impl_->layers, 1u) * ((GetMipSide(impl_->width, mip) + side - 1) / side) *
           ((GetMipSide(impl_->height, mip) + side - 1) / side) * GetTexelBytes(impl_->format);
}

namespace {

/// What images of a format are for, among what the device can do with it.
vk::ImageUsageFlags GetUsage(ImageFormat format, const vk::FormatProperties& properties) {
    vk::ImageUsageFlags usage = vk::ImageUsageFlagBits::eSampled | vk::ImageUsageFlagBits::eTransferSrc |
                                vk::ImageUsageFlagBits::eTransferDst;
    if (format == ImageFormat::D32)
        return usage | vk::ImageUsageFlagBits::eDepthStencilAttachment;
    if (IsSampledOnly(format))
        return usage;
    if (properties.optimalTilingFeatures & vk::FormatFeatureFlagBits::eColorAttachment)
        usage |= vk::ImageUsageFlagBits::eColorAttachment;
    return usage | vk::ImageUsageFlagBits::eStorage;
}

vk::FormatFeatureFlagBits GetNeededUse(ImageFormat format) {
    if (format == ImageFormat::D32)
        return vk::FormatFeatureFlagBits::eDepthStencilAttachment;
    if (IsOfBlocks(format))
        return vk::FormatFeatureFlagBits::eSampledImage;
    return IsSampledOnly(format) ? vk::FormatFeatureFlagBits::eSampledImageFilterLinear
                                 : vk::FormatFeatureFlagBits::eStorageImage;
}

/// Without which the device has no image of the format.
std::optional<Feature> GetNeededFeature(ImageFormat format) {
    if (format == ImageFormat::BGRA4)
        return std::nullopt;
    if (format == ImageFormat::ARGB4)
        return Feature::Formats4444;
    return IsOfBlocks(format) ? Feature::BlockCompression : Feature::StorageImages;
}

} // namespace

Expected<void> Context::Impl::CheckImage(ImageFormat format, std::uint32_t width,
                                         std::uint32_t height) const {
    const std::optional<Feature> needed = GetNeededFeature(format);
    if (needed && !info.features.Has(*needed))
        return Fail(Status::Unsupported, "device or feature absent: %s: %s", GetFeatureName(*needed),
                    info.features.GetAbsence(*needed).c_str());
    const std::uint32_t limit = physicalDevice.getProperties().limits.maxImageDimension2D;
    if (width < 1 || height < 1 || width > limit || height > limit)
        return Fail(Status::OutOfRange, "image: %u x %u: 1 ... %u", width, height, limit);
    const vk::Format vulkan = GetVulkanFormat(format);
    if (!(physicalDevice.getFormatProperties(vulkan).optimalTilingFeatures & GetNeededUse(format)))
        return Fail(Status::Unsupported, "device or feature absent: images of format %d: %s",
                    static_cast<int>(vulkan), info.name.c_str());
    return {};
}

void Context::Impl::MakeImage(Image::Impl& image) {
    const vk::Format vulkan = GetVulkanFormat(image.format);
    const std::uint32_t layers = std::max(image.layers, 1u);
    image.image = vk::raii::Image(
        device,
        vk::ImageCreateInfo({}, vk::ImageType::e2D, vulkan, {image.width, image.height, 1}, image.mips,
                            layers, vk::SampleCountFlagBits::e1, vk::ImageTiling::eOptimal,
                            GetUsage(image.format, physicalDevice.getFormatProperties(vulkan))));
    const vk::MemoryRequirements needs = image.image.getMemoryRequirements();
    std::optional<std::uint32_t> type;
    for (std::uint32_t i = 0; i < memory.memoryTypeCount; ++i) {
        const bool isLocal =
            static_cast<bool>(memory.memoryTypes[i].propertyFlags & vk::MemoryPropertyFlagBits::eDeviceLocal);
        if ((needs.memoryTypeBits >> i & 1u) != 0 && isLocal && !type)
            type = i;
    }
    if (!type)
        throw std::runtime_error("no memory type for an image");
    image.memory = Allocate(vk::MemoryAllocateInfo(needs.size, *type));
    image.image.bindMemory(*image.memory, 0);
    const vk::ImageSubresourceRange whole(GetAspect(image.format), 0, image.mips, 0, layers);
    const vk::ImageViewType kind = image.layers > 0 ? vk::ImageViewType::e2DArray : vk::ImageViewType::e2D;
    image.view = vk::raii::ImageView(
        device, vk::ImageViewCreateInfo({}, *image.image, kind, vulkan, GetComponents(image.format), whole));
    for (std::uint32_t mip = 0; mip < image.mips && image.layers == 0; ++mip)
        image.mipViews.emplace_back(device, vk::ImageViewCreateInfo({}, *image.image, vk::ImageViewType::e2D,
                                                                    vulkan, GetComponents(image.format),
                                                                    {GetAspect(image.format), mip, 1, 0, 1}));
    Submit([&](const vk::raii::CommandBuffer& target) {
        const vk::ImageMemoryBarrier toGeneral(
            {}, vk::AccessFlagBits::eTransferWrite, vk::ImageLayout::eUndefined, vk::ImageLayout::eGeneral,
            VK_QUEUE_FAMILY_IGNORED, VK_QUEUE_FAMILY_IGNORED, *image.image, whole);
        target.pipelineBarrier(vk::PipelineStageFlagBits::eTopOfPipe, vk::PipelineStageFlagBits::eTransfer,
                               {}, {}, {}, toGeneral);
        if (image.format == ImageFormat::D32)
            target.clearDepthStencilImage(*image.image, vk::ImageLayout::eGeneral,
                                          vk::ClearDepthStencilValue(), whole);
        else if (!IsOfBlocks(image.format)) // Vulkan clears no blocks
            target.clearColorImage(*image.image, vk::ImageLayout::eGeneral, vk::ClearColorValue(), whole);
    });
}

Expected<void> CheckMips(std::uint32_t width, std::uint32_t height, std::uint32_t mips) {
    if (mips < 1 || mips > static_cast<std::uint32_t>(std::bit_width(std::max(width, height))))
        return Fail(Status::OutOfRange, "image: %u mips of %u x %u", mips, width, height);
    return {};
}

Expected<Image> Context::CreateImage(ImageFormat format, std::uint32_t width, std::uint32_t height,
                                     std::uint32_t mips) {
    OPENNTC_CHECK(impl_->CheckImage(format, width, height));
    OPENNTC_CHECK(CheckMips(width, height, mips));
    return Guard("image", [&]() -> Expected<Image> {
        auto image = std::make_unique<Image::Impl>();
        image->format = format;
        image->width = width;
        image->height = height;
        image->mips = mips;
        impl_->MakeImage(*image);
        return Image(std::move(image));
    });
}

void Context::Impl::CopyToImage(vk::Buffer buffer, const Image::Impl& image, std::uint32_t mip) {
    Submit([&](const vk::raii::CommandBuffer& target) {
        const vk::MemoryBarrier before(vk::AccessFlagBits::eMemoryWrite,
                                       vk::AccessFlagBits::eTransferRead |
                                           vk::AccessFlagBits::eTransferWrite);
        target.pipelineBarrier(vk::PipelineStageFlagBits::eAllCommands, vk::PipelineStageFlagBits::eTransfer,
                               {}, before, {}, {});
        target.copyBufferToImage(buffer, *image.image, vk::ImageLayout::eGeneral, MakeCopy(image, mip));
        const vk::MemoryBarrier after(vk::AccessFlagBits::eTransferWrite,
                                      vk::AccessFlagBits::eMemoryRead | vk::AccessFlagBits::eMemoryWrite);
        target.pipelineBarrier(vk::PipelineStageFlagBits::eTransfer, vk::PipelineStageFlagBits::eAllCommands,
                               {}, after, {}, {});
    });
}

Expected<void> Context::Write(const Image& image, std::span<const std::byte> texels, std::uint32_t mip) {
    if (image.GetImpl() == nullptr || texels.empty() || texels.size() != image.GetBytes(mip))
        return Fail(Status::InvalidArgument, "image write: %zu bytes: mip %u has %zu", texels.size(), mip,
                    image.GetBytes(mip));
    return Guard("image write", [&]() -> Expected<void> {
        const auto staging = impl_->MakeBuffer(
            texels.size(), BufferKind::Storage, vk::BufferUsageFlagBits::eTransferSrc,
            vk::MemoryPropertyFlagBits::eHostVisible | vk::MemoryPropertyFlagBits::eHostCoherent);
        std::memcpy(staging->mapped, texels.data(), texels.size());
        impl_->CopyToImage(*staging->buffer, *image.GetImpl(), mip);
        return {};
    });
}

Expected<void> Context::Copy(const Buffer& buffer, const Image& image, std::uint32_t mip) {
    const std::size_t bytes = image.GetBytes(mip);
    if (bytes == 0 || buffer.GetSize() < bytes)
        return Fail(Status::OutOfRange, "image copy: %llu bytes: mip %u has %zu",
                    static_cast<unsigned long long>(buffer.GetSize()), mip, bytes);
    return Guard("image copy", [&]() -> Expected<void> {
        impl_->CopyToImage(*buffer.GetImpl()->buffer, *image.GetImpl(), mip);
        return {};
    });
}

Expected<void> Context::Read(const Image& image, std::span<std::byte> texels, std::uint32_t mip) {
    if (image.GetImpl() == nullptr || texels.empty() || texels.size() != image.GetBytes(mip))
        return Fail(Status::InvalidArgument, "image read: %zu bytes: mip %u has %zu", texels.size(), mip,
                    image.GetBytes(mip));
    return Guard("image read", [&]() -> Expected<void> {
        const auto staging = impl_->MakeBuffer(
            texels.size(), BufferKind::Storage, vk::BufferUsageFlagBits::eTransferDst,
            vk::MemoryPropertyFlagBits::eHostVisible | vk::MemoryPropertyFlagBits::eHostCoherent);
        impl_->Submit([&](const vk::raii::CommandBuffer& target) {
            const vk::MemoryBarrier before(vk::AccessFlagBits::eMemoryWrite,
                                           vk::AccessFlagBits::eTransferRead);
            target.pipelineBarrier(vk::PipelineStageFlagBits::eAllCommands,
                                   vk::PipelineStageFlagBits::eTransfer, {}, before, {}, {});
            target.copyImageToBuffer(*image.GetImpl()->image, vk::ImageLayout::eGeneral, *staging->buffer,
                                     MakeCopy(*image.GetImpl(), mip));
            const vk::MemoryBarrier after(vk::AccessFlagBits::eTransferWrite, vk::AccessFlagBits::eHostRead);
            target.pipelineBarrier(vk::PipelineStageFlagBits::eTransfer, vk::PipelineStageFlagBits::eHost, {},
                                   after, {}, {});
        });
        std::memcpy(texels.data(), staging->mapped, texels.size());
        return {};
    });
}

} // namespace openntc::harness
