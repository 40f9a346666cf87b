// SPDX-License-Identifier: MIT
// DDS and KTX2 files: headers, descriptors, places and sizes, and the texels in them.
#include "cli/Program.h"
#include "cli/TextureFiles.h"
#include "support/Files.h"

#include "TextureImage.h"
#include "textures/TextureFile.h"
#include "textures/TextureFileHeaders.h"

#include "openntc/core/Half.h"

#include <cmath>
#include <cstring>
#include <map>

#if defined(OPENNTC_TOOL_HAS_ZSTD)
#include <zstd.h>
#endif

using namespace openntc_tests;
using namespace openntc;
using tool::TexelNumber;
using tool::TextureContainer;
using tool::TextureFormat;

namespace {

constexpr std::uint32_t kFileWide = 13, kFileHigh = 11, kFileMips = 4;

/// All 16 outputs of a texel, linear or as the network stores them.
class Samples {
public:
    Samples(const Folder& folder, const std::string& set, bool linear) {
        std::string list;
        for (std::uint32_t mip = 0; mip < kFileMips; ++mip) {
            starts_.push_back(count_);
            for (std::uint32_t y = 0; y < std::max(kFileHigh >> mip, 1U); ++y)
                for (std::uint32_t x = 0; x < std::max(kFileWide >> mip, 1U); ++x, ++count_)
                    list += std::to_string(mip) + " " + std::to_string(x) + " " + std::to_string(y) + "\n";
        }
        WriteText(folder / "list", list);
        const auto json = ParseValid(
            RunProgram(folder, "sample " + set + " --texels list --json" + (linear ? " --linear" : ""))
                .output,
            "sample");
        for (const auto& texel : json["texels"].GetArray())
            for (const auto& value : texel["values"].GetArray())
                values_.push_back(value.IsString() ? std::nanf("") : value.GetFloat());
    }
    float Get(std::uint32_t mip, std::uint32_t x, std::uint32_t y, std::uint32_t channel) const {
        const std::uint32_t width = std::max(kFileWide >> mip, 1U);
        return values_[(starts_[mip] + y * width + x) * 16 + channel];
    }

private:
    std::vector<std::uint32_t> starts_;
    std::uint32_t count_ = 0;
    std::vector<float> values_;
};

std::uint32_t GetNumber(const std::string& bytes, std::size_t index, std::size_t size) {
    std::uint32_t number = 0;
    for (std::size_t i = 0; i < size; ++i)
        number |= std::uint32_t{static_cast<unsigned char>(bytes.at(index * size + i))} << (8 * i);
    return number;
}

/// What a texel's channel holds, before block compression.
std::uint32_t Quantise(TexelNumber number, float value) {
    switch (number) {
    case TexelNumber::Unorm8:
        return tool::QuantiseUnorm(value, 255);
    case TexelNumber::Unorm16:
        return tool::QuantiseUnorm(value, 65535);
    case TexelNumber::Half:
        return FloatToHalf(value);
    default:
        break;
    }
    std::uint32_t bits;
    std::memcpy(&bits, &value, 4);
    return bits;
}

struct FileFormat {
    const char* name;
    TexelNumber number;
    std::uint32_t first, count; // channels of the set
    std::uint32_t stored;       // in a texel
    bool linear;                // compared with linear samples
    std::uint32_t vulkan, dxgi;
};

// With --bc none: what WriteManyFormats says becomes these formats.
constexpr FileFormat kPlain[] = {
    {"color", TexelNumber::Unorm8, 0, 3, 4, false, 43, 29},
    {"cut", TexelNumber::Unorm8, 0, 4, 4, false, 43, 29},
    {"gray", TexelNumber::Unorm8, 4, 1, 1, true, 9, 61},
    {"two", TexelNumber::Unorm8, 5, 2, 2, true, 16, 49},
    {"deep", TexelNumber::Unorm16, 7, 2, 2, true, 77, 35},
    {"hdr", TexelNumber::Half, 9, 3, 4, true, 97, 10},
    {"float", TexelNumber::Float, 12, 4, 4, true, 109, 2},
};

void CheckTexels(const FileFormat& expected, const ParsedTexture& texture, const Samples& samples) {
    const auto size = static_cast<std::size_t>(tool::GetNumberBytes(expected.number));
    REQUIRE(texture.levels.size() == kFileMips);
    for (std::uint32_t mip = 0; mip < kFileMips; ++mip) {
        const std::uint32_t width = std::max(kFileWide >> mip, 1U), height = std::max(kFileHigh >> mip, 1U);
        REQUIRE(texture.levels[mip].bytes.size() == std::size_t{width} * height * expected.stored * size);
        std::size_t at = 0;
        for (std::uint32_t y = 0; y < height; ++y) {
            for (std::uint32_t x = 0; x < width; ++x) {
                for (std::uint32_t c = 0; c < expected.stored; ++c, ++at) {
                    const float value = c < expected.count ? samples.Get(mip, x, y, expected.first + c)
                                        : c == 3           ? 1.0f
                                                           : 0.0f;
                    REQUIRE(GetNumber(texture.levels[mip].bytes, at, size) ==
                            Quantise(expected.number, value));
                }
            }
        }
    }
}

} // namespace

