// SPDX-License-Identifier: MIT
// DDS and KTX2 files as other programs read them: ffmpeg, OpenImageIO, Pillow and ktx-parse. Which reader knows which format
// was found out by trying (Debian 12). Blocks are random, so that no encoder of ours has a say.
#include "cli/Program.h"
#include "cli/TextureFiles.h"
#include "support/TestSeed.h"

#include "encode/InputImage.h"
#include "textures/TextureFile.h"

#include "openntc/bc/BlockDecoder.h"

#include <cstdlib>
#include <cstring>
#include <random>
#include <sstream>

using namespace openntc_tests;
using namespace openntc;
using bc::BlockFormat;
using tool::TextureContainer;
using tool::TextureFileDesc;

namespace {

/// What a shell command prints, or an empty text if it fails.
std::string RunShell(const std::string& command) {
    const Folder folder;
    const fs::path output = folder / "out";
    return std::system((command + " >'" + output.string() + "' 2>/dev/null").c_str()) == 0 ? ReadText(output)
                                                                                           : std::string();
}

std::mt19937_64 MakeRandom() {
    MESSAGE("OPENNTC_TEST_SEED=", test::GetTestSeed());
    return std::mt19937_64(test::GetTestSeed());
}

/// A block that every decoder takes: no reserved codes, whose handling differs.
void MakeBlock(BlockFormat format, std::mt19937_64& random, std::byte* block) {
    const std::size_t bytes = bc::GetBytesPerBlock(format);
    for (;;) {
        for (std::size_t i = 0; i < bytes; ++i)
            block[i] = static_cast<std::byte>(random() & 0xFFU);
        const auto first = static_cast<unsigned>(block[0]);
        const bool isBc6 = format == BlockFormat::Bc6Unsigned || format == BlockFormat::Bc6Signed;
        if (isBc6 && (first & 0x13U) == 0x13U)
            continue; // 10011, 10111, 11011 and 11111
        if (format == BlockFormat::Bc7 && first == 0)
            continue;
        return;
    }
}

std::string GetText(BlockFormat format) {
    return bc::BlockFormatToString(format);
}

struct Size {
    std::uint32_t width, height;
};

struct WrittenTexture {
    TextureFileDesc desc;
    std::vector<std::vector<std::byte>> levels; // largest first
};

WrittenTexture WriteRandom(const fs::path& path, const TextureFileDesc& desc, std::mt19937_64& random) {
    WrittenTexture written{desc, {}};
    written.levels.resize(desc.levels);
    tool::TextureFileWriter writer(path, path.string(), desc);
    for (std::uint32_t level = desc.levels; level-- > 0;) {
        std::vector<std::byte>& bytes = written.levels[level];
        bytes.resize(static_cast<std::size_t>(writer.GetLayout().levels[level].bytes));
        const std::uint32_t unit = tool::GetUnitBytes(desc.format);
        for (std::size_t at = 0; at < bytes.size(); at += unit) {
            if (desc.format.block)
                MakeBlock(*desc.format.block, random, bytes.data() + at);
            else
                for (std::size_t i = 0; i < unit; ++i)
                    bytes[at + i] = static_cast<std::byte>(random() & 0xFFU);
        }
        writer.BeginLevel(level);
        writer.Write(bytes);
        writer.EndLevel();
    }
    const std::uint64_t size = writer.Finish();
    CHECK(size == fs::file_size(path));
    return written;
}

TextureFileDesc MakeDesc(TextureContainer container, BlockFormat block, bool srgb, std::uint32_t width,
                         std::uint32_t height) {
    TextureFileDesc desc;
    desc.container = container;
    desc.format.block = block;
    desc.format.srgb = srgb;
    desc.width = width;
    desc.height = height;
    while (std::max(width, height) >> desc.levels != 0)
        ++desc.levels;
    return desc;
}

std::vector<std::uint8_t> DecodeBytes(const WrittenTexture& written) {
    std::vector<std::uint8_t> texels(std::size_t{written.desc.width} * written.desc.height * 4);
    REQUIRE(bc::DecodeBlocksToBytes(*written.desc.format.block, written.levels[0], written.desc.width,
                                    written.desc.height, texels)
                .has_value());
    return texels;
}

/// Largest difference in the first `channels` of four.
int CompareBytes(const std::string& read, const std::vector<std::uint8_t>& wanted, int channels) {
    REQUIRE(read.size() == wanted.size());
    int worst = 0;
    for (std::size_t i = 0; i < wanted.size(); ++i) {
        if (static_cast<int>(i % 4) < channels)
            worst = std::max(worst, std::abs(int{static_cast<unsigned char>(read[i])} - int{wanted[i]}));
    }
    return worst;
}

/// A Python that has Pillow, or nothing.
std::string FindPillow() {
    for (const std::string python : {"python3", "/usr/bin/python3"})
        if (RunShell(python + " -c 'import PIL; print(1)'") == "1\n")
            return python;
    return {};
}

/// The module ktx-parse, where tests/install.sh puts it or OPENNTC_KTX_PARSE says; may not exist.
fs::path GetKtxParse() {
    if (const char* given = std::getenv("OPENNTC_KTX_PARSE"))
        return given;
    const char* home = std::getenv("HOME");
    return fs::path(home != nullptr ? home : "/") / ".cache/openntc/node_modules/ktx-parse/dist/index.mjs";
}

} // namespace

