// SPDX-License-Identifier: MIT
// The device side: buffers, the pipeline, and a pass over all pixels. With a page table it takes tiles from a
// demand loader; without one every latent is there from the start.
#pragma once

#include "Landscape.h"

#include "openntc/streaming/DemandLoader.h"
#include "vulkan_harness/Vulkan.h"

#include <optional>
#include <vector>

namespace openntc::landscape {

/// What a pass left behind.
struct Picture {
    std::vector<LandscapePixel> pixels;
    std::vector<std::uint32_t> colors; ///< R, G, B, 255 from the lowest byte on
};

class Renderer final : public TileUploader {
public:
    /// With `table` a streaming renderer, whose pool has `poolBytes`; without, all latents of the landscape
    /// are made and uploaded. Throws CommandError: NoDevice where the device cannot bind so much.
    Renderer(harness::Context& context, const Landscape& landscape, std::uint64_t pixels,
             const PageTable* table, std::uint64_t poolBytes);

    /// Fields get the textures that they are sampled from: one each.
    void SetTextures(std::span<const std::uint32_t> textureIds);

    Expected<void> Upload(const TileUpload& upload) override;
    /// Brings a plan's changes to the device, and empties the queue.
    void Apply(const LaunchPlan& plan, const PageTable& table);
    /// Seconds of the pass: the device's where it has timestamps.
    double Draw(const LandscapeScene& scene);
    /// What shaders asked for and used; valid until the next call.
    DemandReadback ReadState();
    Picture ReadPicture(std::uint64_t pixels);

private:
    harness::Buffer Make(std::span<const std::byte> bytes, harness::BufferKind kind);
    harness::Buffer Make(std::uint64_t bytes);
    void MakePipeline(bool isTiled);
    std::uint64_t UploadAllLatents();

    harness::Context& context_;
    const Landscape& landscape_;
    LaunchState state_;
    std::vector<LandscapeField> fieldRows_;
    std::vector<std::byte> stateBytes_;
    harness::Buffer scene_, latents_, weights_, sets_, fields_, pixels_, colors_, table_, launchState_;
    harness::ComputePipeline pipeline_;
    std::vector<harness::BoundBuffer> bound_;
};

} // namespace openntc::landscape
