// SPDX-License-Identifier: MIT
// What decides the bytes of an encoded material, as short texts: equal keys need no second encoding.
#pragma once

#include "encode/EncodeJob.h"

#include <functional>
#include <string>

namespace openntc::tool {

/// Of the bytes of a file or of an embedded image: size, CRC-32 and FNV-1a, as hexadecimal digits.
std::string MakeDigest(std::span<const std::byte> bytes);

/// Of a file, read piece by piece. Throws CommandError(BadInput).
std::string MakeFileDigest(const std::string& path);

/// Text that stands for the texels of a texture's image.
using ImageDigest = std::function<std::string(const ManifestTexture&)>;

/// MakeDigest of the image, wherever its bytes are.
std::string MakeImageDigest(const ManifestTexture& texture);

/// 16 hexadecimal digits over the options of training and of reading images. Where a file is made (threads, the
/// fastest kernel of a machine, a device) is none of them: any of these files will do.
std::string MakeSettingsKey(const EncodeJob& job);

/// 16 hexadecimal digits over the settings, the images and what the job's manifest says of them. The manifest must be
/// there. Throws what `digest` throws.
std::string MakeContentKey(const EncodeJob& job, const ImageDigest& digest = MakeImageDigest);

} // namespace openntc::tool
