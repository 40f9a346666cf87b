// SPDX-License-Identifier: MIT
// Stability: internal
// Document to JSON text: compact, keys in the order of the tables, optional fields only when set, empty
// arrays omitted, reals as the shortest decimal of the value widened to binary64. The same document gives the
// same bytes everywhere.
#pragma once

#include "openntc/container/DocumentChecks.h"
#include "openntc/container/Utf8.h"
#include "openntc/core/FloatBits.h"

#include <charconv>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "openntc/core/HideMacros.h"

namespace openntc::container {
namespace detail {

class JsonWriter {
public:
    JsonWriter(Array<char>& text, std::uint32_t generation) noexcept
        : text_(&text), generation_(generation) {}

    Expected<void> WriteObject(const ObjectType& type, const void* object, const PathStep* step) noexcept {
        OPENNTC_CHECK(Add("{"));
        bool first = true;
        for (const Field& field : type.fields) {
            Scalar value;
            const std::size_t count = field.count != nullptr ? field.count(object) : 1;
            if (count == 0 || !field.IsIn(generation_) ||
                (field.load != nullptr && !field.load(object, value)))
                continue;
            OPENNTC_CHECK(Add(first ? "\"" : ",\""));
            OPENNTC_CHECK(Add(field.key));
            OPENNTC_CHECK(Add(IsArray(field.kind) ? "\":[" : "\":"));
            first = false;
            for (std::size_t i = 0; i < count; ++i) {
                const PathStep next{step, &field, i};
                if (i > 0)
                    OPENNTC_CHECK(Add(","));
                if (field.kind == FieldKind::U32Array)
                    value.integer = *static_cast<const std::uint32_t*>(field.get(object, i));
                if (field.type != nullptr)
                    OPENNTC_CHECK(WriteObject(*field.type, field.get(object, i), &next));
                else if (field.kind == FieldKind::Text)
                    OPENNTC_CHECK(WriteString(static_cast<const Text*>(field.get(object, i))->View(), next));
                else
                    OPENNTC_CHECK(WriteScalar(value, next));
            }
            if (IsArray(field.kind))
                OPENNTC_CHECK(Add("]"));
        }
        return Add("}");
    }

private:
    Expected<void> Add(std::string_view part) noexcept {
        return text_->Append(std::span<const char>(part.data(), part.size()));
    }

    static Unexpected Refuse(const PathStep& step, const char* why) noexcept {
        JsonPath path;
        AddSteps(path, &step);
        return Fail(Status::InvalidArgument, "%s: %s", path.GetText(), why);
    }

    Expected<void> WriteScalar(const Scalar& value, const PathStep& step) noexcept {
        const Field& field = *step.field;
        if (field.kind == FieldKind::F32)
            return WriteReal(value.real, step);
        if (field.kind == FieldKind::Enum) {
            if (value.integer >= field.names.size())
                return Refuse(step, "not an enumerator: cannot be written");
            OPENNTC_CHECK(Add("\""));
            OPENNTC_CHECK(Add(field.names[static_cast<std::size_t>(value.integer)]));
            return Add("\"");
        }
        char digits[24];
        const std::to_chars_result end = std::to_chars(digits, digits + sizeof(digits), value.integer);
        return Add(std::string_view(digits, static_cast<std::size_t>(end.ptr - digits)));
    }

