// SPDX-License-Identifier: MIT
// A small Vulkan compute harness for our tests and examples: one device, one queue, every call waits for its
// result.
//
// Not part of the product: engines own their devices and queues. The Vulkan loader is opened at run time, so
// programs that use this start without it; what is missing is reported as Status::Unsupported with the text
// "device or feature absent: ...". No Vulkan header is needed to include this file.
#pragma once

#include "openntc/core/Expected.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace openntc::harness {

/// Part of the name of Mesa's CPU implementation, the device of our tests.
inline constexpr const char* kLavapipe = "llvmpipe";

struct DeviceInfo {
    std::uint32_t index = 0; ///< as accepted by ContextOptions::device
    std::string name;
    std::string driver;
    std::uint32_t apiVersion = 0; ///< VK_MAKE_API_VERSION
    bool isCpu = false;
    bool hasIntegerDotProduct = false;
    bool hasFloat16 = false; ///< arithmetic in 16-bit floats
    bool hasBufferDeviceAddress = false;
    bool hasBufferArrays = false; ///< arrays of storage buffers, indices uniform over a draw or dispatch
    bool hasNonUniformIndexing = false; ///< the same, indices that differ between invocations
    bool hasSubgroupShuffle = false;    ///< in compute shaders
    std::uint32_t subgroupSize = 0;
    // Float controls of binary32 that a shader may ask for by an execution mode.
    bool hasDenormPreserve = false;
    bool hasDenormFlushToZero = false;
    bool hasSignedZeroInfNanPreserve = false;
    bool hasRoundToNearestEven = false;
    bool hasRoundTowardZero = false;
    bool hasTimestamps = false;            ///< on the compute queue that is used
    std::uint32_t timestampValidBits = 0;  ///< of that queue
    double timestampPeriodNanoseconds = 0; ///< nanoseconds per tick
    std::uint64_t maxStorageBufferBytes = 0;
    std::uint64_t maxUniformBufferBytes = 0;
    std::uint32_t maxPushConstantBytes = 0;
    std::uint32_t maxWorkgroupCount[3] = {};
};

/// What the validation layer reported. Shared, so that it can be read after the context has gone.
struct ValidationLog {
    std::vector<std::string> errors;
    std::vector<std::string> warnings;
};

struct ContextOptions {
    std::string device; ///< an index, part of a name (case-sensitive), or empty: a GPU if there is one
    bool validation =
        false; ///< needs VK_LAYER_KHRONOS_validation; its errors make the call that caused them fail
    std::string loaderLibrary;          ///< empty: the system's Vulkan loader
    std::shared_ptr<ValidationLog> log; ///< empty: the context makes its own
};

enum class BufferKind { Storage, Uniform };
enum class BufferMemory {
    HostVisible, ///< mapped; for data that is read back or written often
    DeviceLocal, ///< the device's own memory, through a staging buffer where the host cannot see it
};

class Context;

/// A buffer of a Context, which must outlive it.
class Buffer {
public:
    struct Impl;
    Buffer() noexcept;
    explicit Buffer(std::unique_ptr<Impl> impl) noexcept;
    Buffer(Buffer&&) noexcept;
    Buffer& operator=(Buffer&&) noexcept;
    ~Buffer();

    std::uint64_t GetSize() const noexcept;
    /// Where shaders find it; 0 if it is no storage buffer or the device has no buffer device addresses.
    std::uint64_t GetDeviceAddress() const noexcept;
    Impl* GetImpl() const noexcept { return impl_.get(); }

private:
    std::unique_ptr<Impl> impl_;
};

/// A binding of a pipeline, with more than one buffer an array.
struct BufferSlot {
    std::uint32_t binding;
    BufferKind kind;
    std::uint32_t set = 0; ///< descriptor set, 0 ... kMaxDescriptorSets - 1
    std::uint32_t count = 1;

    bool operator==(const BufferSlot&) const = default;
};

inline constexpr std::uint32_t kMaxDescriptorSets = 4; ///< what every device has

/// A compute pipeline of a Context, which must outlive it. Copies are the same pipeline.
class ComputePipeline {
public:
    struct Impl;
    ComputePipeline() noexcept;
    explicit ComputePipeline(std::shared_ptr<const Impl> impl) noexcept;

    /// Wall-clock seconds that vkCreateComputePipelines took.
    double GetCreationSeconds() const noexcept;
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

struct DispatchRequest {
    const ComputePipeline* pipeline = nullptr;
    std::span<const BoundBuffer> buffers;
    std::span<const std::byte> pushConstants;
    std::uint32_t groups[3] = {1, 1, 1};
};

struct DispatchTiming {
    std::optional<double>
        gpuSeconds;         ///< between timestamps around the dispatch; empty without timestamp support
    double wallSeconds = 0; ///< submission until the host saw completion
};

/// An instance, a device and a compute queue. Use from one thread at a time.
class Context {
public:
    /// Errors: Unsupported ("device or feature absent: ...") when the loader, the layer or the device is
    /// missing.
    static Expected<std::unique_ptr<Context>> Create(const ContextOptions& options);

    /// The devices that Create can choose from. An empty list is not an error; a missing loader is.
    static Expected<std::vector<DeviceInfo>> ListDevices(const std::string& loaderLibrary = {});

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
    Expected<void> Read(const Buffer& buffer, std::uint64_t offset, std::span<std::byte> bytes);

    /// Entry point "main". The context keeps its pipelines: asked again for the same code and slots it returns the one
    /// that it has, because drivers take tenths of a second to make one (some of that in the first dispatch).
    Expected<ComputePipeline> CreateComputePipeline(std::span<const std::uint32_t> spirv,
                                                    std::span<const BufferSlot> slots,
                                                    std::uint32_t pushConstantBytes);

    /// Runs one dispatch and waits. Every element of every slot must be bound to a buffer of the slot's kind.
    Expected<DispatchTiming> Dispatch(const DispatchRequest& request);

private:
    struct Impl;
    explicit Context(std::unique_ptr<Impl> impl) noexcept;
    template <typename F>
    auto Guard(const char* what, F&& function) -> decltype(function());
    std::unique_ptr<Impl> impl_;
};

} // namespace openntc::harness
