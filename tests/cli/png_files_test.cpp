// SPDX-License-Identifier: MIT
// PNG files as `ntc encode` reads them: every form of the format, and every checksum.
#include "cli/ImageFiles.h"
#include "cli/PngForms.h"
#include "cli/Program.h"

#include "Failure.h"
#include "encode/InputImage.h"

#include "openntc/core/Crc32.h"

#include <array>
#include <cstring>
#include <optional>
#include <set>
#include <span>

using namespace openntc_tests;
using openntc::tool::CommandError;
using openntc::tool::ExitCode;
using openntc::tool::InputImage;

namespace {

std::uint32_t ReadNumber(const std::string& file, std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i)
        value = value << 8 | static_cast<std::uint8_t>(file[at + i]);
    return value;
}

void WriteNumber(std::string& file, std::size_t at, std::uint32_t value) {
    for (std::size_t i = 0; i < 4; ++i)
        file[at + i] = static_cast<char>(value >> (24 - 8 * i));
}

struct Chunk {
    std::string name;
    std::size_t at = 0; ///< of the length
    std::size_t length = 0;
};

std::vector<Chunk> ListChunks(const std::string& file) {
    std::vector<Chunk> chunks;
    for (std::size_t at = 8; at + 12 <= file.size(); at += 12 + chunks.back().length)
        chunks.push_back({file.substr(at + 4, 4), at, ReadNumber(file, at)});
    return chunks;
}

void MendChecksum(std::string& file, const Chunk& chunk) {
    const auto bytes = std::as_bytes(std::span(file)).subspan(chunk.at + 4, 4 + chunk.length);
    WriteNumber(file, chunk.at + 8 + chunk.length, openntc::Crc32(bytes));
}

/// The error of reading `bytes`, or nothing.
std::optional<CommandError> Read(const std::string& bytes) {
    try {
        openntc::tool::ReadImage("a.png", std::as_bytes(std::span(bytes)));
    } catch (const CommandError& error) {
        return error;
    }
    return std::nullopt;
}

void CheckRefused(const std::string& bytes, const std::string& text) {
    const std::optional<CommandError> error = Read(bytes);
    REQUIRE(error);
    CAPTURE(error->GetLine());
    CHECK(error->GetCode() == ExitCode::BadInput);
    CHECK(error->GetSubject() == "a.png");
    CHECK(error->GetLine().find("image: " + text) != std::string::npos);
}

} // namespace

TEST_CASE("PNG: every form gives its samples, whatever gamma it claims") {
    const Folder folder;
    for (const PngForm& form : kPngForms) {
        for (const bool interlaced : {false, true}) {
            CAPTURE(form.name);
            CAPTURE(interlaced);
            WritePngForm(folder / "a.png", form, interlaced);
            const InputImage image = openntc::tool::ReadImage((folder / "a.png").string());
            CHECK(image.width == kPngFormWidth);
            CHECK(image.height == kPngFormHeight);
            CHECK(image.channels == form.channelsRead);
            CHECK(image.bits == (form.bits == 16 ? 16 : 8));
            CHECK(image.texels == GetPngFormSamples(form));
        }
    }
}

TEST_CASE("PNG: a checksum that differs is an error that names the chunk") {
    const Folder folder;
    // gAMA and tEXt are in the file too: all chunks count, not only those that hold texels.
    WritePngForm(folder / "a.png", kPngForms[0], false);
    const std::string good = ReadText(folder / "a.png");
    REQUIRE_FALSE(Read(good));
    std::set<std::string> names;
    for (const Chunk& chunk : ListChunks(good)) {
        CAPTURE(chunk.name);
        names.insert(chunk.name);
        std::string damaged = good;
        damaged[chunk.at + 8 + chunk.length] ^= 1; // the checksum
        CheckRefused(damaged, chunk.name + ": checksum");
        if (chunk.length > 0) {
            damaged = good;
            damaged[chunk.at + 8 + chunk.length / 2] ^= 0x10; // the data
            CheckRefused(damaged, chunk.name + ": checksum");
        }
    }
    CHECK(names == std::set<std::string>{"IHDR", "gAMA", "tEXt", "IDAT", "IEND"});
}

TEST_CASE("PNG: zlib's check value of the texels is verified behind a right CRC") {
    const Folder folder;
    for (const PngForm& form : kPngForms) {
        for (const bool interlaced : {false, true}) {
            CAPTURE(form.name);
            WritePngForm(folder / "a.png", form, interlaced);
            std::string file = ReadText(folder / "a.png");
            std::optional<Chunk> last;
            for (const Chunk& chunk : ListChunks(file)) {
                if (chunk.name == "IDAT")
                    last = chunk;
            }
            REQUIRE(last);
            file[last->at + 8 + last->length - 1] ^= 1; // the last byte of Adler-32
            MendChecksum(file, *last);
            const std::string text = std::to_string(kPngFormWidth) + " x " + std::to_string(kPngFormHeight) +
                                     ": IDAT: checksum of the texels";
            CheckRefused(file, text);
            // In a chunk of its own the check value is read after the last row.
            const std::string check = file.substr(last->at + 8 + last->length - 4, 4);
            std::string split = file.substr(0, last->at + 8 + last->length - 4);
            WriteNumber(split, last->at, static_cast<std::uint32_t>(last->length - 4));
            split += std::string(4, '\0') + std::string("\0\0\0\4IDAT", 8) + check + std::string(4, '\0') +
                     file.substr(last->at + 12 + last->length);
            for (const Chunk& chunk : ListChunks(split)) {
                if (chunk.name == "IDAT")
                    MendChecksum(split, chunk);
            }
            CheckRefused(split, text);
        }
    }
}

