// SPDX-License-Identifier: MIT
// Stability: stable
// A texture set being put together for writing: the document and the bytes of its views, in the form of the
// LibNTC of its generation: 0.7.2, 0.8 or 0.9.2. Call order gives the order of views: networks (Int8, then
// FP8), textures, latent images or latent mips, BC7 modes.
#pragma once

#include "openntc/container/GDeflateEncoder.h"
#include "openntc/container/Writer.h"
#include "openntc/core/Allocator.h"
#include "openntc/core/Crc32.h"
#include "openntc/texture_set/InferenceWeights.h"
#include "openntc/texture_set/LatentShape.h"
#include "openntc/texture_set/MipChain.h"
#include "openntc/texture_set/TextureSetTypes.h"

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// What of a set of generation 3 is compressed (GDeflate). A view that does not shrink enough is stored as it
/// is.
struct CompressionOptions {
    bool latents = false;
    bool blockModes = false;
    int level = container::kDefaultGDeflateLevel; ///< 1 … 12
    float largestRatio = 0.95f; ///< compressed by uncompressed bytes: from this on it is not worth it
};

class WritableTextureSet {
public:
    explicit WritableTextureSet(Allocator& allocator = GetDefaultAllocator()) noexcept
        : document_(), bytes_(allocator), views_(allocator), compressed_(allocator) {}

    /// Sizes, shape, channels and the generation, 1 to 3. Odd channel counts become even, as LibNTC writes
    /// them; the channel added is Linear and belongs to no texture. `channelColorSpaces` holds 2 bits per
    /// channel. Errors: OutOfRange.
    Expected<void> SetDescription(const TextureSetDesc& desc, const LatentShape& shape,
                                  std::uint32_t channelColorSpaces, int generation = 1) noexcept;

    /// For what is added from now on. Errors: InvalidArgument if the set is not of generation 3.
    Expected<void> SetCompression(const CompressionOptions& options) noexcept;

    /// Adds the weights of one storage form; none in `weights` is no error. Errors: InvalidArgument,
    /// OutOfMemory.
    Expected<void> AddNetwork(const InferenceWeights& weights, InferenceWeightType type) noexcept;

    /// Adds a texture with its BC7 statistics, which generation 3 does not have: AddBlockModes. Errors:
    /// OutOfMemory.
    Expected<void> AddTexture(const Texture& texture) noexcept;

    /// Adds a latent image of generation 1; widths and heights of the grids are used, the latents are packed
    /// words (GetLatentGridBytes). Errors: InvalidArgument for data of another size, OutOfMemory.
    Expected<void> AddLatentImage(const LatentImage& image, std::span<const std::byte> highRes,
                                  std::span<const std::byte> lowRes) noexcept;

    /// Adds a latent mip of generation 2 or 3: its layers [layer][y][x] in texels of 16 bits. Errors:
    /// InvalidArgument for data of another size, OutOfMemory.
    Expected<void> AddLatentMip(int width, int height, std::span<const std::byte> layers) noexcept;

    /// The same from the bytes of another file, a span for each layer, as it stores them (generation 3).
    Expected<void> AddStoredLatentMip(const LatentMip& mip,
                                      std::span<const std::span<const std::byte>> layers) noexcept;

    /// Adds modes and partitions of the BC7 blocks of a mip to a texture of a set of generation 3
    /// (PackBlockModes), after all latents. Errors: InvalidArgument, OutOfMemory.
    Expected<void> AddBlockModes(std::size_t texture, int mip, std::span<const std::byte> packed) noexcept;

    /// The same from the bytes of another file, as it stores them.
    Expected<void> AddStoredBlockModes(std::size_t texture, const BlockModeBuffer& modes,
                                       std::span<const std::byte> stored) noexcept;

    /// Adds the next mip. Errors: OutOfMemory.
    Expected<void> AddColorMip(const ColorMip& mip) noexcept;

    /// The document so far; views are laid out when writing.
    container::Document& GetDocument() noexcept { return document_; }

    /// Writes the complete file from position 0 of the stream. Errors: those of container::WriteContainer.
    Expected<void> Write(Stream& destination) noexcept;

private:
    struct Extent {
        std::size_t offset;
        std::size_t size;
    };

