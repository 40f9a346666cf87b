// SPDX-License-Identifier: MIT
// `ntc export`: its files are the bytes that shaders read, and decode to the set's texels.
#include "cli/Program.h"
#include "support/SpecificationVectors.h"

#include "openntc/core/Crc32.h"
#include "openntc/decode/ReferenceDecoder.h"

#include <array>
#include <bit>
#include <cstring>

using namespace openntc;
using namespace openntc_tests;

namespace {

std::span<const std::byte> ToBytes(const std::string& text) {
    return std::as_bytes(std::span(text.data(), text.size()));
}

void WriteSet(const fs::path& path, const std::vector<std::byte>& bytes) {
    WriteText(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

/// The files of a folder, checked against its index.
struct Exported {
    rapidjson::Document index;
    std::string constants, weights, latents;

    explicit Exported(const fs::path& folder) : index(ParseValid(ReadText(folder / "index.json"), "export")) {
        for (const auto& [key, text] : {std::pair("constants", &constants), std::pair("weights", &weights),
                                        std::pair("latents", &latents)}) {
            const auto& entry = index[key];
            *text = ReadText(folder / entry["file"].GetString());
            CHECK(entry["bytes"].GetUint64() == text->size());
            CHECK(entry["crc32"].GetUint() == Crc32(ToBytes(*text)));
        }
    }
};

} // namespace

TEST_CASE("export: constants, weights and latents as shaders read them, which decode to the set's texels") {
    const Folder folder;
    WriteSet(folder / "v1.ntc", SynthesizeV1());
    const ProgramResult result = RunProgram(folder, "export v1.ntc -o out/deep --json");
    CAPTURE(result.errors);
    REQUIRE(result.code == 0);
    CHECK(result.output == ReadText(folder / "out/deep/index.json"));
    const Exported exported(folder / "out/deep");
    CHECK(exported.index["network"].GetString() == std::string("small"));
    CHECK(exported.index["defines"][0].GetString() == std::string("NETWORK_VERSION=1"));
    CHECK(exported.index["defines"][1].GetString() == std::string("NTC_MATH=1"));
    CHECK(exported.index["imageMips"].GetInt() == exported.index["mips"].GetInt());
    CHECK(exported.index["textures"].Size() == 1);
    // Four files and nothing temporary.
    CHECK(std::distance(fs::directory_iterator(folder / "out/deep"), fs::directory_iterator()) == 4);

    const auto shown = ParseValid(RunProgram(folder, "constants v1.ntc --json").output, "constants");
    std::string hex;
    for (const char c : exported.constants) {
        char digits[3];
        std::snprintf(digits, sizeof(digits), "%02x", static_cast<unsigned>(static_cast<unsigned char>(c)));
        hex += digits;
    }
    CHECK(hex == shown["constants"].GetString());
    CHECK(exported.constants.size() == 624);
    CHECK(exported.weights.size() == 13952);
    CHECK(Crc32(ToBytes(exported.weights)) == 0x2c7b7511u); // format specification, V1
    const std::string file = ReadText(folder / "v1.ntc");
    CHECK(exported.latents == file.substr(15884, 56));

    NtcTextureSetConstants constants;
    REQUIRE(exported.constants.size() == sizeof(constants));
    std::memcpy(&constants, exported.constants.data(), sizeof(constants));
    const DecodeSource source{&constants, ToBytes(exported.latents), ToBytes(exported.weights),
                              NTC_NETWORK_SMALL};
    std::array<float, 16> texel{};
    REQUIRE(DecodeReference(source, 0, {0, 0, 1, 1}, {}, texel));
    CHECK(std::bit_cast<std::uint32_t>(texel[0]) == 0xbf815600u); // format specification, V1
    CHECK(std::bit_cast<std::uint32_t>(texel[1]) == 0x3dadfd00u);
}

TEST_CASE("export: part of the mips, whole words, other weights, and what is refused") {
    const Folder folder;
    WriteSet(folder / "v1.ntc", SynthesizeV1());
    for (const std::string range : {"--first-mip 1", "--first-mip 1 --mips 2", "--first-mip 3"}) {
        CAPTURE(range);
        REQUIRE(RunProgram(folder, "export v1.ntc -o part " + range).code == 0);
        const Exported exported(folder / "part");
        const auto shown =
            ParseValid(RunProgram(folder, "constants v1.ntc --json " + range).output, "constants");
        const std::size_t size = shown["latentSize"].GetUint64();
        CHECK(exported.index["latentBytes"].GetUint64() == size);
        CHECK(exported.latents.size() == (size + 3) / 4 * 4);
        std::string expected = ReadText(folder / "v1.ntc").substr(shown["latentOffset"].GetUint64(), size);
        expected.resize(exported.latents.size());
        CHECK(exported.latents == expected);
    }
    CheckFails(RunProgram(folder, "export v1.ntc -o x --first-mip 99"), 2);
    CheckFails(RunProgram(folder, "export v1.ntc -o x --first-mip 1 --mips 99"), 2);
    CheckFails(RunProgram(folder, "export v1.ntc -o x --mips 1"), 2);
    CheckFails(RunProgram(folder, "export v1.ntc -o x --weights fp32"), 2);
    CheckFails(RunProgram(folder, "export v1.ntc"), 2);
    CheckFails(RunProgram(folder, "export none.ntc -o x"), 3);
    CheckFails(RunProgram(folder, "export v1.ntc -o v1.ntc/x"), 1);
    CheckFails(RunProgram(folder, "export v1.ntc -o x --weights fp8"), 3); // it has Int8 only
    CHECK_FALSE(fs::exists(folder / "x"));

    openntc::SynthesisDesc both = GetV2().synthesis;
    both.withFP8 = true;
    WriteSet(folder / "both.ntc", MakeFile(both));
    REQUIRE(RunProgram(folder, "export both.ntc -o both --weights fp8").code == 0);
    const Exported exported(folder / "both");
    CHECK(exported.index["weightType"].GetString() == std::string("fp8"));
    CHECK(exported.index["defines"][1].GetString() == std::string("NTC_MATH=3"));
    CHECK(exported.index["network"].GetString() == std::string("large"));
    const auto shown =
        ParseValid(RunProgram(folder, "constants both.ntc --weights fp8 --json").output, "constants");
    CHECK(exported.weights.size() == shown["weightBytes"].GetUint64());
    CHECK(Crc32(ToBytes(exported.weights)) == shown["weightCrc32"].GetUint());
}
