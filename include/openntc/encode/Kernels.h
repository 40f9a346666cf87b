// SPDX-License-Identifier: MIT
// Stability: stable
// The encoder's matrix code: names, and what this build and this machine can run.
#pragma once

#include "openntc/core/Processor.h"
#include "openntc/encode/EncodeOptions.h"

#include "openntc/core/HideMacros.h"

namespace openntc::encode {

/// From the fastest to the slowest.
inline constexpr KernelChoice kKernels[] = {
    KernelChoice::Amx,      KernelChoice::Avx512Bf16, KernelChoice::Avx512,  KernelChoice::Avx2,
    KernelChoice::NeonBf16, KernelChoice::Neon,       KernelChoice::Portable};

/// As EncodeResult::kernel names it; "best" for Best.
constexpr const char* KernelToString(KernelChoice kernel) noexcept {
    switch (kernel) {
    case KernelChoice::Best:
        break;
    case KernelChoice::Portable:
        return "portable";
    case KernelChoice::Avx2:
        return "avx2";
    case KernelChoice::Amx:
        return "amx-bf16";
    case KernelChoice::Avx512:
        return "avx512";
    case KernelChoice::Avx512Bf16:
        return "avx512-bf16";
    case KernelChoice::Neon:
        return "neon";
    case KernelChoice::NeonBf16:
        return "neon-bf16";
    }
    return "best";
}

/// True if this build and this machine can run a kernel, and OPENNTC_SIMD_CAP (core/Processor.h) allows it.
inline bool IsKernelAvailable(KernelChoice kernel) noexcept {
    [[maybe_unused]] const ProcessorFeatures& features = GetProcessorFeatures();
    switch (kernel) {
#if OPENNTC_DETECT_AMX
    case KernelChoice::Amx:
        return features.amxBf16 && RequestMatrixTiles();
#else
    case KernelChoice::Amx:
        return false;
#endif
#if OPENNTC_FAST_X86
    case KernelChoice::Avx512Bf16:
        return features.avx512Bf16;
    case KernelChoice::Avx512:
        return features.avx512;
    case KernelChoice::Avx2:
        return features.fma;
#else
    case KernelChoice::Avx512Bf16:
    case KernelChoice::Avx512:
    case KernelChoice::Avx2:
        return false;
#endif
#if OPENNTC_FAST_NEON
    case KernelChoice::NeonBf16:
        return OPENNTC_FAST_NEON_BF16 != 0 && features.neonBf16;
    case KernelChoice::Neon:
        return true;
#else
    case KernelChoice::NeonBf16:
    case KernelChoice::Neon:
        return false;
#endif
    case KernelChoice::Best:
    case KernelChoice::Portable:
        return true;
    }
    return false;
}

/// True if a kernel trains a network (NTC_NETWORK_*); UNKNOWN stands for those of generation 1.
constexpr bool IsKernelFor(KernelChoice kernel, int networkVersion) noexcept {
    return kernel != KernelChoice::Amx || GetGeneration(networkVersion) < 2;
}

/// What Best stands for on this machine.
inline KernelChoice GetBestKernel(int networkVersion = NTC_NETWORK_UNKNOWN) noexcept {
    for (const KernelChoice kernel : kKernels) {
        if (IsKernelFor(kernel, networkVersion) && IsKernelAvailable(kernel))
            return kernel;
    }
    return KernelChoice::Portable;
}

} // namespace openntc::encode

#include "openntc/core/RestoreMacros.h"
