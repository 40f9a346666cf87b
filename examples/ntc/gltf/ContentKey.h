// SPDX-License-Identifier: MIT
// What decides the bytes of an encoded material, as a short text: equal keys need no second encoding.
#pragma once

#include "encode/EncodeJob.h"

#include <string>

namespace openntc::tool {

/// 16 hexadecimal digits over the images' bytes, their meaning and the options of training. Throws
/// CommandError(BadInput) for images that cannot be read.
std::string MakeContentKey(const EncodeJob& job);

} // namespace openntc::tool
