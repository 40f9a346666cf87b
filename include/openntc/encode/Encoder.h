// SPDX-License-Identifier: MIT
// Stability: stable
// The encoder: from a material's texels to a texture-set file, on any processor.
#pragma once

#include "openntc/core/ThreadTeam.h"
#include "openntc/encode/EncodeOptions.h"
#include "openntc/encode/Kernels.h"
#include "openntc/encode/Material.h"
#include "openntc/encode/detail/AmxKernel.h"
#include "openntc/encode/detail/EncodeChecks.h"
#include "openntc/encode/detail/EncodeRun.h"
#include "openntc/encode/detail/Fp8Kernel.h"
#include "openntc/encode/detail/PortableKernel.h"
#include "openntc/encode/detail/blocked/Avx2.h"
#include "openntc/encode/detail/blocked/Avx512.h"
#include "openntc/encode/detail/blocked/Neon.h"

#include <memory>

#include "openntc/core/HideMacros.h"

namespace openntc::encode {

/// Encodes materials. No state: calls may run in parallel.
class Encoder {
public:
    /// Trains and returns the complete file. `progress` is called on the calling thread; when it returns
    /// false the result is marked cancelled and holds the state to resume from instead of a file. Errors:
    /// OutOfRange (shape, options), InvalidArgument (incomplete material, an OPENNTC_SIMD_CAP that names no
    /// cap), FileIncompatible (resume state), OutOfMemory.
    static Expected<EncodeResult> Encode(const Material& material, const EncodeOptions& options,
                                         const ProgressCallback& progress = {}) {
        return Dispatch(material, nullptr, options, progress);
    }
    /// The same, and frees the material's texels (Material::ReleaseTexels) before training, which keeps its
    /// own copy in 16 bits: a third of the memory stays in use.
    static Expected<EncodeResult> Encode(Material&& material, const EncodeOptions& options,
                                         const ProgressCallback& progress = {}) {
        return Dispatch(material, &material, options, progress);
    }

private:
    /// `disposable`: null or `material`.
    static Expected<EncodeResult> Dispatch(const Material& material, Material* disposable,
                                           const EncodeOptions& options, const ProgressCallback& progress) {
        OPENNTC_ASSIGN(const LatentShape shape, detail::CheckEncodeOptions(material, options));
        OPENNTC_CHECK(GetSimdCap());
        const KernelChoice kernel =
            options.kernel == KernelChoice::Best ? GetBestKernel(options.networkVersion) : options.kernel;
        if (!IsKernelAvailable(kernel))
            return Fail(Status::Unsupported, "kernel: %s: this machine or build does not have it",
                        KernelToString(kernel));
        if (!IsKernelFor(kernel, options.networkVersion))
            return Fail(Status::Unsupported, "kernel: %s: trains networks of generation 1 only",
                        KernelToString(kernel));
        EncodeOptions chosen = options;
        chosen.kernel = kernel;
        return RunKernel(kernel, material, disposable, chosen, shape, progress);
    }

    static Expected<EncodeResult> RunKernel(KernelChoice kernel, const Material& material,
                                            Material* disposable, const EncodeOptions& options,
                                            const LatentShape& shape, const ProgressCallback& progress) {
        switch (kernel) {
#if defined(OPENNTC_ENCODE_AMX)
        case KernelChoice::Amx:
            return Run<detail::AmxKernel, detail::avx512::bf16::HeadKernel>(material, disposable, options,
                                                                            shape, progress);
#endif
#if OPENNTC_FAST_X86
        case KernelChoice::Avx512Bf16:
            return Run<detail::avx512::bf16::Kernel, detail::avx512::bf16::HeadKernel>(
                material, disposable, options, shape, progress);
        case KernelChoice::Avx512:
            return Run<detail::avx512::fma::Kernel, detail::avx512::fma::HeadKernel>(
                material, disposable, options, shape, progress);
        case KernelChoice::Avx2:
            return Run<detail::avx2::Kernel, detail::avx2::HeadKernel>(material, disposable, options, shape,
                                                                       progress);
#elif OPENNTC_FAST_NEON
#if OPENNTC_FAST_NEON_BF16
        case KernelChoice::NeonBf16:
            return Run<detail::neon::bf16::Kernel, detail::neon::bf16::HeadKernel>(material, disposable,
                                                                                   options, shape, progress);
#endif
        case KernelChoice::Neon:
            return Run<detail::neon::fma::Kernel, detail::neon::fma::HeadKernel>(material, disposable,
                                                                                 options, shape, progress);
#endif
        case KernelChoice::Best:
        case KernelChoice::Portable:
#if !defined(OPENNTC_ENCODE_AMX)
        case KernelChoice::Amx:
#endif
#if !OPENNTC_FAST_X86
        case KernelChoice::Avx512Bf16:
        case KernelChoice::Avx512:
        case KernelChoice::Avx2:
#endif
#if OPENNTC_FAST_X86 || !OPENNTC_FAST_NEON
        case KernelChoice::Neon:
#endif
#if OPENNTC_FAST_X86 || !OPENNTC_FAST_NEON || !OPENNTC_FAST_NEON_BF16
        case KernelChoice::NeonBf16:
#endif
            break;
        }
        return Run<detail::PortableKernel, detail::Fp8Kernel>(material, disposable, options, shape, progress);
    }

    template <typename Kernel, typename HeadKernel>
    static Expected<EncodeResult> Run(const Material& material, Material* disposable,
                                      const EncodeOptions& options, const LatentShape& shape,
                                      const ProgressCallback& progress) {
        const auto run = std::make_unique<detail::EncodeRun<Kernel, HeadKernel>>(material, options, shape);
        if (disposable != nullptr) // its texels are in the training set now
            disposable->ReleaseTexels();
        return run->Run(progress);
    }
};

} // namespace openntc::encode

#include "openntc/core/RestoreMacros.h"
