// SPDX-License-Identifier: MIT
// Stability: internal
// Events of RapidJSON's parser to Document, driven by the tables of Schema.h.
#pragma once

#include "openntc/container/JsonNumber.h"
#include "openntc/container/JsonPath.h"
#include "openntc/container/RapidJson.h"
#include "openntc/container/Schema.h"
#include "openntc/container/Utf8.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string_view>

#include "openntc/core/HideMacros.h"

namespace openntc::container {
namespace detail {

constexpr char ToLower(char c) noexcept {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c + ('a' - 'A')) : c;
}

constexpr bool EqualsIgnoringCase(std::string_view a, std::string_view b) noexcept {
    if (a.size() != b.size())
        return false;
    for (std::size_t i = 0; i < a.size(); ++i) {
        if (ToLower(a[i]) != ToLower(b[i]))
            return false;
    }
    return true;
}

/// The schemaVersion at the root of a JSON text, wherever it stands there, because which keys are known
/// depends on it; of several the last one, as the parser does it. Nothing for what is no JSON, and for a
/// number that is no u32.
inline std::optional<std::uint32_t> FindSchemaVersion(std::string_view text) noexcept {
    constexpr std::string_view kKey = "\"schemaVersion\"";
    const std::size_t last = text.rfind(kKey);
    if (last == std::string_view::npos)
        return std::nullopt;
    const auto skipSpace = [text](std::size_t at) {
        return std::min(text.find_first_not_of(" \t\r\n", at), text.size());
    };
    std::optional<std::uint32_t> found;
    std::size_t depth = 0;
    for (std::size_t i = 0; i <= last; ++i) {
        if (text[i] == '{' || text[i] == '[')
            ++depth;
        else if ((text[i] == '}' || text[i] == ']') && depth > 0)
            --depth;
        if (text[i] != '"')
            continue;
        const std::size_t begin = i;
        for (++i; i < text.size() && text[i] != '"'; ++i)
            i += text[i] == '\\' ? 1u : 0u;
        const std::size_t colon = skipSpace(std::min(i + 1, text.size()));
        if (depth != 1 || text.substr(begin, kKey.size()) != kKey || text.substr(colon, 1) != ":")
            continue;
        const std::size_t number = skipSpace(colon + 1);
        const std::size_t end = text.find_first_of(" \t\r\n,}", number);
        std::uint64_t version = 0;
        if (ParseInteger(text.substr(number, end - number), std::numeric_limits<std::uint32_t>::max(),
                         version))
            found = static_cast<std::uint32_t>(version);
    }
    return found;
}

/// Receives RapidJSON's events for a file of a generation; other generations' keys are unknown ones. After
/// the first error it only follows the nesting. Where a text names no schemaVersion, what its objects must
/// have is not known: the version is what is absent then.
class DocumentHandler : public rapidjson::BaseReaderHandler<rapidjson::UTF8<>, DocumentHandler> {
public:
    DocumentHandler(Document& document, std::uint32_t generation, bool isVersionNamed,
                    Allocator& allocator) noexcept
        : document_(&document), allocator_(&allocator), generation_(generation),
          isVersionNamed_(isVersionNamed) {}

    bool Null() noexcept { return Mismatch("null"); }
    bool Bool(bool value) noexcept { return Mismatch(value ? "true" : "false"); }

    bool RawNumber(const char* text, rapidjson::SizeType length, bool) noexcept {
        const std::string_view number(text, length);
        if (IsSkipping())
            return true;
        if (!IsScalarExpected())
            return Mismatch(number);
        Frame& frame = Top();
        Scalar value;
        switch (frame.field->kind) {
        case FieldKind::U32Array:
            if (frame.field->count(frame.object) >= frame.field->maxCount)
                return RefuseCount();
            [[fallthrough]];
        case FieldKind::U32:
            if (!ParseInteger(number, std::numeric_limits<std::uint32_t>::max(), value.integer))
                return Refuse(number, "must be an integer from 0 to 4294967295");
            break;
        case FieldKind::U64:
            if (!ParseInteger(number, std::numeric_limits<std::uint64_t>::max(), value.integer))
                return Refuse(number, "must be an integer from 0 to 18446744073709551615");
            break;
        case FieldKind::F32:
            if (!ParseReal(number, value.real))
                return Refuse(number, "must be a number that a 32-bit float can hold");
            break;
        case FieldKind::Enum:
        case FieldKind::Text:
        case FieldKind::Object:
        case FieldKind::ObjectArray:
            return Mismatch(number);
        }
        if (frame.field->kind != FieldKind::U32Array) {
            frame.field->store(frame.object, value);
            return true;
        }
        const Expected<void*> element = frame.field->add(frame.object, *allocator_);
        if (!element)
            return Stop(element.error());
        *static_cast<std::uint32_t*>(*element) = static_cast<std::uint32_t>(value.integer);
        return true;
    }