TEST_CASE("PNG: cut files and impossible sizes say what is wrong") {
    const Folder folder;
    WritePngForm(folder / "a.png", kPngForms[0], false);
    const std::string good = ReadText(folder / "a.png");
    for (std::size_t size = 8; size < good.size(); ++size) {
        const std::optional<CommandError> error = Read(good.substr(0, size));
        REQUIRE(error);
        CHECK(error->GetCode() == ExitCode::BadInput);
        CHECK(error->GetLine().find(std::to_string(size)) != std::string::npos);
    }
    const Chunk header = ListChunks(good).front();
    for (const auto& [width, height] : std::vector<std::pair<std::uint32_t, std::uint32_t>>{
             {0, 5}, {5, 0}, {0, 0}, {16385, 1}, {1, 16385}, {100000, 100000}, {0xFFFFFFFFu, 1}}) {
        std::string file = good;
        WriteNumber(file, header.at + 8, width);
        WriteNumber(file, header.at + 12, height);
        MendChecksum(file, header);
        CheckRefused(file,
                     "IHDR: " + std::to_string(width) + " x " + std::to_string(height) + ": 1 to 16384");
    }
}

TEST_CASE("a damaged PNG: exit 3 and nothing written") {
    const Folder folder;
    WritePngForm(folder / "a.png", kPngForms[0], false);
    std::string file = ReadText(folder / "a.png");
    for (const Chunk& chunk : ListChunks(file)) {
        if (chunk.name == "IDAT")
            file[chunk.at + 8 + chunk.length / 2] ^= 0x10;
    }
    WriteText(folder / "a.png", file);
    const ProgramResult result = RunProgram(folder, "encode a.png -o a.ntc --steps 2");
    CheckFails(result, 3);
    CHECK(result.errors.starts_with("ntc: a.png: image: IDAT: checksum"));
    CHECK_FALSE(fs::exists(folder / "a.ntc"));
    CheckFails(RunProgram(folder, "compare a.png a.png"), 3);
}

TEST_CASE("other formats: empty, foreign and damaged files say what they are") {
    const Folder folder;
    const std::vector<std::pair<std::string, std::string>> files = {
        {"", "0 bytes: the file is empty"},
        {"not an image, but long enough", "an unknown format"},
        {std::string("RIFF\x10\0\0\0WEBPVP8 ", 16), "WebP"},
        {std::string("II*\0\x08\0\0\0", 8), "TIFF"},
        {"DDS |   ", "DDS"},
        {"\xABKTX 20\xBB\r\n\x1A\n", "KTX"},
        {"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 100000 +X 100000\n", "100000 x 100000: 1 to 16384"},
        {"P6 0 5 255\n", "0 x 5: 1 to 16384"}};
    for (const auto& file : files) {
        const auto& [bytes, text] = file;
        CAPTURE(file.second);
        WriteText(folder / "a.png", bytes);
        const ProgramResult result = RunProgram(folder, "encode a.png -o a.ntc --steps 2");
        CAPTURE(result.errors);
        CheckFails(result, 3);
        CHECK(result.errors.find("image: ") != std::string::npos);
        CHECK(result.errors.find(text) != std::string::npos);
    }
}

#if defined(OPENNTC_TOOL_HAS_EXR)
TEST_CASE("OpenEXR: compressed texels that are damaged are an error") {
    const Folder folder;
    // Noise, so that every scan line block is compressed or stored; every byte behind the offset table is
    // data.
    std::uint32_t state = 1;
    WriteImage(folder / "a.exr", MakeImage(64, 32, 3, [&](float u, float, int) {
                   state = state * 1664525u + 1013904223u;
                   return u > 0.5f ? 1.0f : static_cast<float>(state >> 24);
               }));
    const std::string good = ReadText(folder / "a.exr");
    REQUIRE_FALSE(Read(good));
    int refused = 0, tried = 0;
    for (std::size_t at = good.size() / 2; at < good.size(); at += 97) {
        std::string damaged = good;
        damaged[at] ^= 0x40;
        ++tried;
        refused += Read(damaged) ? 1 : 0;
    }
    CHECK(refused == tried);
    std::string cut = good.substr(0, good.size() / 2);
    CHECK(Read(cut));
}
#endif
