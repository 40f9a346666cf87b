// SPDX-License-Identifier: MIT
// Cases of textures in the exported suite: what the pass DecompressToTextures, or an engine's own, writes of
// a rectangle of a mip: which channels, in which colour spaces, where, and to which codes. Texels that are
// not converted are expected bit for bit; of those that are, every code that the precision of a device's pow,
// exp and log lets it find.
#pragma once

#include "openntc/core/Expected.h"
#include "openntc/core/Rect.h"
#include "openntc/decode/DecodeTypes.h"
#include "openntc/texture_set/TextureSetMetadata.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace openntc::tool {
class JsonWriter;
}

namespace openntc::conformance {

class Model;

inline constexpr int kMaxTextureSide = 1024;    ///< of a request
inline constexpr std::size_t kMaxTextures = 16; ///< of a request

/// A texture of four components that is written: channels firstChannel … firstChannel + channels - 1, then 0,
/// the fourth 1. Stored as binary32 (bits 0) or as codes of 8 or 16 bits, the nearest, without dither.
struct TextureOutput {
    int firstChannel = 0; ///< 0 … 15
    int channels = 4;     ///< 1 … 4, within the 16
    ColorSpace rgb = ColorSpace::Linear;
    ColorSpace alpha = ColorSpace::Linear;
    int bits = 8;

    std::size_t GetComponentBytes() const { return bits == 0 ? 4 : static_cast<std::size_t>(bits) / 8; }
};

/// Textures of one size, cleared to 0, into which a rectangle of a mip is written.
struct TextureRequest {
    DecodeMath math = DecodeMath::Int8;
    int mip = 0;
    Rect rect; ///< texels of the mip
    int destinationLeft = 0, destinationTop = 0;
    int textureWidth = 0, textureHeight = 0;
    std::vector<TextureOutput> outputs; ///< 1 … kMaxTextures

    std::size_t GetRowBytes(const TextureOutput& output) const {
        return 4 * output.GetComponentBytes() * static_cast<std::size_t>(textureWidth);
    }
    std::size_t GetTextureBytes(const TextureOutput& output) const {
        return GetRowBytes(output) * static_cast<std::size_t>(textureHeight);
    }
    /// The first thing that is wrong with it for a mip of that size, or nullptr.
    const char* FindProblem(int mipWidth, int mipHeight) const;
};

/// The bytes of each texture, rows one after the other, components little-endian.
using Textures = std::vector<std::vector<std::byte>>;

/// One case of suite.json.
struct TextureSuiteCase {
    std::string name;
    std::string set;    ///< file name of the texture set
    std::string values; ///< file name of the textures: of each the least that passes, then the greatest
    TextureRequest request;
    bool mustPass = false;
    std::string about;
};

/// The list `textures` of suite.json; empty where there is none. Errors: Status::FileUnrecognized, naming the
/// member; file names that leave the folder are refused.
Expected<std::vector<TextureSuiteCase>> ReadTextureCases(std::span<const std::byte> json);
/// Writes the member.
void WriteTextureCases(tool::JsonWriter& json, std::span<const TextureSuiteCase> cases);

/// The cases of this version.
std::vector<TextureSuiteCase> ListTextureSuite();

/// `linear`, `srgb`, `hlg`.
const char* GetColorSpaceWord(ColorSpace space);
bool FindColorSpace(std::string_view word, ColorSpace& space);

/// The textures that texels of the rectangle make, row by row as they are stored in the set: by the constants
/// of MakeDecompressionPass and the shader's functions. Throws CommandError.
Textures MakeTextures(const TextureSetMetadata& metadata, const TextureRequest& request,
                      std::span<const std::array<float, 16>> texels);

/// The least and the greatest textures that pass.
struct TextureRange {
    Textures least, greatest;
};
/// `texels`: of the rectangle, row by row.
TextureRange MakeTextureRange(const TextureSetMetadata& metadata, const TextureRequest& request,
                              std::span<const std::array<float, 16>> texels);

/// Where components are outside a range, bit for bit but for NaN, which is one, and numbers below flushBelow,
/// which are 0.
struct TextureDifference {
    std::size_t components = 0; ///< that are compared
    std::size_t different = 0;
    std::string first; ///< "output 1 texel (3, 4) component 2: 17: expected 18"
};
TextureDifference CompareTextures(const TextureRequest& request, const Textures& textures,
                                  const TextureRange& range, float flushBelow);

/// What passes that write textures do wrong.
enum class TextureMistake : std::uint8_t {
    None,
    FirstChannelIgnored,
    FirstOutputForAll,
    SwappedRedBlue,
    MissingAlphaZero,
    MissingRepeated,
    NoChannel15,
    SpaceOfFirst,
    AlphaAsRgb,
    NotConverted,
    AlwaysLinear,
    AlwaysEncoded,
    Gamma22,
    DestinationIgnored,
    SourceAtOrigin,
    SourceAtDestination,
    InclusiveRect,
    UpsideDown,
    Dithered,
    Truncated,
    PowerOfTwoCodes,
    Wrapped,
    ClampedFloats,
    EightBitCodes,
    HalfFloats,
};

struct TextureMistakeInfo {
    TextureMistake mistake;
    const char* name;     ///< of wrong_decoder
    const char* cause;    ///< what the pass does, and should do
    const char* caseName; ///< the exported case that is meant for it
};

/// Every mistake but None.
std::span<const TextureMistakeInfo> ListTextureMistakes();

/// Textures of the independent model, which shares nothing with the pass, with or without mistakes. Both
/// arguments must outlive it; texels are decoded once.
class TextureModel {
public:
    TextureModel(const Model& model, const TextureRequest& request) : model_(model), request_(request) {}

    Textures Make(TextureMistake mistake) { return Make(mistake, 0); }
    /// What devices may find of it.
    TextureRange MakeRange(TextureMistake mistake) { return {Make(mistake, -1), Make(mistake, 1)}; }

private:
    Textures Make(TextureMistake mistake, int side);
    const std::array<float, 16>& GetTexel(int x, int y);

    const Model& model_;
    const TextureRequest& request_;
    std::map<std::pair<int, int>, std::array<float, 16>> texels_;
};

} // namespace openntc::conformance
