// SPDX-License-Identifier: MIT
#include "Suite.h"

#include "../Json.h"
#include "Protocol.h"
#include "SuiteEntry.h"

#include <rapidjson/document.h>

#include <bit>
#include <cstring>

namespace openntc::conformance {

namespace {

constexpr std::size_t kHeaderBytes = 20;
constexpr std::size_t kRecordBytes = 76;
constexpr std::size_t kIntervalRecordBytes = 204;

std::uint32_t LoadUint32(const std::byte* bytes) {
    std::uint32_t value = 0;
    for (int i = 0; i < 4; ++i)
        value |= static_cast<std::uint32_t>(bytes[i]) << (8 * i);
    return value;
}

void Append(std::vector<std::byte>& bytes, std::uint32_t value) {
    for (int i = 0; i < 4; ++i)
        bytes.push_back(static_cast<std::byte>(value >> (8 * i) & 255u));
}

bool ReadSlice(const rapidjson::Value& value, std::optional<Rect>& slice) {
    if (!value.IsArray() || value.Size() != 4)
        return false;
    Rect rect;
    unsigned i = 0;
    for (int* number : {&rect.left, &rect.top, &rect.width, &rect.height}) {
        if (!value[i].IsInt() || value[i].GetInt() < (i < 2 ? 0 : 1) || value[i].GetInt() > kMaxDecodeSize)
            return false;
        *number = value[i++].GetInt();
    }
    slice = rect;
    return true;
}

bool ReadSliceMips(const rapidjson::Value& value, SuiteCase& suiteCase) {
    if (!suiteCase.slice || !value.IsArray() || value.Size() != 2 || !value[0].IsInt() || !value[1].IsInt())
        return false;
    suiteCase.sliceMip = value[0].GetInt();
    suiteCase.sliceMips = value[1].GetInt();
    return suiteCase.sliceMip >= 0 && suiteCase.sliceMip < NTC_MAX_MIPS && suiteCase.sliceMips >= 1 &&
           suiteCase.sliceMips <= NTC_MAX_MIPS - suiteCase.sliceMip;
}

} // namespace

Expected<std::vector<SuiteCase>> ReadSuite(std::span<const std::byte> json) {
    rapidjson::Document root;
    root.Parse<rapidjson::kParseIterativeFlag>(reinterpret_cast<const char*>(json.data()), json.size());
    if (root.HasParseError() || !root.IsObject())
        return Fail(Status::FileUnrecognized, "JSON: syntax error at byte %zu", root.GetErrorOffset());
    const auto find = [](const rapidjson::Value& object, const char* key) -> const rapidjson::Value* {
        const auto member = object.FindMember(key);
        return member == object.MemberEnd() ? nullptr : &member->value;
    };
    const rapidjson::Value* version = find(root, "version");
    if (version == nullptr || !version->IsInt() || version->GetInt() < 1 || version->GetInt() > kSuiteVersion)
        return Fail(Status::FileUnrecognized, "version: not 1 to %d", kSuiteVersion);
    const rapidjson::Value* list = find(root, "cases");
    if (list == nullptr || !list->IsArray())
        return Fail(Status::FileUnrecognized, "cases: not an array");

    std::vector<SuiteCase> cases;
    for (const rapidjson::Value& entry : list->GetArray()) {
        SuiteCase suiteCase;
        const char* problem = nullptr;
        if (!entry.IsObject())
            return Fail(Status::FileUnrecognized, "cases: not an array of objects");
        const auto text = [&](const char* key, std::string& value) {
            const rapidjson::Value* member = find(entry, key);
            if (member == nullptr || !member->IsString())
                problem = key;
            else
                value.assign(member->GetString(), member->GetStringLength());
        };
        const auto flag = [&](const char* key, bool& value) {
            const rapidjson::Value* member = find(entry, key);
            value = member != nullptr && member->IsTrue();
        };
        std::string math;
        text("name", suiteCase.name);
        text("set", suiteCase.set);
        text("values", suiteCase.values);
        text("math", math);
        text("about", suiteCase.about);
        flag("linear", suiteCase.linear);
        flag("wholeMip", suiteCase.wholeMip);
        flag("interval", suiteCase.interval);
        flag("outside", suiteCase.outside);
        flag("mustPass", suiteCase.mustPass);
        const std::optional<DecodeMath> mode = FindMath(math);
        if (problem == nullptr && !mode)
            problem = "math";
        if (problem == nullptr && (!IsPlainName(suiteCase.set) || !IsPlainName(suiteCase.values)))
            problem = "set, values";
        if (problem != nullptr)
            return Fail(Status::FileUnrecognized, "cases[%zu].%s: missing or not valid", cases.size(),
                        problem);
        suiteCase.math = *mode;
        if (const rapidjson::Value* slice = find(entry, "slice")) {
            if (!ReadSlice(*slice, suiteCase.slice) || suiteCase.wholeMip || suiteCase.outside)
                return Fail(Status::FileUnrecognized,
                            "cases[%zu].slice: not four numbers, or with wholeMip or outside", cases.size());
        }
        const rapidjson::Value* mips = find(entry, "sliceMips");
        if (mips != nullptr && !ReadSliceMips(*mips, suiteCase))
            return Fail(Status::FileUnrecognized,
                        "cases[%zu].sliceMips: not a mip and a count, or without slice", cases.size());
        if (suiteCase.interval && suiteCase.linear)
            return Fail(Status::FileUnrecognized, "cases[%zu].interval: not with linear", cases.size());
        cases.push_back(std::move(suiteCase));
    }
    return cases;
}

std::string WriteSuite(std::span<const SuiteCase> cases, const SuiteParts& parts) {
    tool::JsonWriter json(0);
    json.BeginObject();
    json.Member("format", "openntc-conformance");
    json.Member("version", kSuiteVersion);
    json.Key("cases");
    json.BeginArray();
    for (const SuiteCase& suiteCase : cases) {
        json.BeginObject();
        json.Member("name", std::string_view(suiteCase.name));
        json.Member("set", std::string_view(suiteCase.set));
        json.Member("values", std::string_view(suiteCase.values));
        json.Member("math", tool::GetName(suiteCase.math));
        json.Member("linear", suiteCase.linear);
        json.Member("wholeMip", suiteCase.wholeMip);
        json.Member("interval", suiteCase.interval);
        if (suiteCase.outside)
            json.Member("outside", true);
        if (suiteCase.slice) {
            json.Key("slice");
            json.BeginArray();
            for (const int number : {suiteCase.slice->left, suiteCase.slice->top, suiteCase.slice->width,
                                     suiteCase.slice->height})
                json.Value(number);
            json.EndArray();
        }
        if (suiteCase.sliceMip >= 0) {
            json.Key("sliceMips");
            json.BeginArray();
            json.Value(suiteCase.sliceMip);
            json.Value(suiteCase.sliceMips);
            json.EndArray();
        }
        json.Member("mustPass", suiteCase.mustPass);
        json.Member("about", std::string_view(suiteCase.about));
        json.EndObject();
    }
    json.EndArray();
    WriteBlockCases(json, parts.blocks);
    WriteTextureCases(json, parts.textures);
    WriteFilterCases(json, parts.filtering);
    json.EndObject();
    return json.Take();
}

Expected<std::vector<ValueRecord>> ReadValues(std::span<const std::byte> file, const SuiteCase& suiteCase) {
    if (file.size() < kHeaderBytes || std::memcmp(file.data(), "NTCV", 4) != 0)
        return Fail(Status::FileUnrecognized, "signature: not NTCV");
    if (const std::uint32_t version = LoadUint32(file.data() + 4); version != (suiteCase.interval ? 2u : 1u))
        return Fail(Status::FileUnrecognized, "version: %u: 1, with intervals 2", version);
    if (LoadUint32(file.data() + 8) != static_cast<std::uint32_t>(suiteCase.math) ||
        LoadUint32(file.data() + 12) != (suiteCase.linear ? 1u : 0u))
        return Fail(Status::FileUnrecognized, "maths mode, linear: not those of suite.json");
    const std::uint64_t count = LoadUint32(file.data() + 16);
    const std::size_t recordBytes = suiteCase.interval ? kIntervalRecordBytes : kRecordBytes;
    if (count == 0 || kHeaderBytes + count * recordBytes != file.size())
        return Fail(Status::FileUnrecognized, "records: %llu of %zu bytes: do not make a file of %zu bytes",
                    static_cast<unsigned long long>(count), recordBytes, file.size());
    std::vector<ValueRecord> records(static_cast<std::size_t>(count));
    const std::byte* bytes = file.data() + kHeaderBytes;
    for (ValueRecord& record : records) {
        record.texel.mip = static_cast<std::int32_t>(LoadUint32(bytes));
        record.texel.x = static_cast<std::int32_t>(LoadUint32(bytes + 4));
        record.texel.y = static_cast<std::int32_t>(LoadUint32(bytes + 8));
        for (std::size_t c = 0; c < 16; ++c) {
            record.outputs[c] = std::bit_cast<float>(LoadUint32(bytes + 12 + 4 * c));
            if (!suiteCase.interval)
                continue;
            record.low[c] = std::bit_cast<float>(LoadUint32(bytes + 76 + 4 * c));
            record.high[c] = std::bit_cast<float>(LoadUint32(bytes + 140 + 4 * c));
            if (!(record.low[c] <= record.outputs[c] && record.outputs[c] <= record.high[c]))
                return Fail(Status::FileUnrecognized, "mip %d texel (%d, %d): output outside its interval",
                            record.texel.mip, record.texel.x, record.texel.y);
        }
        bytes += recordBytes;
    }
    return records;
}

std::vector<std::byte> WriteValues(std::span<const ValueRecord> records, const SuiteCase& suiteCase) {
    std::vector<std::byte> bytes;
    for (const char c : {'N', 'T', 'C', 'V'})
        bytes.push_back(static_cast<std::byte>(c));
    Append(bytes, suiteCase.interval ? 2 : 1);
    Append(bytes, static_cast<std::uint32_t>(suiteCase.math));
    Append(bytes, suiteCase.linear ? 1 : 0);
    Append(bytes, static_cast<std::uint32_t>(records.size()));
    for (const ValueRecord& record : records) {
        for (const int value : {record.texel.mip, record.texel.x, record.texel.y})
            Append(bytes, static_cast<std::uint32_t>(value));
        for (const Outputs* values : {&record.outputs, &record.low, &record.high}) {
            if (values != &record.outputs && !suiteCase.interval)
                break;
            for (const float value : *values)
                Append(bytes, std::bit_cast<std::uint32_t>(value));
        }
    }
    return bytes;
}

} // namespace openntc::conformance
