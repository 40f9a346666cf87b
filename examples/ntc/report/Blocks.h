// SPDX-License-Identifier: MIT
// What accuracy costs in time where textures are compressed to blocks on load: every format at every level.
#pragma once

#include "report/Accuracy.h"
#include "report/Encodings.h"
#include "report/Report.h"
#include "textures/BlockMeasurement.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace openntc::report {

/// A point of the axis of block compression.
struct BlockCase {
    bc::BlockFormat format = bc::BlockFormat::Bc7;
    tool::BlockEffort effort = tool::BlockEffort::Normal;
    bool isHinted = false; ///< with the modes that the search chose, as a file of hints gives them at load

    std::string GetId() const;
    /// The case whose blocks this one must have: itself, without hints.
    BlockCase GetSearch() const { return {format, effort, false}; }
};

/// `quick`: three formats.
std::vector<BlockCase> ListBlockCases(bool quick);

/// What one format compresses: textures of the sample material, as the INT8 decoder yields mip 0 of them.
struct BlockTexture {
    std::string name; ///< `BaseColor, in linear light`
    tool::BlockSource decoded, original;
    int width = 0, height = 0;
    std::uint64_t rawBytes = 0; ///< of the channels that the format keeps of them
};

/// Of a case with hints: one a block, from the blocks of the search. Empty without hints.
std::vector<std::int32_t> GatherBlockHints(const BlockCase& c, const BlockTexture& texture);

/// Throws CommandError.
BlockTexture MakeBlockTexture(bc::BlockFormat format, const Encoding& encoding, ReferenceDecodes& references);

/// All textures and mips of an encoding: raw, in the block formats that the set names, and as the set itself.
BlockSizeRecord MeasureBlockSizes(const Encoding& encoding);

/// One way to encode a texture, ready to run. Refers to the texture and its device, which must outlive it.
class PreparedBlocks {
public:
    virtual ~PreparedBlocks() = default;
    /// On a processor; 0: a GPU, or a driver that decides itself.
    virtual int GetThreads() const = 0;
    /// The blocks of the texture.
    virtual std::vector<std::byte> Encode() = 0;
    /// Nanoseconds per texel of `repeats` runs, after what is needed to warm up.
    virtual std::vector<double> Time(int repeats) = 0;
};

/// The C++ encoder: with one thread by the processor's time, with several by the wall clock, on copies of the
/// texture if it has too few texels for all.
std::unique_ptr<PreparedBlocks> PrepareBlocksOnCpu(const BlockCase& c, const BlockTexture& texture,
                                                   int threads);

/// A record with everything but the times. `expected`: the C++ encoder's blocks, of the search if the case has hints.
BlockRecord JudgeBlocks(const BlockCase& c, const BlockTexture& texture, PreparedBlocks& prepared,
                        std::span<const std::byte> expected);

} // namespace openntc::report
