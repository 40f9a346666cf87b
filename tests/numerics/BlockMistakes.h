// SPDX-License-Identifier: MIT
// Block encoders and decoders as the hard cases of block compression see them: ours, or ours with a known
// mistake.
#pragma once

#include "textures/BlockCoding.h"

#include "openntc/bc/BlockFormat.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace numerics {

/// What integrations and other encoders do wrong.
enum class BlockMistake {
    None,
    TruncatedColors,   ///< colours are cut to five bits before the search
    InsetEndpoints,    ///< the ends of a palette are moved inwards by a sixteenth
    ExtremesOnly,      ///< BC4's ends are the smallest and the largest texel, always
    RoundedAlpha,      ///< alpha keeps seven bits
    ThresholdOpaque,   ///< a texel at the threshold counts as opaque
    NanIsLargest,      ///< NaN counts as infinity does
    SignDropped,       ///< negative numbers count as positive ones
    OffsetBinary,      ///< signed bytes are taken as 0 … 255 with 128 in the middle
    ZeroBeyondEdge,    ///< texels beyond the image are 0
    PaddedRows,        ///< rows are taken as multiples of four texels
    LevelIgnored,      ///< every level is the one below it
    ReservedCodeMode0, ///< a block without a mode bit is read as mode 0
    Last = ReservedCodeMode0,
};

/// Makes the encoder or decoder wrong while it lives.
class PlantedBlockMistake {
public:
    explicit PlantedBlockMistake(BlockMistake mistake);
    ~PlantedBlockMistake();
    PlantedBlockMistake(const PlantedBlockMistake&) = delete;
    PlantedBlockMistake& operator=(const PlantedBlockMistake&) = delete;
};

/// Texels as numbers, interleaved, as many channels as the format keeps: bytes, signed bytes, or halves by
/// their bits.
struct BlockPicture {
    openntc::bc::BlockFormat format{};
    int width = 0, height = 0;
    std::vector<int> numbers;
    bool hasAlpha = true; ///< of BC1: alpha below 128 is transparent

    int GetChannels() const { return openntc::bc::GetBlockChannels(format); }
    int& At(int x, int y, int channel) { return numbers[GetPlace(x, y, channel)]; }
    int At(int x, int y, int channel) const { return numbers[GetPlace(x, y, channel)]; }

private:
    std::size_t GetPlace(int x, int y, int channel) const {
        return static_cast<std::size_t>((y * width + x) * GetChannels() + channel);
    }
};

/// A picture of one number in every channel of every texel.
BlockPicture MakePicture(openntc::bc::BlockFormat format, int width, int height, int number = 0);

std::vector<std::byte> EncodePicture(const BlockPicture& picture, openntc::tool::BlockEffort effort,
                                     int threads = 1);

/// Texels of a block, four channels each, as the numbers of a picture. BC1 to BC5 by a model in fractions
/// that shares nothing with the product; BC6H and BC7 by the product's decoder, which shader_bc compares with
/// samplers.
void DecodeNumbers(openntc::bc::BlockFormat format, const std::byte* block, double (&texels)[64]);

} // namespace numerics
