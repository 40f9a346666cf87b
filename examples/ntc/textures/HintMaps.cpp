// SPDX-License-Identifier: MIT
#include "textures/HintMaps.h"

#include "Failure.h"

#include <algorithm>
#include <span>

namespace openntc::tool {

void HintMapMaker::AddTexture(std::size_t index, const TextureFormat& format) {
    const Texture& texture = metadata_.GetTextures()[index];
    textures_.push_back({index, &texture, format, TexelConverter(metadata_, texture, format),
                         HintGatherer(format, texture.numChannels, effort_, threads_, subject_)});
}

std::uint64_t HintMapMaker::GetTexels() const {
    std::uint64_t texels = 0;
    for (const ColorMip& mip : metadata_.GetColorMips())
        texels += static_cast<std::uint64_t>(mip.width) * static_cast<std::uint64_t>(mip.height);
    return texels * textures_.size();
}

void HintMapMaker::Run(Decoder& decoder, DecodeMath math, const std::function<void(std::uint64_t)>& advance) {
    for (int mip = 0; mip < metadata_.GetDesc().mips; ++mip)
        GatherMip(decoder, math, mip, advance);
    std::stable_sort(maps_.begin(), maps_.end(),
                     [](const Map& a, const Map& b) { return a.map.texture < b.map.texture; });
}

std::vector<bc::BlockHintMap> HintMapMaker::GetMaps() const {
    std::vector<bc::BlockHintMap> maps;
    for (const Map& map : maps_)
        maps.push_back(map.map);
    return maps;
}

void HintMapMaker::GatherMip(Decoder& decoder, DecodeMath math, int mip,
                             const std::function<void(std::uint64_t)>& advance) {
    const ColorMip& size = metadata_.GetColorMips()[static_cast<std::size_t>(mip)];
    // So few that an interrupt does not wait long for the search.
    constexpr int kTexelsPerBand = 1 << 16;
    const int bandRows = std::max(4, kTexelsPerBand / size.width / 4 * 4); // whole blocks
    DecodeOptions stored;
    stored.math = math; // each texture converts to its own colour space
    for (int top = 0; top < size.height; top += bandRows) {
        const int rows = std::min(bandRows, size.height - top);
        outputs_.resize(static_cast<std::size_t>(size.width) * 16 * static_cast<std::size_t>(rows));
        Require(decoder.Decode(mip, {0, top, size.width, rows}, stored, outputs_), ExitCode::Failed,
                subject_);
        for (TextureWork& work : textures_) {
            texels_.clear();
            work.converter.Append(outputs_, texels_);
            work.gatherer.AddRows(
                {texels_, static_cast<std::uint32_t>(size.width), static_cast<std::uint32_t>(rows)});
            advance(static_cast<std::uint64_t>(size.width) * static_cast<std::uint64_t>(rows));
        }
    }
    for (TextureWork& work : textures_) {
        Map& map = maps_.emplace_back();
        map.map.texture = static_cast<std::uint32_t>(work.index);
        map.map.mip = static_cast<std::uint32_t>(mip);
        map.map.width = bc::CountBlocks(static_cast<std::uint32_t>(size.width));
        map.map.height = bc::CountBlocks(static_cast<std::uint32_t>(size.height));
        map.map.texels = {work.gatherer.GetTexelCrc(), static_cast<std::uint8_t>(math), work.format.srgb,
                          ToBlockQuality(effort_)};
        map.packed = work.gatherer.TakeMap();
        map.map.packed = map.packed; // stays where it is when maps are moved
    }
}

} // namespace openntc::tool