TEST_CASE("texture readers: ffmpeg reads DDS of BC1 to BC5") {
    if (RunShell("ffmpeg -version").empty()) {
        MESSAGE("SKIP: DDS of BC1 to BC5 read by ffmpeg: no ffmpeg");
        return;
    }
    std::mt19937_64 random = MakeRandom();
    const Folder folder;
    // ffmpeg rounds endpoints of 5 and 6 bits to the nearest of 8 bits, where the formats repeat bits (up to 1 of 255
    // apart), and cuts thirds off (less than 1): with our rounding to nearest less than 2.5. Alpha and BC4, BC5 have no
    // such endpoints: less than 1.5.
    struct Case {
        BlockFormat format;
        bool srgb;
        int channels;
    };
    std::vector<WrittenTexture> written;
    std::vector<int> channels;
    std::string inputs, outputs; // of one ffmpeg for all of them: it takes long to start
    for (const Case& c : {Case{BlockFormat::Bc1, false, 4},
                          {BlockFormat::Bc1, true, 4},
                          {BlockFormat::Bc2, false, 4},
                          {BlockFormat::Bc2, true, 4},
                          {BlockFormat::Bc3, false, 4},
                          {BlockFormat::Bc3, true, 4},
                          {BlockFormat::Bc4Unsigned, false, 1},
                          {BlockFormat::Bc5Unsigned, false, 2}}) {
        for (const Size& size : {Size{64U, 48U}, {28U, 4U}, {4U, 4U}}) {
            const std::string number = std::to_string(written.size());
            const fs::path path = folder / (number + ".dds");
            written.push_back(WriteRandom(
                path, MakeDesc(TextureContainer::Dds, c.format, c.srgb, size.width, size.height), random));
            channels.push_back(c.channels);
            inputs += " -i '" + path.string() + "'";
            outputs += " -map " + number + " -f rawvideo -pix_fmt rgba '" +
                       (folder / (number + ".raw")).string() + "'";
        }
    }
    RunShell("ffmpeg -v error" + inputs + outputs);
    for (std::size_t i = 0; i < written.size(); ++i) {
        CAPTURE(GetText(*written[i].desc.format.block));
        CAPTURE(written[i].desc.width);
        const std::string read = ReadText(folder / (std::to_string(i) + ".raw"));
        CHECK(CompareBytes(read, DecodeBytes(written[i]), channels[i]) <= (channels[i] == 4 ? 2 : 1));
    }
}

