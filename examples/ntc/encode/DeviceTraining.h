// SPDX-License-Identifier: MIT
// The encoder on a device, behind functions.
#pragma once

#include "openntc/encode/EncodeOptions.h"
#include "openntc/encode/Material.h"
#include "openntc/encode/TrainingDevice.h"

#include <string>

namespace openntc::tool {

/// encode::DeviceEncoder::Encode, compiled with the options of hot code.
Expected<encode::EncodeResult> Train(const encode::Material& material, const encode::EncodeOptions& options,
                                     encode::TrainingDevice& device,
                                     const encode::ProgressCallback& progress = {});
/// The same, and frees the material's texels.
Expected<encode::EncodeResult> Train(encode::Material&& material, const encode::EncodeOptions& options,
                                     encode::TrainingDevice& device,
                                     const encode::ProgressCallback& progress = {});

/// On the Vulkan device of that index, or with that part in its name. Errors: Unsupported where it or what it needs is
/// missing, and those of training.
Expected<encode::EncodeResult> TrainOnVulkan(const std::string& device, const encode::Material& material,
                                             const encode::EncodeOptions& options,
                                             const encode::ProgressCallback& progress);
/// The same, and frees the material's texels.
Expected<encode::EncodeResult> TrainOnVulkan(const std::string& device, encode::Material&& material,
                                             const encode::EncodeOptions& options,
                                             const encode::ProgressCallback& progress);

} // namespace openntc::tool
