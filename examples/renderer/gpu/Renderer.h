// SPDX-License-Identifier: MIT
// Renders a scene: a visibility buffer that compute shaders shade in tiles, or forward in fragment shaders; blended surfaces
// forward, from the farthest to the nearest; the mean over frames; the picture.
#pragma once

#include "renderer/gpu/MaterialPlan.h"
#include "renderer/gpu/SceneBuffers.h"
#include "renderer/gpu/ShaderCache.h"
#include "renderer/gpu/TextureStore.h"

#include "vulkan_harness/Vulkan.h"

#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <vector>

namespace openntc::renderer {

enum class Pass { Visibility, Masks, Sky, Shade, Blend, Accumulate, Resolve, Decode, Transcode, Count };

inline constexpr std::size_t kPassCount = static_cast<std::size_t>(Pass::Count);

/// Seconds of a frame on the device, by pass.
using PassSeconds = std::array<double, kPassCount>;

/// Of the device, where it has a clock.
inline double GetSeconds(const harness::DispatchTiming& timing) {
    return timing.gpuSeconds.value_or(timing.wallSeconds);
}

struct TexelCounts {
    std::uint64_t read = 0;    ///< texels of lookups, each of all textures that share it
    std::uint64_t decoded = 0; ///< by a network
};

class Renderer {
public:
    /// Loads textures and makes pipelines. Throws CommandError.
    Renderer(harness::Context& context, ShaderCache& shaders, Scene& scene, const RenderOptions& options);
    Renderer(const Renderer&) = delete; // parts know the options where they are
    Renderer& operator=(const Renderer&) = delete;

    /// Takes other options; what they do not change stays. False, and all stays, where they call for other textures: that is another
    /// Renderer. The next frame begins a new mean. Throws CommandError.
    bool Apply(const RenderOptions& options);

    /// Adds frame `frame` to the mean of those since frame 0, which begins a new one. On feedback it is drawn again until
    /// its tiles are there (RenderOptions::settle); seconds are those of all its passes.
    PassSeconds Render(const Camera& camera, std::uint32_t frame, bool isJittered);
    const RenderOptions& GetOptions() const { return options_; }
    /// On feedback: whether the last frame would be the same drawn again. Else always.
    bool IsSettled() const { return isSettled_; }
    /// The picture: width * height words, RGBA from the lowest byte on.
    const harness::Buffer& GetPixels() const { return pixels_; }
    /// RGBA, rows from the top.
    std::vector<std::uint8_t> ReadPicture();
    /// Of all frames since the last call.
    TexelCounts TakeCounts();

    const std::vector<MaterialPlan>& GetPlans() const { return plans_; }
    const TextureStore& GetTextures() const { return textures_; }
    std::uint64_t GetGeometryBytes() const { return buffers_.GetBytes(); }
    std::uint64_t GetTargetBytes() const;

private:
    struct MaterialState {
        harness::Buffer constants;
        std::vector<harness::BoundBuffer> buffers;
        std::vector<harness::BoundImage> images;
        harness::ComputePipeline shade;   // of compute
        harness::ComputePipeline resolve; // of masks
        // By culling: of instances as they are, and of flipped ones.
        std::array<harness::ComputePipeline, 2> draw, collect, forward;
    };
    using DrawPipelines = std::array<harness::ComputePipeline, 2> MaterialState::*;

    void MakeTargets();
    void MakeMaterials();
    void BindMaterial(MaterialState& state, const MaterialPlan& plan);
    void MakePipelines(MaterialState& state, const Material& material, const MaterialPlan& plan);
    std::array<harness::ComputePipeline, 2> MakeDraws(const char* fragment,
                                                      const std::vector<std::string>& defines,
                                                      const std::vector<harness::BufferSlot>& slots,
                                                      const Material& material, harness::RasterState state);
    double DispatchScreen(const harness::ComputePipeline& pipeline);
    void DrawFrame(PassSeconds& seconds);
    void WriteFrame(const Camera& camera, std::uint32_t frame, bool isJittered);
    double Draw(const std::vector<std::size_t>& instances, DrawPipelines pipelines,
                const harness::Image& color, bool clears);
    double DispatchTiles(harness::ComputePipeline MaterialState::*pipeline, bool overlaps);
    std::vector<std::size_t> ListInstances(AlphaMode mode) const;
    void MakeMaskTargets();
    void MakeVisibility(MaterialState& state, const Material& material, const MaterialPlan& plan);
    void MakeMaskPipelines(MaterialState& state, const Material& material, const MaterialPlan& plan);
    double CollectCandidates(const std::vector<std::size_t>& instances);
    double DrawMasks(const std::vector<std::size_t>& instances);
    const Material& GetMaterial(std::size_t instance) const;
    bool IsShown(int material) const;

    harness::Context& context_;
    ShaderCache& shaders_;
    Scene& scene_;
    RenderOptions options_;
    SceneBuffers buffers_;
    TextureStore textures_;
    std::vector<MaterialPlan> plans_;
    std::deque<MaterialState> materials_; // states stay where they are
    harness::Buffer frame_, counters_, pixels_;
    harness::Buffer candidates_, lists_; // of masked surfaces; empty without any
    harness::Image visible_, depth_, picture_, mean_;
    harness::ComputePipeline sky_, accumulate_, clearCandidates_;
    std::vector<harness::BoundBuffer> frameBuffers_;
    std::vector<harness::BoundImage> frameImages_;
    glm::mat4 toClip_{1.0f};
    bool isSettled_ = true;
};

} // namespace openntc::renderer