    Expected<std::uint32_t> AddView(std::span<const std::byte> data) noexcept;
    Expected<std::uint32_t> AddCompressibleView(std::span<const std::byte> data, bool isWanted) noexcept;
    Expected<std::uint32_t> AddStoredView(const StoredData& about,
                                          std::span<const std::byte> stored) noexcept;
    Expected<void> AddLatentMipRecord(container::LatentImageRecord& record, int width, int height) noexcept;
    Expected<void> CheckBlockModes(std::size_t texture, int mip) const noexcept;

    container::Document document_;
    Array<std::byte> bytes_; // of all views
    Array<Extent> views_;    // in bytes_
    CompressionOptions compression_;
    Array<std::byte> compressed_; // of one view
};

inline Expected<std::uint32_t> WritableTextureSet::AddView(std::span<const std::byte> data) noexcept {
    const std::size_t offset = bytes_.size();
    if (data.size() > std::numeric_limits<std::size_t>::max() / 4 - offset)
        return Fail(Status::OutOfMemory, "views: %zu bytes: address space", data.size());
    const std::size_t size = offset + data.size();
    OPENNTC_CHECK(
        bytes_.Reserve(std::max(size, 2 * offset))); // may exceed the need: growth stays linear in total
    OPENNTC_CHECK(bytes_.Resize(size));
    if (!data.empty())
        std::memcpy(bytes_.data() + offset, data.data(), data.size());
    OPENNTC_CHECK(views_.PushBack({offset, data.size()}));
    OPENNTC_CHECK(document_.views.PushBack({}));
    return static_cast<std::uint32_t>(views_.size() - 1);
}

inline Expected<void> WritableTextureSet::SetCompression(const CompressionOptions& options) noexcept {
    if (document_.schemaVersion < 3 && (options.latents || options.blockModes))
        return Fail(Status::InvalidArgument, "compression: of a set of generation %u: needs generation 3",
                    document_.schemaVersion);
    compression_ = options;
    return {};
}

inline Expected<std::uint32_t> WritableTextureSet::AddCompressibleView(std::span<const std::byte> data,
                                                                       bool isWanted) noexcept {
    if (!isWanted || data.empty())
        return AddView(data);
    container::GDeflateEncoder encoder(compression_.level, bytes_.GetAllocator());
    OPENNTC_CHECK(encoder.Compress(data, compressed_));
    const float ratio = static_cast<float>(compressed_.size()) / static_cast<float>(data.size());
    if (!(ratio < compression_.largestRatio))
        return AddView(data);
    return AddStoredView({{}, data.size(), true, Crc32(data)}, std::as_const(compressed_).AsSpan());
}

inline Expected<std::uint32_t> WritableTextureSet::AddStoredView(const StoredData& about,
                                                                 std::span<const std::byte> stored) noexcept {
    OPENNTC_ASSIGN(const std::uint32_t view, AddView(stored));
    container::BufferView& record = document_.views[view];
    if (about.isCompressed) {
        record.compression = container::Compression::GDeflate;
        record.uncompressedSize = about.bytes;
    }
    if (about.crc32 != 0)
        record.crc32 = about.crc32;
    return view;
}

