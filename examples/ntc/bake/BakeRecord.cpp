// SPDX-License-Identifier: MIT
#include "bake/BakeRecord.h"

#include "Failure.h"
#include "InputFile.h"
#include "Json.h"
#include "bake/MaterialTree.h"
#include "encode/StateFile.h"

#include <rapidjson/document.h>

#include <cmath>
#include <filesystem>
#include <limits>

namespace openntc::tool {

namespace {

namespace fs = std::filesystem;

constexpr int kRecordVersion = 1;

std::string GetText(const rapidjson::Value& object, const char* name) {
    const auto member = object.FindMember(name);
    return member != object.MemberEnd() && member->value.IsString()
               ? std::string(member->value.GetString(), member->value.GetStringLength())
               : std::string();
}
std::uint64_t GetUnsigned(const rapidjson::Value& object, const char* name) {
    const auto member = object.FindMember(name);
    return member != object.MemberEnd() && member->value.IsUint64() ? member->value.GetUint64() : 0;
}
/// Exact constants have a PSNR of "inf".
double GetReal(const rapidjson::Value& object, const char* name) {
    const auto member = object.FindMember(name);
    if (member == object.MemberEnd() || !member->value.IsNumber())
        return std::numeric_limits<double>::infinity();
    return member->value.GetDouble();
}
FileStamp GetStamp(const rapidjson::Value& object) {
    // A time is a text: it may be negative, and readers of JSON with 53 bits would round it.
    return {GetUnsigned(object, "bytes"), std::strtoll(GetText(object, "time").c_str(), nullptr, 10)};
}
void WriteStamp(JsonWriter& json, const FileStamp& stamp) {
    json.Member("bytes", stamp.bytes);
    json.Member("time", std::string_view(std::to_string(stamp.time)));
}
std::string MakeAbsolute(const std::string& path, const std::string& folder) {
    return GetAbsolutePath((fs::path(folder) / path).string());
}

} // namespace

std::string GetBakeFolder(const std::string& folder) {
    return (fs::path(folder) / ".bake").string();
}

std::string GetRecordPath(const std::string& folder, const std::string& name) {
    return (fs::path(GetBakeFolder(folder)) / (name + ".json")).string();
}

std::optional<BakeRecord> ReadRecord(const std::string& path, const std::string& folder) {
    std::error_code error;
    if (!fs::is_regular_file(path, error))
        return std::nullopt;
    const std::string text = ReadAllText(path);
    rapidjson::Document json;
    json.Parse<rapidjson::kParseIterativeFlag>(text.c_str(), text.size());
    if (json.HasParseError() || !json.IsObject() || GetUnsigned(json, "bakeRecord") != kRecordVersion ||
        !json.HasMember("sources") || !json["sources"].IsArray())
        return std::nullopt;
    BakeRecord record;
    record.name = GetText(json, "material");
    record.root = MakeAbsolute(GetText(json, "root"), folder);
    record.origin = MakeAbsolute(GetText(json, "origin"), folder);
    record.key = GetText(json, "key");
    record.settings = GetText(json, "settings");
    record.kernel = GetText(json, "kernel");
    record.missed = GetText(json, "missed");
    record.output = GetStamp(json);
    record.crc = static_cast<std::uint32_t>(GetUnsigned(json, "crc32"));
    record.psnr = GetReal(json, "psnr");
    record.bitsPerPixel = GetReal(json, "bitsPerPixel");
    record.steps = GetUnsigned(json, "steps");
    for (const rapidjson::Value& source : json["sources"].GetArray()) {
        if (!source.IsObject())
            return std::nullopt;
        const auto settled = source.FindMember("settled");
        record.sources.push_back({MakeAbsolute(GetText(source, "path"), folder),
                                  {GetStamp(source), GetText(source, "digest"),
                                   settled == source.MemberEnd() || !settled->value.IsFalse()}});
    }
    return record;
}

void WriteRecord(const BakeRecord& record, const std::string& folder) {
    JsonWriter json;
    json.BeginObject();
    json.Member("bakeRecord", kRecordVersion);
    json.Member("material", std::string_view(record.name));
    json.Member("root", std::string_view(GetRelativePath(record.root, folder)));
    json.Member("origin", std::string_view(GetRelativePath(record.origin, folder)));
    json.Member("key", std::string_view(record.key));
    json.Member("settings", std::string_view(record.settings));
    json.Member("kernel", std::string_view(record.kernel));
    if (!record.missed.empty())
        json.Member("missed", std::string_view(record.missed));
    WriteStamp(json, record.output);
    json.Member("crc32", record.crc);
    json.Member("psnr", record.psnr);
    json.Member("bitsPerPixel", record.bitsPerPixel);
    json.Member("steps", record.steps);
    json.Key("sources");
    json.BeginArray();
    for (const BakeSource& source : record.sources) {
        json.BeginObject();
        json.Member("path", std::string_view(GetRelativePath(source.path, folder)));
        WriteStamp(json, source.hash.stamp);
        json.Member("digest", std::string_view(source.hash.digest));
        if (!source.hash.isSettled)
            json.Member("settled", false);
        json.EndObject();
    }
    json.EndArray();
    json.EndObject();
    const std::string path = GetRecordPath(folder, record.name);
    std::error_code error;
    fs::create_directories(fs::path(path).parent_path(), error);
    if (error)
        throw CommandError(ExitCode::Failed, path, "folder: cannot be made: " + error.message());
    const std::string text = json.Take();
    WriteWholeFile(path, {std::as_bytes(std::span(text))});
}

std::vector<BakeRecord> ReadRecords(const std::string& folder) {
    std::vector<BakeRecord> records;
    std::error_code error;
    for (fs::recursive_directory_iterator entry(GetBakeFolder(folder), error), end; !error && entry != end;
         entry.increment(error)) {
        if (entry->path().extension() != ".json")
            continue;
        if (std::optional<BakeRecord> record = ReadRecord(entry->path().string(), folder))
            records.push_back(std::move(*record));
    }
    return records;
}

} // namespace openntc::tool
