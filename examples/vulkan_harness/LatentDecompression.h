// SPDX-License-Identifier: MIT
// Latents of sets with compressed layers, decompressed by the device itself or by a compute pass.
#pragma once

#include "vulkan_harness/Vulkan.h"

#include "openntc/inference/LatentDecompression.h"

#include <cstdint>
#include <deque>
#include <vector>

namespace openntc::harness {

enum class TileDecoder {
    Device, ///< VK_NV_memory_decompression
    Shader, ///< passes/DecompressGDeflate, on any device
};

/// Does what plans say, of many at once. The context must outlive it.
class LatentDecompressor {
public:
    /// Errors: Unsupported for Device without Feature::MemoryDecompression.
    static Expected<LatentDecompressor> Create(Context& context, TileDecoder decoder);

    /// Forgets all plans.
    void Clear();
    /// `work` and `latents` have at least workBytes and latentBytes, and stay where they are. The plan's tiles
    /// become work of the next Run. Errors: as Context::CreateBuffer.
    Expected<void> Add(const LatentDecompression& plan, const Buffer& work, const Buffer& latents);
    bool IsEmpty() const { return tiles_.empty() && works_.empty(); }
    /// Decompresses and copies, when uploads are written, and waits. Returns seconds of the device, or of the
    /// host where it has no clock. Errors: FileUnrecognized for tiles that are corrupt, which only Shader finds;
    /// Context::Decompress's.
    Expected<double> Run();

private:
    /// A dispatch with what it refers to.
    struct Work {
        const Buffer* tiles = nullptr;
        const Buffer* work = nullptr;
        const Buffer* output = nullptr;
        std::vector<std::byte> constants;
        std::uint32_t groups[3] = {1, 1, 1};
    };

    LatentDecompressor(Context& context, TileDecoder decoder) : context_(&context), decoder_(decoder) {}
    Expected<void> AddShaderWork(const LatentDecompression& plan, const Buffer& work, const Buffer& latents);
    Expected<double> RunShader();

    Context* context_;
    TileDecoder decoder_;
    std::vector<DecompressedTile> tiles_; // of Device
    std::vector<BufferCopy> copies_;
    ComputePipeline pipeline_; // of Shader, as all that follows
    Buffer corrupt_;
    std::deque<Buffer> tileBuffers_;
    std::deque<Work> works_;
};

} // namespace openntc::harness