TEST_CASE("texture files: every size in 64 bits") {
    TextureFormat format;
    format.number = TexelNumber::Float; // RGBA32F: 16384 x 16384 is 2^32 bytes
    for (const auto container : {TextureContainer::Dds, TextureContainer::Ktx2}) {
        const tool::TextureFileLayout layout =
            tool::LayOutTextureFile({container, format, 16384, 16384, 15, 0});
        REQUIRE(layout.levels.size() == 15);
        CHECK(layout.levels[0].bytes == std::uint64_t{1} << 32);
        std::uint64_t sum = 0;
        for (const tool::TextureFileLevel& level : layout.levels)
            sum += level.bytes;
        CHECK(sum == 16 * (((std::uint64_t{1} << 30) - 1) / 3)); // 16 (4^15 - 1) / 3
        CHECK(layout.fileBytes >= layout.headerBytes + sum);
        CHECK(layout.fileBytes <= layout.headerBytes + sum + 15);
        // In a DDS file what follows the first level lies above 4 GiB; in a KTX2 file the first level comes last.
        if (container == TextureContainer::Dds)
            CHECK(layout.levels[1].offset == 148 + (std::uint64_t{1} << 32));
        else
            CHECK(layout.levels[0].offset + layout.levels[0].bytes == layout.fileBytes);
    }
    // The largest set, in blocks of 16 bytes: a row of it alone is 4 MiB.
    format = {};
    format.block = bc::BlockFormat::Bc7;
    const auto layout = tool::LayOutTextureFile({TextureContainer::Ktx2, format, 1 << 20, 1 << 20, 21, 0});
    CHECK(layout.levels[0].bytes == std::uint64_t{1} << 40);
    CHECK(layout.levels[20].bytes == 16);
    // What does not fit into the DDS header's 32 bits is 0 there, not cut off.
    const auto header = tool::MakeDdsHeader({TextureContainer::Dds, format, 1 << 20, 1 << 20, 21, 0});
    CHECK(
        std::all_of(header.begin() + 20, header.begin() + 24, [](std::byte b) { return b == std::byte{0}; }));
}

