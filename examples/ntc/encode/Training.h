// SPDX-License-Identifier: MIT
// The encoder behind a function, so that its kernels are compiled once, with the options of hot code.
#pragma once

#include "openntc/encode/EncodeOptions.h"
#include "openntc/encode/Material.h"

namespace openntc::tool {

/// encode::Encoder::Encode.
Expected<encode::EncodeResult> Train(const encode::Material& material, const encode::EncodeOptions& options,
                                     const encode::ProgressCallback& progress = {});
/// The same, and frees the material's texels.
Expected<encode::EncodeResult> Train(encode::Material&& material, const encode::EncodeOptions& options,
                                     const encode::ProgressCallback& progress = {});

} // namespace openntc::tool
