// SPDX-License-Identifier: MIT
// Checked numbers out of a glTF file's JSON.
#pragma once

#include "gltf/GltfFile.h"

#include <span>
#include <string>

namespace openntc::renderer {

/// Reads `parent`.`name` into all of `numbers`; false, and nothing written, where there is no such member.
/// Errors are CommandError(BadInput): not an array of as many numbers, or too large for binary32.
bool ReadFloats(const tool::GltfFile& file, const tool::GltfFile::Value& parent, const char* name,
                const std::string& where, std::span<float> numbers);

struct FloatRange {
    float low, high;
};

/// A number inside `range`, or `fallback` where there is none.
float ReadFloat(const tool::GltfFile& file, const tool::GltfFile::Value& parent, const char* name,
                const std::string& where, float fallback, FloatRange range);

/// An index into the root's `array`, or -1 where there is none.
int ReadIndex(const tool::GltfFile& file, const tool::GltfFile::Value& parent, const char* name,
              const char* array, const std::string& where);

} // namespace openntc::renderer