inline Expected<void> WritableTextureSet::SetDescription(const TextureSetDesc& desc, const LatentShape& shape,
                                                         std::uint32_t channelColorSpaces,
                                                         int generation) noexcept {
    OPENNTC_CHECK(ValidateTextureSetDesc(desc));
    if (generation < 1 || generation > 3)
        return Fail(Status::OutOfRange, "generation: %d: must be 1 … 3", generation);
    OPENNTC_CHECK(generation == 1 ? detail::ValidateLatentEncoding(shape, NTC_NETWORK_UNKNOWN)
                                  : detail::ValidateLayeredEncoding(shape));
    document_.schemaVersion = static_cast<std::uint32_t>(generation);
    document_.width = static_cast<std::uint32_t>(desc.width);
    document_.height = static_cast<std::uint32_t>(desc.height);
    document_.numChannels = static_cast<std::uint32_t>(desc.channels + desc.channels % 2);
    document_.numColorMips = static_cast<std::uint32_t>(desc.mips);
    document_.latentShape = container::LatentShapeRecord{
        static_cast<std::uint32_t>(shape.highResFeatures), static_cast<std::uint32_t>(shape.highResQuantBits),
        static_cast<std::uint32_t>(shape.lowResFeatures), static_cast<std::uint32_t>(shape.lowResQuantBits),
        static_cast<std::uint32_t>(shape.highResFeatures)};
    document_.channels.clear();
    for (int c = 0; c < static_cast<int>(document_.numChannels); ++c) {
        container::ChannelRecord record;
        const std::uint32_t space = c < desc.channels ? (channelColorSpaces >> (2 * c)) & 3u : 0u;
        if (space > static_cast<std::uint32_t>(ColorSpace::HLG))
            return Fail(Status::OutOfRange, "channels[%d].colorSpace: %u: must be 0 … 2", c, space);
        record.colorSpace = static_cast<ColorSpace>(space);
        OPENNTC_CHECK(document_.channels.PushBack(record));
    }
    return {};
}

inline Expected<void> WritableTextureSet::AddNetwork(const InferenceWeights& weights,
                                                     InferenceWeightType type) noexcept {
    using container::MlpDataType;
    const std::span<const std::byte> buffer = weights.Get(type);
    if (buffer.empty())
        return {};
    const bool isFP8 = type == InferenceWeightType::GenericFP8;
    const NetworkDescription network = GetNetworkDescription(weights.networkVersion);
    if (GetGeneration(weights.networkVersion) != static_cast<int>(document_.schemaVersion))
        return Fail(Status::InvalidArgument, "weights: of a %s network: the set is of generation %u",
                    GetNetworkName(weights.networkVersion), document_.schemaVersion);
    if (buffer.size() != static_cast<std::size_t>(isFP8 ? network.fp8Bytes : network.int8Bytes))
        return Fail(Status::InvalidArgument, "weights: %zu bytes: not a %s network", buffer.size(),
                    GetNetworkName(weights.networkVersion));
    const auto addPart = [&](int offset, int bytes) noexcept {
        return AddView(buffer.subspan(static_cast<std::size_t>(offset), static_cast<std::size_t>(bytes)));
    };
    container::Mlp mlp;
    mlp.activation = container::MlpActivation::HGELUClamp;
    mlp.weightLayout = container::MatrixLayout::RowMajor;
    for (std::size_t i = 0; i < kNetworkLayers; ++i) {
        const bool isE4M3 = isFP8 && i < 3;
        const int outputs = network.outputs[i];
        container::MlpLayer layer;
        layer.inputChannels = static_cast<std::uint32_t>(network.inputs[i]);
        layer.outputChannels = static_cast<std::uint32_t>(outputs);
        layer.weightType = isE4M3 ? MlpDataType::FloatE4M3 : MlpDataType::Int8;
        OPENNTC_ASSIGN(layer.weightView, addPart(network.weightOffsets[i], network.inputs[i] * outputs));
        if (isE4M3) {
            layer.biasType = MlpDataType::Float16;
            OPENNTC_ASSIGN(layer.biasView, addPart(network.fp8BiasOffsets[i], 2 * outputs));
        } else {
            layer.scaleType = MlpDataType::Float32;
            layer.biasType = MlpDataType::Int32;
            const int scales = isFP8 ? network.fp8ScaleOffset : network.int8ScaleOffsets[i];
            const int biases = isFP8 ? network.fp8BiasOffsets[i] : network.int8BiasOffsets[i];
            OPENNTC_ASSIGN(layer.scaleView, addPart(scales, 4 * outputs));
            OPENNTC_ASSIGN(layer.biasView, addPart(biases, 4 * outputs));
        }
        OPENNTC_CHECK(mlp.layers.PushBack(layer));
    }
    // LibNTC 0.7 puts the Int8 network into the old slot, where its version 0.5 looks for it.
    if (isFP8 || document_.schemaVersion > 1)
        return document_.mlpVersions.PushBack(std::move(mlp));
    document_.mlp = std::move(mlp);
    return {};
}

