// SPDX-License-Identifier: MIT
// Stability: stable
// Options, progress and result of the encoder.
#pragma once

#include "openntc/core/Expected.h"
#include "openntc/format/NetworkDescription.h"
#include "openntc/texture_set/LatentShape.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "openntc/core/HideMacros.h"

namespace openntc::encode {

/// How good the result is to be, whatever the size: GetEffortSteps has the steps.
enum class Effort { Fast, Normal, Best };

/// Matrix code. Results differ in rounding between kernels; Best picks the fastest that the machine has.
enum class KernelChoice { Best, Portable, Avx2, Amx, Avx512, Avx512Bf16, Neon, NeonBf16 };

struct EncodeOptions {
    LatentShape latentShape{}; ///< empty: chosen by bitsPerPixel
    float bitsPerPixel = 4.0f; ///< see PickLatentShape
    /// Of generation 1, or NTC_NETWORK_GENERATION_3: sets that LibNTC 0.9 reads.
    int networkVersion = NTC_NETWORK_MEDIUM;
    Effort effort = Effort::Normal; ///< steps follow from the size; fewer where quality no longer grows
    std::uint64_t steps = 0;        ///< > 0: exactly this many training steps, reproducible
    double seconds = 0.0;           ///< > 0 (and steps = 0): end within this time; by nature not reproducible
    std::uint32_t seed = 1;
    int threads = 0;      ///< 0: all cores. The result does not depend on it
    int maskChannel = -1; ///< alpha mask whose exact 0 and 1 are to survive
    /// Add an FP8 network; a tenth of the steps, at most 1000, or 5 % of the time go into it. Generation 3
    /// always has one.
    bool fp8 = false;
    bool compress = false; ///< generation 3: latents are stored by GDeflate where that makes them smaller
    bool discardMasked = false; ///< texels whose mask is 0 may decode to anything in other channels
    std::array<float, kMaxChannels> lossScales = {1, 1, 1, 1, 1, 1, 1, 1,
                                                  1, 1, 1, 1, 1, 1, 1, 1}; ///< per channel; 0: ignored
    std::span<const std::byte>
        resumeState{};           ///< EncodeResult::state of a cancelled run with the same material and shape
    double resumeFraction = 0.0; ///< EncodeResult::fraction of that run; only used with `seconds`
    double reportSeconds = 0.25; ///< between calls of the progress callback
    /// Called about every `saveSeconds` with what `resumeState` and `resumeFraction` continue from, so that a
    /// run that is killed can go on; continued, it gives the bytes of a run that never stopped. The span
    /// lives until it returns.
    std::function<void(std::span<const std::byte> state, double fraction)> save = {};
    double saveSeconds = 120.0;
    KernelChoice kernel = KernelChoice::Best;
    /// Of a training step. Steps are counted in units of 4096 texels whatever this is, so that as many
    /// steps mean as many texels. A multiple of 1024 up to 65536; 0: on the processor 4096, for generation 3
    /// 1024; by size on a device (GetDeviceBatchTexels).
    int batchTexels = 0;
    float rateScale = 1.0f; ///< multiplies the learning rates; large values diverge and are taken back
};

/// True if an FP8 network is trained too: where it is asked for, and always in generation 3.
inline bool HasFp8Network(const EncodeOptions& options) noexcept {
    return options.fp8 || GetGeneration(options.networkVersion) == 3;
}

/// State of training, passed to the callback a few times per second.
struct Progress {
    std::uint64_t step = 0;
    std::uint64_t steps = 0;      ///< planned; an estimate when a time limit ends training
    double fraction = 0.0;        ///< of the schedule, 0 ... 1
    double psnr = 0.0;            ///< of recent batches, in dB: an estimate of the result
    double seconds = 0.0;         ///< since the start
    double secondsLeft = 0.0;     ///< estimate
    double texelsPerSecond = 0.0; ///< training samples
    const char* kernel = "";      ///< name of the matrix code
    int threads = 0;              ///< that train
};

/// Returns false to cancel.
using ProgressCallback = std::function<bool(const Progress&)>;

struct EncodeResult {
    std::vector<std::byte> file; ///< the texture set
    LatentShape latentShape{};
    /// dB, stored values, all declared channels, all mips by texels; with discardMasked without the texels
    /// whose mask is 0
    double psnr = 0.0;
    std::vector<double> mipPsnr;                    ///< the same per mip
    double fp8Psnr = 0.0;                           ///< of the FP8 network, when there is one
    int restarts = 0;                               ///< returns to the last good state after divergence
    std::array<double, kMaxChannels> channelPsnr{}; ///< of declared channels; infinite for exact ones
    std::uint64_t steps = 0;
    double seconds = 0.0;
    double texelsPerSecond = 0.0;
    std::uint64_t maskViolations =
        0;                        ///< texels whose mask is exactly 0 or 1 and decodes to another UNORM8 value
    bool cancelled = false;       ///< there is no file, but `state`
    double fraction = 1.0;        ///< of the schedule, when cancelled
    std::vector<std::byte> state; ///< when cancelled: what EncodeOptions::resumeState continues from
    const char* kernel = "";      ///< name of the matrix code that was used
    int batchTexels = 0;          ///< of a training step, as was asked for or chosen
};

} // namespace openntc::encode

#include "openntc/core/RestoreMacros.h"
