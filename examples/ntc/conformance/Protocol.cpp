// SPDX-License-Identifier: MIT
#include "Protocol.h"

#include "../Output.h"

#include <algorithm>
#include <bit>
#include <charconv>

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
    }
    return capabilities;
}

} // namespace openntc::conformance
