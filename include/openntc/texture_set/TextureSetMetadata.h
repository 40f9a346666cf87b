// SPDX-License-Identifier: MIT
// Stability: stable
// Everything about a texture set except its latents: read once, checked, immutable.
#pragma once

#include "openntc/core/Allocator.h"
#include "openntc/core/Stream.h"
#include "openntc/texture_set/TextureSetLoader.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// What a texture set file says, with its networks' weights. Immutable and safe to use from many threads at
/// once; move- only. The stream is needed again only for the latents (GetStreamRangeForLatents says where
/// they are).
class TextureSetMetadata {
public:
    /// Reads files of generations 1 to 3 (LibNTC 0.5 – 0.9) from the start of the stream. Every number that
    /// later code indexes or allocates with has been checked when this succeeds. Errors: FileUnrecognized
    /// (not such a file, or contradictory), OutOfRange (sizes and shapes beyond the documented limits),
    /// IOError, OutOfMemory.
    static Expected<TextureSetMetadata> Load(Stream& stream,
                                             Allocator& allocator = GetDefaultAllocator()) noexcept {
        Expected<detail::TextureSetContents> contents = detail::LoadTextureSet(stream, allocator);
        if (!contents)
            return PassError(contents);
        return TextureSetMetadata(std::move(*contents));
    }

    const TextureSetDesc& GetDesc() const noexcept { return contents_.desc; }

    /// The generation of the file: 1 is LibNTC 0.5 – 0.7.x, 2 is 0.8, 3 is 0.9.
    int GetGeneration() const noexcept { return static_cast<int>(contents_.document.schemaVersion); }

    /// gridSizeScale is derived from the sizes of image and latents; it may lie outside 2 … 8 (1 × N images)
    /// and is informational: decoding does not use it. Of generations 2 and 3 see MakeLayeredShape.
    const LatentShape& GetLatentShape() const noexcept { return contents_.latentShape; }

    /// NTC_NETWORK_SMALL … NTC_NETWORK_XLARGE, or that of generation 2 or 3.
    int GetNetworkVersion() const noexcept { return contents_.weights.networkVersion; }

    std::span<const Texture> GetTextures() const noexcept { return contents_.textures.AsSpan(); }

    /// Encoding of a network output before any shuffling; Linear for channels that the set does not have.
    ColorSpace GetChannelStorageColorSpace(int channel) const noexcept {
        if (channel < 0 || channel >= NTC_MAX_CHANNELS)
            return ColorSpace::Linear;
        return static_cast<ColorSpace>((contents_.weights.channelColorSpaces >> (2 * channel)) & 3u);
    }

    /// Bit c: channel c belongs to a texture. Other outputs are untrained.
    std::uint32_t GetValidChannelMask() const noexcept { return contents_.weights.validChannelMask; }

    /// For code that handles the grids of generation 1 only; `what` names it. Errors: Unsupported.
    Expected<void> CheckHasGrids(const char* what) const noexcept {
        if (GetGeneration() == 1)
            return {};
        return Fail(Status::Unsupported, "%s: of a set of generation %d: only generation 1 has them", what,
                    GetGeneration());
    }

    /// 1 … 8 latent images of generation 1, finest first; none in others.
    std::span<const LatentImage> GetLatentImages() const noexcept {
        return {contents_.latentImages.data(), static_cast<std::size_t>(contents_.latentImageCount)};
    }

    /// 2 … 8 latent mips of generations 2 and 3, finest first; none in generation 1.
    std::span<const LatentMip> GetLatentMips() const noexcept {
        return {contents_.latentMips.data(), static_cast<std::size_t>(contents_.latentMipCount)};
    }

    /// One entry per mip.
    std::span<const ColorMip> GetColorMips() const noexcept {
        return {contents_.colorMips.data(), static_cast<std::size_t>(contents_.desc.mips)};
    }

    /// The run of mips around `mip` that its latent image serves. Errors: OutOfRange.
    Expected<MipRange> GetFusedMipLevels(int mip) const noexcept;

    /// The first run of mips that a latent image serves, or a latent mip as the finer of two. Errors:
    /// OutOfRange, also if it serves none.
    Expected<MipRange> GetMipLevelsForLatentImage(int image) const noexcept;

    /// The smallest byte range that holds all latents of mips firstMip … firstMip + numMips - 1 and of every
    /// latent image between theirs, as the file has them (in generations 2 and 3 ReadLatents makes what
    /// decoders read). Errors: OutOfRange.
    Expected<StreamRange> GetStreamRangeForLatents(int firstMip, int numMips) const noexcept;

    /// A run of mips that the set has. Errors: OutOfRange.
    Expected<void> CheckMips(int firstMip, int numMips) const noexcept;

    /// The latent images or latent mips that serve mips firstMip … firstMip + numMips - 1, and those between
    /// them. The mips must have passed CheckMips.
    MipRange GetLatentsOfMips(int firstMip, int numMips) const noexcept;

