// SPDX-License-Identifier: MIT
#include "TexelList.h"

#include "Failure.h"
#include "Interrupt.h"
#include "Output.h"
#include "Progress.h"

#include <algorithm>
#include <charconv>
#include <map>
#include <tuple>

namespace openntc::tool {

namespace {

constexpr std::string_view kSpaces = " \t\r\f\v";

// The next word of `line`, removed from it; empty at the end.
std::string_view TakeWord(std::string_view& line) {
    line.remove_prefix(std::min(line.find_first_not_of(kSpaces), line.size()));
    const std::string_view word = line.substr(0, line.find_first_of(kSpaces));
    line.remove_prefix(word.size());
    return word;
}

// Integers too large for int are saturated: they are outside every image, like any other large number.
bool ParseInteger(std::string_view word, int& value) {
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (end != word.data() + word.size())
        return false;
    if (error == std::errc::result_out_of_range)
        value = word.front() == '-' ? std::numeric_limits<int>::min() : std::numeric_limits<int>::max();
    return error == std::errc() || error == std::errc::result_out_of_range;
}

void CheckInside(const Texel& texel, const TextureSetMetadata& metadata, const std::string& path,
                 std::size_t line) {
    const int mips = metadata.GetDesc().mips;
    if (texel.mip < 0 || texel.mip >= mips)
        throw CommandError(ExitCode::Usage, path,
                           Format("line %zu: mip %d: 0 ... %d", line, texel.mip, mips - 1));
    const ColorMip& mip = metadata.GetColorMips()[static_cast<std::size_t>(texel.mip)];
    if (texel.x < 0 || texel.x >= mip.width || texel.y < 0 || texel.y >= mip.height)
        throw CommandError(ExitCode::Usage, path,
                           Format("line %zu: texel (%d, %d) of mip %d: inside %d x %d", line, texel.x,
                                  texel.y, texel.mip, mip.width, mip.height));
}

} // namespace

std::vector<Texel> ReadTexelList(const std::string& path, const TextureSetMetadata& metadata) {
    const std::vector<std::byte> bytes = ReadAll(path);
    std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    std::vector<Texel> texels;
    for (std::size_t line = 1; !text.empty(); ++line) {
        const std::size_t length = std::min(text.find('\n'), text.size());
        std::string_view rest = text.substr(0, length);
        text.remove_prefix(std::min(length + 1, text.size()));
        rest = rest.substr(0, rest.find('#'));
        const std::string_view first = TakeWord(rest);
        if (first.empty())
            continue;
        Texel texel;
        if (!ParseInteger(first, texel.mip) || !ParseInteger(TakeWord(rest), texel.x) ||
            !ParseInteger(TakeWord(rest), texel.y) || !TakeWord(rest).empty())
            throw CommandError(ExitCode::BadInput, path,
                               Format("line %zu: not `mip x y`: three integers", line));
        CheckInside(texel, metadata, path, line);
        texels.push_back(texel);
    }
    return texels;
}

std::vector<std::array<float, 16>> DecodeTexels(Decoder& decoder, const TextureSetMetadata& metadata,
                                                std::span<const Texel> texels, const DecodeOptions& options,
                                                const std::string& subject, Progress* progress) {
    const int tileSize = decoder.GetTileSize();
    std::map<std::tuple<int, int, int>, std::vector<std::size_t>> tiles; // (mip, tile y, tile x) → texels
    for (std::size_t i = 0; i < texels.size(); ++i)
        tiles[{texels[i].mip, texels[i].y / tileSize, texels[i].x / tileSize}].push_back(i);

    std::vector<std::array<float, 16>> values(texels.size());
    std::vector<float> outputs;
    for (const auto& [key, members] : tiles) {
        ThrowIfInterrupted();
        const auto& [mip, tileY, tileX] = key;
        const ColorMip& size = metadata.GetColorMips()[static_cast<std::size_t>(mip)];
        Rect rect{tileX * tileSize, tileY * tileSize, 0, 0};
        rect.width = std::min(tileSize, size.width - rect.left);
        rect.height = std::min(tileSize, size.height - rect.top);
        outputs.resize(static_cast<std::size_t>(rect.width) * static_cast<std::size_t>(rect.height) * 16);
        Require(decoder.Decode(mip, rect, options, outputs), ExitCode::Failed, subject);
        for (const std::size_t i : members) {
            const std::size_t row = static_cast<std::size_t>(texels[i].y - rect.top);
            const std::size_t column = static_cast<std::size_t>(texels[i].x - rect.left);
            const std::size_t texel = row * static_cast<std::size_t>(rect.width) + column;
            std::copy_n(outputs.begin() + static_cast<std::ptrdiff_t>(texel * 16), 16, values[i].begin());
        }
        if (progress != nullptr)
            progress->Advance(members.size());
    }
    return values;
}

} // namespace openntc::tool