inline Expected<void> WritableTextureSet::AddTexture(const Texture& texture) noexcept {
    container::TextureRecord record;
    OPENNTC_CHECK(record.name.Assign(texture.name));
    record.firstChannel = static_cast<std::uint32_t>(texture.firstChannel);
    record.numChannels = static_cast<std::uint32_t>(texture.numChannels);
    record.channelFormat = texture.channelFormat;
    record.rgbColorSpace = texture.rgbColorSpace;
    record.alphaColorSpace = texture.alphaColorSpace;
    record.bcFormat = texture.bcFormat;
    record.bcQuality = static_cast<std::uint32_t>(texture.bcQuality);
    if (!texture.bcModes.empty() && document_.schemaVersion < 3) {
        // The struct in memory is the record of the file on little-endian machines.
        static_assert(sizeof(BlockCompressionMode) == 4 && std::endian::native == std::endian::little);
        OPENNTC_ASSIGN(record.bcAccelerationDataView, AddView(std::as_bytes(texture.bcModes)));
    }
    return document_.textures.PushBack(std::move(record));
}

inline Expected<void> WritableTextureSet::AddLatentImage(const LatentImage& image,
                                                         std::span<const std::byte> highRes,
                                                         std::span<const std::byte> lowRes) noexcept {
    if (!document_.latentShape)
        return Fail(Status::InvalidArgument, "latentShape: absent: call SetDescription first");
    const container::LatentShapeRecord& shape = *document_.latentShape;
    const auto isOfSize = [](const LatentGrid& grid, std::uint32_t features, std::uint32_t bits,
                             std::size_t bytes) {
        return bytes == GetLatentGridBytes(grid.width, grid.height, static_cast<int>(features),
                                           static_cast<int>(bits));
    };
    if (!isOfSize(image.highRes, shape.highResFeatures, shape.highResQuantBits, highRes.size()) ||
        !isOfSize(image.lowRes, shape.lowResFeatures, shape.lowResQuantBits, lowRes.size()))
        return Fail(Status::InvalidArgument, "latents[%zu]: %zu and %zu bytes: do not fit the grids",
                    document_.latents.size(), highRes.size(), lowRes.size());
    container::LatentImageRecord record;
    record.highResWidth = static_cast<std::uint32_t>(image.highRes.width);
    record.highResHeight = static_cast<std::uint32_t>(image.highRes.height);
    record.lowResWidth = static_cast<std::uint32_t>(image.lowRes.width);
    record.lowResHeight = static_cast<std::uint32_t>(image.lowRes.height);
    record.highResBitsPerPixel = shape.highResFeatures * shape.highResQuantBits;
    record.lowResBitsPerPixel = shape.lowResFeatures * shape.lowResQuantBits;
    OPENNTC_ASSIGN(record.highResView, AddView(highRes));
    OPENNTC_ASSIGN(record.lowResView, AddView(lowRes));
    return document_.latents.PushBack(record);
}

/// Fills a record but for its views, and checks that the set has layers.
inline Expected<void> WritableTextureSet::AddLatentMipRecord(container::LatentImageRecord& record, int width,
                                                             int height) noexcept {
    if (!document_.latentShape || document_.schemaVersion == 1)
        return Fail(Status::InvalidArgument,
                    "latentShape: of no generation with latent mips: call SetDescription");
    record.width = static_cast<std::uint32_t>(width);
    record.height = static_cast<std::uint32_t>(height);
    record.arraySize = document_.latentShape->numFeatures / kFeatureStep;
    record.layerViews.count = record.arraySize;
    return {};
}

inline Expected<void> WritableTextureSet::AddLatentMip(int width, int height,
                                                       std::span<const std::byte> layers) noexcept {
    container::LatentImageRecord record;
    OPENNTC_CHECK(AddLatentMipRecord(record, width, height));
    const std::size_t layerBytes = std::size_t{2} * record.width * record.height;
    if (layers.size() != layerBytes * record.arraySize)
        return Fail(Status::InvalidArgument, "latents[%zu]: %zu bytes: %d x %d in %u layers have %zu",
                    document_.latents.size(), layers.size(), width, height, record.arraySize,
                    layerBytes * record.arraySize);
    if (document_.schemaVersion == 2) {
        OPENNTC_ASSIGN(record.view, AddView(layers));
        return document_.latents.PushBack(record);
    }
    for (std::size_t i = 0; i < record.arraySize; ++i) {
        OPENNTC_ASSIGN(record.layerViews.views[i],
                       AddCompressibleView(layers.subspan(i * layerBytes, layerBytes), compression_.latents));
    }
    return document_.latents.PushBack(record);
}