    bool String(const char* text, rapidjson::SizeType length, bool) noexcept {
        if (IsSkipping())
            return true;
        const std::string_view string(text, length);
        if (!IsScalarExpected())
            return Mismatch(string);
        Frame& frame = Top();
        if (frame.field->kind == FieldKind::Text) {
            if (!IsValidUtf8(string)) // RapidJSON lets the escape of a low surrogate alone pass
                return Refuse("an escape", "must not be half of a surrogate pair");
            const Expected<void*> member = frame.field->add(frame.object, *allocator_);
            if (!member)
                return Stop(member.error());
            if (const Expected<void> assigned = static_cast<Text*>(*member)->Assign(string); !assigned)
                return Stop(assigned.error());
            return true;
        }
        if (frame.field->kind != FieldKind::Enum)
            return Mismatch(string);
        for (std::size_t i = 0; i < frame.field->names.size(); ++i) {
            if (EqualsIgnoringCase(string, frame.field->names[i])) {
                frame.field->store(frame.object, Scalar{i, 0.0f});
                return true;
            }
        }
        return Refuse(string, "is not one of the known names");
    }

    bool Key(const char* text, rapidjson::SizeType length, bool) noexcept {
        const std::string_view key(text, length);
        if (error_ || skipDepth_ > 0)
            return true;
        Frame& frame = Top();
        const std::span<const Field> fields = frame.type->fields;
        frame.field = nullptr;
        // Writers keep the order of the table, so that the field after the last one is the likely one.
        std::size_t index = frame.next;
        for (std::size_t tries = 0; tries < fields.size(); ++tries, ++index) {
            if (index >= fields.size())
                index = 0;
            if (fields[index].key != key || !fields[index].IsIn(generation_))
                continue;
            const std::uint32_t bit = 1u << index;
            frame.field = &fields[index];
            frame.isRepeated = (frame.seen & bit) != 0;
            frame.seen |= bit;
            frame.next = index + 1;
            break;
        }
        return true;
    }

    bool StartObject() noexcept {
        if (!Enter())
            return false;
        if (IsSkipping())
            return SkipStart();
        if (frameCount_ == 0) {
            Push(kObjectType<Document>, document_);
            return true;
        }
        Frame& frame = Top();
        const bool isArray = frame.field->kind == FieldKind::ObjectArray;
        if (!isArray && frame.field->kind != FieldKind::Object)
            return Mismatch("an object") && SkipStart();
        if (!frame.isInArray && frame.isRepeated)
            return Refuse("again", "an object or array may be given once") && SkipStart();
        if (isArray && frame.field->count(frame.object) >= frame.field->maxCount)
            return RefuseCount() && SkipStart();
        const Expected<void*> object = frame.field->add(frame.object, *allocator_);
        if (!object)
            return Stop(object.error());
        Push(*frame.field->type, *object);
        return true;
    }

    bool EndObject(rapidjson::SizeType) noexcept {
        --depth_;
        if (error_ || SkipEnd())
            return true;
        const Frame& frame = Top();
        const std::span<const Field> fields = frame.type->fields;
        const std::uint32_t absent = frame.type->required[generation_] & ~frame.seen;
        if (absent == 0) {
            --frameCount_;
            return true;
        }
        if (!isVersionNamed_) {
            error_ = MakeError(Status::FileUnrecognized, "schemaVersion: absent: is required");
            return true;
        }
        Top().field = &fields[static_cast<std::size_t>(std::countr_zero(absent))];
        return Refuse("absent", "is required");
    }

    bool StartArray() noexcept {
        if (!Enter())
            return false;
        if (IsSkipping())
            return SkipStart();
        if (frameCount_ == 0 || Top().isInArray || !IsArray(Top().field->kind))
            return Mismatch("an array") && SkipStart();
        if (Top().isRepeated)
            return Refuse("again", "an object or array may be given once") && SkipStart();
        Top().isInArray = true;
        return true;
    }

    bool EndArray(rapidjson::SizeType) noexcept {
        --depth_;
        if (error_ || SkipEnd())
            return true;
        Top().isInArray = false;
        return true;
    }

    /// Any other event, of which this configuration of the parser has none.
    bool Default() noexcept { return Mismatch("?"); }

