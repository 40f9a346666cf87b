// SPDX-License-Identifier: MIT
// An ordinary texture in memory, and the functions of StochasticFiltering.h round its texels: the same few
// lines that an engine writes round its own.
#pragma once

#include "WaveEmulator.h" // before what needs waves

#include "openntc/StochasticFiltering.h"
#include "openntc/filtering/StfShare.h"

#include <cstdint>
#include <utility>
#include <vector>

namespace openntc_filtering {

namespace stf = openntc::shader;

/// Square mips of linear colours, each half as large as the one before.
struct Texture {
    std::vector<std::vector<stf::float4>> mips;
    stf::NtcStfExtent extent{};
};

inline Texture MakeTexture(int size, std::vector<stf::float4> texels) {
    Texture texture;
    texture.mips.push_back(std::move(texels));
    for (int side = size / 2; side > 0; side /= 2) {
        const std::vector<stf::float4>& from = texture.mips.back();
        std::vector<stf::float4> to;
        for (int i = 0; i < side * side; ++i) {
            const int x = i % side * 2, y = i / side * 2;
            const auto at = [&](int dx, int dy) {
                return from[static_cast<std::size_t>((y + dy) * side * 2 + x + dx)];
            };
            to.push_back((at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1)) * 0.25f);
        }
        texture.mips.push_back(std::move(to));
    }
    texture.extent = stf::NtcStfMakeExtent(size, size, static_cast<int>(texture.mips.size()));
    return texture;
}

/// What Fetch gets: the texture, and a count of what it reads.
struct TextureReader {
    const Texture* texture;
    std::uint64_t* decodes;
};

inline stf::float4 FetchTexel(const TextureReader& reader, const stf::NtcStfTap& tap) {
    if (tap.isBorder)
        return {0, 0, 0, 0};
    ++*reader.decodes;
    const int side = stf::NtcStfGetMipSize(reader.texture->extent.width, tap.mip);
    return reader.texture
        ->mips[static_cast<std::size_t>(tap.mip)][static_cast<std::size_t>(tap.texel.y * side + tap.texel.x)];
}

} // namespace openntc_filtering

namespace openntc::shader {

using openntc_filtering::FetchTexel;
using openntc_filtering::TextureReader;

NTC_STF_DEFINE_FILTER(FilterAll, float4, TextureReader, FetchTexel)
NTC_STF_DEFINE_COLLABORATION(FilterTogether, float4, TextureReader, FetchTexel)
NTC_STF_DEFINE_SHARING(FilterShared, float4, TextureReader, FetchTexel)

/// One stochastic texel, or two where the kernel has negative weights.
inline float4 FilterOne(const TextureReader& reader, const NtcStfSampler& settings, float2 uv,
                        const NtcStfFootprint& footprint, uint4 random) {
    const NtcStfPair pair = NtcStfSamplePair(settings, reader.texture->extent, uv, footprint, random);
    float4 value(0, 0, 0, 0);
    NtcStfAdd(value, FetchTexel(reader, pair.first), pair.first.scale);
    if (pair.second.scale != 0.0f)
        NtcStfAdd(value, FetchTexel(reader, pair.second), pair.second.scale);
    return value;
}

} // namespace openntc::shader
