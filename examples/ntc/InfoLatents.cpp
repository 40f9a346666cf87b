// SPDX-License-Identifier: MIT
#include "InfoLatents.h"

#include "Output.h"
#include "TextureSizes.h"

#include "openntc/container/Schema.h"
#include "openntc/texture_set/LatentShape.h"

#include <string>

namespace openntc::tool {

namespace {

unsigned long long Wide(std::uint64_t value) {
    return value;
}

void PrintGrid(const char* name, const LatentGrid& grid) {
    WriteOutput(Format(" %s %dx%d at %llu + %llu", name, grid.width, grid.height, Wide(grid.offset),
                       Wide(grid.size)));
}

void WriteGrid(JsonWriter& json, const char* key, const LatentGrid& grid) {
    json.Key(key);
    json.BeginObject();
    json.Member("width", grid.width);
    json.Member("height", grid.height);
    json.Member("offset", grid.offset);
    json.Member("size", grid.size);
    json.EndObject();
}

void WriteLatentMips(JsonWriter& json, const TextureSetMetadata& metadata) {
    json.Key("latentMips");
    json.BeginArray();
    for (const LatentMip& mip : metadata.GetLatentMips()) {
        json.BeginObject();
        json.Member("width", mip.width);
        json.Member("height", mip.height);
        json.Key("layers");
        json.BeginArray();
        for (std::size_t layer = 0; layer < static_cast<std::size_t>(mip.layers); ++layer) {
            const StoredData& data = mip.layerData[layer];
            json.BeginObject();
            json.Member("offset", data.range.offset);
            json.Member("size", data.range.size);
            json.Member("compressed", data.isCompressed);
            json.EndObject();
        }
        json.EndArray();
        json.EndObject();
    }
    json.EndArray();
}

bool IsCompressed(const container::BufferView& view) {
    return view.compression == container::Compression::GDeflate;
}

} // namespace

const char* GetReleases(int generation) {
    return generation == 1 ? "0.5 - 0.7" : generation == 2 ? "0.8" : "0.9";
}

void PrintLatentShape(const TextureSetMetadata& metadata) {
    const LatentShape& shape = metadata.GetLatentShape();
    // The shape's own figure is defined only when it has a grid scale.
    const double bits =
        shape.gridSizeScale > 0 ? static_cast<double>(GetLatentShapeBitsPerPixel(shape)) : 0.0;
    if (metadata.GetGeneration() == 1) {
        WriteOutput(Format(
            "  latents   %g bits per pixel: grid scale %d, %d features of %d bits and %d of %d at half "
            "resolution\n",
            bits, shape.gridSizeScale, shape.highResFeatures, shape.highResQuantBits, shape.lowResFeatures,
            shape.lowResQuantBits));
        return;
    }
    std::uint64_t stored = 0;
    std::uint64_t all = 0;
    for (const LatentMip& mip : metadata.GetLatentMips()) {
        for (std::size_t layer = 0; layer < static_cast<std::size_t>(mip.layers); ++layer)
            stored += mip.layerData[layer].range.size;
        all += mip.GetLayerBytes() * static_cast<std::uint64_t>(mip.layers);
    }
    WriteOutput(
        Format("  latents   %g bits per pixel: grid scale %d, %zu latent mips of %d features of 4 bits in %d "
               "layers, %s of %s stored\n",
               bits, shape.gridSizeScale, metadata.GetLatentMips().size(), shape.highResFeatures,
               GetLatentLayers(shape), FormatBytes(stored).c_str(), FormatBytes(all).c_str()));
}

void PrintLatentDetails(const TextureSetMetadata& metadata) {
    std::size_t index = 0;
    for (const LatentImage& image : metadata.GetLatentImages()) {
        WriteOutput(Format("  latent image %zu:", index++));
        PrintGrid("high-res", image.highRes);
        PrintGrid("low-res", image.lowRes);
        WriteOutput("\n");
    }
    for (const LatentMip& mip : metadata.GetLatentMips()) {
        WriteOutput(
            Format("  latent mip %zu: %dx%d, %d layers at", index++, mip.width, mip.height, mip.layers));
        for (std::size_t layer = 0; layer < static_cast<std::size_t>(mip.layers); ++layer) {
            const StoredData& data = mip.layerData[layer];
            WriteOutput(Format(" %llu + %llu%s", Wide(data.range.offset), Wide(data.range.size),
                               data.isCompressed ? " (GDeflate)" : ""));
        }
        WriteOutput("\n");
    }
}

void PrintViews(const TextureSetMetadata& metadata) {
    std::size_t index = 0;
    for (const container::BufferView& view : metadata.GetDocument().views) {
        WriteOutput(Format("  view %zu: %llu + %llu", index++, Wide(view.offset), Wide(view.storedSize)));
        if (IsCompressed(view))
            WriteOutput(Format(", GDeflate of %llu", Wide(view.uncompressedSize.value_or(0))));
        WriteOutput("\n");
    }
}

void WriteLatents(JsonWriter& json, const TextureSetMetadata& metadata) {
    if (metadata.GetGeneration() > 1)
        return WriteLatentMips(json, metadata);
    json.Key("latentImages");
    json.BeginArray();
    for (const LatentImage& image : metadata.GetLatentImages()) {
        json.BeginObject();
        WriteGrid(json, "highRes", image.highRes);
        WriteGrid(json, "lowRes", image.lowRes);
        json.EndObject();
    }
    json.EndArray();
}

void WriteViews(JsonWriter& json, const TextureSetMetadata& metadata) {
    json.Key("views");
    json.BeginArray();
    for (const container::BufferView& view : metadata.GetDocument().views) {
        json.BeginObject();
        json.Member("offset", view.offset);
        json.Member("storedSize", view.storedSize);
        if (IsCompressed(view)) {
            json.Member("compression", "GDeflate");
            json.Member("uncompressedSize", view.uncompressedSize.value_or(0));
        }
        json.EndObject();
    }
    json.EndArray();
}

} // namespace openntc::tool
