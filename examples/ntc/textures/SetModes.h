// SPDX-License-Identifier: MIT
// BC7 mode buffers of sets of generation 3: how blocks are coded, kept in the set itself.
#pragma once

#include "TextureSet.h"
#include "textures/HintGatherer.h"

#include "openntc/bc/BlockHints.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace openntc::tool {

/// The file of a set of generation 3 with these maps in the place of its own mode buffers; their textures are
/// declared to be BC7 where the set has no hint, since modes of no use to the format that a loader picks would
/// never be read. `compress`: by GDeflate, where that makes them smaller. Throws CommandError: Failed, BadInput
/// for what cannot be read.
std::vector<std::byte> PutModes(const TextureSetMetadata& metadata, Stream& stream,
                                std::span<const bc::BlockHintMap> maps, bool compress,
                                const std::string& subject);

struct SetModes {
    std::vector<std::byte> file; ///< empty if the set has no texture for BC7
    std::size_t textures = 0;
    HintStatistics statistics; ///< of all
};

/// Searches for the best BC7 blocks of each texture that is compared with BC7 (ChooseBlockFormat), of texels
/// that the set decodes to, and puts their modes into the file. `advance` is given texels and how many there
/// are in all. Throws CommandError(Failed), also when interrupted.
SetModes AddModes(std::span<const std::byte> file, bool compress, int threads, const std::string& subject,
                  const std::function<void(std::uint64_t, std::uint64_t)>& advance);

} // namespace openntc::tool
