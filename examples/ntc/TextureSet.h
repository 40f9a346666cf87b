// SPDX-License-Identifier: MIT
// A texture set opened from a file or from standard input.
#pragma once

#include "InputFile.h"

#include "openntc/core/Stream.h"
#include "openntc/inference/InferenceData.h"
#include "openntc/texture_set/TextureSetMetadata.h"

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace openntc::tool {

/// A seekable stream over a file, or over a copy of standard input for "-". Throws CommandError(BadInput).
class Input {
public:
    explicit Input(const std::string& path);

    const std::string& GetName() const noexcept { return name_; }
    Stream& GetStream() noexcept { return *stream_; }

private:
    std::string name_;
    std::vector<std::byte> bytes_;
    std::unique_ptr<Stream> stream_;
};

/// An input whose metadata is valid.
struct TextureSet {
    Input input;
    TextureSetMetadata metadata;
};

TextureSet LoadTextureSet(const std::string& path);

/// The bytes of a range of the input. Throws CommandError(BadInput).
std::vector<std::byte> ReadRange(Input& input, StreamRange range);

/// Throws CommandError(BadInput) if the set has no weights of that type.
std::span<const std::byte> GetWeights(const TextureSet& set, InferenceWeightType type);

/// `Linear`, `sRGB`, `HLG`.
const char* GetName(ColorSpace colorSpace);
/// `UNORM8` and so on.
const char* GetName(ChannelFormat format);
/// `None`, `BC1` … `BC7`.
const char* GetName(BlockCompressedFormat format);

} // namespace openntc::tool