    /// True for the generic forms that the file holds. Cooperative-vector forms are made on a GPU; not
    /// supported yet.
    bool IsInferenceWeightTypeSupported(InferenceWeightType type) const noexcept {
        return !contents_.weights.Get(type).empty();
    }

    /// The weights as stored in the file (biases as integers), with channel mask and colour spaces.
    const InferenceWeights& GetWeights() const noexcept { return contents_.weights; }

    /// The bytes to upload. Errors: Unsupported if the set has no weights of this form.
    Expected<std::span<const std::byte>> GetInferenceWeights(InferenceWeightType type) const noexcept {
        const std::span<const std::byte> bytes = contents_.weights.Get(type);
        if (bytes.empty())
            return Fail(Status::Unsupported, "weightType: %s: the set has no such weights",
                        InferenceWeightTypeToString(type));
        return bytes;
    }

    /// What the file said, for display.
    const container::Document& GetDocument() const noexcept { return contents_.document; }

private:
    explicit TextureSetMetadata(detail::TextureSetContents&& contents) noexcept
        : contents_(std::move(contents)) {}

    detail::TextureSetContents contents_;
};

inline Expected<MipRange> TextureSetMetadata::GetFusedMipLevels(int mip) const noexcept {
    const std::span<const ColorMip> mips = GetColorMips();
    if (mip < 0 || mip >= contents_.desc.mips)
        return Fail(Status::OutOfRange, "mip: %d: must be 0 … %d", mip, contents_.desc.mips - 1);
    const std::size_t index = static_cast<std::size_t>(mip);
    std::size_t first = index;
    std::size_t last = index;
    while (first > 0 && mips[first - 1].neuralMip == mips[index].neuralMip)
        --first;
    while (last + 1 < mips.size() && mips[last + 1].neuralMip == mips[index].neuralMip)
        ++last;
    return MipRange{static_cast<int>(first), static_cast<int>(last)};
}

inline Expected<MipRange> TextureSetMetadata::GetMipLevelsForLatentImage(int image) const noexcept {
    const int images = std::max(contents_.latentImageCount, contents_.latentMipCount); // one of them is 0
    if (image < 0 || image >= images)
        return Fail(Status::OutOfRange, "latent image: %d: must be 0 … %d", image, images - 1);
    for (int mip = 0; mip < contents_.desc.mips; ++mip) {
        if (contents_.colorMips[static_cast<std::size_t>(mip)].neuralMip == image)
            return GetFusedMipLevels(mip);
    }
    return Fail(Status::OutOfRange, "latent image: %d: serves no mip", image);
}

inline MipRange TextureSetMetadata::GetLatentsOfMips(int firstMip, int numMips) const noexcept {
    MipRange images{NTC_MAX_NEURAL_MIPS, 0};
    for (const ColorMip& mip :
         GetColorMips().subspan(static_cast<std::size_t>(firstMip), static_cast<std::size_t>(numMips))) {
        images.first = std::min(images.first, mip.neuralMip);
        images.last = std::max(images.last, mip.neuralMip);
    }
    if (GetGeneration() > 1)
        ++images.last; // a mip is decoded from two
    return images;
}

inline Expected<void> TextureSetMetadata::CheckMips(int firstMip, int numMips) const noexcept {
    const int mips = contents_.desc.mips;
    if (firstMip < 0 || firstMip >= mips)
        return Fail(Status::OutOfRange, "firstMip: %d: must be 0 … %d", firstMip, mips - 1);
    if (numMips < 1 || numMips > mips - firstMip)
        return Fail(Status::OutOfRange, "numMips: %d: must be 1 … %d", numMips, mips - firstMip);
    return {};
}

inline Expected<StreamRange> TextureSetMetadata::GetStreamRangeForLatents(int firstMip,
                                                                          int numMips) const noexcept {
    OPENNTC_CHECK(CheckMips(firstMip, numMips));
    const MipRange images = GetLatentsOfMips(firstMip, numMips);
    std::uint64_t begin = ~std::uint64_t{0};
    std::uint64_t end = 0;
    const auto include = [&](std::uint64_t offset, std::uint64_t size) {
        begin = std::min(begin, offset);
        end = std::max(end, offset + size); // inside the stream: cannot wrap
    };
    for (int i = images.first; i <= images.last; ++i) {
        if (GetGeneration() == 1) {
            const LatentImage& image = contents_.latentImages[static_cast<std::size_t>(i)];
            include(image.highRes.offset, image.highRes.size);
            include(image.lowRes.offset, image.lowRes.size);
            continue;
        }
        const LatentMip& mip = contents_.latentMips[static_cast<std::size_t>(i)];
        for (std::size_t layer = 0; layer < static_cast<std::size_t>(mip.layers); ++layer)
            include(mip.layerData[layer].range.offset, mip.layerData[layer].range.size);
    }
    return StreamRange{begin, end - begin};
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
