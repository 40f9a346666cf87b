// SPDX-License-Identifier: MIT
#include "gltf/GltfAccessor.h"

#include "Output.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <string_view>

namespace openntc::tool {

namespace {

using Value = GltfFile::Value;

constexpr int kByte = 5120, kUnsignedByte = 5121, kShort = 5122, kUnsignedShort = 5123, kUnsignedInt = 5125,
              kFloat = 5126;

std::size_t GetComponentSize(int type) {
    return type == kByte || type == kUnsignedByte ? 1 : type == kShort || type == kUnsignedShort ? 2 : 4;
}

/// A component's bits, little-endian in the file.
std::uint32_t ReadBits(const std::byte* bytes, std::size_t size) {
    std::uint32_t bits = 0;
    for (std::size_t i = size; i-- > 0;)
        bits = bits << 8 | std::to_integer<std::uint32_t>(bytes[i]);
    return bits;
}

float ReadComponent(const std::byte* bytes, int type, bool isNormalized) {
    const std::uint32_t bits = ReadBits(bytes, GetComponentSize(type));
    switch (type) {
    case kByte: {
        const float value = static_cast<float>(static_cast<std::int8_t>(bits));
        return isNormalized ? std::max(value / 127.0f, -1.0f) : value;
    }
    case kUnsignedByte:
        return isNormalized ? static_cast<float>(bits) / 255.0f : static_cast<float>(bits);
    case kShort: {
        const float value = static_cast<float>(static_cast<std::int16_t>(bits));
        return isNormalized ? std::max(value / 32767.0f, -1.0f) : value;
    }
    case kUnsignedShort:
        return isNormalized ? static_cast<float>(bits) / 65535.0f : static_cast<float>(bits);
    case kUnsignedInt:
        return static_cast<float>(bits);
    default:
        return std::bit_cast<float>(bits);
    }
}

} // namespace

std::size_t GltfAccessorReader::Layout::GetElementSize() const {
    return GetComponentSize(type) * static_cast<std::size_t>(components);
}

std::size_t GltfAccessorReader::GetNumber(const Value& parent, const char* name, const std::string& at,
                                          std::size_t limit, bool isRequired) {
    const auto member = parent.FindMember(name);
    if (member == parent.MemberEnd() && !isRequired)
        return 0;
    if (member == parent.MemberEnd())
        file_.Fail(at + "." + name, "missing");
    if (!member->value.IsUint64())
        file_.Fail(at + "." + name, "must be a whole number");
    if (member->value.GetUint64() > limit)
        file_.Fail(
            at + "." + name,
            Format("%llu: at most %zu", static_cast<unsigned long long>(member->value.GetUint64()), limit));
    return static_cast<std::size_t>(member->value.GetUint64());
}

GltfAccessorReader::Layout GltfAccessorReader::GetLayout(const Value& accessor, const std::string& at) {
    Layout layout;
    layout.count = GetNumber(accessor, "count", at, maximumCount_, true);
    if (layout.count == 0)
        file_.Fail(at + ".count", "0: at least 1");
    layout.type = static_cast<int>(GetNumber(accessor, "componentType", at, kFloat, true));
    if (layout.type < kByte || layout.type == 5124)
        file_.Fail(at + ".componentType", Format("%d: no such type", layout.type));
    const std::string type = file_.GetString(accessor, "type", at);
    constexpr std::string_view kTypes[] = {"SCALAR", "VEC2", "VEC3", "VEC4"};
    const auto found = std::find(std::begin(kTypes), std::end(kTypes), type);
    if (found == std::end(kTypes))
        file_.Fail(at + ".type", type + ": SCALAR, VEC2, VEC3 or VEC4 is needed");
    layout.components = static_cast<int>(found - std::begin(kTypes)) + 1;
    if (const auto member = accessor.FindMember("normalized"); member != accessor.MemberEnd()) {
        if (!member->value.IsBool())
            file_.Fail(at + ".normalized", "must be true or false");
        layout.isNormalized = member->value.GetBool();
    }
    return layout;
}

/// Copies `count` elements of `size` bytes from `parent`.bufferView, from `parent`.byteOffset on.
void GltfAccessorReader::ReadView(const Value& parent, const std::string& at, std::size_t count,
                                  std::size_t size, std::vector<std::byte>& elements) {
    const ImageBytes view = file_.GetView(parent, at);
    const Value& description = file_.Follow(parent, "bufferView", "bufferViews", at);
    std::size_t stride = GetNumber(description, "byteStride", at + ".bufferView", 252, false);
    stride = stride == 0 ? size : stride;
    if (stride < size)
        file_.Fail(at + ".bufferView.byteStride", Format("%zu: elements have %zu bytes", stride, size));
    const std::size_t offset = GetNumber(parent, "byteOffset", at, view.size, false);
    // The last element needs no padding behind it.
    if (size > view.size - offset || (view.size - offset - size) / stride < count - 1)
        file_.Fail(at + ".count",
                   Format("%zu elements of %zu bytes, %zu apart, at %zu: the view has %zu bytes", count, size,
                          stride, offset, view.size));
    elements.resize(count * size);
    const std::byte* bytes = view.Get().data() + offset;
    for (std::size_t i = 0; i < count; ++i)
        std::memcpy(elements.data() + i * size, bytes + i * stride, size);
}

void GltfAccessorReader::ApplySparse(const Value& sparse, const Layout& layout, const std::string& at,
                                     std::vector<std::byte>& elements) {
    const std::size_t count = GetNumber(sparse, "count", at, layout.count, true);
    if (count == 0)
        file_.Fail(at + ".count", "0: at least 1");
    const std::string indicesAt = at + ".indices", valuesAt = at + ".values";
    const Value& indices = file_.GetObject(sparse, "indices", indicesAt);
    const int type = static_cast<int>(GetNumber(indices, "componentType", indicesAt, kUnsignedInt, true));
    if (type != kUnsignedByte && type != kUnsignedShort && type != kUnsignedInt)
        file_.Fail(indicesAt + ".componentType", Format("%d: 5121, 5123 or 5125", type));
    const std::size_t indexSize = GetComponentSize(type), size = layout.GetElementSize();
    std::vector<std::byte> places, values;
    ReadView(indices, indicesAt, count, indexSize, places);
    ReadView(file_.GetObject(sparse, "values", valuesAt), valuesAt, count, size, values);
    std::size_t next = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const std::size_t place = ReadBits(places.data() + i * indexSize, indexSize);
        if (place < next || place >= layout.count)
            file_.Fail(indicesAt, Format("%zu: must rise, and be below %zu", place, layout.count));
        next = place + 1;
        std::memcpy(elements.data() + place * size, values.data() + i * size, size);
    }
}