inline Expected<void>
WritableTextureSet::AddStoredLatentMip(const LatentMip& mip,
                                       std::span<const std::span<const std::byte>> layers) noexcept {
    container::LatentImageRecord record;
    OPENNTC_CHECK(AddLatentMipRecord(record, mip.width, mip.height));
    if (document_.schemaVersion != 3 || layers.size() != record.arraySize)
        return Fail(Status::InvalidArgument, "latents[%zu]: %zu layers: must be %u, of generation 3",
                    document_.latents.size(), layers.size(), record.arraySize);
    for (std::size_t i = 0; i < layers.size(); ++i) {
        OPENNTC_ASSIGN(record.layerViews.views[i], AddStoredView(mip.layerData[i], layers[i]));
    }
    return document_.latents.PushBack(record);
}

inline Expected<void> WritableTextureSet::CheckBlockModes(std::size_t texture, int mip) const noexcept {
    if (document_.schemaVersion != 3)
        return Fail(Status::InvalidArgument, "bcModeBuffers: of a set of generation %u: needs generation 3",
                    document_.schemaVersion);
    if (texture >= document_.textures.size())
        return Fail(Status::InvalidArgument, "bcModeBuffers: texture %zu: the set has %zu", texture,
                    document_.textures.size());
    if (mip < 0 || mip >= static_cast<int>(document_.numColorMips))
        return Fail(Status::InvalidArgument, "bcModeBuffers: mip %d: the set has %u", mip,
                    document_.numColorMips);
    return {};
}

inline Expected<void> WritableTextureSet::AddBlockModes(std::size_t texture, int mip,
                                                        std::span<const std::byte> packed) noexcept {
    OPENNTC_CHECK(CheckBlockModes(texture, mip));
    container::BcModeBufferRecord record;
    record.mipLevel = static_cast<std::uint32_t>(mip);
    OPENNTC_ASSIGN(record.view, AddCompressibleView(packed, compression_.blockModes));
    return document_.textures[texture].bcModeBuffers.PushBack(record);
}

inline Expected<void> WritableTextureSet::AddStoredBlockModes(std::size_t texture,
                                                              const BlockModeBuffer& modes,
                                                              std::span<const std::byte> stored) noexcept {
    OPENNTC_CHECK(CheckBlockModes(texture, modes.mip));
    container::BcModeBufferRecord record;
    record.mipLevel = static_cast<std::uint32_t>(modes.mip);
    OPENNTC_ASSIGN(record.view, AddStoredView(modes.data, stored));
    return document_.textures[texture].bcModeBuffers.PushBack(record);
}

inline Expected<void> WritableTextureSet::AddColorMip(const ColorMip& mip) noexcept {
    container::ColorMipRecord record;
    record.width = static_cast<std::uint32_t>(mip.width);
    record.height = static_cast<std::uint32_t>(mip.height);
    record.latentMip = static_cast<std::uint32_t>(mip.neuralMip);
    record.positionLod = mip.positionLod;
    record.positionScale = mip.positionScale;
    return document_.colorMips.PushBack(record);
}

inline Expected<void> WritableTextureSet::Write(Stream& destination) noexcept {
    Array<std::span<const std::byte>> viewData(bytes_.GetAllocator());
    OPENNTC_CHECK(viewData.Reserve(views_.size()));
    for (const Extent& view : views_)
        OPENNTC_CHECK(viewData.PushBack(std::as_const(bytes_).AsSpan().subspan(view.offset, view.size)));
    OPENNTC_CHECK(container::LayOutViews(document_, std::as_const(viewData).AsSpan()));
    return container::WriteContainer(destination, {&document_, std::as_const(viewData).AsSpan()},
                                     bytes_.GetAllocator());
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
