// SPDX-License-Identifier: MIT
// Tiles of texture sets into atlases: passes/DecompressToTextures of a tile's rectangles, passes/CompressBlocks, copies.
#pragma once

#include "renderer/gpu/FeedbackTiles.h"
#include "renderer/gpu/SetDecoding.h"
#include "renderer/gpu/ShaderCache.h"

#include "Decoder.h"
#include "vulkan_harness/Vulkan.h"

#include <cstdint>
#include <deque>
#include <map>
#include <span>
#include <utility>
#include <vector>

namespace openntc::renderer {

/// A texture set whose textures are decoded on demand; a tile has all of them.
struct StreamedSet {
    const TextureSetMetadata* metadata = nullptr;
    NtcTextureSetConstants constants = {};
    harness::Buffer latents, weights;
    TileLayout layout;
    std::vector<SlotPlan> slots; ///< of its textures, in the order of a pool's atlases
    std::vector<DecompressionOutput> outputs;
};

/// A tile to decode, and where it goes: texels of a layer.
struct TileJob {
    const StreamedSet* set = nullptr;
    std::uint32_t tile = 0;
    const std::vector<harness::Image>* atlases = nullptr; ///< one a texture of the set
    std::uint32_t left = 0;
    std::uint32_t top = 0;
    std::uint32_t layer = 0;
};

/// Of the device; copies into atlases, and all on a device that is the CPU, by the host's clock.
struct TileSeconds {
    double resolve = 0.0;
    double decode = 0.0;
    double transcode = 0.0; ///< with the copies
};

class FeedbackDecoder {
public:
    FeedbackDecoder(harness::Context& context, ShaderCache& shaders, const DeviceFeatures& device,
                    int tileSize, tool::BlockEffort effort)
        : context_(context), shaders_(shaders), device_(device), tileSize_(tileSize), effort_(effort) {}

    /// Decodes all and waits. Throws CommandError.
    void Run(std::span<const TileJob> jobs, TileSeconds& seconds);

    /// Of texels and blocks on their way.
    std::uint64_t GetBytes() const;

private:
    /// Texels of one tile and texture: where they are, and where they go.
    struct Piece {
        const harness::Image* texels;
        const harness::Image* atlas;
        const SlotPlan* slot;
        Rect from;
        harness::ImageRegion to;
    };

    void RunBatch(std::span<const TileJob> jobs, TileSeconds& seconds);
    std::vector<Piece> Decode(std::span<const TileJob> jobs, TileSeconds& seconds);
    void Transcode(const std::vector<Piece>& pieces, TileSeconds& seconds);
    void CopyTexels(const std::vector<Piece>& pieces);
    /// Scratch images of a set's textures.
    std::vector<const harness::Image*> FindScratch(const StreamedSet& set);
    const harness::Buffer& GetConstants(std::size_t number);

    harness::Context& context_;
    ShaderCache& shaders_;
    DeviceFeatures device_;
    int tileSize_;
    tool::BlockEffort effort_;
    std::map<std::pair<harness::ImageFormat, std::size_t>, harness::Image> scratch_;
    std::deque<harness::Buffer> constants_;
    harness::Buffer blocks_;
};

} // namespace openntc::renderer
