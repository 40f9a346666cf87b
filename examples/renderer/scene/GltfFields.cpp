// SPDX-License-Identifier: MIT
#include "renderer/scene/GltfFields.h"

#include "Output.h"

#include <cmath>
#include <limits>

namespace openntc::renderer {

namespace {

float ReadElement(const tool::GltfFile& file, const tool::GltfFile::Value& value, const std::string& at) {
    if (!value.IsNumber())
        file.Fail(at, "must be a number");
    const double number = value.GetDouble();
    if (!(std::fabs(number) <= static_cast<double>(std::numeric_limits<float>::max())))
        file.Fail(at, tool::Format("%g: too large for binary32", number));
    return static_cast<float>(number);
}

} // namespace

bool ReadFloats(const tool::GltfFile& file, const tool::GltfFile::Value& parent, const char* name,
                const std::string& where, std::span<float> numbers) {
    const auto member = parent.FindMember(name);
    if (member == parent.MemberEnd())
        return false;
    const std::string at = where + "." + name;
    if (!member->value.IsArray() || member->value.Size() != numbers.size())
        file.Fail(at, tool::Format("must be %zu numbers", numbers.size()));
    for (rapidjson::SizeType i = 0; i < member->value.Size(); ++i)
        numbers[i] = ReadElement(file, member->value[i], at);
    return true;
}

float ReadFloat(const tool::GltfFile& file, const tool::GltfFile::Value& parent, const char* name,
                const std::string& where, float fallback, FloatRange range) {
    const auto member = parent.FindMember(name);
    if (member == parent.MemberEnd())
        return fallback;
    const std::string at = where + "." + name;
    const float number = ReadElement(file, member->value, at);
    if (!(number >= range.low && number <= range.high))
        file.Fail(at, tool::Format("%g: %g to %g", static_cast<double>(number),
                                   static_cast<double>(range.low), static_cast<double>(range.high)));
    return number;
}

int ReadIndex(const tool::GltfFile& file, const tool::GltfFile::Value& parent, const char* name,
              const char* array, const std::string& where) {
    if (!parent.HasMember(name))
        return -1;
    file.Follow(parent, name, array, where);
    return static_cast<int>(parent[name].GetUint());
}

} // namespace openntc::renderer
