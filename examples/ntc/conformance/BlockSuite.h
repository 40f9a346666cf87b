// SPDX-License-Identifier: MIT
// Cases of block compression in the exported suite: a picture, a format and a level give these blocks, bit for
// bit. Our encoders are whole numbers, so that whoever compiles their shaders, with whatever compiler and for
// whatever device, has the same blocks or has found a fault.
#pragma once

#include "../textures/BlockCoding.h"

#include "openntc/core/Expected.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace openntc::tool {
class JsonWriter;
}

namespace openntc::conformance {

inline constexpr int kMaxBlockPicture = 1024; ///< texels of a side of a request

/// A picture to compress: four channels a texel, R first, rows one after the other; unsigned bytes, signed ones
/// for signed BC4 and BC5, for BC6H binary16 with the low byte first.
struct BlockRequest {
    bc::BlockFormat format{};
    tool::BlockEffort level = tool::BlockEffort::Normal;
    int alphaThreshold = -1; ///< BC1: alpha at most this is transparent; -1: nothing is
    int width = 0, height = 0;
    std::span<const std::byte> texels;

    std::size_t GetTexelBytes() const;   ///< 4 or 8
    std::size_t GetPictureBytes() const; ///< of all texels
    std::size_t GetRowBytes() const;     ///< of a row of blocks
    std::size_t GetBlockBytes() const;   ///< of all blocks
};

/// One case of suite.json.
struct BlockSuiteCase {
    std::string name;
    std::string texels; ///< file name of the picture
    std::string blocks; ///< file name of the expected blocks
    bc::BlockFormat format{};
    tool::BlockEffort level = tool::BlockEffort::Normal;
    int alphaThreshold = -1;
    int width = 0, height = 0;
    bool mustPass = false; ///< a decoder that has the capability at all must pass
    std::string about;

    BlockRequest MakeRequest(std::span<const std::byte> picture) const {
        return {format, level, alphaThreshold, width, height, picture};
    }
};

/// The list `blocks` of suite.json; empty where there is none. Errors: Status::FileUnrecognized, naming the
/// member; file names that leave the folder are refused.
Expected<std::vector<BlockSuiteCase>> ReadBlockCases(std::span<const std::byte> json);
/// Writes the member.
void WriteBlockCases(tool::JsonWriter& json, std::span<const BlockSuiteCase> cases);

/// The cases of this version, and the picture of one; the same on every machine.
std::vector<BlockSuiteCase> ListBlockSuite();
std::vector<std::byte> MakeBlockPicture(const BlockSuiteCase& blockCase);

/// `fast`, `normal`, `best`.
bool FindBlockLevel(std::string_view name, tool::BlockEffort& level);

/// What integrations of block compression do wrong.
enum class BlockMistake : std::uint8_t {
    None,
    SwappedRedBlue,
    UpsideDown,
    ZeroBeyondEdge,
    SrgbRead,
    LevelFast,
    LevelNormal,
    ThresholdOpaque,
    ThresholdIgnored,
    ThresholdAlways,
    SignedAsUnsigned,
    NanIsLargest,
    SignDropped,
    SwappedWords,
    SwappedHalves,
    ColumnOrder,
};

struct BlockMistakeInfo {
    BlockMistake mistake;
    const char* name;     ///< of wrong_decoder
    const char* cause;    ///< what the encoder does, and should do
    const char* caseName; ///< the exported case that is meant for it
};

/// Every mistake but None.
std::span<const BlockMistakeInfo> ListBlockMistakes();

/// The blocks of our encoder, or of one with a mistake. Throws CommandError.
std::vector<std::byte> EncodeBlockRequest(const BlockRequest& request,
                                          BlockMistake mistake = BlockMistake::None);

} // namespace openntc::conformance
