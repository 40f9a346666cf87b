// SPDX-License-Identifier: MIT
#include "report/ReportJson.h"

#include "Failure.h"
#include "Json.h"
#include "TextureSet.h"
#include "report/Analysis.h"

#include <rapidjson/document.h>

#include <limits>

namespace openntc::report {

using tool::CommandError;
using tool::ExitCode;

namespace {

class Writer {
public:
    explicit Writer(tool::JsonWriter& json) : json_(json) {}

    template <typename T>
    void operator()(const char* key, T& value) {
        json_.Key(key);
        Write(value);
    }
    template <typename T>
    void Optional(const char* key, T& value) {
        (*this)(key, value);
    }
    template <typename T>
    void Write(T& value) {
        if constexpr (std::is_class_v<T>) {
            json_.BeginObject();
            Describe(*this, value);
            json_.EndObject();
        } else {
            json_.Value(value);
        }
    }
    void Write(std::string& value) { json_.Value(std::string_view(value)); }
    template <typename T>
    void Write(std::vector<T>& values) {
        json_.BeginArray();
        for (T& value : values)
            Write(value);
        json_.EndArray();
    }

private:
    tool::JsonWriter& json_;
};

class Reader {
public:
    Reader(const std::string& file, const rapidjson::Value& object, std::string where)
        : file_(file), object_(object), where_(std::move(where)) {}

    template <typename T>
    void operator()(const char* key, T& value) {
        const std::string name = where_.empty() ? key : where_ + "." + key;
        const auto found = object_.FindMember(key);
        if (found == object_.MemberEnd())
            Refuse(name, "missing");
        Read(name, found->value, value);
    }
    /// Left as it is where there is none.
    template <typename T>
    void Optional(const char* key, T& value) {
        if (object_.HasMember(key))
            (*this)(key, value);
    }
    template <typename T>
    void Read(const std::string& name, const rapidjson::Value& json, T& value) {
        if (!json.IsObject())
            Refuse(name, "must be an object");
        Reader inner(file_, json, name);
        Describe(inner, value);
    }
    template <typename T>
    void Read(const std::string& name, const rapidjson::Value& json, std::vector<T>& values) {
        if (!json.IsArray())
            Refuse(name, "must be an array");
        values.resize(json.Size());
        for (rapidjson::SizeType i = 0; i < json.Size(); ++i)
            Read(name + "[" + std::to_string(i) + "]", json[i], values[i]);
    }
    void Read(const std::string& name, const rapidjson::Value& json, std::string& value) {
        if (!json.IsString())
            Refuse(name, "must be a string");
        value.assign(json.GetString(), json.GetStringLength());
    }
    void Read(const std::string& name, const rapidjson::Value& json, bool& value) {
        if (!json.IsBool())
            Refuse(name, "must be true or false");
        value = json.GetBool();
    }
    void Read(const std::string& name, const rapidjson::Value& json, int& value) {
        if (!json.IsInt())
            Refuse(name, "must be an integer");
        value = json.GetInt();
    }
    void Read(const std::string& name, const rapidjson::Value& json, std::uint32_t& value) {
        if (!json.IsUint())
            Refuse(name, "must be an integer, 0 or more");
        value = json.GetUint();
    }
    void Read(const std::string& name, const rapidjson::Value& json, std::uint64_t& value) {
        if (!json.IsUint64())
            Refuse(name, "must be an integer, 0 or more");
        value = json.GetUint64();
    }
    void Read(const std::string& name, const rapidjson::Value& json, double& value) {
        const std::string_view text = json.IsString() ? json.GetString() : "";
        if (json.IsNumber())
            value = json.GetDouble();
        else if (text == "inf" || text == "-inf")
            value = (text == "inf" ? 1 : -1) * std::numeric_limits<double>::infinity();
        else if (text == "nan")
            value = std::numeric_limits<double>::quiet_NaN();
        else
            Refuse(name, "must be a number");
    }

private:
    [[noreturn]] void Refuse(const std::string& name, const char* why) const {
        throw CommandError(ExitCode::BadInput, file_, name + ": " + why);
    }

    const std::string& file_;
    const rapidjson::Value& object_;
    std::string where_;
};

rapidjson::Document Parse(const std::string& path) {
    const std::vector<std::byte> bytes = tool::ReadAll(path);
    rapidjson::Document document;
    document.Parse<rapidjson::kParseIterativeFlag>(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    if (document.HasParseError())
        throw CommandError(ExitCode::BadInput, path,
                           "JSON: malformed at byte " + std::to_string(document.GetErrorOffset()));
    return document;
}

} // namespace

std::string WriteReport(const ReportRecord& report) {
    tool::JsonWriter json;
    ReportRecord copy = report; // Describe lists members of something that may be written to
    copy.loadExceedsThreads = IsOverloaded(report);
    Writer(json).Write(copy);
    return json.Take();
}

ReportRecord ReadReport(const std::string& path) {
    const rapidjson::Document document = Parse(path);
    if (!document.IsObject())
        throw CommandError(ExitCode::BadInput, path, "JSON: must be an object: a report.json");
    const auto version = document.FindMember("version");
    if (version == document.MemberEnd() || !version->value.IsInt() ||
        version->value.GetInt() != ReportRecord{}.version)
        throw CommandError(ExitCode::BadInput, path, "version: must be 1: not a report of this tool");
    ReportRecord report;
    Reader(path, document, "").Read("", document, report);
    report.loadExceedsThreads = IsOverloaded(report);
    return report;
}

std::vector<HardCaseRecord> ReadHardCases(const std::string& path) {
    const rapidjson::Document document = Parse(path);
    std::vector<HardCaseRecord> cases;
    Reader(path, document, "").Read("hard cases", document, cases);
    return cases;
}

} // namespace openntc::report
