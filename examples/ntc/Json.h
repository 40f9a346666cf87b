// SPDX-License-Identifier: MIT
// The JSON that `--json` prints. Schemas of every output are in schemas/.
#pragma once

#include "openntc/texture_set/LatentShape.h"

#include <rapidjson/prettywriter.h>
#include <rapidjson/stringbuffer.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace openntc::tool {

/// A thin layer over RapidJSON's writer: text that came from a file or a command line is made valid UTF-8,
/// and numbers that JSON has no notation for become the strings "nan", "inf" and "-inf".
class JsonWriter {
public:
    /// `indent`: blanks before a member for each object or array round it.
    explicit JsonWriter(unsigned indent = 2) : writer_(buffer_) { writer_.SetIndent(' ', indent); }

    void BeginObject() { writer_.StartObject(); }
    void EndObject() { writer_.EndObject(); }
    void BeginArray() { writer_.StartArray(); }
    void EndArray() { writer_.EndArray(); }
    void Key(std::string_view key) { writer_.Key(key.data(), static_cast<rapidjson::SizeType>(key.size())); }

    void Value(std::string_view text);
    void Value(const char* text) { Value(std::string_view(text)); }
    void Value(bool value) { writer_.Bool(value); }
    void Value(int value) { writer_.Int(value); }
    void Value(std::uint32_t value) { writer_.Uint(value); }
    void Value(std::uint64_t value) { writer_.Uint64(value); }
    void Value(double value);
    void Value(float value); ///< nine digits, as FormatFloat
    void Null() { writer_.Null(); }

    template <typename T>
    void Member(std::string_view key, const T& value) {
        Key(key);
        Value(value);
    }

    /// The text so far, ending in a line feed.
    std::string Take() { return std::string(buffer_.GetString(), buffer_.GetSize()) + "\n"; }

    /// The same on one line: line feeds inside of texts are escaped, others are the layout's.
    std::string TakeLine() {
        std::string text(buffer_.GetString(), buffer_.GetSize());
        std::erase(text, '\n');
        return text + "\n";
    }

private:
    rapidjson::StringBuffer buffer_;
    rapidjson::PrettyWriter<rapidjson::StringBuffer> writer_;
};

/// `text` with every malformed UTF-8 sequence replaced by U+FFFD.
std::string MakeValidUtf8(std::string_view text);

/// Two lower-case digits a byte.
std::string ToHex(std::span<const std::byte> bytes);

/// The member "latentShape".
void WriteLatentShape(JsonWriter& json, const LatentShape& shape);

} // namespace openntc::tool
