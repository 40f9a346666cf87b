// SPDX-License-Identifier: MIT
// Sets of generation 3 whose latents are compressed, of several kinds of data and of streams that no writer
// makes.
#pragma once

#include "support/SpecificationVectors.h"

#include "openntc/container/GDeflateEncoder.h"
#include "openntc/inference/ReadLatents.h"
#include "openntc/texture_set/WritableTextureSet.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <string>
#include <vector>

namespace openntc_tests {

enum class LatentBytes { Noise, Repeated, Few }; ///< stored blocks, dynamic ones with matches, ones without

struct CompressedSetDesc {
    int width = 0; ///< of colour mip 0
    int height = 0;
    LatentBytes latents = LatentBytes::Noise;
    std::size_t extraBytes = 0; ///< of each layer's data, beyond its texels
    std::size_t gap = 0;        ///< bytes behind each compressed tile, which move the next one off its grid
};

inline std::vector<std::byte> MakeLatentBytes(LatentBytes kind, std::size_t size, std::uint32_t seed) {
    std::vector<std::byte> bytes(size);
    std::uint32_t state = seed;
    for (std::size_t i = 0; i < size; ++i) {
        state = state * 1664525u + 1013904223u;
        const std::uint32_t random = state >> 20;
        bytes[i] = static_cast<std::byte>(kind == LatentBytes::Noise      ? random & 255u
                                          : kind == LatentBytes::Repeated ? (i / 512 + i % 96) & 63u
                                                                          : random % 5u);
    }
    return bytes;
}

/// A GDeflate stream of `data`, with `gap` bytes behind each tile.
inline std::vector<std::byte> MakeGDeflateStream(std::span<const std::byte> data, std::size_t gap) {
    openntc::container::GDeflateEncoder encoder(4);
    openntc::Array<std::byte> stream;
    REQUIRE(encoder.Compress(data, stream));
    std::vector<std::byte> bytes(stream.begin(), stream.end());
    const auto header = *openntc::container::DecodeGDeflateHeader(bytes);
    for (std::uint32_t tile = header.tiles; gap > 0 && tile-- > 0;) {
        const auto range = *openntc::container::FindGDeflateTile(header, std::as_const(stream).AsSpan(),
                                                                 stream.size(), tile);
        bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(range.offset + range.size), gap,
                     std::byte{0xEE});
        if (tile == 0)
            continue;
        const auto offset = static_cast<std::uint32_t>(range.offset - header.GetTableBytes() + gap * tile);
        std::memcpy(bytes.data() + 8 + std::size_t{4} * tile, &offset, 4);
    }
    return bytes;
}

/// The set's file: six channels, three colour mips, latents of twelve features at a quarter of the size.
inline std::vector<std::byte> MakeCompressedSet(const CompressedSetDesc& desc) {
    using namespace openntc;
    SynthesisDesc synthesis;
    synthesis.seed = 11;
    synthesis.desc = {desc.width, desc.height, 6, 3};
    synthesis.networkVersion = NTC_NETWORK_GENERATION_3;
    synthesis.shape = MakeLayeredShape(4, 12);
    const std::vector<std::byte> plain = MakeFile(synthesis);
    ReadOnlyMemoryStream stream(plain);
    const auto metadata = TextureSetMetadata::Load(stream);
    REQUIRE_MESSAGE(metadata, std::string(metadata.error().GetText()));
    WritableTextureSet set;
    REQUIRE(set.SetDescription(metadata->GetDesc(), metadata->GetLatentShape(), 0, 3));
    REQUIRE(set.AddNetwork(metadata->GetWeights(), InferenceWeightType::GenericInt8));
    for (const Texture& texture : metadata->GetTextures())
        REQUIRE(set.AddTexture(texture));
    std::uint32_t seed = 1;
    for (LatentMip mip : metadata->GetLatentMips()) {
        const std::size_t bytes = static_cast<std::size_t>(mip.GetLayerBytes()) + desc.extraBytes;
        std::array<std::vector<std::byte>, kMaxLatentLayers> streams;
        std::array<std::span<const std::byte>, kMaxLatentLayers> parts;
        const auto layers = static_cast<std::size_t>(mip.layers);
        for (std::size_t layer = 0; layer < layers; ++layer) {
            const std::vector<std::byte> data = MakeLatentBytes(desc.latents, bytes, seed++);
            streams[layer] = MakeGDeflateStream(data, desc.gap);
            parts[layer] = streams[layer];
            mip.layerData[layer].isCompressed = true;
            mip.layerData[layer].bytes = bytes;
            mip.layerData[layer].crc32 = Crc32(data);
        }
        REQUIRE(set.AddStoredLatentMip(mip, std::span(parts).first(layers)));
    }
    for (const ColorMip& mip : metadata->GetColorMips())
        REQUIRE(set.AddColorMip(mip));
    MemoryStream result;
    REQUIRE(set.Write(result));
    return {result.GetBytes().begin(), result.GetBytes().end()};
}

/// Sets that tell mistakes apart: one tile; several, of which the last is short; layers that end between multiples of
/// four; data longer than a layer; tiles off the grid of words.
inline std::vector<CompressedSetDesc> ListCompressedSets() {
    std::vector<CompressedSetDesc> sets;
    for (const LatentBytes kind : {LatentBytes::Noise, LatentBytes::Repeated, LatentBytes::Few}) {
        sets.push_back({64, 64, kind});    // 512 bytes a layer
        sets.push_back({724, 724, kind});  // 65522: 2 more than a multiple of four
        sets.push_back({1024, 512, kind}); // 65536: whole tiles
        sets.push_back({1004, 588, kind}); // 73794: two tiles, the last one short
    }
    sets.push_back({1024, 1536, LatentBytes::Repeated}); // 196608: three whole ones
    sets.push_back({1024, 512, LatentBytes::Few, 70000});
    sets.push_back({1004, 588, LatentBytes::Repeated, 2, 3});
    sets.push_back({1024, 1536, LatentBytes::Few, 0, 1});
    return sets;
}

} // namespace openntc_tests
