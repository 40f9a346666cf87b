// SPDX-License-Identifier: MIT
// Stability: internal
// What the loader checks of generations 2 and 3 only: latent mips in layers, and the places of BC7 modes.
#pragma once

#include "openntc/container/Reader.h"
#include "openntc/container/Views.h"
#include "openntc/texture_set/LatentShape.h"
#include "openntc/texture_set/TextureSetContents.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "openntc/core/HideMacros.h"

namespace openntc::detail {

/// A u32 of the file as an int, so large ones as INT_MAX: both are outside every range that is checked here.
constexpr int ToInt(std::uint32_t value) noexcept {
    constexpr std::uint32_t kMax = static_cast<std::uint32_t>(std::numeric_limits<int>::max());
    return static_cast<int>(std::min(value, kMax));
}

/// Where the data of a view are. Its index has been checked.
inline StoredData GetStoredData(const container::BinaryChunk& chunk, std::uint32_t view) noexcept {
    const container::BufferView& record = chunk.views[view];
    StoredData data;
    data.range = {chunk.offset + record.offset, record.storedSize};
    data.isCompressed = record.compression == container::Compression::GDeflate;
    data.bytes = data.isCompressed ? record.uncompressedSize.value_or(0) : record.storedSize;
    data.crc32 = record.crc32.value_or(0);
    return data;
}

/// The data of a layer, which takes `bytes`. What a view has beyond them is of no use.
inline Expected<StoredData> CheckLayerView(const container::BinaryChunk& chunk, std::uint32_t view,
                                           std::uint64_t bytes, const container::ElementPath& path) noexcept {
    StoredData data = GetStoredData(chunk, view);
    if (data.bytes < bytes)
        return Fail(Status::FileUnrecognized,
                    "latents[%zu].layerViews: views[%u].%s: %llu: needs at least %llu bytes", path.index,
                    view, data.isCompressed ? "uncompressedSize" : "storedSize",
                    static_cast<unsigned long long>(data.bytes), static_cast<unsigned long long>(bytes));
    return data;
}

/// Layers of generation 3, a view each.
inline Expected<void> CheckLayerViews(const container::LatentImageRecord& record,
                                      const container::BinaryChunk& chunk, const container::ElementPath& path,
                                      LatentMip& mip) noexcept {
    if (ToInt(record.layerViews.count) != mip.layers)
        return Fail(Status::FileUnrecognized, "latents[%zu].layerViews: %u views: latentShape gives %d",
                    path.index, record.layerViews.count, mip.layers);
    for (std::size_t layer = 0; layer < record.layerViews.count; ++layer) {
        OPENNTC_ASSIGN(mip.layerData[layer],
                       CheckLayerView(chunk, record.layerViews.views[layer], mip.GetLayerBytes(), path));
    }
    return {};
}

/// Layers of generation 2, one after the other in one view.
inline Expected<void> CheckArrayView(const container::LatentImageRecord& record,
                                     const container::BinaryChunk& chunk, const container::ElementPath& path,
                                     LatentMip& mip) noexcept {
    if (ToInt(record.arraySize) != mip.layers)
        return Fail(Status::FileUnrecognized, "latents[%zu].arraySize: %u: latentShape gives %d", path.index,
                    record.arraySize, mip.layers);
    const std::uint64_t bytes = mip.GetLayerBytes();
    const auto layers = static_cast<std::uint64_t>(mip.layers);
    OPENNTC_CHECK(container::CheckView(chunk.views, record.view, bytes * layers, path, "view"));
    const std::uint64_t offset = chunk.offset + chunk.views[record.view].offset;
    for (std::uint64_t layer = 0; layer < layers; ++layer)
        mip.layerData[static_cast<std::size_t>(layer)] = {{offset + layer * bytes, bytes}, bytes, false, 0};
    return {};
}

/// Every latent mip has half the size of the one before it: they are mips of one texture.
inline Expected<void> CheckLatentMips(TextureSetContents& set, const container::BinaryChunk& chunk) noexcept {
    constexpr std::uint32_t kMax = static_cast<std::uint32_t>(kMaxLatentDimension);
    const container::Document& document = set.document;
    if (document.latents.size() < 2)
        return Fail(Status::FileUnrecognized, "latents: %zu: a colour mip is decoded from two latent mips",
                    document.latents.size());
    for (std::size_t i = 0; i < document.latents.size(); ++i) {
        const container::LatentImageRecord& record = document.latents[i];
        const container::ElementPath path{"", "latents", i};
        if (record.width < 1 || record.width > kMax || record.height < 1 || record.height > kMax)
            return Fail(Status::OutOfRange, "latents[%zu]: %u x %u: sides must be 1 … %u", i, record.width,
                        record.height, kMax);
        LatentMip& mip = set.latentMips[i];
        mip.width = ToInt(record.width);
        mip.height = ToInt(record.height);
        mip.layers = GetLatentLayers(set.latentShape);
        const int width = GetMipDimension(set.latentMips[0].width, static_cast<int>(i));
        const int height = GetMipDimension(set.latentMips[0].height, static_cast<int>(i));
        if (mip.width != width || mip.height != height)
            return Fail(Status::FileUnrecognized,
                        "latents[%zu]: %d x %d: must be %d x %d, as a mip of latents[0]", i, mip.width,
                        mip.height, width, height);
        OPENNTC_CHECK(document.schemaVersion == 2 ? CheckArrayView(record, chunk, path, mip)
                                                  : CheckLayerViews(record, chunk, path, mip));
    }
    set.latentMipCount = static_cast<int>(document.latents.size());
    return {};
}

/// The places of all textures' BC7 modes, one after the other in set.blockModes; those of mips that the set
/// does not have are left out, as in LibNTC.
inline Expected<void> LoadBlockModePlaces(TextureSetContents& set,
                                          const container::BinaryChunk& chunk) noexcept {
    std::size_t total = 0;
    for (const container::TextureRecord& record : set.document.textures)
        total += record.bcModeBuffers.size();
    OPENNTC_CHECK(set.blockModes.Reserve(total));
    for (std::size_t i = 0; i < set.document.textures.size(); ++i) {
        const std::size_t first = set.blockModes.size();
        for (const container::BcModeBufferRecord& record : set.document.textures[i].bcModeBuffers) {
            if (ToInt(record.mipLevel) < set.desc.mips)
                OPENNTC_CHECK(
                    set.blockModes.PushBack({ToInt(record.mipLevel), GetStoredData(chunk, record.view)}));
        }
        set.textures[i].blockModes = set.blockModes.AsSpan().subspan(first);
    }
    return {};
}

} // namespace openntc::detail

#include "openntc/core/RestoreMacros.h"
