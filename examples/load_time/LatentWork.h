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

/// Who decompresses latents that files keep compressed. Cpu: all threads. Gpu: the GPU that decodes, with
/// VK_NV_memory_decompression. Shader: the GPU that decodes, by a compute pass.
enum class Decompressor { Cpu, Gpu, Shader };

/// The name that --decompress has for it.
const char* GetName(Decompressor decompressor);
/// Throws CommandError(Usage).
Decompressor FindDecompressor(const std::string& name);

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
