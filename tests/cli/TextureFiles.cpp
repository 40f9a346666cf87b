// SPDX-License-Identifier: MIT
#include "cli/TextureFiles.h"
#include "cli/Program.h"

#include "openntc/core/FileStream.h"
#include "openntc/inference/Synthesis.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace openntc_tests {

using namespace openntc;

namespace {

std::uint64_t GetLong(const std::string& bytes, std::size_t at) {
    return GetWord(bytes, at) | std::uint64_t{GetWord(bytes, at + 4)} << 32;
}

} // namespace

std::uint32_t GetWord(const std::string& bytes, std::size_t at) {
    REQUIRE(at + 4 <= bytes.size());
    std::uint32_t word = 0;
    for (std::size_t i = 0; i < 4; ++i)
        word |= std::uint32_t{static_cast<unsigned char>(bytes[at + i])} << (8 * i);
    return word;
}

ParsedTexture ReadDds(const std::filesystem::path& path, std::uint32_t unit, std::uint32_t side) {
    const std::string file = ReadText(path);
    ParsedTexture texture;
    REQUIRE(file.size() >= 148);
    for (std::size_t i = 0; i < 37; ++i)
        texture.words.push_back(GetWord(file, 4 * i));
    CHECK(file.substr(0, 4) == "DDS ");
    CHECK(file.substr(84, 4) == "DX10");
    texture.height = texture.words[3];
    texture.width = texture.words[4];
    texture.format = texture.words[32];
    // What readers have stumbled over: sizes of the parts, caps, a 2D texture in an array of one, and its alpha.
    CHECK(texture.words[1] == 124);
    CHECK(texture.words[19] == 32);
    CHECK((texture.words[27] & 0x1000) != 0);
    CHECK(((texture.words[27] & 0x400008) == 0x400008) == (texture.words[7] > 1));
    CHECK(texture.words[33] == 3);
    CHECK(texture.words[35] == 1);
    CHECK((texture.words[36] == 1 || texture.words[36] == 3));
    const std::uint32_t topBytes =
        (texture.width + side - 1) / side * ((texture.height + side - 1) / side) * unit;
    if (side == 4) { // blocks: the bytes of mip 0; texels: those of a row
        CHECK(texture.words[2] == (0x1 | 0x2 | 0x4 | 0x1000 | 0x20000 | 0x80000));
        CHECK(texture.words[5] == topBytes);
    } else {
        CHECK(texture.words[2] == (0x1 | 0x2 | 0x4 | 0x8 | 0x1000 | 0x20000));
        CHECK(texture.words[5] == texture.width * unit);
    }
    std::size_t at = 148;
    for (std::uint32_t i = 0; i < texture.words[7]; ++i) {
        const std::uint32_t width = std::max(texture.width >> i, 1U),
                            height = std::max(texture.height >> i, 1U);
        const std::size_t bytes =
            std::size_t{(width + side - 1) / side} * ((height + side - 1) / side) * unit;
        REQUIRE(at + bytes <= file.size());
        texture.levels.push_back({at, bytes, file.substr(at, bytes)});
        at += bytes;
    }
    CHECK(at == file.size());
    return texture;
}

