// SPDX-License-Identifier: MIT
// Compressed latents of a set on their way into memory: as they are uploaded, or decompressed on the CPU.
#pragma once

#include "openntc/core/ThreadTeam.h"
#include "openntc/inference/LatentDecompression.h"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace openntc::load_time {

struct LatentWork {
    LatentDecompression plan;
    std::vector<std::byte> upload; ///< plan.uploadBytes
};

/// Nothing where no layer is compressed. Throws CommandError(BadInput).
std::optional<LatentWork> ReadLatentWork(const TextureSetMetadata& metadata, Stream& stream,
                                         const std::string& name);

/// The latents, tile by tile on the team's threads. Throws CommandError(BadInput).
std::vector<std::byte> DecompressOnCpu(LatentWork& work, ThreadTeam& team, const std::string& name);

} // namespace openntc::load_time