TEST_CASE("texture files: KTX2 descriptors are those that the validator accepted") {
    const fs::path path = GetConformanceFolder() / "bc-anchors.json";
    if (!fs::exists(path)) {
        MESSAGE("SKIP: KTX2 descriptors: no bc-anchors.json in ", path.parent_path().string());
        return;
    }
    rapidjson::Document anchors;
    anchors.Parse(ReadText(path).c_str());
    REQUIRE_FALSE(anchors.HasParseError());
    std::map<std::uint32_t, const rapidjson::Value*> rows;
    for (const auto& row : anchors["containers"]["ktx2_dfd_accepted_by_validator"]["rows"].GetArray()) {
        const auto& number = row["vkFormat"];
        if (number.IsUint())
            rows[number.GetUint()] = &row;
        else // "145/146"
            for (const std::uint32_t each : {145U, 146U})
                rows[each] = &row;
    }
    std::size_t found = 0;
    for (int i = 0; i < bc::kBlockFormatCount; ++i) {
        for (const bool srgb : {false, true}) {
            for (const bool hasAlpha : {false, true}) {
                TextureFormat format;
                format.block = static_cast<bc::BlockFormat>(i);
                format.srgb = srgb && bc::HasSrgbForm(*format.block);
                format.hasAlpha = hasAlpha;
                const bool isSigned = *format.block == bc::BlockFormat::Bc4Signed ||
                                      *format.block == bc::BlockFormat::Bc5Signed;
                format.number = isSigned ? TexelNumber::Snorm8 : TexelNumber::Unorm8;
                const auto row = rows.find(tool::GetVulkanFormat(format));
                if (row == rows.end())
                    continue;
                ++found;
                CAPTURE(row->first);
                const auto words = tool::MakeDataFormatDescriptor(format);
                const auto& samples = (*row->second)["samples"];
                REQUIRE(words.size() == 7 + 4 * samples.Size());
                CHECK(words[0] == 4 * words.size());
                CHECK(words[1] == 0);
                CHECK(words[2] == (2 | (words[0] - 4) << 16));
                CHECK((words[3] & 0xFF) == (*row->second)["model"].GetUint());
                CHECK((words[3] >> 8) == (1U | (format.srgb ? 2U : 1U) << 8));
                CHECK(words[4] == 0x0303);
                CHECK(words[5] == bc::GetBytesPerBlock(*format.block));
                CHECK(words[6] == 0);
                for (rapidjson::SizeType s = 0; s < samples.Size(); ++s) {
                    const std::size_t at = 7 + 4 * std::size_t{s};
                    CHECK(words[at] == (samples[s][0].GetUint() | (samples[s][1].GetUint() - 1) << 16 |
                                        samples[s][2].GetUint() << 24));
                    CHECK(words[at + 1] == 0);
                    CHECK(words[at + 2] == samples[s][3].GetUint());
                    CHECK(words[at + 3] == samples[s][4].GetUint());
                }
            }
        }
    }
    CHECK(found >= rows.size());
}

TEST_CASE("decode: DDS and KTX2 without blocks hold all mips, texel by texel") {
    const Folder folder;
    WriteManyFormats(folder / "a.ntc");
    const Samples stored(folder, "a.ntc", false), linear(folder, "a.ntc", true);
    const ProgramResult dds = RunProgram(folder, "decode a.ntc --format dds --bc none -o dds --json");
    INFO(dds.errors);
    REQUIRE(dds.code == 0);
    CHECK(dds.errors.empty()); // nothing is lost
    const auto json = ParseValid(dds.output, "decode");
    CHECK(json["files"].Size() == 7);
    REQUIRE(RunProgram(folder, "decode a.ntc --format ktx2 --bc none -o ktx2").code == 0);
    for (const FileFormat& expected : kPlain) {
        CAPTURE(expected.name);
        const std::uint32_t bytes =
            expected.stored * static_cast<std::uint32_t>(tool::GetNumberBytes(expected.number));
        const fs::path name = std::string("dds/") + expected.name + ".dds";
        const ParsedTexture d = ReadDds(folder / name.string(), bytes, 1);
        CHECK(d.width == kFileWide);
        CHECK(d.height == kFileHigh);
        CHECK(d.words[7] == kFileMips);
        CHECK(d.words[20] == 4);
        CHECK(d.words[27] == (0x1000 | 0x8 | 0x400000));
        CHECK(d.format == expected.dxgi);
        CHECK(d.words[34] == 0);
        CHECK(d.words[36] == (expected.count == 4 ? 1 : 3));
        CheckTexels(expected, d, expected.linear ? linear : stored);
        const ParsedTexture k = ReadKtx2(folder / (std::string("ktx2/") + expected.name + ".ktx2"));
        CHECK(k.format == expected.vulkan);
        CHECK(k.width == kFileWide);
        CHECK(k.height == kFileHigh);
        CHECK(k.typeSize == static_cast<std::uint32_t>(tool::GetNumberBytes(expected.number)));
        CHECK(k.scheme == 0);
        CHECK(k.descriptor[5] == bytes);
        CHECK((k.descriptor[3] >> 16 & 0xFF) == (expected.vulkan == 43 ? 2 : 1));
        CHECK(k.keyValues.find(std::string("KTXorientation\0rd\0", 18)) == 4);
        CHECK(k.keyValues.find(std::string("KTXwriter\0OpenNTC ", 18)) != std::string::npos);
        for (std::uint32_t mip = 0; mip < kFileMips; ++mip)
            CHECK(k.levels.at(mip).bytes == d.levels.at(mip).bytes);
    }
}

