// SPDX-License-Identifier: MIT
// Which files `ntc decode` writes of a texture set, in which formats.
#pragma once

#include "textures/ImageSink.h"

#include "openntc/core/Rect.h"
#include "openntc/decode/DecodeTypes.h"
#include "openntc/texture_set/TextureSetMetadata.h"

#include <filesystem>
#include <list>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace openntc::tool {

enum class ImageFormat { Auto, Png, Exr, Tga, Dds, Ktx2 };

struct DecodePlanOptions {
    ImageFormat format = ImageFormat::Auto;
    bool mips = false;
    bool linear = false;
    bool pad = false;
    BlockChoice blocks;
    BlockEffort effort = BlockEffort::Normal;
    int zstdLevel = 0;
    std::optional<Rect> rect; ///< of mip 0
};

struct PlannedFile {
    const Texture* texture = nullptr;
    ImageFormat kind = ImageFormat::Png; ///< not Auto
    std::string name;                    ///< within the folder
    std::optional<int> mip;              ///< empty: all mips
    std::optional<TextureFormat> format; ///< of DDS and KTX2
    const TextureImage* image = nullptr; ///< of the others
    const TexelConverter* converter = nullptr;
    std::size_t index = 0;               ///< of the texture in the set
    const TextureHints* hints = nullptr; ///< of BC7, where UseHints found some
};

class DecodePlan {
public:
    /// `metadata` must outlive the plan; errors name `subject`. Throws CommandError(Failed) if there is nothing to write,
    /// CommandError(Usage) for a rectangle that leaves the image.
    DecodePlan(const TextureSetMetadata& metadata, const DecodePlanOptions& options, std::string subject);

    /// Texture by texture, its mips from the largest to the smallest.
    const std::vector<PlannedFile>& GetFiles() const { return files_; }
    /// For people.
    const std::vector<std::string>& GetWarnings() const { return warnings_; }
    /// One line about textures that the format does not hold, or empty.
    std::string DescribeUnwritten() const;

    /// Mips to decode, from mip 0 on.
    int GetMips() const { return mips_; }
    /// Texels of a mip to decode.
    Rect GetRect(int mip) const;
    std::uint64_t CountTexels() const;
    /// True for DDS and KTX2.
    bool IsContainer() const {
        return options_.format == ImageFormat::Dds || options_.format == ImageFormat::Ktx2;
    }

    /// True if a file gets blocks for which there may be hints.
    bool HasBc7() const;
    /// Takes what a side file has for the files, and adds warnings about what does not fit. `math`: of the decoder; the
    /// maps' memory must outlive the plan.
    void UseHints(const HintFile& hints, DecodeMath math);

    std::unique_ptr<ImageSink> MakeSink(const PlannedFile& file, const SinkFile& where) const;

private:
    void CheckRect() const;
    void CheckSize() const;
    void CountMips();
    void AddImages(const Texture& texture, const std::string& name, ImageFormat kind);
    void AddContainer(std::size_t index, const std::string& name);
    void AddUnwritten(const Texture& texture, const std::string& name);
    void WarnOfSize();

    const TextureSetMetadata& metadata_;
    DecodePlanOptions options_;
    std::string subject_;
    int mips_ = 1;
    std::vector<PlannedFile> files_;
    std::list<TextureImage> images_;
    std::list<TexelConverter> converters_;
    std::list<TextureHints> hints_;
    std::vector<std::string> warnings_;
    std::string unwritten_;
};

} // namespace openntc::tool
