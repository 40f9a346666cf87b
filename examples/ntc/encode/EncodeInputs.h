// SPDX-License-Identifier: MIT
// From a command line (images, a folder or a manifest) to a material.
#pragma once

#include "encode/Manifest.h"

#include "openntc/encode/Material.h"

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace openntc::tool {

/// What an option says of one texture, by its name or that of its file: NAME=NUMBER.
struct NamedNumber {
    std::string name;
    double number = 0.0;
};

struct InputOptions {
    std::vector<std::string> paths;                  ///< images, or one folder, or one manifest (.json)
    std::optional<Manifest> manifest = {};           ///< instead; paths[0] then only names it in errors
    int mips = 0;                                    ///< 0: the full chain
    bool strict = false;                             ///< images of another size are an error, not resampled
    std::vector<std::string> srgb = {}, linear = {}; ///< textures whose colour space the user says
    float keepCoverage = 0.0f;           ///< > 0: threshold of the alpha test whose coverage mips keep
    std::optional<int> maskChannel = {}; ///< absent: as the manifest says; -1: none
    std::optional<image::MipFilter> mipFilter = {}; ///< absent: as the manifest says
    std::optional<image::MipWrap> mipWrap = {};     ///< likewise
    std::vector<std::string> normalMaps = {};       ///< textures that are normal maps, beside the manifest's
    std::vector<NamedNumber> weights = {};          ///< of textures' errors
    std::vector<NamedNumber> targets = {};          ///< dB of textures
};

/// How one image was understood.
struct UnderstoodTexture {
    std::string name, file;
    int firstChannel = 0, channels = 0;    ///< of the set
    double targetPsnr = 0.0;               ///< > 0: dB that it is to reach
    ColorSpace space = ColorSpace::Linear; ///< of the stored texels
    std::string reason;                    ///< why
    std::string hint;                      ///< what the user may want instead, or empty
};

struct EncodeInputs {
    encode::Material material;
    int maskChannel = -1; ///< from the options or the manifest's labels
    std::array<float, 16> lossScales{};
    std::vector<std::string> warnings;
    std::vector<UnderstoodTexture> textures; ///< in the order of the inputs, without mips
    std::vector<std::string> files;          ///< every file that was read
    std::uint64_t rawBytes = 0;              ///< of all mips, at the bits of the images
};

/// Throws CommandError: BadInput for files, Failed for sizes that differ with --strict, Usage for channels
/// that do not fit.
EncodeInputs LoadInputs(const InputOptions& options);

} // namespace openntc::tool