ParsedTexture ReadKtx2(const std::filesystem::path& path) {
    const std::string file = ReadText(path);
    ParsedTexture texture;
    REQUIRE(file.size() >= 80);
    CHECK(file.substr(0, 12) == std::string("\xABKTX 20\xBB\r\n\x1A\n", 12));
    texture.format = GetWord(file, 12);
    texture.typeSize = GetWord(file, 16);
    texture.width = GetWord(file, 20);
    texture.height = GetWord(file, 24);
    CHECK(GetWord(file, 28) == 0);
    CHECK(GetWord(file, 32) == 0);
    CHECK(GetWord(file, 36) == 1);
    const std::uint32_t levels = GetWord(file, 40);
    texture.scheme = GetWord(file, 44);
    const std::uint32_t descriptorAt = GetWord(file, 48), descriptorBytes = GetWord(file, 52);
    const std::uint32_t pairsAt = GetWord(file, 56), pairBytes = GetWord(file, 60);
    CHECK(GetLong(file, 64) == 0);
    CHECK(GetLong(file, 72) == 0);
    CHECK(descriptorAt == 80 + 24 * levels);
    CHECK(pairsAt == descriptorAt + descriptorBytes);
    REQUIRE(pairsAt + pairBytes <= file.size());
    for (std::uint32_t i = 0; i < descriptorBytes / 4; ++i)
        texture.descriptor.push_back(GetWord(file, descriptorAt + 4 * i));
    texture.keyValues = file.substr(pairsAt, pairBytes);
    // Levels lie one after the other from the smallest on, with no gap but what alignment asks for.
    const std::uint64_t unit = texture.descriptor.at(5) & 0xFFU;
    const std::uint64_t alignment = texture.scheme == 0 ? std::lcm(unit, std::uint64_t{4}) : 1;
    std::uint64_t end = pairsAt + pairBytes;
    texture.levels.resize(levels);
    for (std::uint32_t i = levels; i-- > 0;) {
        ParsedLevel& level = texture.levels[i];
        level.offset = GetLong(file, 80 + 24 * i);
        const std::uint64_t bytes = GetLong(file, 88 + 24 * i);
        level.uncompressedBytes = GetLong(file, 96 + 24 * i);
        CHECK(level.offset == (end + alignment - 1) / alignment * alignment);
        REQUIRE(level.offset + bytes <= file.size());
        level.bytes = file.substr(level.offset, bytes);
        end = level.offset + bytes;
    }
    CHECK(end == file.size());
    return texture;
}

void WriteManyFormats(const std::filesystem::path& path, int width, int height, int mips, int generation) {
    const auto make = [](const char* name, int first, int count, ChannelFormat format, ColorSpace space,
                         BlockCompressedFormat blocks) {
        Texture texture;
        texture.name = name;
        texture.firstChannel = first;
        texture.numChannels = count;
        texture.channelFormat = format;
        texture.rgbColorSpace = space;
        texture.bcFormat = blocks;
        return texture;
    };
    using B = BlockCompressedFormat;
    const std::array textures = {
        make("color", 0, 3, ChannelFormat::UNORM8, ColorSpace::sRGB, B::BC7),
        make("cut", 0, 4, ChannelFormat::UNORM8, ColorSpace::sRGB, B::BC1),
        make("gray", 4, 1, ChannelFormat::UNORM8, ColorSpace::Linear, B::BC4),
        make("two", 5, 2, ChannelFormat::UNORM8, ColorSpace::Linear, B::BC5),
        make("deep", 7, 2, ChannelFormat::UNORM16, ColorSpace::Linear, B::Uncompressed),
        make("hdr", 9, 3, ChannelFormat::FLOAT16, ColorSpace::Linear, B::BC6),
        make("float", 12, 4, ChannelFormat::FLOAT32, ColorSpace::Linear, B::Uncompressed)};
    SynthesisDesc desc;
    desc.seed = 5;
    desc.desc.width = width;
    desc.desc.height = height;
    desc.desc.channels = 16;
    desc.desc.mips = mips;
    desc.shape = {.gridSizeScale = 4,
                  .highResFeatures = 8,
                  .lowResFeatures = 8,
                  .highResQuantBits = 4,
                  .lowResQuantBits = 4};
    if (generation == 3) {
        desc.networkVersion = NTC_NETWORK_GENERATION_3;
        desc.shape = MakeLayeredShape(4, 8);
        desc.compression = {true, false, 1, 2.0f};
    }
    desc.textures = textures;
    for (int c = 0; c < 3; ++c)
        desc.channelColorSpaces |= static_cast<std::uint32_t>(ColorSpace::sRGB) << (2 * c);
    for (int c = 9; c < 12; ++c)
        desc.channelColorSpaces |= static_cast<std::uint32_t>(ColorSpace::HLG) << (2 * c);
    auto file = FileWriter::Create(path);
    REQUIRE(file.has_value());
    const auto written = SynthesizeTextureSet(*file, desc);
    REQUIRE_MESSAGE(written.has_value(), std::string(written.error().GetText()));
    REQUIRE(file->Commit().has_value());
}

} // namespace openntc_tests
