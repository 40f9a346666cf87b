// SPDX-License-Identifier: MIT
// The texture sets V1 and V2 of the format specification, as decoder inputs.
#pragma once

#include "openntc/InferenceConstants.h"
#include "openntc/decode/DecodeTypes.h"

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

namespace decode_test {

struct SpecificationSet {
    openntc::NtcTextureSetConstants constants{};
    std::vector<std::byte> weights; // generic Int8 buffer
    std::vector<std::byte> latents;
    int networkVersion = 0;
};

inline openntc::DecodeSource GetSource(const SpecificationSet& set) {
    return {&set.constants, set.latents, set.weights, set.networkVersion};
}

struct SpecificationShape {
    std::uint32_t seed;
    int width, height, mips, channels, networkVersion;
    int highResFeatures, lowResFeatures, highResBits, lowResBits;
    std::vector<std::vector<int>> grids; // per latent image: high-res width, height, low-res width, height
    std::vector<int> neuralMips;         // per colour mip
};

inline SpecificationShape GetV1Shape() {
    return {1, 24, 20, 4, 4, NTC_NETWORK_SMALL, 4, 8, 2, 4, {{6, 5, 3, 2}}, {0, 0, 0, 0}};
}

inline SpecificationShape GetV2Shape() {
    return {2,
            40,
            64,
            6,
            4,
            NTC_NETWORK_LARGE,
            12,
            16,
            4,
            8,
            {{20, 32, 10, 16}, {5, 8, 2, 4}},
            {0, 0, 0, 1, 1, 1}};
}

/// CRC-32s that the specification gives for one whole mip level: the network's inputs, and its outputs as binary16
/// and as binary32.
struct SpecificationMip {
    int mip, width, height;
    std::uint32_t inputs, half, binary32;
};

constexpr SpecificationMip kV1Mips[] = {
    {0, 24, 20, 0xb371c088, 0xbf80e76f, 0x007d97d0},
    {1, 12, 10, 0x27c54b25, 0x2b2db22a, 0x753fadfb},
    {2, 6, 5, 0x671158e0, 0x01aa6b12, 0xa0be28f5},
    {3, 3, 2, 0x37abac82, 0x16f196a5, 0x15b5c1e1},
};
constexpr SpecificationMip kV2Mips[] = {
    {0, 40, 64, 0x978577f5, 0x4484fd84, 0x9f75f00c}, {1, 20, 32, 0x90dc2a2f, 0x3ba32a83, 0xd3342cd7},
    {2, 10, 16, 0xe2b92fdc, 0xd30af414, 0xf06d2b91}, {3, 5, 8, 0xfc31cac4, 0x0426cc42, 0x7cc52f91},
    {4, 2, 4, 0x77ae567a, 0x0b35c34c, 0x3f6c89f8},   {5, 1, 2, 0x510afbe0, 0x45d68f0c, 0x265b6c2f},
};

namespace detail {

class Generator {
public:
    explicit Generator(std::uint32_t seed) : state_(seed) {}
    int Next() {
        state_ = state_ * 1664525u + 1013904223u;
        return static_cast<int>(state_ >> 16);
    }

private:
    std::uint32_t state_;
};

template <typename T>
void Append(std::vector<std::byte>& bytes, T value) {
    const std::size_t at = bytes.size();
    bytes.resize(at + sizeof(T));
    std::memcpy(bytes.data() + at, &value, sizeof(T));
}

inline openntc::NtcLatentEncodingConstants MakeEncoding(int features, int bits) {
    const int log = 5 - std::countr_zero(static_cast<unsigned>(bits));
    const int scale = bits == 1 ? 85 : bits == 2 ? 51 : bits == 4 ? 15 : 1;
    const int bias = bits == 1 ? 0 : bits == 2 ? -51 : bits == 4 ? -105 : -126;
    return {features, bits, log, 0, (1u << log) - 1u, (1u << bits) - 1u, scale, bias};
}

} // namespace detail

inline SpecificationSet MakeSpecificationSet(const SpecificationShape& shape) {
    SpecificationSet set;
    set.networkVersion = shape.networkVersion;
    openntc::NtcTextureSetConstants& c = set.constants;
    detail::Generator generator(shape.seed);
    std::vector<std::byte> scales;
    std::vector<std::byte> biases;
    const int rows[4] = {64, 64, 64, 16};
    int offsets[4] = {};
    for (int layer = 0; layer < 4; ++layer) {
        offsets[layer] = static_cast<int>(set.weights.size());
        const int inputs = layer == 0 ? 32 + 16 * shape.networkVersion : 64;
        std::vector<int> sums;
        for (int row = 0; row < rows[layer]; ++row) {
            int sum = 0;
            for (int i = 0; i < inputs; ++i) {
                const int weight = generator.Next() % 255 - 127;
                sum += weight;
                detail::Append(set.weights, static_cast<std::int8_t>(weight));
            }
            sums.push_back(sum);
        }
        for (int row = 0; row < rows[layer]; ++row)
            detail::Append(scales, static_cast<float>(1 + generator.Next() % 64) / 1048576.0f);
        for (const int sum : sums)
            detail::Append(biases, generator.Next() % 8192 - 4096 + (layer > 0 ? 113 * sum : 0));
    }
    c.networkWeightOffset0 = offsets[0];
    c.networkWeightOffset1 = offsets[1];
    c.networkWeightOffset2 = offsets[2];
    c.networkWeightOffset3 = offsets[3];
    c.networkScaleBiasOffset = static_cast<int>(set.weights.size());
    set.weights.insert(set.weights.end(), scales.begin(), scales.end());
    set.weights.insert(set.weights.end(), biases.begin(), biases.end());

    const auto appendGrid = [&](int width, int height, int features, int bits) {
        openntc::NtcNeuralMipConstants grid{};
        grid.dataOffset = static_cast<std::uint32_t>(set.latents.size());
        grid.imageWidthHeight = static_cast<std::uint32_t>(width | (height << 16));
        grid.sliceWidthHeight = grid.imageWidthHeight;
        const int perWord = 32 / bits;
        const int elements = width * height * features;
        std::uint32_t word = 0;
        for (int e = 0; e < elements; ++e) {
            const int n = generator.Next();
            const int code = bits == 8 ? n % 254 : n % (1 << bits);
            word |= static_cast<std::uint32_t>(code) << ((e % perWord) * bits);
            if (e % perWord == perWord - 1 || e == elements - 1) {
                detail::Append(set.latents, word);
                word = 0;
            }
        }
        return grid;
    };
    for (std::size_t image = 0; image < shape.grids.size(); ++image) {
        const std::vector<int>& g = shape.grids[image];
        c.highResNeuralMips[image] = appendGrid(g[0], g[1], shape.highResFeatures, shape.highResBits);
        c.lowResNeuralMips[image] = appendGrid(g[2], g[3], shape.lowResFeatures, shape.lowResBits);
    }
    c.highResEncoding = detail::MakeEncoding(shape.highResFeatures, shape.highResBits);
    c.lowResEncoding = detail::MakeEncoding(shape.lowResFeatures, shape.lowResBits);
    for (int mip = 0; mip < shape.mips; ++mip) {
        const int neuralMip = shape.neuralMips[static_cast<std::size_t>(mip)];
        const int depth = mip - 2 * neuralMip;
        c.colorMips[mip] = {neuralMip, static_cast<float>(depth / 3.0), static_cast<float>(1 << depth), 0};
    }
    c.imageWidth = shape.width;
    c.imageHeight = shape.height;
    c.imageMips = shape.mips;
    c.validChannelMask = (1u << shape.channels) - 1u;
    return set;
}

} // namespace decode_test