TEST_CASE("texture readers: OpenImageIO reads DDS of BC6H, half by half") {
#if defined(OPENNTC_TOOL_HAS_EXR)
    if (RunShell("oiiotool --version").empty()) {
        MESSAGE("SKIP: DDS of BC6H read by oiiotool: no oiiotool");
        return;
    }
    std::mt19937_64 random = MakeRandom();
    const Folder folder;
    std::vector<WrittenTexture> written;
    std::string conversions; // by one oiiotool for all of them: it takes long to start
    const auto name = [&](std::size_t texture, std::uint32_t level) {
        return (folder / (std::to_string(texture) + "-" + std::to_string(level) + ".exr")).string();
    };
    for (const BlockFormat format : {BlockFormat::Bc6Unsigned, BlockFormat::Bc6Signed}) {
        for (const Size& size : {Size{64U, 48U}, {27U, 13U}, {5U, 3U}}) {
            const fs::path path = folder / (std::to_string(written.size()) + ".dds");
            written.push_back(WriteRandom(
                path, MakeDesc(TextureContainer::Dds, format, false, size.width, size.height), random));
            for (std::uint32_t level = 0; level < written.back().desc.levels; ++level)
                conversions += " '" + path.string() + "' --selectmip " + std::to_string(level) +
                               " --ch R,G,B -d half -o '" + name(written.size() - 1, level) + "' --pop";
        }
    }
    RunShell("oiiotool" + conversions);
    for (std::size_t i = 0; i < written.size(); ++i) {
        const TextureFileDesc& desc = written[i].desc;
        CAPTURE(GetText(*desc.format.block));
        CAPTURE(desc.width);
        for (std::uint32_t level = 0; level < desc.levels; ++level) {
            CAPTURE(level);
            const std::uint32_t wide = std::max(desc.width >> level, 1U);
            const std::uint32_t high = std::max(desc.height >> level, 1U);
            const tool::InputImage read = tool::ReadImage(name(i, level));
            REQUIRE(read.width == static_cast<int>(wide));
            REQUIRE(read.height == static_cast<int>(high));
            std::vector<float> texels(std::size_t{wide} * high * 4);
            REQUIRE(bc::DecodeBlocksToFloats(*desc.format.block, written[i].levels[level], wide, high, texels)
                        .has_value());
            std::size_t different = 0;
            for (std::size_t t = 0; t < texels.size(); ++t)
                different += t % 4 == 3 || read.texels[t] == texels[t] ? 0 : 1;
            CHECK(different == 0);
        }
    }
#else
    MESSAGE("SKIP: DDS of BC6H read by oiiotool: built without tinyexr");
#endif
}

TEST_CASE("texture readers: Pillow reads DDS of BC7, byte by byte") {
    const std::string python = FindPillow();
    if (python.empty()) {
        MESSAGE("SKIP: DDS of BC7 read by Pillow: no python3 with Pillow");
        return;
    }
    std::mt19937_64 random = MakeRandom();
    const Folder folder;
    const fs::path path = folder / "a.dds";
    for (const bool srgb : {false, true}) {
        for (const Size& size : {Size{64U, 48U}, {12U, 20U}, {4U, 4U}}) {
            const std::uint32_t width = size.width, height = size.height;
            CAPTURE(srgb);
            CAPTURE(width);
            const WrittenTexture written = WriteRandom(
                path, MakeDesc(TextureContainer::Dds, BlockFormat::Bc7, srgb, width, height), random);
            const std::string read =
                RunShell(python +
                         " -c 'import sys; from PIL import Image; "
                         "sys.stdout.buffer.write(Image.open(sys.argv[1]).convert(\"RGBA\").tobytes())' '" +
                         path.string() + "'");
            CHECK(CompareBytes(read, DecodeBytes(written), 4) == 0);
        }
    }
}

