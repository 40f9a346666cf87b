// SPDX-License-Identifier: MIT
#include "Output.h"
#include "encode/ComparedSet.h"

#include <algorithm>
#include <array>
#include <optional>

namespace openntc::tool {

namespace {

constexpr int kChannels = 16;

/// Of two sides, which channel of the second belongs to each of the first; -1: none.
using Partners = std::array<int, kChannels>;

/// For each texture of `a` the one of `b` with its name, or else with the name of its file.
std::vector<std::optional<std::size_t>> MatchTextures(const ComparedSet& a, const ComparedSet& b) {
    std::vector<std::optional<std::size_t>> matches(a.textures.size());
    for (std::string ComparedTexture::*const name : {&ComparedTexture::name, &ComparedTexture::fileName}) {
        for (std::size_t i = 0; i < a.textures.size(); ++i) {
            for (std::size_t j = 0; j < b.textures.size() && !matches[i]; ++j) {
                const bool isFree = std::find(matches.begin(), matches.end(), j) == matches.end();
                if (isFree && a.textures[i].*name == b.textures[j].*name)
                    matches[i] = j;
            }
        }
    }
    return matches;
}

std::string JoinNumbers(std::span<const int> numbers) {
    std::string text;
    for (const int number : numbers)
        text += (text.empty() ? "" : ", ") + std::to_string(number);
    return text;
}

ComparedPairs::LeftOut ListLeftOut(const ComparedSet& side, std::uint32_t compared, bool isByName) {
    ComparedPairs::LeftOut left;
    for (int c = 0; c < kChannels; ++c) {
        if (((side.declared & ~compared) >> c & 1u) != 0)
            left.channels.push_back(c);
    }
    for (const ComparedTexture& texture : side.textures) {
        std::vector<int> channels;
        for (int c = texture.firstChannel; c < texture.firstChannel + texture.channels; ++c) {
            if ((compared >> c & 1u) == 0)
                channels.push_back(c);
        }
        if (channels.empty())
            continue;
        const bool isWhole = static_cast<int>(channels.size()) == texture.channels;
        if (isWhole)
            left.textures.push_back(texture.name);
        left.text += (left.text.empty() ? "" : ", ") +
                     (isWhole ? "texture " : "channels " + JoinNumbers(channels) + " of ") +
                     Printable(texture.name);
    }
    if (!isByName)
        left.text = left.channels.empty() ? "" : "channels " + JoinNumbers(left.channels);
    return left;
}

/// Gives channels the numbers of their partners; those without one get the numbers that are left.
void MoveChannels(ComparedSet& set, const Partners& partners) {
    Partners numbers; // of each channel
    numbers.fill(-1);
    for (int c = 0; c < kChannels; ++c) {
        if (partners[static_cast<std::size_t>(c)] >= 0)
            numbers[static_cast<std::size_t>(partners[static_cast<std::size_t>(c)])] = c;
    }
    int free = 0;
    for (int& number : numbers) {
        if (number >= 0)
            continue;
        while (partners[static_cast<std::size_t>(free)] >= 0)
            ++free;
        number = free++;
    }
    std::uint32_t declared = 0;
    for (int c = 0; c < kChannels; ++c)
        declared |= (set.declared >> c & 1u) << numbers[static_cast<std::size_t>(c)];
    set.declared = declared;
    if (set.maskChannel >= 0)
        set.maskChannel = numbers[static_cast<std::size_t>(set.maskChannel)];
    for (ComparedSet::Mip& mip : set.mips) {
        std::vector<float> planes[kChannels];
        for (std::size_t c = 0; c < kChannels; ++c)
            planes[numbers[c]] = std::move(mip.planes[c]);
        std::move(std::begin(planes), std::end(planes), std::begin(mip.planes));
    }
}

} // namespace

ComparedPairs PairChannels(const ComparedSet& a, ComparedSet& b) {
    ComparedPairs pairs;
    Partners partners;
    partners.fill(-1);
    std::uint32_t comparedB = 0;
    const auto pair = [&](int channelA, int channelB) {
        int& partner = partners[static_cast<std::size_t>(channelA)];
        if (partner >= 0 || (comparedB >> channelB & 1u) != 0) // textures of a hostile file may overlap
            return;
        partner = channelB;
        pairs.channels |= 1u << channelA;
        comparedB |= 1u << channelB;
    };
    const std::vector<std::optional<std::size_t>> matches = MatchTextures(a, b);
    for (std::size_t i = 0; i < matches.size(); ++i) {
        if (!matches[i])
            continue;
        const ComparedTexture &first = a.textures[i], &second = b.textures[*matches[i]];
        const int channels = std::min(first.channels, second.channels);
        for (int c = 0; c < channels; ++c)
            pair(first.firstChannel + c, second.firstChannel + c);
        pairs.textures.push_back({first.name, first.fileName, first.firstChannel, channels});
    }
    pairs.isByName = pairs.channels != 0;
    if (!pairs.isByName) {
        for (int c = 0; c < kChannels; ++c) {
            if ((a.declared & b.declared & 1u << c) != 0)
                pair(c, c);
        }
        pairs.textures = b.textures;
    }
    std::erase_if(pairs.textures, [&](const ComparedTexture& texture) {
        return (((1u << texture.channels) - 1u) << texture.firstChannel & pairs.channels) == 0;
    });
    pairs.onlyInA = ListLeftOut(a, pairs.channels, pairs.isByName);
    pairs.onlyInB = ListLeftOut(b, comparedB, pairs.isByName);
    MoveChannels(b, partners);
    return pairs;
}

} // namespace openntc::tool
