// SPDX-License-Identifier: MIT
#include "RawFile.h"

#include <rapidjson/prettywriter.h>
#include <rapidjson/stringbuffer.h>
#include <rapidjson/writer.h>

#include <cstdint>
#include <cstring>
#include <numeric>
#include <stdexcept>
#include <string_view>

namespace openntc::conformance {

namespace {

using rapidjson::Value;

constexpr std::size_t kFileHeaderBytes = 40;

std::size_t LoadSize(std::span<const std::byte> file, std::size_t at) {
    std::uint64_t value = 0;
    std::memcpy(&value, file.data() + at, sizeof value);
    return static_cast<std::size_t>(value);
}

void StoreSize(std::vector<std::byte>& file, std::size_t at, std::size_t size) {
    const std::uint64_t value = size;
    std::memcpy(file.data() + at, &value, sizeof value);
}

template <typename Function>
void ForEachMember(Value& value, Function function) {
    if (value.IsArray()) {
        for (Value& element : value.GetArray())
            ForEachMember(element, function);
    } else if (value.IsObject()) {
        // Compared with <: rapidjson's != of iterators that are not const is ambiguous in C++20.
        for (auto member = value.MemberBegin(); member < value.MemberEnd(); ++member) {
            function(std::string_view(member->name.GetString()), member->value);
            ForEachMember(member->value, function);
        }
    }
}

Value Disguise(const Value& value, rapidjson::Document::AllocatorType& allocator) {
    if (value.IsArray()) {
        Value array(rapidjson::kArrayType);
        for (const Value& element : value.GetArray())
            array.PushBack(Disguise(element, allocator), allocator);
        return array;
    }
    if (!value.IsObject())
        return Value(value, allocator);
    Value object(rapidjson::kObjectType);
    for (auto member = value.MemberEnd(); member != value.MemberBegin();) {
        --member;
        object.AddMember(Value(member->name, allocator), Disguise(member->value, allocator), allocator);
    }
    object.AddMember("x-vendor", Value("a \"quoted\" name, \\ and {[", allocator), allocator);
    return object;
}

} // namespace

RawFile::RawFile(std::span<const std::byte> file) {
    const std::string text(reinterpret_cast<const char*>(file.data()) + LoadSize(file, 8),
                           LoadSize(file, 16));
    json.Parse<rapidjson::kParseFullPrecisionFlag>(text.c_str());
    if (json.HasParseError())
        throw std::runtime_error("RawFile: JSON");
    const std::size_t binary = LoadSize(file, 24);
    for (const Value& view : json["views"].GetArray()) {
        const auto bytes = file.subspan(binary + static_cast<std::size_t>(view["offset"].GetUint64()),
                                        static_cast<std::size_t>(view["storedSize"].GetUint64()));
        views.emplace_back(bytes.begin(), bytes.end());
    }
}

void RawFile::Set(Value& object, const char* key, Value value) {
    object.RemoveMember(key);
    object.AddMember(Value(key, json.GetAllocator()), value, json.GetAllocator());
}

void RawFile::Set(Value& object, const char* key, const char* text) {
    Set(object, key, Value(text, json.GetAllocator()));
}

void RawFile::RenumberViews(std::span<const std::size_t> indices) {
    std::vector<std::vector<std::byte>> moved(views.size());
    for (std::size_t i = 0; i < views.size(); ++i)
        moved[indices[i]] = std::move(views[i]);
    views = std::move(moved);
    ForEachMember(json, [&](std::string_view key, Value& value) {
        if (key.ends_with("View") && value.IsUint())
            value.SetUint(static_cast<unsigned>(indices[value.GetUint()]));
    });
}

void RawFile::DisguiseText() {
    ForEachMember(json, [&](std::string_view key, Value& value) {
        if (!value.IsString() || key == "name")
            return;
        std::string word = value.GetString();
        for (std::size_t i = 0; i < word.size(); ++i) {
            const char c = word[i];
            const bool isLetter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
            if (isLetter && i % 2 == 0)
                word[i] = static_cast<char>(c ^ 0x20);
        }
        value.SetString(word.c_str(), json.GetAllocator());
    });
    Value disguised = Disguise(json, json.GetAllocator());
    static_cast<Value&>(json) = disguised; // moves
}

std::vector<std::byte> RawFile::Write(const RawLayout& layout) const {
    std::vector<std::size_t> order = layout.order;
    if (order.empty()) {
        order.resize(views.size());
        std::iota(order.begin(), order.end(), std::size_t{0});
    }
    std::vector<std::byte> binary;
    std::vector<std::size_t> offsets(views.size());
    for (const std::size_t view : order) {
        binary.resize(binary.size() + layout.gap, std::byte{0xA5});
        offsets[view] = binary.size();
        binary.insert(binary.end(), views[view].begin(), views[view].end());
        binary.resize((binary.size() + 3) / 4 * 4);
    }
    rapidjson::Document document;
    document.CopyFrom(json, document.GetAllocator());
    Value list(rapidjson::kArrayType);
    for (std::size_t i = 0; i < views.size(); ++i) {
        Value view(rapidjson::kObjectType);
        view.AddMember("offset", static_cast<std::uint64_t>(offsets[i]), document.GetAllocator());
        view.AddMember("storedSize", static_cast<std::uint64_t>(views[i].size()), document.GetAllocator());
        list.PushBack(view, document.GetAllocator());
    }
    document["views"] = list;
    rapidjson::StringBuffer buffer;
    if (layout.isPretty) {
        rapidjson::PrettyWriter<rapidjson::StringBuffer> writer(buffer);
        document.Accept(writer);
    } else {
        rapidjson::Writer<rapidjson::StringBuffer> writer(buffer);
        document.Accept(writer);
    }
    std::string text(buffer.GetString(), buffer.GetSize());
    if (layout.hasNul)
        text += '\0';
    while (text.size() % 4 != 0 && layout.dataFirst)
        text += '\0';

    std::vector<std::byte> file(kFileHeaderBytes);
    const auto append = [&](const void* bytes, std::size_t size) {
        file.resize((file.size() + 3) / 4 * 4 + (file.size() > kFileHeaderBytes ? layout.chunkGap : 0));
        const std::size_t at = file.size();
        file.resize(at + size);
        std::memcpy(file.data() + at, bytes, size);
        return at;
    };
    std::size_t jsonOffset = 0;
    std::size_t binaryOffset = 0;
    if (layout.dataFirst) {
        binaryOffset = append(binary.data(), binary.size());
        jsonOffset = append(text.data(), text.size());
    } else {
        jsonOffset = append(text.data(), text.size());
        binaryOffset = append(binary.data(), binary.size());
    }
    std::memcpy(file.data(), "NTEX", 4);
    file[5] = std::byte{1}; // version 0x100
    StoreSize(file, 8, jsonOffset);
    StoreSize(file, 16, text.size());
    StoreSize(file, 24, binaryOffset);
    StoreSize(file, 32, binary.size());
    return file;
}

} // namespace openntc::conformance
