// SPDX-License-Identifier: MIT
// A small Vulkan harness for our tests, tools and examples: one device, one queue, every call waits for its result, and
// every error is an Expected.
//
// Not part of the product: engines own their devices and queues. The Vulkan loader is opened at run time, so
// programs that use this start without it; what is missing is reported as Status::Unsupported with the text
// "device or feature absent: ...". No Vulkan header is needed to include this file.
//
// Rooms: Features (a table of what may be absent), Devices, Buffers, Images, Pipelines (descriptors, dispatches, timing), Pictures, Raster,
// Sequences (many dispatches, not waited for), MemoryDecompression, Presentation (windows), CooperativeVectors, MatrixProbe;
// GpuDecoder decodes with the library's compute pass. A new room has a public header without Vulkan, its objects in VulkanObjects.h, and records its commands through Context::Impl::Submit.
#pragma once

#include "vulkan_harness/Buffers.h"
#include "vulkan_harness/Devices.h"
#include "vulkan_harness/Images.h"
#include "vulkan_harness/Pipelines.h"
#include "vulkan_harness/Presentation.h"
#include "vulkan_harness/Sequences.h"

#include "openntc/core/Expected.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace openntc::harness {

/// An instance, a device and a compute queue. Use from one thread at a time.
class Context {
public:
    /// Errors: Unsupported ("device or feature absent: ...") when the loader, the layer, the device or a feature that
    /// is required is missing, with the reason.
    static Expected<std::unique_ptr<Context>> Create(const ContextOptions& options);

    ~Context();
    Context(const Context&) = delete;
    Context& operator=(const Context&) = delete;

    const DeviceInfo& GetDevice() const noexcept;
    const ValidationLog& GetValidationLog() const noexcept;

    /// Zero-filled. `bytes` > 0 and within the device's limit for the kind.
    Expected<Buffer> CreateBuffer(std::uint64_t bytes, BufferKind kind, BufferMemory memory);
    /// A buffer with a copy of `contents`; an empty span gives one zero word, because Vulkan has no empty
    /// buffers.
    Expected<Buffer> CreateBuffer(std::span<const std::byte> contents, BufferKind kind, BufferMemory memory);
    Expected<void> Write(const Buffer& buffer, std::uint64_t offset, std::span<const std::byte> bytes);
    /// All of them in one submission, through staging memory that the context keeps.
    Expected<void> Write(std::span<const BufferWrite> writes);
    Expected<void> Read(const Buffer& buffer, std::uint64_t offset, std::span<std::byte> bytes);

    /// Zero-filled, but for blocks, which are what is written. Errors: Unsupported without Feature::StorageImages (blocks:
    /// BlockCompression) or for a format that the device does not store to (blocks: sample);
    /// OutOfRange.
    Expected<Image> CreateImage(ImageFormat format, std::uint32_t width, std::uint32_t height,
                                std::uint32_t mips = 1);
    /// Layers of one size, to be sampled as an array. Errors: as CreateImage.
    Expected<Image> CreateImageArray(ImageFormat format, std::uint32_t width, std::uint32_t height,
                                     std::uint32_t layers, std::uint32_t mips = 1);
    /// All texels of a mip, rows one after the other: Image::GetBytes(mip) bytes.
    Expected<void> Write(const Image& image, std::span<const std::byte> texels, std::uint32_t mip = 0);
    Expected<void> Read(const Image& image, std::span<std::byte> texels, std::uint32_t mip = 0);
    /// The buffer's first bytes become a mip.
    Expected<void> Copy(const Buffer& buffer, const Image& image, std::uint32_t mip);
    /// Rectangles of mip 0, in one submission. Errors: OutOfRange for what is not inside the image or the buffer.
    Expected<void> Copy(const Buffer& buffer, const Image& image, std::span<const BufferToImage> regions);
    /// The same from an image of the same format.
    Expected<void> Copy(const Image& from, const Image& image, std::span<const ImageToImage> regions);

    /// Entry point "main".
    Expected<ComputePipeline> CreateComputePipeline(std::span<const std::uint32_t> spirv,
                                                    std::span<const BufferSlot> slots,
                                                    std::uint32_t pushConstantBytes,
                                                    const PipelineOptions& options = {});

    /// Runs one dispatch and waits. Every element of every slot must be bound to a buffer of the slot's kind or to an image.
    Expected<DispatchTiming> Dispatch(const DispatchRequest& request);

    /// Runs the dispatches one after the other, each when those before have ended and their writes are seen, unless it says
    /// that it overlaps them, in one command buffer, and waits. Errors: as Dispatch.
    Expected<BatchTiming> DispatchBatch(std::span<const DispatchRequest> requests);

