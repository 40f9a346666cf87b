// SPDX-License-Identifier: MIT
// DDS and KTX2 files read by the letter of their specifications, apart from the code that writes them; and a set with
// textures of many formats to decode into them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace openntc_tests {

struct ParsedLevel {
    std::uint64_t offset = 0;
    std::uint64_t uncompressedBytes = 0;
    std::string bytes;
};

struct ParsedTexture {
    std::uint32_t width = 0, height = 0;
    std::uint32_t format = 0;              ///< VkFormat or DXGI_FORMAT
    std::vector<ParsedLevel> levels;       ///< largest first
    std::vector<std::uint32_t> descriptor; ///< KTX2: words of the data format descriptor, its size first
    std::string keyValues;
    std::uint32_t scheme = 0;         ///< KTX2: supercompression
    std::uint32_t typeSize = 0;       ///< KTX2
    std::vector<std::uint32_t> words; ///< DDS: the header's 37 words
};

/// Little-endian.
std::uint32_t GetWord(const std::string& bytes, std::size_t at);

/// `unit`: bytes of a texel or block, `side`: texels that it covers. Fails the test where the file breaks its format.
ParsedTexture ReadDds(const std::filesystem::path& path, std::uint32_t unit, std::uint32_t side);
ParsedTexture ReadKtx2(const std::filesystem::path& path);

/// 13 x 11 texels, 4 mips, seven textures: color (RGB sRGB, BC7), cut (RGBA sRGB, BC1), gray (R, BC4), two (RG, BC5), deep
/// (RG UNORM16), hdr (RGB FLOAT16 stored as HLG, BC6) and float (RGBA FLOAT32). Generation 1, or 3 with compressed latents.
void WriteManyFormats(const std::filesystem::path& path, int width = 13, int height = 11, int mips = 4,
                      int generation = 1);

} // namespace openntc_tests
