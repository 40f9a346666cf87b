// SPDX-License-Identifier: MIT
// Stability: internal
// The portable kernel compiled for AVX2 with fused multiply-add, chosen at run time.
#pragma once

#include "openntc/core/Processor.h"
#include "openntc/encode/detail/PortableKernel.h"

#if OPENNTC_DETECT_X86
#define OPENNTC_ENCODE_AVX2 1

// Flattening inlines the whole kernel into each entry point, where the wider instructions apply.
#define OPENNTC_AVX2_ENTRY __attribute__((target("avx2,fma"), flatten))

#include "openntc/core/HideMacros.h"

namespace openntc::encode::detail {

inline bool IsAvx2Available() {
    return GetProcessorFeatures().fma;
}

class Avx2Kernel : public PortableKernel {
public:
    using PortableKernel::PortableKernel;

    OPENNTC_AVX2_ENTRY void Train(const KernelContext& context, TileTask* tiles, int count,
                                  GradientSums& sums) {
        PortableKernel::Train(context, tiles, count, sums);
    }
    OPENNTC_AVX2_ENTRY const float* Infer(const KernelContext& context, TileTask* tiles, int count) {
        return PortableKernel::Infer(context, tiles, count);
    }
    OPENNTC_AVX2_ENTRY static void TexelLosses(const KernelContext& context, const TileTask& tile,
                                               const float* outputs, int stride, float* to,
                                               std::size_t pitch) {
        WriteTexelLosses(context, tile, outputs, stride, to, pitch);
    }
    OPENNTC_AVX2_ENTRY static void AdamRow(float* values, float* first, float* second, const float* gradients,
                                           int count, const AdamStep& step, float lowest, float highest) {
        PortableKernel::AdamRow(values, first, second, gradients, count, step, lowest, highest);
    }
    OPENNTC_AVX2_ENTRY static void RoundRow(const float* from, float* to, int count,
                                            const LatentQuantiser& quantiser) {
        PortableKernel::RoundRow(from, to, count, quantiser);
    }
    OPENNTC_AVX2_ENTRY static void NoiseRow(const float* from, float* to, int count,
                                            const LatentQuantiser& quantiser, std::uint32_t seed) {
        PortableKernel::NoiseRow(from, to, count, quantiser, seed);
    }
};

} // namespace openntc::encode::detail

#include "openntc/core/RestoreMacros.h"
#endif
