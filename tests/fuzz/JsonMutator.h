// SPDX-License-Identifier: MIT
// Grammar-aware mutations of a JSON text: the text is indexed once, and each mutation is a few edits of its
// spans.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace openntc::fuzz {

/// xorshift64*: the same sequence everywhere.
class Random {
public:
    explicit Random(std::uint64_t seed) : state_(seed * 0x9E3779B97F4A7C15u + 1) {}
    std::size_t Below(std::size_t limit) {
        state_ ^= state_ >> 12;
        state_ ^= state_ << 25;
        state_ ^= state_ >> 27;
        return static_cast<std::size_t>((state_ * 0x2545F4914F6CDD1Du) >> 33) % limit;
    }

private:
    std::uint64_t state_;
};

class JsonMutator {
public:
    /// `text` must be valid JSON without whitespace.
    explicit JsonMutator(std::string text) : text_(std::move(text)) { Index(); }

    std::string Mutate(Random& random) const {
        std::vector<Edit> edits;
        const std::size_t count = random.Below(4) == 0 ? 1 + random.Below(4) : 1;
        for (std::size_t i = 0; i < count; ++i)
            AddEdit(random, edits);
        std::string result = Apply(edits);
        if (random.Below(16) == 0) {
            for (std::size_t i = 1 + random.Below(3); i > 0 && !result.empty(); --i)
                result[random.Below(result.size())] = static_cast<char>(random.Below(256));
        }
        if (random.Below(64) == 0)
            result.resize(random.Below(result.size() + 1));
        return result;
    }

private:
    struct Value {
        std::size_t keyBegin; ///< of the member, at its quote; the value's begin for elements
        std::size_t begin;
        std::size_t end;
    };
    struct Edit {
        std::size_t begin;
        std::size_t end;
        std::string text;
    };

    void Index() {
        std::vector<std::size_t> open;
        std::size_t key = kNone;
        const auto begin = [&](std::size_t at) {
            values_.push_back({key == kNone ? at : key, at, at});
            key = kNone;
            return values_.size() - 1;
        };
        for (std::size_t i = 0; i < text_.size();) {
            const char c = text_[i];
            if (c == '{' || c == '[') {
                open.push_back(begin(i));
                ++i;
            } else if (c == '}' || c == ']') {
                values_[open.back()].end = ++i;
                open.pop_back();
            } else if (c == ',' || c == ':') {
                ++i;
            } else {
                std::size_t end = i + 1;
                if (c == '"') {
                    while (text_[end] != '"')
                        end += text_[end] == '\\' ? 2 : 1;
                    ++end;
                } else {
                    end = text_.find_first_of(",]}", i);
                }
                if (end < text_.size() && text_[end] == ':')
                    key = i;
                else
                    values_[begin(i)].end = end;
                i = end;
            }
        }
    }

