// SPDX-License-Identifier: MIT
// Decoder sources of generations 2 and 3 with pseudo-random networks and latents, made in memory.
#pragma once

#include "ModeSets.h"
#include "openntc/core/Crc32.h"
#include "openntc/decode/DecodeTypes.h"
#include "openntc/inference/Synthesis.h"
#include "openntc/texture_set/MipChain.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <vector>

namespace decode_test {

struct LatentMipShape {
    std::uint32_t seed;
    int networkVersion;
    int width, height, mips;
    int gridSizeScale, features;
};

/// A set of one of the later generations and what decoders need of it, for Int8 and for FP8 weights.
class LatentMipSet {
public:
    explicit LatentMipSet(const LatentMipShape& shape) : shape_(shape) {
        const openntc::NetworkDescription network = openntc::GetNetworkDescription(shape.networkVersion);
        openntc::detail::SynthesisGenerator generator(shape.seed);
        openntc::InferenceWeights weights;
        REQUIRE(openntc::detail::SynthesizeInt8Network(generator, network, weights));
        REQUIRE(openntc::detail::SynthesizeFP8Network(generator, network, weights));
        int8_.assign(weights.int8.begin(), weights.int8.end());
        fp8_.assign(weights.fp8.begin(), weights.fp8.end());
        MakeLatents(generator);
        MakeConstants(network);
    }

    const LatentMipShape& GetShape() const { return shape_; }
    openntc::NtcTextureSetConstants& GetConstants() { return constants_; }
    std::vector<std::byte>& GetLatents() { return latents_; }

    openntc::DecodeSource GetSource(openntc::DecodeWeights format) const {
        return {&constants_, latents_, format == openntc::DecodeWeights::FP8 ? fp8_ : int8_,
                shape_.networkVersion, format};
    }

    int GetLatentMips() const { return latentMips_; }
    /// Width in the lower half, height in the upper one.
    unsigned GetGridSize(int latentMip) const { return grids_[latentMip].imageWidthHeight; }
    /// The texels of a latent mip, all layers.
    std::span<const std::byte> GetLatentBytes(int latentMip) const {
        const openntc::NtcNeuralMipConstants& grid = grids_[latentMip];
        const std::size_t texels =
            std::size_t{grid.imageWidthHeight & 0xFFFFu} * (grid.imageWidthHeight >> 16);
        return std::span(latents_).subspan(grid.dataOffset,
                                           texels * static_cast<std::size_t>(shape_.features) / 2);
    }

    /// Of code `feature` of a latent texel.
    unsigned GetCode(int latentMip, int feature, int x, int y) const {
        const openntc::NtcNeuralMipConstants& grid = grids_[latentMip];
        const unsigned width = grid.imageWidthHeight & 0xFFFFu;
        const unsigned texel =
            (static_cast<unsigned>(feature / 4) * (grid.imageWidthHeight >> 16) + static_cast<unsigned>(y)) *
                width +
            static_cast<unsigned>(x);
        const auto byte = latents_[grid.dataOffset + 2 * texel + static_cast<unsigned>(feature % 4 / 2)];
        return std::to_integer<unsigned>(byte) >> (4 * (feature % 2)) & 15u;
    }

private:
    void MakeLatents(openntc::detail::SynthesisGenerator& generator) {
        const openntc::TextureSetDesc desc = {shape_.width, shape_.height, 16, shape_.mips};
        latentMips_ = openntc::GetLatentMipCount(desc, shape_.gridSizeScale);
        for (int mip = 0; mip < latentMips_; ++mip) {
            const int width = openntc::GetLatentMipDimension(shape_.width, shape_.gridSizeScale, mip);
            const int height = openntc::GetLatentMipDimension(shape_.height, shape_.gridSizeScale, mip);
            const unsigned size = static_cast<unsigned>(height) << 16 | static_cast<unsigned>(width);
            latents_.resize((latents_.size() + 3) / 4 * 4);
            grids_[mip] = {static_cast<std::uint32_t>(latents_.size()), size, 0, size};
            for (int i = 0; i < width * height * shape_.features / 2; ++i)
                latents_.push_back(static_cast<std::byte>(generator.Next() & 0xFF));
        }
        latents_.resize((latents_.size() + 3) / 4 * 4);
    }

