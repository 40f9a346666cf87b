// SPDX-License-Identifier: MIT
// Stability: experimental
// What the encoder needs to train on a GPU: buffers, passes and their constants. Creating and submitting
// them stays with the caller, who implements TrainingDevice for his queue; encode/DeviceEncoder.h trains
// with it.
#pragma once

#include "openntc/core/Expected.h"
#include "openntc/encode/TrainConstants.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc::encode {

/// Storage buffers; the value is the binding in set 0 of all passes.
enum class TrainingBuffer : std::uint32_t {
    Constants,
    Mips,
    Taps,
    Tiles,
    References,
    Batch, ///< written by submissions
    Weights,
    Rows,
    Latents,
    LatentGradients,
    Partials,
    FirstMoments,
    SecondMoments,
    Network,
    Losses, ///< is read while later submissions run: memory that the host sees
    Ranges,
    Kept,
    Tried,
    Count,
};
inline constexpr std::size_t kTrainingBuffers = static_cast<std::size_t>(TrainingBuffer::Count);

/// Compute shaders: shaders/openntc/passes/NAME.comp.
enum class TrainingPass : std::uint32_t {
    TrainTexels, ///< has a form on matrices
    TrainUpdate,
    TryMoves, ///< the same, compiled with NTC_TRAIN_TRIES=1
    TrainMoves,
    Count,
};
inline constexpr std::size_t kTrainingPasses = static_cast<std::size_t>(TrainingPass::Count);

inline constexpr const char* kTrainingPassNames[kTrainingPasses] = {"TrainTexels", "TrainUpdate",
                                                                    "TrainTexels", "TrainMoves"};
/// Buffers that a pass binds, a bit each.
inline constexpr std::uint32_t kTrainingBindings[kTrainingPasses] = {0x007FFu, 0x07FEFu, 0x301DFu, 0x3C103u};

/// What a training needs; memory on the device is the sum of the buffers.
struct TrainingPlan {
    std::array<std::uint64_t, kTrainingBuffers> bytes{}; ///< of each buffer, multiples of 16; zeroed at first
    int generation = 1;                                  ///< NTC_TRAIN_GENERATION of the shaders, 1 or 3
    int inputs = 64; ///< NTC_TRAIN_INPUTS of the shaders: 64 or 96, in generation 3 32 or 64
};

struct TrainingDispatch {
    TrainingPass pass = TrainingPass::TrainTexels;
    NtcTrainStep step{}; ///< push constants
    std::uint32_t groups = 1;
};

/// A device that trains. Calls come from one thread; after an error nothing else is asked of it.
class TrainingDevice {
public:
    virtual ~TrainingDevice() = default;

    /// Of the arithmetic, as a program names it and a state is bound to it; at most 15 characters.
    virtual const char* GetKernelName() const = 0;
    /// Bytes of the largest storage buffer. References that are larger come with each submission.
    virtual std::uint64_t GetLargestBuffer() const = 0;
    /// Makes pipelines and zeroed buffers; those of an earlier plan go. Errors: Unsupported for what the
    /// device lacks, OutOfMemory.
    virtual Expected<void> Create(const TrainingPlan& plan) = 0;
    /// `offset` and the number of bytes are multiples of 4. After all that was submitted before.
    virtual Expected<void> Write(TrainingBuffer buffer, std::uint64_t offset,
                                 std::span<const std::byte> bytes) = 0;
    /// After all that was submitted before; TrainingBuffer::Losses after what has been waited for.
    virtual Expected<void> Read(TrainingBuffer buffer, std::uint64_t offset, std::span<std::byte> bytes) = 0;
    /// Writes TrainingBuffer::Batch and, unless there are none, TrainingBuffer::References from their
    /// beginning and runs the dispatches, each when the ones before have ended and their writes are seen,
    /// after all that was submitted before. Returns at once.
    virtual Expected<void> Submit(std::span<const std::uint32_t> batch,
                                  std::span<const std::uint16_t> references,
                                  std::span<const TrainingDispatch> dispatches) = 0;
    /// Until `submissions` of Submit have ended, counted from Create.
    virtual Expected<void> Wait(std::uint64_t submissions) = 0;
};

} // namespace openntc::encode

#include "openntc/core/RestoreMacros.h"