    void AddEdit(Random& random, std::vector<Edit>& edits) const {
        const Value& value = values_[random.Below(values_.size())];
        const Value& other = values_[random.Below(values_.size())];
        const std::string_view text(text_);
        const std::string_view self = text.substr(value.begin, value.end - value.begin);
        const std::string_view member = text.substr(value.keyBegin, value.end - value.keyBegin);
        const bool isNumber = self[0] == '-' || (self[0] >= '0' && self[0] <= '9');
        switch (random.Below(14)) {
        case 0:
        case 1:
        case 2: // another number, or another string, of the same kind as far as possible
        case 3:
            if (isNumber)
                edits.push_back(
                    {value.begin, value.end, std::string(kNumbers[random.Below(std::size(kNumbers))])});
            else if (self[0] == '"')
                edits.push_back(
                    {value.begin, value.end, std::string(kStrings[random.Below(std::size(kStrings))])});
            else
                edits.push_back(
                    {value.begin, value.end, std::string(kOthers[random.Below(std::size(kOthers))])});
            break;
        case 4: // a number near this one
            if (isNumber && self.size() < 10 &&
                self.find_first_not_of("0123456789") == std::string_view::npos) {
                const long number = std::stol(std::string(self)) + static_cast<long>(random.Below(9)) - 4;
                edits.push_back({value.begin, value.end, std::to_string(number)});
            }
            break;
        case 5: // another type
            edits.push_back({value.begin, value.end, std::string(kOthers[random.Below(std::size(kOthers))])});
            break;
        case 6: // delete the member or element, with one comma if there is one
        {
            std::size_t end = value.end;
            std::size_t begin = value.keyBegin;
            if (end < text.size() && text[end] == ',')
                ++end;
            else if (begin > 0 && text[begin - 1] == ',')
                --begin;
            edits.push_back({begin, end, ""});
            break;
        }
        case 7: // repeat it
        {
            std::string repeated;
            for (std::size_t i = random.Below(32) == 0 ? 300 : 1 + random.Below(18); i > 0; --i)
                repeated.append(",").append(member);
            edits.push_back({value.end, value.end, std::move(repeated)});
            break;
        }
        case 8: // another value over this one
            edits.push_back(
                {value.begin, value.end, std::string(text.substr(other.begin, other.end - other.begin))});
            break;
        case 9: // swap two values, or members
            if (random.Below(2) == 0) {
                edits.push_back(
                    {value.begin, value.end, std::string(text.substr(other.begin, other.end - other.begin))});
                edits.push_back({other.begin, other.end, std::string(self)});
            } else {
                edits.push_back({value.keyBegin, value.end,
                                 std::string(text.substr(other.keyBegin, other.end - other.keyBegin))});
                edits.push_back({other.keyBegin, other.end, std::string(member)});
            }
            break;
        case 10: // another key
            if (value.keyBegin != value.begin)
                edits.push_back({value.keyBegin, value.begin - 1,
                                 std::string(kStrings[random.Below(std::size(kStrings))])});
            break;
        case 11: // one more member, known or not
        {
            std::string added(",");
            added.append(kStrings[random.Below(std::size(kStrings))]).append(":");
            added.append(kOthers[random.Below(std::size(kOthers))]);
            edits.push_back({value.end, value.end, std::move(added)});
            break;
        }
        case 12: // nest it
        {
            const std::size_t levels = 1 + random.Below(random.Below(4) == 0 ? 100 : 3);
            std::string nested(levels, '[');
            nested.append(self).append(levels, ']');
            edits.push_back({value.begin, value.end, std::move(nested)});
            break;
        }
        default: // a bare object for an array, an array for an object
            if (self.size() > 2 && self[0] == '[')
                edits.push_back({value.begin, value.end, std::string(self.substr(1, self.size() - 2))});
            else
                edits.push_back({value.begin, value.end, std::string("[").append(self).append("]")});
            break;
        }
    }

    /// Edits that overlap an earlier one are dropped.
    std::string Apply(std::vector<Edit>& edits) const {
        std::stable_sort(edits.begin(), edits.end(),
                         [](const Edit& a, const Edit& b) { return a.begin < b.begin; });
        std::string result;
        std::size_t at = 0;
        for (const Edit& edit : edits) {
            if (edit.begin < at)
                continue;
            result.append(text_, at, edit.begin - at).append(edit.text);
            at = edit.end;
        }
        return result.append(text_, at);
    }

