// SPDX-License-Identifier: MIT
// Compute pipelines, what is bound to them, and dispatches.
#pragma once

#include "vulkan_harness/Buffers.h"
#include "vulkan_harness/Images.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace openntc::harness {

/// A binding of a pipeline, with more than one buffer or image an array.
struct BufferSlot {
    std::uint32_t binding;
    BufferKind kind;
    std::uint32_t set = 0; ///< descriptor set, 0 ... kMaxDescriptorSets - 1
    std::uint32_t count = 1;

    bool operator==(const BufferSlot&) const = default;
};

inline constexpr std::uint32_t kMaxDescriptorSets = 4; ///< what every device has

struct PipelineOptions {
    /// The context keeps the pipeline: asked again for the same code and slots it returns the one that it has, because
    /// drivers take tenths of a second to make one (some of that in the first dispatch).
    bool isKept = true;
    bool wantsStatistics = false; ///< where the device has Feature::PipelineStatistics
};

/// A pipeline of a Context, which must outlive it: for Dispatch, or of the other makers for Draw and TraceRays. Copies are
/// the same pipeline.
class ComputePipeline {
public:
    struct Impl;
    ComputePipeline() noexcept;
    explicit ComputePipeline(std::shared_ptr<const Impl> impl) noexcept;

    /// Wall-clock seconds that vkCreateComputePipelines took.
    double GetCreationSeconds() const noexcept;
    /// What the driver says about registers and memory; empty unless asked for.
    const std::string& GetStatistics() const noexcept;
    const Impl* GetImpl() const noexcept { return impl_.get(); }

private:
    std::shared_ptr<const Impl> impl_;
};

struct BoundBuffer {
    std::uint32_t binding;
    const Buffer* buffer;
    std::uint32_t set = 0;
    std::uint32_t element = 0; ///< of an array
};

struct BoundImage {
    std::uint32_t binding;
    const Image* image;
    std::uint32_t set = 0;
    std::uint32_t element = 0; ///< of an array
    std::uint32_t mip = 0;     ///< of a storage image; all are there to be sampled
};

struct DispatchRequest {
    const ComputePipeline* pipeline = nullptr;
    std::span<const BoundBuffer> buffers;
    std::span<const std::byte> pushConstants;
    std::uint32_t groups[3] = {1, 1, 1};
    std::span<const BoundImage> images = {};
    /// In a batch: need not wait for the dispatch before, none of whose writes it reads or overwrites.
    bool overlapsPrevious = false;
};

/// What Draw and TraceRays take: buffers and push constants as for a dispatch, and the size of the picture in pixels or of
/// the launch in rays.
struct PictureRequest {
    const ComputePipeline* pipeline = nullptr;
    std::span<const BoundBuffer> buffers;
    std::span<const std::byte> pushConstants;
    std::uint32_t width = 1;
    std::uint32_t height = 1;
    std::uint32_t vertices = 3; ///< of Draw: triangles of three
};

enum class Culling { None, Front, Back }; ///< front faces are counter-clockwise on the screen

/// What a pipeline of CreateRasterPipeline does with its images besides writing them.
struct RasterState {
    ImageFormat color = ImageFormat::RGBA32F;
    Culling culling = Culling::None;
    bool writesDepth = true;  ///< what is nearer passes: larger depth, cleared to 0
    bool passesEqual = false; ///< and what is as near
    bool writesColor = true;
    bool blends = false; ///< source alpha over what is there; alpha adds up likewise
};

/// Triangles without vertex buffers: gl_VertexIndex counts from firstVertex, gl_InstanceIndex is `instance`.
struct RasterDraw {
    const ComputePipeline* pipeline = nullptr;
    std::span<const BoundBuffer> buffers;
    std::span<const BoundImage> images;
    std::span<const std::byte> pushConstants;
    std::uint32_t firstVertex = 0;
    std::uint32_t vertices = 0;
    std::uint32_t instance = 0;
};

/// Draws into two images of one size, in order.
struct RasterRequest {
    const Image* color = nullptr;
    const Image* depth = nullptr; ///< D32
    bool clearsColor = true;      ///< to 0, before
    bool clearsDepth = true;      ///< likewise
    std::span<const RasterDraw> draws;
};

struct DispatchTiming {
    std::optional<double>
        gpuSeconds;         ///< between timestamps around the dispatch; empty without timestamp support
    double wallSeconds = 0; ///< submission until the host saw completion
};

/// Of several dispatches in one command buffer.
struct BatchTiming {
    /// Of each, with those after it that overlap it; empty without timestamp support.
    std::vector<double> gpuSeconds;
    double wallSeconds = 0; ///< submission until the host saw completion of all
};

} // namespace openntc::harness