    /// What went wrong, if anything did; `parsed` is RapidJSON's own verdict.
    Expected<void> Finish(const rapidjson::ParseResult& parsed) const noexcept {
        if (error_)
            return Unexpected(*error_);
        if (parsed.IsError())
            return Fail(Status::FileUnrecognized, "JSON: byte %zu: %s", parsed.Offset(),
                        rapidjson::GetParseError_En(parsed.Code()));
        return {};
    }

private:
    struct Frame {
        const ObjectType* type = nullptr;
        void* object = nullptr;
        const Field* field = nullptr; ///< of the last key; null if the key is unknown
        std::uint32_t seen = 0;       ///< a bit per field
        std::size_t next = 0;
        bool isRepeated = false;
        bool isInArray = false;
    };

    Frame& Top() noexcept { return frames_[frameCount_ - 1]; }

    void Push(const ObjectType& type, void* object) noexcept {
        frames_[frameCount_] = Frame{};
        frames_[frameCount_].type = &type;
        frames_[frameCount_].object = object;
        ++frameCount_;
    }

    /// True inside what nobody asked for: the value of an unknown key, or everything after an error.
    bool IsSkipping() noexcept {
        return error_ || skipDepth_ > 0 || (frameCount_ > 0 && Top().field == nullptr);
    }
    bool SkipStart() noexcept {
        ++skipDepth_;
        return true;
    }
    bool SkipEnd() noexcept {
        if (skipDepth_ == 0)
            return false;
        --skipDepth_;
        return true;
    }

    bool IsScalarExpected() noexcept {
        return frameCount_ > 0 && Top().isInArray == (Top().field->kind == FieldKind::U32Array);
    }

    bool Enter() noexcept {
        if (depth_ == kMaxJsonDepth) {
            if (!error_)
                error_ =
                    MakeError(Status::FileUnrecognized, "JSON: nesting: at most %zu levels", kMaxJsonDepth);
            return false;
        }
        ++depth_;
        return true;
    }

    bool Stop(const Error& error) noexcept {
        error_ = error;
        return false;
    }

    bool Mismatch(std::string_view value) noexcept {
        if (IsSkipping())
            return true;
        if (frameCount_ == 0)
            return Refuse(value, "must be an object");
        switch (Top().field->kind) {
        case FieldKind::U32:
        case FieldKind::U64:
            return Refuse(value, "must be an integer");
        case FieldKind::F32:
            return Refuse(value, "must be a number");
        case FieldKind::Enum:
        case FieldKind::Text:
            return Refuse(value, "must be a string");
        case FieldKind::Object:
            return Refuse(value, "must be an object");
        case FieldKind::ObjectArray:
            return Refuse(value, "must be an array of objects");
        case FieldKind::U32Array:
            return Refuse(value, Top().isInArray ? "must be an integer" : "must be an array of integers");
        }
        return Refuse(value, "is not allowed");
    }

    bool RefuseCount() noexcept {
        error_ = MakeError(Status::FileUnrecognized, "%s: too many elements: at most %zu",
                           MakePath(false).GetText(), Top().field->maxCount);
        return true;
    }

    /// Records the error and lets the parser go on.
    bool Refuse(std::string_view value, const char* limit) noexcept {
        constexpr std::size_t kShown = 40;
        char shown[kShown + 1] = "\"\""; // what an empty string looks like
        for (std::size_t i = 0; i < value.size() && i < kShown; ++i) {
            shown[i] = value[i] == '\0' ? '?' : value[i]; // the escape \u0000 would end the message
            shown[i + 1] = '\0';
        }
        error_ = MakeError(Status::FileUnrecognized, "%s: %s%s: %s", MakePath(true).GetText(), shown,
                           value.size() > kShown ? "..." : "", limit);
        return true;
    }

    JsonPath MakePath(bool withLastIndex) noexcept {
        JsonPath path;
        if (frameCount_ == 0)
            path.AddKey("JSON");
        for (std::size_t i = 0; i < frameCount_; ++i) {
            const Frame& frame = frames_[i];
            path.AddKey(frame.field->key);
            if (!IsArray(frame.field->kind))
                continue;
            const std::size_t count = frame.field->count(frame.object);
            if (i + 1 < frameCount_)
                path.AddIndex(count - 1);
            else if (withLastIndex && frame.isInArray)
                path.AddIndex(count);
        }
        return path;
    }

    Document* document_;
    Allocator* allocator_;
    std::uint32_t generation_;
    bool isVersionNamed_;
    Frame frames_[kMaxObjectNesting];
    std::size_t frameCount_ = 0;
    std::size_t depth_ = 0;
    std::size_t skipDepth_ = 0;
    std::optional<Error> error_;
};

} // namespace detail
} // namespace openntc::container

#include "openntc/core/RestoreMacros.h"
