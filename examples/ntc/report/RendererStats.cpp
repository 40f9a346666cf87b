// SPDX-License-Identifier: MIT
#include "report/RendererStats.h"

#include "Failure.h"
#include "TextureSet.h"
#include "report/Device.h"

#include <rapidjson/document.h>

#include <set>

namespace openntc::report {

namespace {

class StatsReader {
public:
    explicit StatsReader(const std::string& path) : path_(path) {
        const std::vector<std::byte> bytes = tool::ReadAll(path);
        document_.Parse<rapidjson::kParseIterativeFlag>(reinterpret_cast<const char*>(bytes.data()),
                                                        bytes.size());
        if (document_.HasParseError() || !document_.IsObject())
            Refuse("JSON", "an object");
    }

    const rapidjson::Value& GetRoot() const { return document_; }

    const rapidjson::Value& Find(const rapidjson::Value& object, const char* name) const {
        const auto found = object.FindMember(name);
        if (found == object.MemberEnd())
            Refuse(name, "there");
        return found->value;
    }
    double GetNumber(const rapidjson::Value& object, const char* name) const {
        const rapidjson::Value& value = Find(object, name);
        if (!value.IsNumber())
            Refuse(name, "a number");
        return value.GetDouble();
    }
    std::string GetText(const rapidjson::Value& object, const char* name) const {
        const rapidjson::Value& value = Find(object, name);
        if (!value.IsString())
            Refuse(name, "a text");
        return value.GetString();
    }
    const rapidjson::Value& FindObject(const rapidjson::Value& object, const char* name) const {
        const rapidjson::Value& value = Find(object, name);
        if (!value.IsObject())
            Refuse(name, "an object");
        return value;
    }
    const rapidjson::Value& FindArray(const rapidjson::Value& object, const char* name) const {
        const rapidjson::Value& value = Find(object, name);
        if (!value.IsArray())
            Refuse(name, "an array");
        return value;
    }

    [[noreturn]] void Refuse(const std::string& name, const char* what) const {
        throw tool::CommandError(tool::ExitCode::Failed, path_, name + ": must be " + what);
    }

private:
    const std::string& path_;
    rapidjson::Document document_;
};

void ReadTimes(const StatsReader& reader, SceneRecord& record) {
    const rapidjson::Value& times = reader.FindObject(reader.GetRoot(), "milliseconds");
    std::vector<double> frames;
    for (const rapidjson::Value& frame : reader.FindArray(times, "frames").GetArray()) {
        if (!frame.IsNumber())
            reader.Refuse("frames", "numbers");
        frames.push_back(frame.GetDouble());
    }
    record.time = Summarise(std::move(frames));
    record.visibility = reader.GetNumber(times, "visibility") + reader.GetNumber(times, "masks");
    for (const char* pass : {"sky", "shade", "blend"})
        record.shading += reader.GetNumber(times, pass);
}

/// Effects that are on in any material that is shown.
void ReadEffects(const StatsReader& reader, SceneRecord& record) {
    std::set<std::string> known;
    for (const rapidjson::Value& material : reader.FindArray(reader.GetRoot(), "materials").GetArray()) {
        for (const auto& effect : reader.FindObject(material, "effects").GetObject()) {
            if (effect.value.IsTrue() && known.emplace(effect.name.GetString()).second)
                record.effectsOn.emplace_back(effect.name.GetString());
        }
    }
}

} // namespace

void ReadRendererStats(const std::string& path, SceneRecord& record) {
    const StatsReader reader(path);
    const rapidjson::Value& root = reader.GetRoot();
    if (!record.math.empty() && reader.GetText(root, "math") != record.math)
        record.skipped = reader.GetText(root, "mathReason");
    ReadTimes(reader, record);
    ReadEffects(reader, record);
    record.texelsRead = reader.GetNumber(root, "texelsPerPixel");
    record.texelsDecoded = reader.GetNumber(root, "texelsDecodedPerPixel");
    for (const auto& kind : reader.FindObject(root, "bytes").GetObject()) {
        if (!kind.value.IsUint64())
            reader.Refuse("bytes", "whole numbers");
        record.bytes.push_back({kind.name.GetString(), kind.value.GetUint64()});
    }
    for (const rapidjson::Value& shader : reader.FindArray(root, "permutations").GetArray()) {
        ++record.permutations;
        record.shaderWords += static_cast<std::uint64_t>(reader.GetNumber(shader, "words"));
        record.compileMilliseconds += reader.GetNumber(shader, "compileMilliseconds");
    }
}

} // namespace openntc::report