    /// Runs the dispatch `repetitions` times and waits: seconds between the timestamps round each, which begins when the
    /// one before has ended. Many are one submission, so that a device does not idle and lower its clocks between them.
    /// Errors: as Dispatch; Unsupported on a queue without timestamps.
    Expected<std::vector<double>> TimeDispatches(const DispatchRequest& request, std::uint32_t repetitions);

    /// Errors: as Dispatch, of what is bound.
    Expected<Sequence> CreateSequence(std::span<const SequencePass> passes);
    /// Writes into buffers (offsets and sizes multiples of 4), then runs the dispatches, each when those before have ended and
    /// their writes are seen, after all that was submitted before. Returns when that is under way, which it waits for only
    /// where kSequenceSubmissions are. Errors: as Dispatch.
    Expected<void> Submit(const Sequence& sequence, std::span<const BufferWrite> writes,
                          std::span<const SequenceDispatch> dispatches);
    /// Until so many submissions of the sequence have ended.
    Expected<void> Wait(const Sequence& sequence, std::uint64_t submissions);

    /// Vertex and fragment shader, entry points "main"; triangles that are not culled, one sample a pixel, and no image: the
    /// fragment shader writes buffers. Kept, as compute pipelines are. Errors: Unsupported without
    /// Feature::FragmentStores or a queue that draws.
    Expected<ComputePipeline> CreateDrawPipeline(std::span<const std::uint32_t> vertexSpirv,
                                                 std::span<const std::uint32_t> fragmentSpirv,
                                                 std::span<const BufferSlot> slots,
                                                 std::uint32_t pushConstantBytes);
    /// The same, which writes a colour and a depth image. Errors: Unsupported without Feature::DynamicRendering, a queue
    /// that draws, or a colour format that the device draws to (and blends).
    Expected<ComputePipeline> CreateRasterPipeline(std::span<const std::uint32_t> vertexSpirv,
                                                   std::span<const std::uint32_t> fragmentSpirv,
                                                   std::span<const BufferSlot> slots,
                                                   std::uint32_t pushConstantBytes, const RasterState& state);
    /// Draws all and waits. Errors: InvalidArgument for images of other formats and sizes, and as Dispatch.
    Expected<DispatchTiming> Draw(const RasterRequest& request);
    /// A ray-generation shader, entry point "main", with nothing to hit. Errors: Unsupported without Feature::RayTracing.
    Expected<ComputePipeline> CreateRayPipeline(std::span<const std::uint32_t> spirv,
                                                std::span<const BufferSlot> slots,
                                                std::uint32_t pushConstantBytes);
    /// Draws once, or launches once, and waits.
    Expected<void> Draw(const PictureRequest& request);
    Expected<void> TraceRays(const PictureRequest& request);

    NativeHandles GetHandles() const noexcept;
    /// Submits what `record` records and waits.
    Expected<void> Record(const RecordCommands& record);
    /// Errors: Unsupported on a queue that does not draw.
    Expected<Overlay> CreateOverlay();
    /// `record` draws over an image of format RGBA8, inside the overlay's render pass. Waits.
    Expected<void> Draw(const Overlay& overlay, const Image& target, const RecordCommands& record);
    /// All of mip 0, scaled to fill the other image; both are of colours and not of blocks.
    Expected<void> Scale(const Image& from, const Image& to);

    /// Errors: Unsupported without Feature::Swapchain, and for surfaces that this queue does not present to or that have no
    /// format of 8 bits without conversion to sRGB.
    Expected<Presenter> CreatePresenter(const MakeSurface& makeSurface);
    /// The surface's size in pixels has changed. With a side of 0 nothing is presented until the next size.
    Expected<void> Resize(Presenter& presenter, std::uint32_t width, std::uint32_t height);
    /// Shows the image, scaled to the surface. False: nothing was shown, because the surface has no size or another one than
    /// was said; to be followed by Resize.
    Expected<bool> Present(Presenter& presenter, const Image& image);

    /// Decompresses all tiles, then makes all copies, in one submission, and waits; passes that come later see
    /// the bytes. Buffers are of kind Storage. Tiles whose bits are corrupt make the device do what it likes.
    /// Errors: Unsupported for tiles without Feature::MemoryDecompression; OutOfRange for what leaves its buffer
    /// or does not suit the device.
    Expected<DispatchTiming> Decompress(std::span<const DecompressedTile> tiles,
                                        std::span<const BufferCopy> copies);

    /// Weights for cooperative vectors in the device's own layout; the offsets are in `weights` afterwards. Errors:
    /// Unsupported without Feature::CooperativeVectors.
    Expected<std::vector<std::byte>> ConvertWeights(CoopVecWeights& weights);

private:
    struct Impl;
    explicit Context(std::unique_ptr<Impl> impl) noexcept;
    template <typename F>
    auto Guard(const char* what, F&& function) -> decltype(function());
    std::unique_ptr<Impl> impl_;
};

} // namespace openntc::harness