TEST_CASE("decode: sides that are no multiples of 4 are warned of, or padded") {
    const Folder folder;
    WriteManyFormats(folder / "a.ntc");
    WriteManyFormats(folder / "even.ntc", 16, 12, 5);
    const ProgramResult odd = RunProgram(folder, "decode a.ntc -o odd --format dds");
    REQUIRE(odd.code == 0);
    CHECK(odd.errors.find("13 x 11: Direct3D creates block-compressed textures of multiples of 4") !=
          std::string::npos);
    const ProgramResult padded = RunProgram(folder, "decode a.ntc -o padded --format dds --pad");
    REQUIRE(padded.code == 0);
    CHECK(padded.errors.find("Direct3D") == std::string::npos);
    const ProgramResult even = RunProgram(folder, "decode even.ntc -o even --format dds");
    REQUIRE(even.code == 0);
    CHECK(even.errors.find("Direct3D") == std::string::npos);
    const ParsedTexture whole = ReadDds(folder / "odd/cut.dds", 8, 4),
                        larger = ReadDds(folder / "padded/cut.dds", 8, 4);
    CHECK(whole.width == 13);
    CHECK(whole.height == 11);
    CHECK(larger.width == 16);
    CHECK(larger.height == 12);
    CHECK(larger.words[7] == whole.words[7]);
    // What is padded is what a block at the border repeats anyway.
    CHECK(larger.levels[0].bytes == whole.levels[0].bytes);
}

TEST_CASE("decode: --linear writes linear formats; the file's space decides otherwise") {
    const Folder folder;
    WriteManyFormats(folder / "a.ntc");
    REQUIRE(RunProgram(folder, "decode a.ntc --format ktx2 --bc none --linear -o out").code == 0);
    const Samples linear(folder, "a.ntc", true);
    FileFormat color = kPlain[0];
    color.linear = true;
    // Three linear channels need a fourth.
    const ParsedTexture texture = ReadKtx2(folder / "out/color.ktx2");
    CHECK(texture.format == 37);
    CheckTexels(color, texture, linear);
}

TEST_CASE("decode: KTX2 levels through Zstandard") {
    const Folder folder;
    WriteManyFormats(folder / "a.ntc");
    const ProgramResult result = RunProgram(folder, "decode a.ntc --format ktx2 --bc none --zstd 19 -o out");
#if defined(OPENNTC_TOOL_HAS_ZSTD)
    INFO(result.errors);
    REQUIRE(result.code == 0);
    REQUIRE(RunProgram(folder, "decode a.ntc --format ktx2 --bc none -o plain").code == 0);
    for (const FileFormat& expected : kPlain) {
        CAPTURE(expected.name);
        const ParsedTexture zstd = ReadKtx2(folder / (std::string("out/") + expected.name + ".ktx2"));
        const ParsedTexture plain = ReadKtx2(folder / (std::string("plain/") + expected.name + ".ktx2"));
        CHECK(zstd.scheme == 2);
        CHECK(zstd.descriptor == plain.descriptor);
        REQUIRE(zstd.levels.size() == plain.levels.size());
        for (std::size_t i = 0; i < zstd.levels.size(); ++i) {
            const std::string& bytes = zstd.levels[i].bytes;
            CHECK(zstd.levels[i].uncompressedBytes == plain.levels[i].bytes.size());
            // The frame says its size, which loaders allocate by.
            REQUIRE(ZSTD_getFrameContentSize(bytes.data(), bytes.size()) == plain.levels[i].bytes.size());
            std::string back(plain.levels[i].bytes.size(), '\0');
            CHECK(ZSTD_decompress(back.data(), back.size(), bytes.data(), bytes.size()) == back.size());
            CHECK(back == plain.levels[i].bytes);
        }
    }
#else
    CheckFails(result, 4);
    CHECK(result.errors.find("libzstd") != std::string::npos);
    MESSAGE("SKIP: KTX2 through Zstandard: built without libzstd");
#endif
}

