// SPDX-License-Identifier: MIT
#include "BlockSuite.h"

#include "../Json.h"
#include "../textures/TextureFormat.h"
#include "SuiteEntry.h"

#include <algorithm>
#include <optional>

namespace openntc::conformance {

namespace {

using bc::BlockFormat;
using tool::BlockEffort;

constexpr BlockEffort kLevels[] = {BlockEffort::Fast, BlockEffort::Normal, BlockEffort::Best};
constexpr int kPictureWidth = 22, kPictureHeight = 18; // blocks reach over both edges

bool IsHalfFormat(BlockFormat format) {
    return format == BlockFormat::Bc6Unsigned || format == BlockFormat::Bc6Signed;
}

std::uint32_t HashTexel(int x, int y, int channel) {
    std::uint32_t h = static_cast<std::uint32_t>(x) * 0x8da6b343u ^
                      static_cast<std::uint32_t>(y) * 0xd8163841u ^
                      static_cast<std::uint32_t>(channel) * 0xcb1ab31fu;
    h = (h ^ (h >> 15)) * 0x2c1b3c6du;
    return h ^ (h >> 13);
}

/// A slope, noise, few values and flat parts, a block or two each; alpha of all kinds.
int GetByte(int x, int y, int channel) {
    const auto noise = static_cast<int>(HashTexel(x, y, channel) & 255);
    if (channel == 3) {
        constexpr int kAlphas[] = {255, 0, 127, 128, 126, 255};
        return x < 8 ? 255 : y < 8 ? noise : kAlphas[HashTexel(x, y, 7) % std::size(kAlphas)];
    }
    switch (x / 8 + 3 * (y / 8)) {
    case 0:
        return 10 + 9 * x + (3 + channel) * y;
    case 1:
        return noise;
    case 2:
        return 40 + 60 * channel;
    case 3:
        return 90 + 20 * channel + (noise & 7);
    case 4:
        return (HashTexel(x, y, 8) & 1) != 0 ? 16 + 30 * channel : 200 - 40 * channel;
    case 5:
        return 255 - 6 * (x - 16) * (channel + 1);
    default:
        return (20 * channel + 11 * x + (noise & 31)) & 255;
    }
}

/// Halves round 1, in a few blocks of every magnitude, with what no block holds between them.
int GetHalf(int x, int y, int channel) {
    constexpr int kOdd[] = {0x7C00, 0xFC00, 0x7E00, 0xFE01, 0x8000, 0x8400, 0xBC00,
                            0xFBFF, 0x0001, 0x8001, 0x03FF, 0x0000, 0x3C00, 0x7BFF};
    const std::uint32_t hash = HashTexel(x, y, channel);
    if (x >= 16)
        return kOdd[hash % std::size(kOdd)];
    if (y >= 12)
        return static_cast<int>(hash % 0x7C00) | (static_cast<int>(hash >> 16 & 1) << 15);
    return 0x3600 + 16 * GetByte(x, y, channel);
}

} // namespace

std::size_t BlockRequest::GetTexelBytes() const {
    return IsHalfFormat(format) ? 8 : 4;
}

std::size_t BlockRequest::GetPictureBytes() const {
    return GetTexelBytes() * static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
}

std::size_t BlockRequest::GetRowBytes() const {
    return bc::GetBytesPerBlock(format) * bc::CountBlocks(static_cast<std::uint32_t>(width));
}

std::size_t BlockRequest::GetBlockBytes() const {
    return GetRowBytes() * bc::CountBlocks(static_cast<std::uint32_t>(height));
}

bool FindBlockLevel(std::string_view name, BlockEffort& level) {
    const auto found = std::find_if(std::begin(kLevels), std::end(kLevels),
                                    [&](BlockEffort effort) { return name == tool::GetName(effort); });
    if (found != std::end(kLevels))
        level = *found;
    return found != std::end(kLevels);
}

Expected<std::vector<BlockSuiteCase>> ReadBlockCases(std::span<const std::byte> json) {
    return ReadCaseList<BlockSuiteCase>(json, "blocks", [](SuiteEntry& entry) {
        BlockSuiteCase blockCase;
        blockCase.name = entry.TakeText("name");
        blockCase.texels = entry.TakeFileName("texels");
        blockCase.blocks = entry.TakeFileName("blocks");
        blockCase.about = entry.TakeText("about");
        const std::optional<BlockFormat> format = tool::FindBlockFormat(entry.TakeText("format"));
        if (!format)
            entry.Refuse("format");
        if (!FindBlockLevel(entry.TakeText("level"), blockCase.level))
            entry.Refuse("level");
        blockCase.format = format.value_or(BlockFormat::Bc7);
        blockCase.alphaThreshold = entry.TakeNumber("alphaThreshold", -1, 255);
        blockCase.width = entry.TakeNumber("width", 1, kMaxBlockPicture);
        blockCase.height = entry.TakeNumber("height", 1, kMaxBlockPicture);
        blockCase.mustPass = entry.TakeFlag("mustPass");
        return blockCase;
    });
}

void WriteBlockCases(tool::JsonWriter& json, std::span<const BlockSuiteCase> cases) {
    json.Key("blocks");
    json.BeginArray();
    for (const BlockSuiteCase& blockCase : cases) {
        json.BeginObject();
        json.Member("name", std::string_view(blockCase.name));
        json.Member("texels", std::string_view(blockCase.texels));
        json.Member("blocks", std::string_view(blockCase.blocks));
        json.Member("format", bc::BlockFormatToString(blockCase.format));
        json.Member("level", tool::GetName(blockCase.level));
        json.Member("alphaThreshold", blockCase.alphaThreshold);
        json.Member("width", blockCase.width);
        json.Member("height", blockCase.height);
        json.Member("mustPass", blockCase.mustPass);
        json.Member("about", std::string_view(blockCase.about));
        json.EndObject();
    }
    json.EndArray();
}

std::vector<BlockSuiteCase> ListBlockSuite() {
    std::vector<BlockSuiteCase> cases;
    const auto add = [&](BlockFormat format, int threshold, const std::string& name,
                         const std::string& about) {
        for (const BlockEffort level : kLevels) {
            BlockSuiteCase blockCase;
            blockCase.name = "blocks-" + name + "-" + tool::GetName(level);
            blockCase.texels = IsHalfFormat(format) ? "blocks-halves.texels8" : "blocks-bytes.texels4";
            blockCase.blocks = blockCase.name + ".blocks";
            blockCase.format = format;
            blockCase.level = level;
            blockCase.alphaThreshold = threshold;
            blockCase.width = kPictureWidth;
            blockCase.height = kPictureHeight;
            blockCase.mustPass = true;
            blockCase.about = about;
            cases.push_back(blockCase);
        }
    };
    for (int f = 0; f < bc::kBlockFormatCount; ++f) {
        const auto format = static_cast<BlockFormat>(f);
        add(format, -1, bc::BlockFormatToString(format),
            IsHalfFormat(format) ? "NaN, infinities, signs, every magnitude; edges within blocks"
                                 : "slopes, noise, flat parts, all kinds of alpha; edges within blocks");
    }
    add(BlockFormat::Bc1, 127, "bc1-cutout", "alpha of 126, 127 and 128 at the threshold 127");
    return cases;
}

std::vector<std::byte> MakeBlockPicture(const BlockSuiteCase& blockCase) {
    std::vector<std::byte> bytes;
    for (int y = 0; y < blockCase.height; ++y) {
        for (int x = 0; x < blockCase.width; ++x) {
            for (int c = 0; c < 4; ++c) {
                const bool isHalf = IsHalfFormat(blockCase.format);
                const int number = isHalf ? GetHalf(x, y, c) : GetByte(x, y, c);
                bytes.push_back(static_cast<std::byte>(number & 0xFF));
                if (isHalf)
                    bytes.push_back(static_cast<std::byte>(number >> 8 & 0xFF));
            }
        }
    }
    return bytes;
}

} // namespace openntc::conformance
