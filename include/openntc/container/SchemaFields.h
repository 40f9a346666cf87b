// SPDX-License-Identifier: MIT
// Stability: experimental
// What the tables of Schema.h are made of: rows that say key, kind, member, generations, and whether the key
// must be there.
#pragma once

#include "openntc/container/Document.h"

#include <array>
#include <span>
#include <string_view>
#include <type_traits>

#include "openntc/core/HideMacros.h"

namespace openntc::container {

inline constexpr std::string_view kColorSpaceNames[] = {"Linear", "sRGB", "HLG"};
inline constexpr std::string_view kChannelFormatNames[] = {"UNKNOWN", "UNORM8",  "UNORM16",
                                                           "FLOAT16", "FLOAT32", "UINT32"};
inline constexpr std::string_view kBlockCompressedFormatNames[] = {"None", "BC1", "BC2", "BC3",
                                                                   "BC4",  "BC5", "BC6", "BC7"};
inline constexpr std::string_view kMlpDataTypeNames[] = {"Int8",      "Int32",   "FloatE4M3",
                                                         "FloatE5M2", "Float16", "Float32"};
inline constexpr std::string_view kMlpActivationNames[] = {"HGELUClamp"};
inline constexpr std::string_view kMatrixLayoutNames[] = {"RowMajor", "ColumnMajor"};
inline constexpr std::string_view kCompressionNames[] = {"None", "GDeflate"};

namespace detail {

/// The strings of an enumeration in the order of its values, which count from 0.
template <typename E>
inline constexpr std::span<const std::string_view> kNames{};
template <>
inline constexpr std::span<const std::string_view> kNames<ColorSpace>{kColorSpaceNames};
template <>
inline constexpr std::span<const std::string_view> kNames<ChannelFormat>{kChannelFormatNames};
template <>
inline constexpr std::span<const std::string_view> kNames<BlockCompressedFormat>{kBlockCompressedFormatNames};
template <>
inline constexpr std::span<const std::string_view> kNames<MlpDataType>{kMlpDataTypeNames};
template <>
inline constexpr std::span<const std::string_view> kNames<MlpActivation>{kMlpActivationNames};
template <>
inline constexpr std::span<const std::string_view> kNames<MatrixLayout>{kMatrixLayoutNames};
template <>
inline constexpr std::span<const std::string_view> kNames<Compression>{kCompressionNames};

} // namespace detail

/// The string that stands for an enumerator in JSON, for example "UNORM8"; "?" for a value that is not an
/// enumerator.
template <typename E>
constexpr std::string_view EnumToString(E value) noexcept {
    const auto index = static_cast<std::size_t>(value);
    return index < detail::kNames<E>.size() ? detail::kNames<E>[index] : std::string_view("?");
}

/// A record whose arrays and strings take their memory from `allocator`.
template <typename T>
T MakeRecord(Allocator& allocator) noexcept {
    T record{};
    if constexpr (std::is_same_v<T, Mlp>) {
        record.layers = Array<MlpLayer>(allocator);
    } else if constexpr (std::is_same_v<T, TextureRecord>) {
        record.name = Text(allocator);
        record.bcModeBuffers = Array<BcModeBufferRecord>(allocator);
    } else if constexpr (std::is_same_v<T, Document>) {
        record.mlpVersions = Array<Mlp>(allocator);
        record.textures = Array<TextureRecord>(allocator);
        record.channels = Array<ChannelRecord>(allocator);
        record.latents = Array<LatentImageRecord>(allocator);
        record.colorMips = Array<ColorMipRecord>(allocator);
        record.views = Array<BufferView>(allocator);
    }
    return record;
}

namespace detail {

enum class FieldKind : std::uint8_t { U32, U64, F32, Enum, Text, Object, ObjectArray, U32Array };

constexpr bool IsArray(FieldKind kind) noexcept {
    return kind == FieldKind::ObjectArray || kind == FieldKind::U32Array;
}

/// Generations of files that have a key, a bit each.
inline constexpr std::uint8_t kIn1 = 1;
inline constexpr std::uint8_t kIn2 = 2;
inline constexpr std::uint8_t kIn3 = 4;
inline constexpr std::uint8_t kInAll = kIn1 | kIn2 | kIn3;

/// The value of a field of kind U32, U64, Enum (`integer`) or F32 (`real`).
struct Scalar {
    std::uint64_t integer = 0;
    float real = 0.0f;
};

struct ObjectType;

/// One row. Function pointers, instantiated for the member, stand between the JSON code and the structs. A
/// key that generations treat differently has a row for each.
struct Field {
    std::string_view key;
    FieldKind kind = FieldKind::U32;
    std::uint8_t generations = kInAll;
    bool required = false;
    bool isViewIndex = false;
    std::size_t maxCount = 1;                  ///< arrays: longest one
    std::span<const std::string_view> names{}; ///< Enum: strings in order of value
    const ObjectType* type = nullptr;          ///< Object and ObjectArray: what the elements are

