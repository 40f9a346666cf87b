// SPDX-License-Identifier: MIT
#include "Json.h"

#include "Output.h"

#include <cmath>

namespace openntc::tool {

namespace {

// Length of the well-formed UTF-8 sequence at the start of `text` (Unicode standard, table 3-7), or 0.
std::size_t GetSequenceLength(std::string_view text) {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
    const auto isContinuation = [&](std::size_t i, unsigned low, unsigned high) {
        return i < text.size() && byte(i) >= low && byte(i) <= high;
    };
    const unsigned first = byte(0);
    if (first < 0x80)
        return 1;
    if (first >= 0xC2 && first <= 0xDF)
        return isContinuation(1, 0x80, 0xBF) ? 2 : 0;
    if (first >= 0xE0 && first <= 0xEF) {
        const unsigned low = first == 0xE0 ? 0xA0 : 0x80;  // no overlong forms
        const unsigned high = first == 0xED ? 0x9F : 0xBF; // no surrogates
        return isContinuation(1, low, high) && isContinuation(2, 0x80, 0xBF) ? 3 : 0;
    }
    if (first >= 0xF0 && first <= 0xF4) {
        const unsigned low = first == 0xF0 ? 0x90 : 0x80;
        const unsigned high = first == 0xF4 ? 0x8F : 0xBF;
        return isContinuation(1, low, high) && isContinuation(2, 0x80, 0xBF) && isContinuation(3, 0x80, 0xBF)
                   ? 4
                   : 0;
    }
    return 0;
}

} // namespace

std::string MakeValidUtf8(std::string_view text) {
    std::string result;
    while (!text.empty()) {
        const std::size_t length = GetSequenceLength(text);
        if (length == 0)
            result += "\xEF\xBF\xBD";
        else
            result += text.substr(0, length);
        text.remove_prefix(length == 0 ? 1 : length);
    }
    return result;
}

void JsonWriter::Value(std::string_view text) {
    const std::string valid = MakeValidUtf8(text);
    writer_.String(valid.data(), static_cast<rapidjson::SizeType>(valid.size()));
}

void JsonWriter::Value(double value) {
    if (std::isfinite(value))
        writer_.Double(value);
    else
        Value(std::string_view(std::isnan(value) ? "nan" : value < 0 ? "-inf" : "inf"));
}

void JsonWriter::Value(float value) {
    const std::string text = FormatFloat(value);
    if (std::isfinite(value))
        writer_.RawValue(text.data(), text.size(), rapidjson::kNumberType);
    else
        Value(std::string_view(text));
}

std::string ToHex(std::span<const std::byte> bytes) {
    static constexpr char kDigits[] = "0123456789abcdef";
    std::string text;
    text.reserve(bytes.size() * 2);
    for (const std::byte b : bytes) {
        text += kDigits[static_cast<unsigned>(b) >> 4];
        text += kDigits[static_cast<unsigned>(b) & 15u];
    }
    return text;
}

void WriteLatentShape(JsonWriter& json, const LatentShape& shape) {
    json.Key("latentShape");
    json.BeginObject();
    json.Member("gridSizeScale", shape.gridSizeScale);
    json.Member("highResFeatures", shape.highResFeatures);
    json.Member("lowResFeatures", shape.lowResFeatures);
    json.Member("highResQuantBits", shape.highResQuantBits);
    json.Member("lowResQuantBits", shape.lowResQuantBits);
    json.EndObject();
}

} // namespace openntc::tool
