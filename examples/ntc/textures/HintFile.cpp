// SPDX-License-Identifier: MIT
#include "textures/HintFile.h"

#include "Decoder.h"
#include "Failure.h"
#include "InputFile.h"
#include "Output.h"

#include "openntc/core/Crc32.h"
#include "openntc/texture_set/BlockModes.h"

#include <algorithm>
#include <filesystem>

namespace openntc::tool {

std::string GetHintPath(const std::string& setPath) {
    return std::filesystem::path(setPath).replace_extension(".bcmodes").string();
}

bc::BlockHintSource IdentifyFile(Input& input) {
    constexpr std::uint64_t kChunk = 1 << 20;
    Stream& stream = input.GetStream();
    bc::BlockHintSource source;
    source.bytes = stream.Size();
    std::vector<std::byte> chunk(static_cast<std::size_t>(std::min(source.bytes, kChunk)));
    bool isGood = stream.Seek(0);
    for (std::uint64_t at = 0; isGood && at < source.bytes; at += chunk.size()) {
        chunk.resize(static_cast<std::size_t>(std::min(source.bytes - at, kChunk)));
        isGood = stream.Read(chunk.data(), chunk.size());
        source.crc = Crc32(chunk, source.crc);
    }
    if (!isGood)
        throw CommandError(ExitCode::BadInput, input.GetName(),
                           "cannot be read: file is shorter than before");
    return source;
}

bc::BlockHintSource IdentifyFile(std::span<const std::byte> bytes) {
    return {bytes.size(), Crc32(bytes)};
}

namespace {

std::uint32_t CountMipBlocks(int side) {
    return bc::CountBlocks(static_cast<std::uint32_t>(side));
}

/// What the largest side file of a set has.
std::uint64_t GetLargestHintBytes(const TextureSetMetadata& metadata) {
    std::uint64_t ofTexture = 0;
    for (const ColorMip& mip : metadata.GetColorMips())
        ofTexture +=
            bc::detail::kHintRecordBytes +
            bc::GetBlockHintBytes(std::uint64_t{CountMipBlocks(mip.width)} * CountMipBlocks(mip.height));
    return bc::detail::kHintHeaderBytes + ofTexture * metadata.GetTextures().size();
}

} // namespace

HintFile::HintFile(const std::string& path, const bc::BlockHintSource& source,
                   const TextureSetMetadata& metadata)
    : path_(path),
      bytes_(ReadAll(
          path, {{GetLargestHintBytes(metadata), ": all hints of the set have fewer: of another set?"}})) {
    const bc::BlockHintFile file = Require(bc::BlockHintFile::Parse(bytes_), ExitCode::BadInput, path);
    const bc::BlockHintSource wanted = file.GetSource();
    if (wanted != source)
        throw CommandError(
            ExitCode::BadInput, path,
            Format("source: hints of a file of %llu bytes with CRC-32 %08x: this one has %llu and %08x: "
                   "make them again (ntc optimize-bc), or leave them out (--no-hints)",
                   static_cast<unsigned long long>(wanted.bytes), wanted.crc,
                   static_cast<unsigned long long>(source.bytes), source.crc));
    for (std::uint32_t i = 0; i < file.GetCount(); ++i) {
        const bc::BlockHintMap map = Require(file.GetMap(i), ExitCode::BadInput, path);
        const std::span<const ColorMip> mips = metadata.GetColorMips();
        if (map.texture >= metadata.GetTextures().size() || map.mip >= mips.size())
            throw CommandError(ExitCode::BadInput, path,
                               Format("map %u: texture %u, mip %u: the set has %zu and %zu", i, map.texture,
                                      map.mip, metadata.GetTextures().size(), mips.size()));
        const ColorMip& mip = mips[map.mip];
        if (map.width != CountMipBlocks(mip.width) || map.height != CountMipBlocks(mip.height))
            throw CommandError(ExitCode::BadInput, path,
                               Format("map %u: %u x %u blocks: mip %u has %u x %u", i, map.width, map.height,
                                      map.mip, CountMipBlocks(mip.width), CountMipBlocks(mip.height)));
        if (Find(map.texture, static_cast<int>(map.mip)))
            throw CommandError(ExitCode::BadInput, path,
                               Format("map %u: a second one of texture %u, mip %u", i, map.texture, map.mip));
        maps_.push_back(map);
    }
}

HintFile::HintFile(const TextureSetMetadata& metadata, Stream& stream, const std::string& name,
                   DecodeMath math)
    : path_(name + " itself"), knowsTexels_(false) {
    std::vector<std::size_t> starts;
    for (std::size_t i = 0; i < metadata.GetTextures().size(); ++i) {
        const Texture& texture = metadata.GetTextures()[i];
        const auto chosen = ChooseFormat(texture, {false, bc::BlockFormat::Bc7}, false);
        for (const BlockModeBuffer& modes : texture.blockModes) {
            const ColorMip& mip = metadata.GetColorMips()[static_cast<std::size_t>(modes.mip)];
            const Array<std::byte> packed =
                Require(ReadBlockModes(modes, stream, mip.width, mip.height), ExitCode::BadInput, name);
            bc::BlockHintMap& map = maps_.emplace_back();
            map.texture = static_cast<std::uint32_t>(i);
            map.mip = static_cast<std::uint32_t>(modes.mip);
            map.width = CountMipBlocks(mip.width);
            map.height = CountMipBlocks(mip.height);
            map.texels.math = static_cast<std::uint8_t>(math);
            map.texels.srgb = chosen && chosen->format.srgb;
            starts.push_back(bytes_.size());
            bytes_.insert(bytes_.end(), packed.begin(), packed.end());
        }
    }
    if (maps_.empty())
        throw CommandError(ExitCode::BadInput, name,
                           "BC7 modes: the set keeps none: ntc optimize-bc --in-set adds them");
    starts.push_back(bytes_.size());
    for (std::size_t i = 0; i < maps_.size(); ++i)
        maps_[i].packed = std::span(bytes_).subspan(starts[i], starts[i + 1] - starts[i]);
}

std::optional<bc::BlockHintMap> HintFile::Find(std::size_t texture, int mip) const {
    const auto found = std::find_if(maps_.begin(), maps_.end(), [&](const bc::BlockHintMap& map) {
        return map.texture == texture && map.mip == static_cast<std::uint32_t>(mip);
    });
    return found == maps_.end() ? std::nullopt : std::optional(*found);
}

void TextureHints::AddMip(int mip, const bc::BlockHintMap& map, const Rect& rect, int width, int height,
                          bool knowsTexels) {
    if (rect.left % 4 == 0 && rect.top % 4 == 0)
        mips_.push_back({mip, map, rect, width, height, knowsTexels});
}

const TextureHints::Mip* TextureHints::Find(std::uint32_t mip) const {
    const auto found = std::find_if(mips_.begin(), mips_.end(),
                                    [&](const Mip& one) { return one.mip == static_cast<int>(mip); });
    return found == mips_.end() ? nullptr : &*found;
}

void TextureHints::Get(std::uint32_t mip, const bc::BlockRect& blocks,
                       std::vector<std::int32_t>& hints) const {
    hints.clear();
    const Mip* const found = Find(mip);
    if (found == nullptr)
        return;
    // Blocks whose texels are those of the map's: whole ones, and those at the mip's own edge, which repeats.
    const Rect& rect = found->rect;
    const auto count = [](int start, int size, int end) {
        return static_cast<std::uint32_t>(start + size == end ? (size + 3) / 4 : size / 4);
    };
    const std::uint32_t columns =
        std::min(count(rect.left, rect.width, found->width), blocks.left + blocks.width);
    const std::uint32_t rows =
        std::min(count(rect.top, rect.height, found->height), blocks.top + blocks.height);
    hints.assign(std::size_t{blocks.width} * blocks.height, -1);
    if (columns <= blocks.left || rows <= blocks.top)
        return;
    const std::uint32_t width = columns - blocks.left;
    std::vector<std::int32_t> row(width);
    for (std::uint32_t y = blocks.top; y < rows; ++y) {
        Require(bc::UnpackBlockHints(found->map, static_cast<std::uint32_t>(rect.left) / 4 + blocks.left,
                                     static_cast<std::uint32_t>(rect.top) / 4 + y, width, 1, row),
                ExitCode::Failed, "hints");
        std::copy(row.begin(), row.end(), hints.begin() + std::ptrdiff_t{y - blocks.top} * blocks.width);
    }
}

void TextureHints::Check(std::uint32_t mip, std::uint32_t texelCrc, const std::string& subject) const {
    const Mip* const found = Find(mip);
    if (found == nullptr || !found->knowsTexels || found->rect.width != found->width ||
        found->rect.height != found->height)
        return;
    if (texelCrc != found->map.texels.crc)
        throw CommandError(ExitCode::BadInput, subject,
                           Format("hints: mip %u: CRC-32 of texels %08x: the hints come from others, %08x: "
                                  "make them again (ntc optimize-bc), or leave them out (--no-hints)",
                                  mip, texelCrc, found->map.texels.crc));
}

std::string DescribeMismatch(const bc::BlockHintTexels& texels, DecodeMath math,
                             const TextureFormat& format) {
    if (texels.math != static_cast<int>(math))
        return Format("gathered with other maths than --math %s", GetName(math));
    if (texels.srgb != format.srgb)
        return std::string("gathered from ") + (texels.srgb ? "sRGB" : "linear") + " colours, not from " +
               (format.srgb ? "sRGB" : "linear") + " ones";
    return {};
}

} // namespace openntc::tool
