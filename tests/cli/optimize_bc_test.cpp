// SPDX-License-Identifier: MIT
// `ntc optimize-bc` and `ntc decode` with its hints: the blocks of a search without one, and side files that lie.
#include "cli/Program.h"
#include "cli/TextureFiles.h"

#include "openntc/bc/BlockDecoder.h"
#include "openntc/bc/BlockHints.h"

#include <cstring>
#include <functional>

using namespace openntc_tests;
using namespace openntc;

namespace {

std::vector<std::byte> ReadHintBytes(const fs::path& path) {
    const std::string text = ReadText(path);
    std::vector<std::byte> bytes(text.size());
    if (!text.empty())
        std::memcpy(bytes.data(), text.data(), text.size());
    return bytes;
}

void WriteHintBytes(const fs::path& path, const std::vector<std::byte>& bytes) {
    WriteText(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

/// Rewrites a side file with all checksums right, after `change` had its hands on a map and its hints.
void ForgeHints(const fs::path& path,
                const std::function<void(bc::BlockHintMap&, std::vector<std::int32_t>&)>& change) {
    const std::vector<std::byte> bytes = ReadHintBytes(path);
    const auto file = bc::BlockHintFile::Parse(bytes);
    REQUIRE(file.has_value());
    std::vector<bc::BlockHintMap> maps;
    std::vector<std::vector<std::byte>> packed(file->GetCount());
    for (std::uint32_t i = 0; i < file->GetCount(); ++i) {
        bc::BlockHintMap map = *file->GetMap(i);
        std::vector<std::int32_t> hints(std::size_t{map.width} * map.height);
        REQUIRE(bc::UnpackBlockHints(map, 0, 0, map.width, map.height, hints).has_value());
        change(map, hints);
        packed[i].resize(bc::GetBlockHintBytes(hints.size()));
        REQUIRE(bc::PackBlockHints(hints, packed[i]).has_value());
        map.packed = packed[i];
        maps.push_back(map);
    }
    std::vector<std::byte> forged(bc::GetBlockHintFileBytes(maps));
    REQUIRE(bc::WriteBlockHintFile(maps, file->GetSource(), forged).has_value());
    WriteHintBytes(path, forged);
}

/// The blocks of all mips of DIR/color.dds, by an encoder that searched (`--no-hints`) or not.
std::string DecodeColor(const Folder& folder, const std::string& arguments) {
    const ProgramResult result =
        RunProgram(folder, "decode a.ntc --format dds --quality best -o out --json " + arguments);
    INFO(arguments << ": " << result.errors);
    REQUIRE(result.code == 0);
    const auto json = ParseValid(result.output, "decode");
    const bool isHinted = arguments.find("--no-hints") == std::string::npos;
    CHECK(json.HasMember("hints") == isHinted);
    std::string color = ReadText(folder / "out/color.dds");
    fs::remove_all(folder / "out");
    return color;
}

/// Squared error of block `index` of mip 0 against the texels of the search's blocks is not known here, but that of two codings
/// of the same texels can be compared through the plain texels.
double GetBlockError(const std::string& dds, const std::string& plain, std::size_t index, int width) {
    std::byte block[16];
    std::memcpy(block, dds.data() + 148 + 16 * index, 16);
    std::uint8_t texels[64];
    bc::DecodeBlockBytes(bc::BlockFormat::Bc7, block, texels);
    const std::size_t columns = static_cast<std::size_t>(width) / 4;
    double sum = 0.0;
    for (std::size_t t = 0; t < 16; ++t) {
        const std::size_t x = index % columns * 4 + t % 4, y = index / columns * 4 + t / 4;
        for (std::size_t c = 0; c < 3; ++c) {
            const int wanted =
                static_cast<unsigned char>(plain[148 + (y * static_cast<std::size_t>(width) + x) * 4 + c]);
            const double difference = wanted - texels[4 * t + c];
            sum += difference * difference;
        }
    }
    return sum;
}

} // namespace

TEST_CASE("optimize-bc: blocks with hints are those of the search, at borders, in rectangles and padded") {
    const Folder folder;
    WriteManyFormats(folder / "a.ntc", 37, 22, 6);
    const ProgramResult result = RunProgram(folder, "optimize-bc a.ntc --json");
    INFO(result.errors);
    REQUIRE(result.code == 0);
    const auto json = ParseValid(result.output, "optimize-bc");
    CHECK(std::string(json["output"].GetString()) == "a.bcmodes");
    CHECK(json["bytes"].GetUint64() == fs::file_size(folder / "a.bcmodes"));
    CHECK(json["maps"].GetInt() == 6);
    REQUIRE(json["textures"].Size() == 1); // the others are not declared to be BC7
    const auto& color = json["textures"][0];
    CHECK(std::string(color["texture"].GetString()) == "color");
    constexpr unsigned kBlocks = 10 * 6 + 5 * 3 + 3 * 2 + 1 + 1 + 1;
    CHECK(color["blocks"].GetUint() == kBlocks);
    CHECK(color["texels"].GetUint() == 37 * 22 + 18 * 11 + 9 * 5 + 4 * 2 + 2 + 1);
    unsigned ofModes = 0;
    for (const auto& blocks : color["modes"].GetArray())
        ofModes += blocks.GetUint();
    CHECK(ofModes == kBlocks);
    CHECK(color["differentBlocks"].GetUint() == 0);
    CHECK(color["search"]["psnr"].GetDouble() == color["hinted"]["psnr"].GetDouble());
    CHECK(color["search"]["psnr"].GetDouble() >= color["fastSearch"]["psnr"].GetDouble());

    // The file's hints do the same in decode; one that starts within blocks searches.
    for (const std::string arguments : {"", "--pad", "--rect 4,8,20,9", "--rect 4,8,33,14", "--rect 8,0,5,5",
                                        "--rect 1,2,24,15", "--backend reference", "--hints a.bcmodes"}) {
        CAPTURE(arguments);
        const bool isNamed = arguments.starts_with("--hints");
        CHECK(DecodeColor(folder, arguments) ==
              DecodeColor(folder, isNamed ? "--no-hints" : arguments + " --no-hints"));
    }
    const ProgramResult said = RunProgram(folder, "decode a.ntc --format ktx2 -o said");
    CHECK(said.output.find("6 mips, with hints of a.bcmodes\n") != std::string::npos);
    CHECK(RunProgram(folder, "decode a.ntc --format ktx2 -o said --no-hints").output.find("hints") ==
          std::string::npos);
    // With files that hold no BC7 there is nothing to read, whatever lies there.
    WriteText(folder / "a.bcmodes", "nonsense");
    CHECK(RunProgram(folder, "decode a.ntc -o png").errors.find("bcmodes") == std::string::npos);
    CHECK(RunProgram(folder, "decode a.ntc --format dds --bc none -o plain").code == 0);
}

TEST_CASE("optimize-bc: every texture, other maths and linear colours on request") {
    const Folder folder;
    WriteManyFormats(folder / "a.ntc", 16, 16, 2);
    const ProgramResult all = RunProgram(folder, "optimize-bc a.ntc --bc bc7 --quality fast --json");
    INFO(all.errors);
    REQUIRE(all.code == 0);
    const auto json = ParseValid(all.output, "optimize-bc");
    CHECK(json["textures"].Size() == 7);
    CHECK(json["maps"].GetInt() == 14);
    const ProgramResult hinted =
        RunProgram(folder, "decode a.ntc --format dds --bc bc7 --quality fast -o hinted --json");
    REQUIRE(hinted.code == 0);
    const auto files = ParseValid(hinted.output, "decode");
    for (const auto& file : files["files"].GetArray())
        CHECK(file["hinted"].GetBool());
    REQUIRE(
        RunProgram(folder, "decode a.ntc --format dds --bc bc7 --quality fast -o search --no-hints").code ==
        0);
    for (const std::string name : {"color", "cut", "gray", "two", "deep", "hdr", "float"})
        CHECK(ReadText(folder / ("hinted/" + name + ".dds")) ==
              ReadText(folder / ("search/" + name + ".dds")));

    // Hints of other texels are left out, and that is said.
    for (const std::string arguments : {"--math int8_half", "--linear"}) {
        const ProgramResult other =
            RunProgram(folder, "decode a.ntc --format dds -o other --json " + arguments);
        CHECK(other.code == 0);
        CHECK(other.errors.find("color.dds: hints not used: gathered ") != std::string::npos);
        const auto document = ParseValid(other.output, "decode");
        CHECK_FALSE(document["files"][0]["hinted"].GetBool());
        REQUIRE(RunProgram(folder, "optimize-bc a.ntc --quality fast -o own.bcmodes " + arguments).code == 0);
        const ProgramResult own =
            RunProgram(folder, "decode a.ntc --format dds --hints own.bcmodes -o own --json " + arguments);
        CHECK(own.errors.find("hints") == std::string::npos);
        CHECK(ParseValid(own.output, "decode")["files"][0]["hinted"].GetBool());
    }
}

TEST_CASE("optimize-bc: hints that are damaged, of another file or of other texels are refused by name") {
    const Folder folder;
    WriteManyFormats(folder / "a.ntc", 16, 16, 3);
    REQUIRE(RunProgram(folder, "optimize-bc a.ntc --quality fast").code == 0);
    const std::vector<std::byte> good = ReadHintBytes(folder / "a.bcmodes");
    const auto decode = [&](const std::string& reason) {
        CAPTURE(reason);
        const ProgramResult result = RunProgram(folder, "decode a.ntc --format dds -o out");
        CheckFails(result, 3);
        CHECK(result.errors.find(reason) != std::string::npos);
        CHECK_FALSE(fs::exists(folder / "out"));
        CHECK(RunProgram(folder, "decode a.ntc --format dds -o free --no-hints").code == 0);
    };
    for (std::size_t at = 0; at < good.size(); at += 7) {
        std::vector<std::byte> bad = good;
        bad[at] ^= std::byte{0x10};
        WriteHintBytes(folder / "a.bcmodes", bad);
        CAPTURE(at);
        CheckFails(RunProgram(folder, "decode a.ntc --format dds -o out"), 3);
    }
    WriteHintBytes(folder / "a.bcmodes", {good.begin(), good.end() - 1});
    decode("a.bcmodes: bcmodes: ");
    WriteText(folder / "a.bcmodes", "");
    decode("a.bcmodes: bcmodes: not a file of BC7 hints");
    WriteText(folder / "a.bcmodes", std::string(1 << 16, 'x'));
    decode("a.bcmodes: size: more than ");
    // The same name beside another set.
    WriteHintBytes(folder / "a.bcmodes", good);
    const std::string set = ReadText(folder / "a.ntc");
    WriteManyFormats(folder / "a.ntc", 16, 12, 3);
    decode("a.bcmodes: source: hints of a file of ");
    WriteText(folder / "a.ntc", set);
    // Right checksums, wrong contents.
    ForgeHints(folder / "a.bcmodes", [](bc::BlockHintMap& map, std::vector<std::int32_t>&) {
        if (map.mip == 1)
            map.texels.crc ^= 1;
    });
    decode("hints: mip 1: CRC-32 of texels ");
    WriteHintBytes(folder / "a.bcmodes", good);
    ForgeHints(folder / "a.bcmodes",
               [](bc::BlockHintMap& map, std::vector<std::int32_t>&) { map.texture += 7; });
    decode("map 0: texture 7, mip 0: the set has 7 and 3");
    WriteHintBytes(folder / "a.bcmodes", good);
    ForgeHints(folder / "a.bcmodes", [](bc::BlockHintMap& map, std::vector<std::int32_t>&) { map.mip = 0; });
    decode("map 1: ");
    CheckFails(RunProgram(folder, "decode a.ntc --format dds -o out --hints none.bcmodes"), 3);
    CheckFails(RunProgram(folder, "decode a.ntc --format dds -o out --hints a.bcmodes --no-hints"), 2);
    CheckFails(RunProgram(folder, "decode a.ntc -o out --no-hints"), 2);
    CheckFails(RunProgram(folder, "decode a.ntc -o out --hints a.bcmodes"), 2);
}

TEST_CASE("optimize-bc: one wrong mode in a map costs quality where it is, and nothing elsewhere") {
    const Folder folder;
    constexpr int kSide = 32;
    WriteManyFormats(folder / "a.ntc", kSide, kSide, 1);
    REQUIRE(RunProgram(folder, "optimize-bc a.ntc").code == 0);
    const std::string right = DecodeColor(folder, "");
    REQUIRE(RunProgram(folder, "decode a.ntc --format dds --bc none -o plain").code == 0);
    const std::string plain = ReadText(folder / "plain/color.dds");
    constexpr std::size_t kBlock = 19;
    ForgeHints(folder / "a.bcmodes", [](bc::BlockHintMap&, std::vector<std::int32_t>& hints) {
        // Mode 3 with two subsets that no content asks for, or mode 6, which has one line.
        hints[kBlock] =
            (hints[kBlock] & 7) == 6 ? bc::MakeBlockHint(3, 17, 0, 0) : bc::MakeBlockHint(6, 0, 0, 0);
    });
    const std::string wrong = DecodeColor(folder, "");
    REQUIRE(wrong.size() == right.size());
    std::vector<std::size_t> different;
    for (std::size_t i = 0; i < kSide * kSide / 16; ++i)
        if (wrong.compare(148 + 16 * i, 16, right, 148 + 16 * i, 16) != 0)
            different.push_back(i);
    REQUIRE(different == std::vector<std::size_t>{kBlock});
    CHECK(GetBlockError(wrong, plain, kBlock, kSide) > GetBlockError(right, plain, kBlock, kSide));
    CHECK(DecodeColor(folder, "--no-hints") == right);
}

TEST_CASE("optimize-bc: all or nothing, and wrong usage") {
    const Folder folder;
    WriteManyFormats(folder / "a.ntc", 8, 8, 1);
    WriteText(folder / "a.bcmodes", "old");
    const ProgramResult full =
        RunProgram(folder, "--version >/dev/null; ulimit -f 0; '" NTC_PROGRAM "' optimize-bc a.ntc");
    CHECK(full.code == 1);
    CHECK(ReadText(folder / "a.bcmodes") == "old");
    WriteManyFormats(folder / "large.ntc", 1024, 1024, 1);
    const ProgramResult stopped =
        RunProgram(folder, "--version >/dev/null; " + SignalAfter(1) +
                               "'" NTC_PROGRAM "' optimize-bc large.ntc --bc bc7 --threads 1");
    CHECK(stopped.code == 1);
    CHECK_FALSE(fs::exists(folder / "large.bcmodes"));
    std::size_t files = 0;
    for (const auto& entry : fs::directory_iterator(folder.GetPath()))
        files += entry.is_regular_file() ? 1 : 0;
    CHECK(files == 3); // no remains

    CheckFails(RunProgram(folder, "optimize-bc none.ntc"), 3);
    CheckFails(RunProgram(folder, "optimize-bc - < a.ntc"), 2);
    CheckFails(RunProgram(folder, "optimize-bc a.ntc -o a.ntc"), 2);
    CheckFails(RunProgram(folder, "optimize-bc a.ntc -o -"), 2);
    CheckFails(RunProgram(folder, "optimize-bc a.ntc --bc bc1"), 2);
    CheckFails(RunProgram(folder, "optimize-bc a.ntc --quality most"), 2);
    CHECK(RunProgram(folder, "optimize-bc - -o piped.bcmodes --quality fast < a.ntc").code == 0);
    REQUIRE(RunProgram(folder, "optimize-bc a.ntc --quality fast").code == 0);
    CHECK(ReadText(folder / "piped.bcmodes") == ReadText(folder / "a.bcmodes"));
}

TEST_CASE("optimize-bc --in-set: a set of generation 3 keeps the modes, and blocks are those of the search") {
    const Folder folder;
    WriteManyFormats(folder / "a.ntc", 45, 29, 4, 3);
    const auto run = [&](const std::string& arguments) { return RequireOutput(folder, arguments); };
    const auto decode = [&](const std::string& arguments) {
        run("decode --format dds --bc bc7 -o out " + arguments);
        std::string textures;
        for (const char* name : {"color", "cut", "gray"})
            textures += ReadText(folder / ("out/" + std::string(name) + ".dds"));
        fs::remove_all(folder / "out");
        return textures;
    };
    const auto made = ParseValid(run("optimize-bc a.ntc --in-set -o b.ntc --bc bc7 --json"), "optimize-bc");
    CHECK(made["all"]["differentBlocks"].GetUint64() == 0);
    CHECK(made["maps"].GetUint64() == 4 * made["textures"].Size());
    CHECK(made["bytes"].GetUint64() == fs::file_size(folder / "b.ntc"));
    run("validate b.ntc");
    CHECK(ParseValid(run("info b.ntc --json"), "info")["textures"][0]["bcModeBuffers"].GetInt() == 4);
    CHECK(ParseValid(run("info a.ntc --json"), "info")["textures"][0]["bcModeBuffers"].GetInt() == 0);
    const std::string searched = decode("a.ntc --quality best");
    CHECK(decode("b.ntc --quality best --set-modes") == searched);
    CHECK(decode("b.ntc --quality best") == searched);     // without, nothing is made of them
    CHECK(decode("b.ntc --set-modes") != decode("b.ntc")); // modes of the best search are not those of normal
    CHECK(decode("b.ntc --quality best --set-modes --rect 4,8,20,12") ==
          decode("a.ntc --quality best --rect 4,8,20,12"));
    // Modes are replaced, not added to, and compressed on request: 96 blocks of a texture with 108 bytes.
    run("optimize-bc b.ntc --in-set -o c.ntc --bc bc7");
    CHECK(ReadText(folder / "c.ntc") == ReadText(folder / "b.ntc"));
    run("optimize-bc b.ntc --in-set -o d.ntc --bc bc7 --compress");
    run("validate d.ntc");
    CHECK(decode("d.ntc --quality best --set-modes") == searched);

    CheckFails(RunProgram(folder, "optimize-bc a.ntc --in-set"), 2);
    CheckFails(RunProgram(folder, "optimize-bc a.ntc --in-set -o a.ntc"), 2);
    CheckFails(RunProgram(folder, "optimize-bc a.ntc --compress -o e.ntc"), 2);
    CheckFails(RunProgram(folder, "optimize-bc a.ntc --in-set --linear -o e.ntc"), 2);
    CheckFails(RunProgram(folder, "decode b.ntc -o out --set-modes"), 2);
    CheckFails(RunProgram(folder, "decode a.ntc --format dds -o out --set-modes"), 3);
    CheckFails(RunProgram(folder, "decode b.ntc --format dds -o out --set-modes --no-hints"), 2);
    WriteManyFormats(folder / "old.ntc", 13, 11, 1);
    CheckFails(RunProgram(folder, "optimize-bc old.ntc --in-set -o e.ntc"), 3);
    CHECK_FALSE(fs::exists(folder / "e.ntc"));
}
