// SPDX-License-Identifier: MIT
#include "Protocol.h"

#include "../Output.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <limits>

namespace openntc::conformance {

std::optional<DecodeMath> FindMath(std::string_view name) {
    for (int math = static_cast<int>(DecodeMath::Int8); math <= static_cast<int>(DecodeMath::FP32); ++math) {
        if (name == tool::GetName(static_cast<DecodeMath>(math)))
            return static_cast<DecodeMath>(math);
    }
    return std::nullopt;
}

std::string_view TakeWord(std::string_view& line) {
    const std::size_t start = std::min(line.find_first_not_of(' '), line.size());
    const std::size_t end = std::min(line.find(' ', start), line.size());
    const std::string_view word = line.substr(start, end - start);
    line.remove_prefix(end);
    return word;
}

std::optional<int> ParseNumber(std::string_view word) {
    int value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size())
        return std::nullopt;
    return value;
}

std::string FormatOutputs(const Outputs& outputs) {
    std::string line;
    for (const float value : outputs)
        line += tool::Format(line.empty() ? "%08x" : " %08x", std::bit_cast<std::uint32_t>(value));
    return line;
}

std::optional<Outputs> ParseOutputs(std::string_view line) {
    Outputs outputs{};
    for (float& value : outputs) {
        const std::string_view word = TakeWord(line);
        std::uint32_t bits = 0;
        const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), bits, 16);
        if (word.size() != 8 || error != std::errc() || end != word.data() + word.size())
            return std::nullopt;
        value = std::bit_cast<float>(bits);
    }
    if (!TakeWord(line).empty())
        return std::nullopt;
    return outputs;
}

std::string FormatBytes(std::span<const std::byte> bytes) {
    constexpr char kDigits[] = "0123456789abcdef";
    std::string text;
    for (const std::byte byte : bytes) {
        text += kDigits[std::to_integer<unsigned>(byte) >> 4];
        text += kDigits[std::to_integer<unsigned>(byte) & 15];
    }
    return text;
}

bool ParseBytes(std::string_view word, std::size_t count, std::vector<std::byte>& bytes) {
    if (word.size() != 2 * count)
        return false;
    for (std::size_t i = 0; i < word.size(); i += 2) {
        unsigned value = 0;
        const auto [end, error] = std::from_chars(word.data() + i, word.data() + i + 2, value, 16);
        if (error != std::errc() || end != word.data() + i + 2)
            return false;
        bytes.push_back(static_cast<std::byte>(value));
    }
    return true;
}

namespace {

std::optional<float> ParseFloat(std::string_view word) {
    std::uint32_t bits = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), bits, 16);
    if (word.size() != 8 || error != std::errc() || end != word.data() + word.size())
        return std::nullopt;
    return std::bit_cast<float>(bits);
}

std::string FormatWord(float value) {
    return tool::Format("%08x", std::bit_cast<std::uint32_t>(value));
}

} // namespace

std::string FormatFilterRequest(const FilterRequest& request, std::span<const FilterLookup> lookups) {
    std::string text = tool::Format(
        "filter %s %s %s %s %s %s %d %d %d %d %d %d %zu\n", GetFilterWayWord(request.way),
        GetKernelWord(request.kernel), GetMipsWord(request.mips), GetWrapWord(request.wrapX),
        GetWrapWord(request.wrapY), FormatWord(request.sigma).c_str(), request.radius, request.maxAnisotropy,
        request.lodBias, request.width, request.height, request.levels, lookups.size());
    for (const FilterLookup& lookup : lookups) {
        for (const std::array<float, 2>* pair : {&lookup.uv, &lookup.ddx, &lookup.ddy}) {
            for (const float number : *pair)
                text += FormatWord(number) + " ";
        }
        text += tool::Format("%u %u %u %u\n", lookup.random[0], lookup.random[1], lookup.random[2],
                             lookup.random[3]);
    }
    return text;
}

