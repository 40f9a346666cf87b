// SPDX-License-Identifier: MIT
// Stability: internal
// Checks of a document that need no knowledge of networks and latents, shared by the reader and the writer.
#pragma once

#include "openntc/container/JsonPath.h"
#include "openntc/container/Schema.h"
#include "openntc/core/CheckedMath.h"

#include "openntc/core/HideMacros.h"

namespace openntc::container {
namespace detail {

/// Where an object lies in the document: a list of steps on the call stack.
struct PathStep {
    const PathStep* parent = nullptr;
    const Field* field = nullptr;
    std::size_t index = 0;
};

inline void AddSteps(JsonPath& path, const PathStep* step) noexcept {
    if (step == nullptr)
        return;
    AddSteps(path, step->parent);
    path.AddKey(step->field->key);
    if (IsArray(step->field->kind))
        path.AddIndex(step->index);
}

/// Calls visit(type, object, step) for an object and all objects in it that files of visit.generation have.
/// The depth is that of the tables.
template <typename Visitor>
Expected<void> VisitObjects(const ObjectType& type, const void* object, const PathStep* step,
                            Visitor& visit) noexcept {
    OPENNTC_CHECK(visit(type, object, step));
    for (const Field& field : type.fields) {
        if (field.type == nullptr || !visit.WantsType(*field.type) || !field.IsIn(visit.generation))
            continue;
        const std::size_t count = field.count(object);
        for (std::size_t i = 0; i < count; ++i) {
            const PathStep next{step, &field, i};
            OPENNTC_CHECK(VisitObjects(*field.type, field.get(object, i), &next, visit));
        }
    }
    return {};
}

struct ViewIndexVisitor {
    std::uint32_t generation;
    std::size_t viewCount;

    static bool WantsType(const ObjectType& type) noexcept { return type.hasViewIndices; }

    Expected<void> operator()(const ObjectType& type, const void* object,
                              const PathStep* step) const noexcept {
        for (const Field& field : type.fields) {
            if (!field.isViewIndex || !field.IsIn(generation))
                continue;
            const std::size_t count = field.count != nullptr ? field.count(object) : 1;
            for (std::size_t i = 0; i < count; ++i) {
                Scalar value;
                if (field.kind == FieldKind::U32Array)
                    value.integer = *static_cast<const std::uint32_t*>(field.get(object, i));
                else if (!field.load(object, value))
                    continue;
                if (value.integer < viewCount)
                    continue;
                JsonPath path;
                const PathStep last{step, &field, i};
                AddSteps(path, &last);
                return Fail(Status::FileUnrecognized, "%s: %llu: must be below %zu", path.GetText(),
                            static_cast<unsigned long long>(value.integer), viewCount);
            }
        }
        return {};
    }
};

struct CountVisitor {
    std::uint32_t generation;

    static bool WantsType(const ObjectType&) noexcept { return true; }

    Expected<void> operator()(const ObjectType& type, const void* object,
                              const PathStep* step) const noexcept {
        for (const Field& field : type.fields) {
            if (!IsArray(field.kind) || !field.IsIn(generation) || field.count(object) <= field.maxCount)
                continue;
            JsonPath path;
            AddSteps(path, step);
            path.AddKey(field.key);
            return Fail(Status::OutOfRange, "%s: %zu elements: at most %zu", path.GetText(),
                        field.count(object), field.maxCount);
        }
        return {};
    }
};

} // namespace detail

/// Every view starts at a multiple of 4 and ends inside a binary chunk of `binarySize` bytes. Errors:
/// FileUnrecognized.
inline Expected<void> CheckViewRanges(const Document& document, std::uint64_t binarySize) noexcept {
    for (std::size_t i = 0; i < document.views.size(); ++i) {
        const BufferView& view = document.views[i];
        if (view.offset % 4 != 0)
            return Fail(Status::FileUnrecognized, "views[%zu].offset: %llu: must be a multiple of 4", i,
                        static_cast<unsigned long long>(view.offset));
        if (!IsRangeInside(view.offset, view.storedSize, binarySize))
            return Fail(Status::FileUnrecognized,
                        "views[%zu].storedSize: %llu bytes at offset %llu: the binary chunk has %llu bytes",
                        i, static_cast<unsigned long long>(view.storedSize),
                        static_cast<unsigned long long>(view.offset),
                        static_cast<unsigned long long>(binarySize));
    }
    return {};
}

/// A generation that has tables. Errors: FileUnrecognized, naming the releases of LibNTC, because their users
/// know no schemaVersion, and what to do.
inline Expected<void> CheckSchemaVersion(std::uint32_t version) noexcept {
    if (version >= kMinSchemaVersion && version <= kMaxSchemaVersion)
        return {};
    if (version == 0)
        return Fail(Status::FileUnrecognized, "schemaVersion: 0: must be %u to %u", kMinSchemaVersion,
                    kMaxSchemaVersion);
    return Fail(
        Status::FileUnrecognized,
        "schemaVersion: %u: must be %u to %u (LibNTC 0.5 - 0.9): of a later release, of whose files this "
        "version of OpenNTC knows nothing: take a later one, or encode the images again",
        version, kMinSchemaVersion, kMaxSchemaVersion);
}

/// Every view index in the document is below the number of views. Errors: FileUnrecognized.
inline Expected<void> CheckViewIndices(const Document& document) noexcept {
    detail::ViewIndexVisitor visitor{document.schemaVersion, document.views.size()};
    return detail::VisitObjects(detail::kObjectType<Document>, &document, nullptr, visitor);
}

/// No array is longer than a reader accepts. Errors: OutOfRange.
inline Expected<void> CheckElementCounts(const Document& document) noexcept {
    detail::CountVisitor visitor{document.schemaVersion};
    return detail::VisitObjects(detail::kObjectType<Document>, &document, nullptr, visitor);
}

} // namespace openntc::container

#include "openntc/core/RestoreMacros.h"