TEST_CASE("decode: rectangles, of one mip and of a chain") {
    const Folder folder;
    WriteManyFormats(folder / "a.ntc");
    const Samples stored(folder, "a.ntc", false);
    const ProgramResult result =
        RunProgram(folder, "decode a.ntc --format dds --bc none --rect 6,3,5,6 -o out --json");
    INFO(result.errors);
    REQUIRE(result.code == 0);
    const auto json = ParseValid(result.output, "decode");
    CHECK(json["files"][0]["width"].GetInt() == 5);
    CHECK(json["files"][0]["height"].GetInt() == 6);
    CHECK(json["files"][0]["mips"].GetInt() == 3); // 5 x 6, 2 x 3, 1 x 1
    const ParsedTexture texture = ReadDds(folder / "out/color.dds", 4, 1);
    REQUIRE(texture.levels.size() == 3);
    for (std::uint32_t mip = 0; mip < 3; ++mip) {
        const std::uint32_t width = std::max(5U >> mip, 1U), height = std::max(6U >> mip, 1U);
        for (std::uint32_t y = 0; y < height; ++y)
            for (std::uint32_t x = 0; x < width; ++x)
                for (std::uint32_t c = 0; c < 3; ++c)
                    CHECK(GetNumber(texture.levels[mip].bytes, (y * width + x) * 4 + c, 1) ==
                          tool::QuantiseUnorm(stored.Get(mip, (6U >> mip) + x, (3U >> mip) + y, c), 255));
    }
    // Images take mip 0 unless more are asked for.
    CHECK(RunProgram(folder, "decode a.ntc --format png --rect 12,10,1,1 -o one").code == 1); // hdr, float
    CHECK(fs::exists(folder / "one/gray.png"));
    CHECK_FALSE(fs::exists(folder / "one/mips"));
    for (const std::string rect : {"0,0,0,4", "0,0,4,0", "13,0,1,1", "0,11,1,1", "-1,0,2,2", "0,0,14,1",
                                   "0,0,1,12", "1,0,2147483647,1", "1,1,1", "a,b,c,d"}) {
        CAPTURE(rect);
        CheckFails(RunProgram(folder, "decode a.ntc --rect " + rect + " -o none"), 2);
        CHECK_FALSE(fs::exists(folder / "none"));
    }
}

TEST_CASE("decode: options of files that do not go together") {
    const Folder folder;
    WriteManyFormats(folder / "a.ntc");
    for (const std::string options :
         {"--bc bc7", "--bc none", "--bc auto --format png", "--bc bc1 --format exr", "--bc bc1 --format tga",
          "--quality best", "--pad --format tga", "--zstd 3", "--zstd 3 --format dds",
          "--zstd 0 --format ktx2", "--zstd 23 --format ktx2", "--bc bc8 --format dds",
          "--bc BC7 --format dds", "--quality slow --format dds", "--format DDS", "--format gif"}) {
        CAPTURE(options);
        CheckFails(RunProgram(folder, "decode a.ntc -o none " + options), 2);
        CHECK_FALSE(fs::exists(folder / "none"));
    }
    // A full disk leaves nothing.
    const ProgramResult full = RunProgram(folder, "--version >/dev/null; ulimit -f 0; '" NTC_PROGRAM
                                                  "' decode a.ntc -o none --format ktx2 --bc none");
    CHECK(full.code == 1);
    CHECK_FALSE(fs::exists(folder / "none"));
}
