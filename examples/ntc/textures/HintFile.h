// SPDX-License-Identifier: MIT
// Side files of BC7 hints (NAME.bcmodes) beside texture sets, and what of them helps to write a texture.
#pragma once

#include "TextureSet.h"
#include "textures/TextureFormat.h"

#include "openntc/bc/BlockHints.h"
#include "openntc/bc/BlockImage.h"
#include "openntc/core/Rect.h"
#include "openntc/decode/DecodeTypes.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace openntc::tool {

/// `dir/NAME.bcmodes` of `dir/NAME.ntc`.
std::string GetHintPath(const std::string& setPath);

/// Size and CRC-32 of a whole file.
bc::BlockHintSource IdentifyFile(Input& input);
bc::BlockHintSource IdentifyFile(std::span<const std::byte> bytes);

/// A side file that belongs to a texture set, every map of it checked; or the modes that a set of generation 3
/// keeps, which do not say what texels they come from.
class HintFile {
public:
    /// The set's own. Throws CommandError(BadInput) if it keeps none, or if they are corrupt.
    HintFile(const TextureSetMetadata& metadata, Stream& stream, const std::string& name, DecodeMath math);
    /// Throws CommandError(BadInput) if it is damaged, was made for another file, or has maps of textures, mips or sizes
    /// that the set does not have.
    HintFile(const std::string& path, const bc::BlockHintSource& source, const TextureSetMetadata& metadata);
    HintFile(const HintFile&) = delete;
    HintFile& operator=(const HintFile&) = delete;

    const std::string& GetPath() const { return path_; }
    std::uint64_t GetBytes() const { return bytes_.size(); }
    /// False: nobody knows the checksum of the texels.
    bool KnowsTexels() const { return knowsTexels_; }
    /// Empty if there is none.
    std::optional<bc::BlockHintMap> Find(std::size_t texture, int mip) const;

private:
    std::string path_;
    std::vector<std::byte> bytes_;
    std::vector<bc::BlockHintMap> maps_;
    bool knowsTexels_ = true;
};

/// The hints for a rectangle of each mip of one texture.
class TextureHints {
public:
    /// Of one mip. Blocks that the rectangle cuts get no hint, and none does where it starts within one.
    /// `width`, `height`: of the mip, in texels.
    /// `knowsTexels`: Check compares the texels' checksum with the map's.
    void AddMip(int mip, const bc::BlockHintMap& map, const Rect& rect, int width, int height,
                bool knowsTexels);

    bool IsEmpty() const { return mips_.empty(); }
    /// Of block rows `top` … `top + height - 1` of a mip's rectangle, `width` blocks each; -1: search. Empty if the
    /// mip has none.
    void Get(std::uint32_t mip, const bc::BlockRect& blocks, std::vector<std::int32_t>& hints) const;
    /// Throws CommandError(BadInput) if the texels of a whole mip have another checksum than those that the hints come
    /// from.
    void Check(std::uint32_t mip, std::uint32_t texelCrc, const std::string& subject) const;

private:
    struct Mip {
        int mip;
        bc::BlockHintMap map;
        Rect rect;
        int width, height;
        bool knowsTexels;
    };
    const Mip* Find(std::uint32_t mip) const;

    std::vector<Mip> mips_;
};

/// Why a map does not help to encode texels that are made so; empty if it does.
std::string DescribeMismatch(const bc::BlockHintTexels& texels, DecodeMath math, const TextureFormat& format);

} // namespace openntc::tool
