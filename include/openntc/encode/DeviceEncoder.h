// SPDX-License-Identifier: MIT
// Stability: experimental
// The encoder whose training runs on a GPU.
#pragma once

#include "openntc/encode/EncodeOptions.h"
#include "openntc/encode/Kernels.h"
#include "openntc/encode/Material.h"
#include "openntc/encode/TrainingDevice.h"
#include "openntc/encode/detail/AmxKernel.h"
#include "openntc/encode/detail/DeviceRefiner.h"
#include "openntc/encode/detail/EncodeChecks.h"
#include "openntc/encode/detail/EncodeRun.h"
#include "openntc/encode/detail/Fp8Kernel.h"
#include "openntc/encode/detail/PortableKernel.h"
#include "openntc/encode/detail/blocked/Avx2.h"
#include "openntc/encode/detail/blocked/Avx512.h"

#include <memory>

#include "openntc/core/HideMacros.h"

namespace openntc::encode {

class DeviceEncoder {
public:
    /// As Encoder::Encode, with the steps of training made by `device`; EncodeOptions::kernel is not looked
    /// at. The result depends on the seed, the number of steps and the device with its driver. When the
    /// device is lost, EncodeOptions::save gets the last good state before the error. Errors: those of
    /// Encoder::Encode and of the device.
    static Expected<EncodeResult> Encode(const Material& material, const EncodeOptions& options,
                                         TrainingDevice& device, const ProgressCallback& progress = {}) {
        return Dispatch(material, nullptr, options, device, progress);
    }
    /// The same, and frees the material's texels before training.
    static Expected<EncodeResult> Encode(Material&& material, const EncodeOptions& options,
                                         TrainingDevice& device, const ProgressCallback& progress = {}) {
        return Dispatch(material, &material, options, device, progress);
    }

private:
    /// `disposable`: null or `material`.
    static Expected<EncodeResult> Dispatch(const Material& material, Material* disposable,
                                           const EncodeOptions& options, TrainingDevice& device,
                                           const ProgressCallback& progress) {
        OPENNTC_ASSIGN(const LatentShape shape, detail::CheckEncodeOptions(material, options));
        OPENNTC_CHECK(GetSimdCap());
#if defined(OPENNTC_ENCODE_AMX)
        if (IsKernelAvailable(KernelChoice::Amx) && IsKernelFor(KernelChoice::Amx, options.networkVersion))
            return Run<detail::AmxKernel, detail::avx512::bf16::HeadKernel>(material, disposable, options,
                                                                            shape, device, progress);
#endif
#if OPENNTC_FAST_X86
        if (IsKernelAvailable(KernelChoice::Avx512Bf16))
            return Run<detail::avx512::bf16::Kernel, detail::avx512::bf16::HeadKernel>(
                material, disposable, options, shape, device, progress);
        if (IsKernelAvailable(KernelChoice::Avx2))
            return Run<detail::avx2::Kernel, detail::avx2::HeadKernel>(material, disposable, options, shape,
                                                                       device, progress);
#endif
        return Run<detail::PortableKernel, detail::Fp8Kernel>(material, disposable, options, shape, device,
                                                              progress);
    }

    /// Kernel: evaluates and refines what the device has trained.
    template <typename Kernel, typename HeadKernel>
    static Expected<EncodeResult> Run(const Material& material, Material* disposable,
                                      const EncodeOptions& options, const LatentShape& shape,
                                      TrainingDevice& device, const ProgressCallback& progress) {
        const auto run = std::make_unique<detail::EncodeRun<detail::DeviceKernel<Kernel>, HeadKernel>>(
            material, options, shape);
        if (disposable != nullptr)
            disposable->ReleaseTexels();
        OPENNTC_CHECK(run->Attach(device));
        return run->Run(progress);
    }
};

} // namespace openntc::encode

#include "openntc/core/RestoreMacros.h"
