// SPDX-License-Identifier: MIT
// Pictures as files: PNG, JPEG, BMP and TGA, by the name's extension.
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace openntc::renderer {

/// Throws CommandError(Usage) about `option` for a name whose extension is none of png, jpg, jpeg, bmp and tga, in whichever case.
void CheckPictureName(const std::string& option, const std::string& path);

/// `texels`: RGBA of 8 bits, width * height * 4 bytes, rows from the top; alpha is not written. The file appears whole or not
/// at all. Throws CommandError: as CheckPictureName, or Failed.
void WritePicture(const std::string& path, std::span<const std::uint8_t> texels, int width, int height);

} // namespace openntc::renderer