TEST_CASE("texture readers: ktx-parse reads KTX2 of every format") {
    const fs::path module = GetKtxParse();
    if (RunShell("node --version").empty() || !fs::exists(module)) {
        MESSAGE("SKIP: KTX2 read by ktx-parse: no node, or no module at ", module.string());
        return;
    }
    std::mt19937_64 random = MakeRandom();
    const Folder folder;
    std::vector<WrittenTexture> written;
    std::string files;
    const auto add = [&](const TextureFileDesc& desc) {
        const fs::path path = folder / (std::to_string(written.size()) + ".ktx2");
        written.push_back(WriteRandom(path, desc, random));
        files += " '" + path.string() + "'";
    };
    for (int i = 0; i < bc::kBlockFormatCount; ++i) {
        const auto format = static_cast<BlockFormat>(i);
        add(MakeDesc(TextureContainer::Ktx2, format, false, 27, 13));
        add(MakeDesc(TextureContainer::Ktx2, format, false, 1, 1));
        if (bc::HasSrgbForm(format))
            add(MakeDesc(TextureContainer::Ktx2, format, true, 16, 4));
    }
    using tool::TexelNumber;
    for (const TexelNumber number :
         {TexelNumber::Unorm8, TexelNumber::Unorm16, TexelNumber::Half, TexelNumber::Float}) {
        for (const int channels : {1, 2, 4}) {
            TextureFileDesc desc = MakeDesc(TextureContainer::Ktx2, BlockFormat::Bc1, false, 5, 3);
            desc.format.block.reset();
            desc.format.number = number;
            desc.format.channels = channels;
            desc.format.hasAlpha = channels == 4;
            desc.zstdLevel = channels == 4 && tool::IsZstdAvailable() ? 3 : 0;
            add(desc);
        }
    }
    const fs::path script = fs::path(NTC_SCHEMA_DIR).parent_path() / "tests/cli/read_ktx2.mjs";
    std::istringstream lines(RunShell("node '" + script.string() + "' '" + module.string() + "'" + files));
    for (const WrittenTexture& texture : written) {
        std::string line;
        REQUIRE(std::getline(lines, line).good());
        INFO(line);
        rapidjson::Document json;
        json.Parse(line.c_str());
        REQUIRE_FALSE(json.HasParseError());
        const TextureFileDesc& desc = texture.desc;
        CHECK(json["vkFormat"].GetUint() == tool::GetVulkanFormat(desc.format));
        CHECK(json["width"].GetUint() == desc.width);
        CHECK(json["height"].GetUint() == desc.height);
        CHECK(json["depth"].GetUint() == 0);
        CHECK(json["layers"].GetUint() == 0);
        CHECK(json["faces"].GetUint() == 1);
        CHECK(json["scheme"].GetUint() == (desc.zstdLevel != 0 ? 2 : 0));
        CHECK(std::string(json["keyValue"]["KTXorientation"].GetString()) == "rd");
        CHECK(std::string(json["keyValue"]["KTXwriter"].GetString()).starts_with("OpenNTC "));
        const auto& descriptor = json["descriptor"];
        CHECK(descriptor["transferFunction"].GetUint() == (desc.format.srgb ? 2 : 1));
        CHECK(descriptor["bytesPlane"][0].GetUint() == tool::GetUnitBytes(desc.format));
        CHECK(descriptor["texelBlockDimension"][0].GetUint() == tool::GetUnitTexels(desc.format) - 1);
        CHECK(descriptor["samples"].Size() > 0);
        REQUIRE(json["levels"].Size() == desc.levels);
        for (rapidjson::SizeType i = 0; i < desc.levels; ++i) {
            std::string hex;
            for (const std::byte byte : texture.levels[i]) {
                char digits[3];
                std::snprintf(digits, sizeof digits, "%02x", static_cast<unsigned>(byte));
                hex += digits;
            }
            CHECK(json["levels"][i]["uncompressedBytes"].GetUint64() == texture.levels[i].size());
            if (desc.zstdLevel == 0)
                CHECK(hex == json["levels"][i]["hex"].GetString());
        }
    }
}
