// SPDX-License-Identifier: MIT
// Searches for the best BC7 blocks of a texture, keeps how they are coded, and tells what knowing it gains.
#pragma once

#include "textures/BlockCoding.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace openntc::tool {

/// One way to make a texture's blocks. Errors are of the channels that the texture has.
struct HintTrial {
    double seconds = 0.0; ///< by the clock
    double squares = 0.0; ///< of differences of bytes, exact up to 2^53
    std::uint64_t numbers = 0;

    HintTrial& operator+=(const HintTrial& other);
    /// Infinite without an error.
    double GetPsnr() const;
};

struct HintStatistics {
    std::uint64_t texels = 0;
    std::uint64_t blocks = 0;
    std::array<std::uint64_t, 8> modes{}; ///< blocks of each
    std::uint64_t different = 0; ///< blocks that hints do not give as the search did: none is expected
    HintTrial search;            ///< with the effort asked for
    HintTrial hinted;            ///< the same effort with the hints
    HintTrial fast;              ///< a search of the lowest effort, for comparison

    HintStatistics& operator+=(const HintStatistics& other);
};

/// Takes the mips of one texture, one after the other.
class HintGatherer {
public:
    /// `format` is of BC7, `channels` (1 … 4) are those that the texture has. `subject` is named in errors.
    HintGatherer(const TextureFormat& format, int channels, BlockEffort effort, int threads,
                 std::string subject);

    /// The next whole rows of the mip, RGBA; a multiple of four, except at its end. Throws CommandError(Failed) when
    /// interrupted.
    void AddRows(const TexelRows& rows);

    std::uint32_t GetTexelCrc() const { return texelCrc_; }
    /// Ends the mip: its packed map.
    std::vector<std::byte> TakeMap();

    const HintStatistics& GetStatistics() const { return statistics_; }

private:
    void Encode(const TexelRows& rows, BlockEffort effort, std::span<const std::int32_t> hints,
                std::vector<std::byte>& blocks, HintTrial& trial) const;

    TextureFormat format_;
    int channels_;
    BlockEffort effort_;
    int threads_;
    std::string subject_;
    HintStatistics statistics_;
    std::uint32_t texelCrc_ = 0;
    std::vector<std::int32_t> hints_; // of the mip
    std::vector<std::byte> found_, again_;
};

} // namespace openntc::tool
