// SPDX-License-Identifier: MIT
#include "textures/BlockCoding.h"

#include "Failure.h"

#include "openntc/bc/BlockEncoder.h"

#include <array>

namespace openntc::tool {

bc::BlockQuality ToBlockQuality(BlockEffort effort) {
    return effort == BlockEffort::Fast     ? bc::BlockQuality::Fast
           : effort == BlockEffort::Normal ? bc::BlockQuality::Normal
                                           : bc::BlockQuality::Best;
}

const char* GetName(BlockEffort effort) {
    return effort == BlockEffort::Fast ? "fast" : effort == BlockEffort::Normal ? "normal" : "best";
}

void EncodeTexelBlocks(const TextureFormat& format, BlockEffort effort, const TexelRows& rows, int threads,
                       const std::string& subject, std::vector<std::byte>& blocks,
                       std::span<const std::int32_t> hints, std::optional<int> alphaThreshold) {
    bc::BlockImage image;
    image.bytes = rows.texels;
    image.width = rows.width;
    image.height = rows.height;
    image.channels = format.channels;
    image.type = format.number == TexelNumber::Half     ? bc::TexelType::Half
                 : format.number == TexelNumber::Snorm8 ? bc::TexelType::Signed8
                                                        : bc::TexelType::Unsigned8;
    const bc::BlockRect all{0, 0, bc::CountBlocks(rows.width), bc::CountBlocks(rows.height)};
    bc::BlockOptions options;
    options.quality = ToBlockQuality(effort);
    options.threads = threads;
    options.hints = hints;
    if (*format.block == bc::BlockFormat::Bc1)
        options.alphaThreshold = alphaThreshold.value_or(format.hasAlpha ? kBc1OpaqueAlpha - 1 : -1);
    blocks.resize(std::size_t{all.width} * all.height * GetUnitBytes(format));
    Require(bc::EncodeBlocks(*format.block, image, all, options, blocks), ExitCode::Failed, subject);
}

bool HasBlockEncoder(bc::BlockFormat format) {
    const std::array<std::byte, 4 * 2> texel{};
    std::array<std::byte, 16> block{};
    bc::BlockImage image;
    image.bytes = texel;
    image.width = image.height = 1;
    image.type = format == bc::BlockFormat::Bc6Unsigned || format == bc::BlockFormat::Bc6Signed
                     ? bc::TexelType::Half
                 : format == bc::BlockFormat::Bc4Signed || format == bc::BlockFormat::Bc5Signed
                     ? bc::TexelType::Signed8
                     : bc::TexelType::Unsigned8;
    bc::BlockOptions options;
    options.quality = bc::BlockQuality::Fast;
    options.threads = 1;
    return bc::EncodeBlocks(format, image, {0, 0, 1, 1}, options, block).has_value();
}

} // namespace openntc::tool