    void MakeConstants(const openntc::NetworkDescription& network) {
        openntc::NtcTextureSetConstants& c = constants_;
        c.highResEncoding = c.lowResEncoding = {shape_.features, 4, 3, 0, 7, 15, 0, 0};
        for (int mip = 0; mip < latentMips_; ++mip) {
            c.highResNeuralMips[mip] = grids_[mip];
            if (mip + 1 < latentMips_)
                c.lowResNeuralMips[mip] = grids_[mip + 1];
        }
        for (int mip = 0; mip < shape_.mips; ++mip) {
            openntc::NtcColorMipConstants& color = c.colorMips[mip];
            color.neuralMip = openntc::GetLatentMipForColorMip(mip, shape_.gridSizeScale, latentMips_);
            const unsigned size = grids_[color.neuralMip].imageWidthHeight;
            color.positionScale = openntc::GetLatentPositionScale(
                openntc::GetMipDimension(shape_.width, mip), openntc::GetMipDimension(shape_.height, mip),
                static_cast<int>(size & 0xFFFFu), static_cast<int>(size >> 16));
            color.positionLod = openntc::GetLatentPositionLod(color.positionScale);
        }
        c.networkWeightOffset0 = network.weightOffsets[0];
        c.networkWeightOffset1 = network.weightOffsets[1];
        c.networkWeightOffset2 = network.weightOffsets[2];
        c.networkWeightOffset3 = network.weightOffsets[3];
        c.networkScaleBiasOffset = network.weightBytes;
        c.imageWidth = shape_.width;
        c.imageHeight = shape_.height;
        c.imageMips = shape_.mips;
        c.validChannelMask = 0xFFFF;
    }

    LatentMipShape shape_;
    std::vector<std::byte> int8_;
    std::vector<std::byte> fp8_;
    std::vector<std::byte> latents_;
    openntc::NtcNeuralMipConstants grids_[NTC_MAX_NEURAL_MIPS] = {};
    openntc::NtcTextureSetConstants constants_{};
    int latentMips_ = 0;
};

/// Sizes that are powers of two and that are not, grids of one texel, and every number of layers.
inline const LatentMipShape kLatentMipShapes[] = {
    {5, NTC_NETWORK_GENERATION_2, 64, 32, 6, 4, 8},   {6, NTC_NETWORK_GENERATION_2, 37, 50, 5, 3, 16},
    {7, NTC_NETWORK_GENERATION_3, 64, 64, 7, 2, 12},  {8, NTC_NETWORK_GENERATION_3, 53, 41, 5, 3, 4},
    {9, NTC_NETWORK_GENERATION_3, 100, 37, 6, 4, 16}, {10, NTC_NETWORK_GENERATION_3, 12, 9, 4, 6, 8},
};

/// CheckChecksums for generations 2 and 3.
template <typename Decode>
void CheckLatentMipChecksums(const char* decoder, Decode decode, std::size_t modes = 5) {
    constexpr std::uint32_t kChecksums[2][5] = {
        {0xe06a0f7au, 0xe06a0f7au, 0x34e9debcu, 0x1db335d6u, 0x285d53beu},
        {0x7c082822u, 0x4c5a902fu, 0xc12f6686u, 0xe7877147u, 0xd45a79efu}};
    for (const int generation : {2, 3}) {
        const LatentMipSet set(
            {77, generation == 2 ? NTC_NETWORK_GENERATION_2 : NTC_NETWORK_GENERATION_3, 19, 17, 5, 3, 12});
        for (std::size_t mode = 0; mode < modes; ++mode) {
            INFO(std::string(decoder) << ", generation " << generation << ", mode " << mode);
            CHECK(GetChecksum(set, kChecksumModes[mode], decode) == kChecksums[generation - 2][mode]);
        }
    }
}

} // namespace decode_test
