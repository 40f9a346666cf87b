// SPDX-License-Identifier: MIT
// Reads the lists of cases in suite.json, whose members are checked one by one.
#pragma once

#include "openntc/core/Expected.h"

#include <rapidjson/document.h>

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace openntc::conformance {

/// True for the name of a file in the suite's folder.
inline bool IsPlainName(const std::string& name) {
    return !name.empty() && name.find_first_of("/\\:") == std::string::npos && name != "..";
}

/// One case. What is missing or not valid is remembered: the last such member.
class SuiteEntry {
public:
    explicit SuiteEntry(const rapidjson::Value& object) : object_(object) {}

    std::string TakeText(const char* key) {
        const rapidjson::Value* value = Find(key);
        if (value == nullptr || !value->IsString()) {
            problem_ = key;
            return {};
        }
        return {value->GetString(), value->GetStringLength()};
    }

    std::string TakeFileName(const char* key) {
        std::string name = TakeText(key);
        if (!IsPlainName(name))
            problem_ = key;
        return name;
    }

    int TakeNumber(const char* key, int least, int most) {
        const rapidjson::Value* value = Find(key);
        return value == nullptr ? Refuse(key, least) : TakeNumber(*value, key, least, most);
    }

    /// `count` numbers.
    std::vector<int> TakeNumbers(const char* key, std::size_t count, int least, int most) {
        std::vector<int> numbers(count, least);
        const rapidjson::Value* value = Find(key);
        if (value == nullptr || !value->IsArray() || value->Size() != count) {
            problem_ = key;
            return numbers;
        }
        for (std::size_t i = 0; i < count; ++i)
            numbers[i] = TakeNumber((*value)[static_cast<rapidjson::SizeType>(i)], key, least, most);
        return numbers;
    }

    bool TakeFlag(const char* key) const {
        const rapidjson::Value* value = Find(key);
        return value != nullptr && value->IsTrue();
    }

    /// An array of objects, or nullptr.
    const rapidjson::Value* FindObjects(const char* key) {
        const rapidjson::Value* value = Find(key);
        bool isGood = value != nullptr && value->IsArray();
        if (isGood) {
            for (const rapidjson::Value& element : value->GetArray())
                isGood = isGood && element.IsObject();
        }
        if (!isGood)
            problem_ = key;
        return isGood ? value : nullptr;
    }

    void Refuse(const char* key) { problem_ = key; }
    /// The member that is missing or not valid, or nullptr.
    const char* GetProblem() const { return problem_; }

private:
    const rapidjson::Value* Find(const char* key) const {
        const auto member = object_.FindMember(key);
        return member == object_.MemberEnd() ? nullptr : &member->value;
    }
    int Refuse(const char* key, int value) {
        problem_ = key;
        return value;
    }
    int TakeNumber(const rapidjson::Value& value, const char* key, int least, int most) {
        const bool isGood = value.IsInt() && value.GetInt() >= least && value.GetInt() <= most;
        return isGood ? value.GetInt() : Refuse(key, least);
    }

    const rapidjson::Value& object_;
    const char* problem_ = nullptr;
};

/// The list `member` of suite.json, each case filled by `read(SuiteEntry&)`; empty where there is none.
/// Errors: Status::FileUnrecognized, naming the member.
template <typename Case, typename Read>
Expected<std::vector<Case>> ReadCaseList(std::span<const std::byte> json, const char* member, Read read) {
    rapidjson::Document document;
    document.Parse<rapidjson::kParseIterativeFlag>(reinterpret_cast<const char*>(json.data()), json.size());
    if (document.HasParseError() || !document.IsObject())
        return Fail(Status::FileUnrecognized, "JSON: syntax error at byte %zu", document.GetErrorOffset());
    const rapidjson::Value& root = document;
    std::vector<Case> cases;
    const auto list = root.FindMember(member);
    if (list == root.MemberEnd())
        return cases;
    if (!list->value.IsArray())
        return Fail(Status::FileUnrecognized, "%s: not an array", member);
    for (const rapidjson::Value& value : list->value.GetArray()) {
        if (!value.IsObject())
            return Fail(Status::FileUnrecognized, "%s: not an array of objects", member);
        SuiteEntry entry(value);
        cases.push_back(read(entry));
        if (entry.GetProblem() != nullptr)
            return Fail(Status::FileUnrecognized, "%s[%zu].%s: missing or not valid", member,
                        cases.size() - 1, entry.GetProblem());
    }
    return cases;
}

} // namespace openntc::conformance
