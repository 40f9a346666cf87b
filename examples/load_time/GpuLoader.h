// SPDX-License-Identifier: MIT
// Loads texture sets on a Vulkan device: latents are uploaded, all mips decoded into images by passes/DecompressToTextures and
// the images turned into blocks by passes/CompressBlocks, in one command buffer for a batch of sets. No Vulkan header is
// needed to include this file.
#pragma once

#include "LatentWork.h"

#include "Decoder.h"
#include "textures/BlockCoding.h"
#include "textures/HintFile.h"

#include "openntc/texture_set/TextureSetMetadata.h"

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace openntc::load_time {

/// What is loaded of one set.
struct GpuSet {
    const TextureSetMetadata* metadata = nullptr;
    const tool::DecodeData* data = nullptr;
    const LatentWork* compressed = nullptr; ///< latents that the device decompresses, instead of the data's
    std::vector<const Texture*> textures;
    std::vector<tool::TextureFormat> formats; ///< of `textures`
    std::vector<tool::TextureHints> hints;    ///< of `textures`; empty ones search
};

struct GpuTimes {
    double upload = 0.0;     ///< milliseconds of the host: copies of latents, weights, constants and hints
    double decompress = 0.0; ///< milliseconds of the device
    double decode = 0.0;     ///< likewise
    double transcode = 0.0;  ///< likewise
};

class GpuLoader {
public:
    /// Throws CommandError(NoDevice) without the device, or in builds without Vulkan.
    static std::unique_ptr<GpuLoader> Create(const std::string& device);
    virtual ~GpuLoader() = default;

    virtual std::string GetDeviceName() const = 0;
    /// Cpu, Gpu or Shader, for this and all later batches. Throws CommandError(NoDevice) for Gpu without the feature.
    virtual void UseDecompressor(Decompressor decompressor) = 0;
    /// False for formats that this program has no shader of.
    virtual bool HasShader(bc::BlockFormat format, tool::BlockEffort effort) const = 0;
    /// One batch. Memory, images and pipelines are made before time begins, as an engine's pools have them. Blocks
    /// are kept until the next batch. Throws CommandError(Failed).
    virtual GpuTimes Load(std::span<const GpuSet> sets, tool::BlockEffort effort) = 0;
    /// The batch's blocks: set by set, mip by mip from the largest, texture by texture.
    virtual std::vector<std::vector<std::byte>> ReadBlocks() = 0;
};

} // namespace openntc::load_time
