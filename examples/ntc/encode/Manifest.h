// SPDX-License-Identifier: MIT
// Lists of images with what they mean: from a JSON manifest, or from file names.
#pragma once

#include "openntc/container/Document.h"
#include "openntc/image/MipFilter.h"

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace openntc::tool {

/// An image that is part of another file; no buffer: none.
struct ImageBytes {
    std::shared_ptr<const std::vector<std::byte>> buffer;
    std::size_t offset = 0, size = 0;

    std::span<const std::byte> Get() const { return {buffer->data() + offset, size}; }
};

struct ManifestTexture {
    std::string path;
    ImageBytes bytes; ///< instead of the file; `path` then only names the image in errors
    std::string name;
    std::string swizzle; ///< of RGBA (A of an image without alpha is 1); empty: the image's channels in order
    int firstChannel = -1;                    ///< -1: first free
    std::optional<bool> isSrgb;               ///< absent: sRGB unless the image is of floats
    std::string colorReason = "by the model"; ///< why isSrgb is what it is, for users
    BlockCompressedFormat bcFormat = BlockCompressedFormat::None;
    int mipLevel = 0;
    std::vector<float> lossScales;             ///< one for all channels, or one per channel
    double targetPsnr = 0.0;                   ///< > 0: dB that the texture's channels are to reach
    std::optional<image::MipFilter> mipFilter; ///< absent: the manifest's
    bool normalMap = false;                    ///< mips are unit vectors
    bool verticalFlip = false;
    char maskLetter = 0;      ///< letter of RGBA that is an alpha mask; 0: none
    bool keepAlpha = false;   ///< an alpha channel that is constantly 1 is kept
    bool alphaIsData = false; ///< channel A is no opacity, also where colours are sRGB
};

struct Manifest {
    std::vector<ManifestTexture> textures;
    int width = 0, height = 0; ///< 0: of the largest image
    float keepCoverage = 0.0f; ///< > 0: threshold of the alpha test whose coverage mips keep
    image::MipRule mips;       ///< of textures that do not say otherwise
};

inline constexpr const char* kMipFilterNames[] = {"box", "kaiser"}; ///< by image::MipFilter
inline constexpr const char* kMipWrapNames[] = {"wrap", "clamp"};   ///< by image::MipWrap

/// Fields that a manifest may have, at its root and in a texture.
std::span<const std::string_view> GetManifestRootFields();
std::span<const std::string_view> GetManifestTextureFields();

/// Throws CommandError(BadInput) naming file, field and value.
Manifest ReadManifest(const std::string& path);

/// Images that a folder is looked through for: by extension.
bool IsImageName(const std::filesystem::path& path);

/// Images in the order given, or those of one folder by name.
Manifest MakeManifest(const std::vector<std::string>& paths);

} // namespace openntc::tool