    /// Scalars: sets the member, and whether and with what it is to be written.
    void (*store)(void* owner, const Scalar& value) noexcept = nullptr;
    bool (*load)(const void* owner, Scalar& value) noexcept = nullptr;
    /// Text, Object and arrays: makes (the next) one; how many there are; the one at an index.
    Expected<void*> (*add)(void* owner, Allocator& allocator) noexcept = nullptr;
    std::size_t (*count)(const void* owner) noexcept = nullptr;
    const void* (*get)(const void* owner, std::size_t index) noexcept = nullptr;

    constexpr bool IsIn(std::uint32_t generation) const noexcept {
        return ((generations >> (generation - kMinSchemaVersion)) & 1u) != 0;
    }
};

/// At most 32 fields, because the reader keeps a bit for each.
struct ObjectType {
    std::span<const Field> fields{};
    bool hasViewIndices = false; ///< in it or in what it contains
    /// For each generation, a bit for each field that must be there.
    std::array<std::uint32_t, kMaxSchemaVersion + 1> required{};

    constexpr ObjectType() noexcept = default;
    constexpr ObjectType(std::span<const Field> rows, bool withViewIndices) noexcept
        : fields(rows), hasViewIndices(withViewIndices) {
        for (std::uint32_t generation = kMinSchemaVersion; generation <= kMaxSchemaVersion; ++generation) {
            for (std::size_t i = 0; i < rows.size(); ++i)
                required[generation] |= rows[i].required && rows[i].IsIn(generation) ? 1u << i : 0u;
        }
    }
};

template <typename T>
inline constexpr ObjectType kObjectType{};

template <typename T>
struct MemberOf;
template <typename Owner, typename Value>
struct MemberOf<Value Owner::*> {
    using OwnerType = Owner;
    using ValueType = Value;
};

template <typename T>
struct Unwrap {
    using Type = T;
    static constexpr bool isOptional = false;
    static constexpr bool isArray = false;
};
template <typename T>
struct Unwrap<std::optional<T>> {
    using Type = T;
    static constexpr bool isOptional = true;
    static constexpr bool isArray = false;
};
template <typename T>
struct Unwrap<Array<T>> {
    using Type = T;
    static constexpr bool isOptional = false;
    static constexpr bool isArray = true;
};

/// The row for one member. A plain member is always written, an optional one when it is set.
template <auto Member>
constexpr Field MakeField(std::string_view key, std::size_t maxCount = 1) noexcept {
    using Owner = typename MemberOf<decltype(Member)>::OwnerType;
    using Wrapped = Unwrap<typename MemberOf<decltype(Member)>::ValueType>;
    using Value = typename Wrapped::Type;
    Field field;
    field.key = key;
    field.maxCount = maxCount;
    if constexpr (std::is_arithmetic_v<Value> || std::is_enum_v<Value>) {
        if constexpr (std::is_enum_v<Value>) {
            field.kind = FieldKind::Enum;
            field.names = kNames<Value>;
        } else if constexpr (std::is_same_v<Value, float>) {
            field.kind = FieldKind::F32;
        } else {
            field.kind = sizeof(Value) == 8 ? FieldKind::U64 : FieldKind::U32;
        }
        field.store = [](void* owner, const Scalar& value) noexcept {
            if constexpr (std::is_same_v<Value, float>)
                static_cast<Owner*>(owner)->*Member = value.real;
            else
                static_cast<Owner*>(owner)->*Member = static_cast<Value>(value.integer);
        };
        field.load = [](const void* owner, Scalar& value) noexcept {
            const auto& member = static_cast<const Owner*>(owner)->*Member;
            const Value* set = nullptr;
            if constexpr (Wrapped::isOptional)
                set = member ? &*member : nullptr;
            else
                set = &member;
            if (set == nullptr)
                return false;
            if constexpr (std::is_same_v<Value, float>)
                value.real = *set;
            else
                value.integer = static_cast<std::uint64_t>(*set);
            return true;
        };
    } else if constexpr (std::is_same_v<Value, LayerViews>) {
        field.kind = FieldKind::U32Array;
        field.maxCount = kMaxLatentLayers;
        field.add = [](void* owner, Allocator&) noexcept -> Expected<void*> {
            LayerViews& list = static_cast<Owner*>(owner)->*Member;
            return &list.views[list.count++];
        };
        field.count = [](const void* owner) noexcept -> std::size_t {
            return (static_cast<const Owner*>(owner)->*Member).count;
        };
        field.get = [](const void* owner, std::size_t index) noexcept -> const void* {
            return &(static_cast<const Owner*>(owner)->*Member).views[index];
        };
    } else {
        if constexpr (std::is_same_v<Value, openntc::Text>) {
            field.kind = FieldKind::Text;
        } else {
            field.kind = Wrapped::isArray ? FieldKind::ObjectArray : FieldKind::Object;
            field.type = &kObjectType<Value>;
        }
        field.add = [](void* owner, [[maybe_unused]] Allocator& allocator) noexcept -> Expected<void*> {
            auto& member = static_cast<Owner*>(owner)->*Member;
            if constexpr (Wrapped::isArray) {
                OPENNTC_CHECK(member.PushBack(MakeRecord<Value>(allocator)));
                return &member.back();
            } else if constexpr (Wrapped::isOptional) {
                return &member.emplace(MakeRecord<Value>(allocator));
            } else {
                return &member;
            }
        };
        field.count = [](const void* owner) noexcept -> std::size_t {
            const auto& member = static_cast<const Owner*>(owner)->*Member;
            if constexpr (Wrapped::isArray)
                return member.size();
            else if constexpr (Wrapped::isOptional)
                return member ? 1 : 0;
            else
                return 1;
        };
        field.get = [](const void* owner, [[maybe_unused]] std::size_t index) noexcept -> const void* {
            const auto& member = static_cast<const Owner*>(owner)->*Member;
            if constexpr (Wrapped::isArray)
                return &member[index];
            else if constexpr (Wrapped::isOptional)
                return &*member;
            else
                return &member;
        };
    }
    return field;
}

template <auto Member>
constexpr Field Required(std::string_view key) noexcept {
    Field field = MakeField<Member>(key);
    field.required = true;
    return field;
}

/// May be absent; written only when it differs from Default.
template <auto Member, auto Default>
constexpr Field Defaulted(std::string_view key) noexcept {
    Field field = MakeField<Member>(key);
    field.load = [](const void* owner, Scalar& value) noexcept {
        const auto& member =
            static_cast<const typename MemberOf<decltype(Member)>::OwnerType*>(owner)->*Member;
        value.integer = static_cast<std::uint64_t>(member);
        return member != Default;
    };
    return field;
}

/// An enumeration of which only these names are known.
template <auto Member>
constexpr Field Named(std::string_view key, std::span<const std::string_view> names) noexcept {
    Field field = MakeField<Member>(key);
    field.names = names;
    return field;
}

/// The same row for some generations only.
constexpr Field In(std::uint8_t generations, Field field) noexcept {
    field.generations = generations;
    return field;
}

/// A number that must be below the length of `views`, or several.
template <auto Member>
constexpr Field View(std::string_view key, bool required) noexcept {
    Field field = MakeField<Member>(key);
    field.required = required;
    field.isViewIndex = true;
    return field;
}

} // namespace detail
} // namespace openntc::container

#include "openntc/core/RestoreMacros.h"
