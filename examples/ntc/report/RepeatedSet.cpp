// SPDX-License-Identifier: MIT
#include "report/RepeatedSet.h"

#include "openntc/format/NetworkDescription.h"

#include <cstdint>

namespace openntc::report {

namespace {

/// Appends `copies` of a grid's latents, of later generations layer by layer; false if they are not whole words, or the grid
/// is too high.
bool AppendCopies(const tool::DecodeData& data, const NtcLatentEncodingConstants& encoding, int copies,
                  NtcNeuralMipConstants& grid, std::vector<std::byte>& latents) {
    const std::uint32_t width = grid.imageWidthHeight & 0xFFFFu, height = grid.imageWidthHeight >> 16;
    const std::uint64_t layers = GetGeneration(data.networkVersion) > 1
                                     ? static_cast<std::uint64_t>(encoding.numFeatures / kLayerFeatures)
                                     : 1;
    const std::uint64_t bits = std::uint64_t{width} * height *
                               static_cast<std::uint64_t>(encoding.numFeatures) *
                               static_cast<std::uint64_t>(encoding.quantBits) / layers;
    const std::uint64_t repeated = std::uint64_t{height} * static_cast<std::uint64_t>(copies);
    if (bits % 32 != 0 || repeated > 0xFFFFu || grid.sliceWidthHeight != grid.imageWidthHeight)
        return false;
    auto first = data.latents.begin() + static_cast<std::ptrdiff_t>(grid.dataOffset);
    const auto bytes = static_cast<std::ptrdiff_t>(bits / 8);
    grid.dataOffset = static_cast<std::uint32_t>(latents.size());
    grid.imageWidthHeight = grid.sliceWidthHeight = width | static_cast<std::uint32_t>(repeated) << 16;
    for (std::uint64_t layer = 0; layer < layers; ++layer, first += bytes) {
        for (int i = 0; i < copies; ++i)
            latents.insert(latents.end(), first, first + bytes);
    }
    return true;
}

} // namespace

RepeatedSet RepeatBelow(const tool::DecodeData& data, int copies) {
    RepeatedSet set{data.constants, {}};
    NtcTextureSetConstants& constants = set.constants;
    const auto image = static_cast<std::size_t>(constants.colorMips[0].neuralMip);
    if (!AppendCopies(data, constants.highResEncoding, copies, constants.highResNeuralMips[image],
                      set.latents) ||
        !AppendCopies(data, constants.lowResEncoding, copies, constants.lowResNeuralMips[image], set.latents))
        set.latents.clear();
    constants.imageHeight *= copies;
    constants.imageMips = 1;
    return set;
}

} // namespace openntc::report