    /// Plain notation for 1e-6 <= |value| < 1e21, with at least one digit on both sides of the point, else
    /// d.ddde±x.
    Expected<void> WriteReal(float value, const PathStep& step) noexcept {
        if (!IsFinite(value))
            return Refuse(step, GetMagnitudeBits(value) > 0x7F800000u ? "nan: must be finite"
                                                                      : "infinite: must be finite");
        char scientific[40];                            // [-]d[.ddd]e±xx
#if defined(_LIBCPP_VERSION) && _LIBCPP_VERSION < 14000 // no to_chars of floating-point numbers
        const char* const written = FormatShortest(scientific, static_cast<double>(value));
#else
        const char* const written = std::to_chars(scientific, scientific + sizeof(scientific),
                                                  static_cast<double>(value), std::chars_format::scientific)
                                        .ptr;
#endif
        char digits[24];
        int count = 0;
        const char* at = scientific;
        if (*at == '-') {
            OPENNTC_CHECK(Add("-"));
            ++at;
        }
        for (; *at != 'e'; ++at) {
            if (*at >= '0' && *at <= '9')
                digits[count++] = *at;
        }
        int exponent = 0; // of the first digit
        std::from_chars(at + (at[1] == '+' ? 2 : 1), written, exponent);
        const auto part = [&](int from, int to) {
            return std::string_view(digits + from, static_cast<std::size_t>(to - from));
        };
        constexpr std::string_view kZeros = "00000000000000000000";
        if (exponent >= 0 && exponent < 21) {
            const int whole = exponent + 1;
            OPENNTC_CHECK(Add(part(0, count < whole ? count : whole)));
            if (count < whole)
                OPENNTC_CHECK(Add(kZeros.substr(0, static_cast<std::size_t>(whole - count))));
            OPENNTC_CHECK(Add("."));
            return Add(count > whole ? part(whole, count) : std::string_view("0"));
        }
        if (exponent < 0 && exponent >= -6) {
            OPENNTC_CHECK(Add("0."));
            OPENNTC_CHECK(Add(kZeros.substr(0, static_cast<std::size_t>(-exponent - 1))));
            return Add(part(0, count));
        }
        OPENNTC_CHECK(Add(part(0, 1)));
        if (count > 1) {
            OPENNTC_CHECK(Add("."));
            OPENNTC_CHECK(Add(part(1, count)));
        }
        OPENNTC_CHECK(Add("e"));
        const std::to_chars_result end = std::to_chars(scientific, scientific + sizeof(scientific), exponent);
        return Add(std::string_view(scientific, static_cast<std::size_t>(end.ptr - scientific)));
    }

    Expected<void> WriteString(std::string_view string, const PathStep& step) noexcept {
        if (!IsValidUtf8(string))
            return Refuse(step, "bytes that are not UTF-8: cannot be written");
        OPENNTC_CHECK(Add("\""));
        constexpr char kHex[] = "0123456789ABCDEF";
        constexpr std::string_view kShort = "\bb\tt\nn\ff\rr\"\"\\\\"; // character, letter of its escape
        std::size_t plain = 0;
        for (std::size_t i = 0; i < string.size(); ++i) {
            const auto c = static_cast<unsigned char>(string[i]);
            if (c >= 0x20 && c != '"' && c != '\\')
                continue;
            OPENNTC_CHECK(Add(string.substr(plain, i - plain)));
            plain = i + 1;
            char escape[] = {'\\', 'u', '0', '0', kHex[c >> 4], kHex[c & 15u]};
            std::size_t length = 6;
            for (std::size_t k = 0; k < kShort.size(); k += 2) {
                if (kShort[k] == string[i]) {
                    escape[1] = kShort[k + 1];
                    length = 2;
                }
            }
            OPENNTC_CHECK(Add(std::string_view(escape, length)));
        }
        OPENNTC_CHECK(Add(string.substr(plain)));
        return Add("\"");
    }

    Array<char>* text_;
    std::uint32_t generation_;
};

} // namespace detail

/// The JSON text of a document without the NUL that ends it in a file. Its layout is that of the LibNTC of
/// its generation; what that does not have is left out. Errors: InvalidArgument for a real that is not finite
/// or a name that is not UTF-8, OutOfRange for too many elements or a text that no reader accepts,
/// FileUnrecognized for a schemaVersion that is none, OutOfMemory.
inline Expected<Array<char>> FormatDocument(const Document& document,
                                            Allocator& allocator = GetDefaultAllocator()) noexcept {
    OPENNTC_CHECK(CheckSchemaVersion(document.schemaVersion));
    OPENNTC_CHECK(CheckElementCounts(document));
    Array<char> text(allocator);
    OPENNTC_CHECK(text.Reserve(4096));
    detail::JsonWriter writer(text, document.schemaVersion);
    OPENNTC_CHECK(writer.WriteObject(detail::kObjectType<Document>, &document, nullptr));
    if (text.size() + 1 > kMaxJsonBytes)
        return Fail(Status::OutOfRange, "JSON: %zu bytes: at most %llu", text.size() + 1,
                    static_cast<unsigned long long>(kMaxJsonBytes));
    return text;
}

} // namespace openntc::container

#include "openntc/core/RestoreMacros.h"