std::optional<FilterRequest> ParseFilterRequest(std::string_view line, int& count) {
    FilterRequest request;
    const int way = FindFilterWay(TakeWord(line));
    request.way = static_cast<FilterWay>(way < 0 ? 0 : way);
    request.kernel = FindKernel(TakeWord(line));
    request.mips = FindMips(TakeWord(line));
    request.wrapX = FindWrap(TakeWord(line));
    request.wrapY = FindWrap(TakeWord(line));
    request.sigma = ParseFloat(TakeWord(line)).value_or(0.0f);
    for (int* number : {&request.radius, &request.maxAnisotropy, &request.lodBias, &request.width,
                        &request.height, &request.levels})
        *number = ParseNumber(TakeWord(line)).value_or(std::numeric_limits<int>::min());
    count = ParseNumber(TakeWord(line)).value_or(0);
    return way >= 0 && request.IsValid() ? std::optional(request) : std::nullopt;
}

std::optional<FilterLookup> ParseLookup(std::string_view line) {
    FilterLookup lookup;
    bool isGood = true;
    for (std::array<float, 2>* pair : {&lookup.uv, &lookup.ddx, &lookup.ddy}) {
        for (float& number : *pair) {
            const std::optional<float> parsed = ParseFloat(TakeWord(line));
            isGood = isGood && parsed;
            number = parsed.value_or(0.0f);
        }
    }
    for (std::uint32_t& number : lookup.random) {
        const int parsed = ParseNumber(TakeWord(line)).value_or(-1);
        isGood = isGood && parsed >= 0 && parsed <= 65535;
        number = static_cast<std::uint32_t>(parsed) & 0xFFFFu;
    }
    return isGood ? std::optional(lookup) : std::nullopt;
}

std::string FormatTaps(std::span<const FilterTap> taps) {
    std::string text;
    for (const FilterTap& tap : taps)
        text += tool::Format("%s%d %d %d %s %d", text.empty() ? "" : " ", tap.x, tap.y, tap.mip,
                             FormatWord(tap.scale).c_str(), tap.isBorder ? 1 : 0);
    return text;
}

bool ParseTaps(std::string_view line, std::vector<FilterTap>& taps) {
    while (line.find_first_not_of(' ') != std::string_view::npos) {
        FilterTap tap;
        bool isGood = true;
        for (int* number : {&tap.x, &tap.y, &tap.mip}) {
            const std::optional<int> parsed = ParseNumber(TakeWord(line));
            isGood = isGood && parsed;
            *number = parsed.value_or(0);
        }
        const std::optional<float> scale = ParseFloat(TakeWord(line));
        const std::string_view border = TakeWord(line);
        if (!isGood || !scale || (border != "0" && border != "1"))
            return false;
        tap.scale = *scale;
        tap.isBorder = border == "1";
        if (tap.isBorder)
            tap.x = tap.y = -1;
        taps.push_back(tap);
    }
    return true;
}

std::string FormatCapabilities(const Capabilities& capabilities) {
    std::string text;
    for (std::size_t math = 1; math < capabilities.math.size(); ++math) {
        if (capabilities.math[math])
            text += std::string(",") + tool::GetName(static_cast<DecodeMath>(math));
    }
    text += capabilities.linear ? ",linear" : "";
    text += capabilities.wholeMips ? ",mip" : "";
    text += capabilities.slices ? ",slice" : "";
    text += capabilities.sliceMips ? ",slice_mips" : "";
    text += capabilities.outside ? ",outside" : "";
    text += capabilities.blocks ? ",blocks" : "";
    text += capabilities.textures ? ",textures" : "";
    text += capabilities.filtering ? ",filtering" : "";
    return text.empty() ? "none" : text.substr(1);
}

Capabilities ParseCapabilities(std::string_view text) {
    Capabilities capabilities;
    while (!text.empty()) {
        const std::size_t end = std::min(text.find(','), text.size());
        const std::string_view word = text.substr(0, end);
        text.remove_prefix(std::min(end + 1, text.size()));
        if (const std::optional<DecodeMath> math = FindMath(word))
            capabilities.math[static_cast<std::size_t>(*math)] = true;
        capabilities.linear = capabilities.linear || word == "linear";
        capabilities.wholeMips = capabilities.wholeMips || word == "mip";
        capabilities.slices = capabilities.slices || word == "slice";
        capabilities.sliceMips = capabilities.sliceMips || word == "slice_mips";
        capabilities.outside = capabilities.outside || word == "outside";
        capabilities.blocks = capabilities.blocks || word == "blocks";
        capabilities.textures = capabilities.textures || word == "textures";
        capabilities.filtering = capabilities.filtering || word == "filtering";
    }
    return capabilities;
}

} // namespace openntc::conformance