std::vector<std::byte> GltfAccessorReader::ReadElements(const Value& accessor, const Layout& layout,
                                                        const std::string& at) {
    std::vector<std::byte> elements;
    if (accessor.HasMember("bufferView"))
        ReadView(accessor, at, layout.count, layout.GetElementSize(), elements);
    else
        elements.resize(layout.count * layout.GetElementSize()); // zeros, by the standard
    if (accessor.HasMember("sparse"))
        ApplySparse(file_.GetObject(accessor, "sparse", at + ".sparse"), layout, at + ".sparse", elements);
    return elements;
}

std::size_t GltfAccessorReader::GetCount(const Value& parent, const char* name, const std::string& where) {
    const Value& accessor = file_.Follow(parent, name, "accessors", where);
    return GetLayout(accessor, Format("accessors[%u]", parent[name].GetUint())).count;
}

GltfNumbers GltfAccessorReader::ReadNumbers(const Value& parent, const char* name, const std::string& where,
                                            int low, int high) {
    const Value& accessor = file_.Follow(parent, name, "accessors", where);
    const std::string at = Format("accessors[%u]", parent[name].GetUint());
    const Layout layout = GetLayout(accessor, at);
    if (layout.components < low || layout.components > high)
        file_.Fail(at + ".type", Format("%d components: %s.%s has %d to %d", layout.components, where.c_str(),
                                        name, low, high));
    const std::vector<std::byte> elements = ReadElements(accessor, layout, at);
    GltfNumbers numbers{layout.count, layout.components, {}};
    numbers.values.resize(layout.count * static_cast<std::size_t>(layout.components));
    const std::size_t size = GetComponentSize(layout.type);
    for (std::size_t i = 0; i < numbers.values.size(); ++i) {
        numbers.values[i] = ReadComponent(elements.data() + i * size, layout.type, layout.isNormalized);
        if (!std::isfinite(numbers.values[i]))
            file_.Fail(at,
                       Format("element %zu is not finite", i / static_cast<std::size_t>(layout.components)));
    }
    return numbers;
}

std::vector<std::uint32_t> GltfAccessorReader::ReadIndices(const Value& parent, const char* name,
                                                           const std::string& where, std::size_t limit) {
    const Value& accessor = file_.Follow(parent, name, "accessors", where);
    const std::string at = Format("accessors[%u]", parent[name].GetUint());
    const Layout layout = GetLayout(accessor, at);
    if (layout.type != kUnsignedByte && layout.type != kUnsignedShort && layout.type != kUnsignedInt)
        file_.Fail(at + ".componentType", Format("%d: indices are 5121, 5123 or 5125", layout.type));
    if (layout.components != 1)
        file_.Fail(at + ".type", "indices are SCALAR");
    const std::vector<std::byte> elements = ReadElements(accessor, layout, at);
    const std::size_t size = GetComponentSize(layout.type);
    std::vector<std::uint32_t> indices(layout.count);
    for (std::size_t i = 0; i < indices.size(); ++i) {
        indices[i] = ReadBits(elements.data() + i * size, size);
        if (indices[i] >= limit)
            file_.Fail(at, Format("index %u: there are %zu vertices", indices[i], limit));
    }
    return indices;
}

} // namespace openntc::tool