    static constexpr std::size_t kNone = static_cast<std::size_t>(-1);
    static constexpr std::string_view kNumbers[] = {"0",
                                                    "1",
                                                    "2",
                                                    "3",
                                                    "4",
                                                    "5",
                                                    "7",
                                                    "8",
                                                    "12",
                                                    "15",
                                                    "16",
                                                    "17",
                                                    "31",
                                                    "32",
                                                    "63",
                                                    "64",
                                                    "65",
                                                    "80",
                                                    "96",
                                                    "127",
                                                    "128",
                                                    "254",
                                                    "255",
                                                    "256",
                                                    "257",
                                                    "1023",
                                                    "4096",
                                                    "32767",
                                                    "32768",
                                                    "65535",
                                                    "65536",
                                                    "1000000",
                                                    "2147483647",
                                                    "2147483648",
                                                    "4294967291",
                                                    "4294967292",
                                                    "4294967295",
                                                    "4294967296",
                                                    "9223372036854775807",
                                                    "9223372036854775808",
                                                    "18446744073709551608",
                                                    "18446744073709551612",
                                                    "18446744073709551615",
                                                    "18446744073709551616",
                                                    "-1",
                                                    "-0",
                                                    "-4",
                                                    "-2147483648",
                                                    "1.0",
                                                    "0.5",
                                                    "-0.0",
                                                    "1e0",
                                                    "1e5",
                                                    "1e38",
                                                    "3.5e38",
                                                    "1e308",
                                                    "1e309",
                                                    "1e-400",
                                                    "-1e-45",
                                                    "0.3333333432674408",
                                                    "123456789012345678901234567890",
                                                    "1e999999999"};
    static constexpr std::string_view kStrings[] = {R"("Int8")",
                                                    R"("Int32")",
                                                    R"("FloatE4M3")",
                                                    R"("FloatE5M2")",
                                                    R"("Float16")",
                                                    R"("Float32")",
                                                    R"("float32")",
                                                    R"("RowMajor")",
                                                    R"("ColumnMajor")",
                                                    R"("HGELUClamp")",
                                                    R"("sRGB")",
                                                    R"("HLG")",
                                                    R"("linear")",
                                                    R"("BC7")",
                                                    R"("UNORM16")",
                                                    R"("None")",
                                                    R"("GDeflate")",
                                                    R"("")",
                                                    R"("x")",
                                                    R"("\u0000")",
                                                    R"("\ud83d\ude00")",
                                                    R"("\ud800")",
                                                    R"("\udc00")",
                                                    R"("\q")",
                                                    R"("a\"b\\c\/\n")",
                                                    "\"\xC3\xA9\"",
                                                    "\"\xC3\"",
                                                    "\"\xED\xA0\x80\"",
                                                    "\"\x01\"",
                                                    "\"\xFF\xFE\"",
                                                    R"("schemaVersion")",
                                                    R"("width")",
                                                    R"("height")",
                                                    R"("numChannels")",
                                                    R"("numColorMips")",
                                                    R"("latentShape")",
                                                    R"("mlp")",
                                                    R"("mlpVersions")",
                                                    R"("layers")",
                                                    R"("textures")",
                                                    R"("channels")",
                                                    R"("latents")",
                                                    R"("colorMips")",
                                                    R"("views")",
                                                    R"("weightType")",
                                                    R"("scaleBiasType")",
                                                    R"("scaleType")",
                                                    R"("biasType")",
                                                    R"("scaleView")",
                                                    R"("offset")",
                                                    R"("storedSize")",
                                                    R"("highResView")",
                                                    R"("bcAccelerationDataView")",
                                                    R"("latentMip")",
                                                    R"("positionLod")",
                                                    R"("compression")",
                                                    R"("uncompressedSize")",
                                                    R"("crc32")",
                                                    R"("numFeatures")",
                                                    R"("arraySize")",
                                                    R"("layerViews")",
                                                    R"("bcModeBuffers")",
                                                    R"("name")"};
    static constexpr std::string_view kOthers[] = {
        "null",
        "true",
        "false",
        "{}",
        "[]",
        "[[]]",
        "[{}]",
        "[{},{}]",
        "0",
        "1",
        "-1",
        "1.5",
        R"("x")",
        "[1,2,3]",
        R"({"a":{"b":[{"c":null}]}})",
        R"({"layers":[{},{},{},{}]})",
        R"({"view":0})",
        R"([null])",
        R"({"inputChannels":64,"outputChannels":64,"weightView":0,"scaleView":1,"biasView":2})",
        R"([{"offset":0,"storedSize":4}])",
        R"([{"mipLevel":0,"view":0}])",
        R"("GDeflate")",
        R"({"numFeatures":8})",
        R"({"highResFeatures":4,"highResQuantBits":2,"lowResFeatures":8,"lowResQuantBits":4})"};

    std::string text_;
    std::vector<Value> values_;
};

} // namespace openntc::fuzz
