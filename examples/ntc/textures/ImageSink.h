// SPDX-License-Identifier: MIT
// Files that take decoded rows: one image of a mip, or a texture with all its mips.
#pragma once

#include "TextureImage.h"
#include "textures/BlockCoding.h"
#include "textures/HintFile.h"
#include "textures/TexelConverter.h"
#include "textures/TextureFile.h"

#include <filesystem>
#include <memory>
#include <span>
#include <string>

namespace openntc::tool {

/// Levels come from the smallest to the largest; errors name the file.
class ImageSink {
public:
    virtual ~ImageSink() = default;

    /// `width` and `height`: of the rows that follow, in texels.
    virtual void BeginLevel(std::uint32_t level, int width, int height) = 0;
    /// Whole rows, 16 outputs a texel; a multiple of four rows, except at the end of the level.
    virtual void WriteRows(std::span<const float> outputs) = 0;
    virtual void EndLevel() = 0;
    /// After all levels. Returns the file's bytes if it knows them, else 0.
    virtual std::uint64_t Finish() = 0;
};

/// Where a sink writes.
struct SinkFile {
    std::filesystem::path path;
    std::string subject; ///< for errors
};

/// Of one level. `image` must outlive the sink.
std::unique_ptr<ImageSink> MakePngSink(const SinkFile& file, const TextureImage& image);
std::unique_ptr<ImageSink> MakeExrSink(const SinkFile& file, const TextureImage& image);
std::unique_ptr<ImageSink> MakeTgaSink(const SinkFile& file, const TextureImage& image);

/// How a sink makes blocks.
struct BlockSearch {
    BlockEffort effort = BlockEffort::Normal;
    const TextureHints* hints = nullptr; ///< BC7: search only where these have none
};

/// Of all levels. Where the file's levels are larger than the rows given, edges repeat. The converter and the hints must
/// outlive the sink, which throws CommandError(BadInput) at the end of a level whose texels are not those of the hints.
std::unique_ptr<ImageSink> MakeTextureSink(const SinkFile& file, const TexelConverter& converter,
                                           const TextureFileDesc& desc, const BlockSearch& search);

} // namespace openntc::tool
