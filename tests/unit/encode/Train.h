// SPDX-License-Identifier: MIT
// The encoder behind a function: its kernels are compiled once for all tests, which is most of their build time.
#pragma once

#include "openntc/encode/EncodeOptions.h"
#include "openntc/encode/Material.h"

namespace openntc::test {

/// encode::Encoder::Encode.
Expected<encode::EncodeResult> Train(const encode::Material& material, const encode::EncodeOptions& options,
                                     const encode::ProgressCallback& progress = {});
Expected<encode::EncodeResult> Train(encode::Material&& material, const encode::EncodeOptions& options,
                                     const encode::ProgressCallback& progress = {});

} // namespace openntc::test
