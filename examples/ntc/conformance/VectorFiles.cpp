// SPDX-License-Identifier: MIT
#include "VectorFiles.h"

#include <rapidjson/document.h>

#include <limits>
#include <string>

namespace openntc::conformance {

namespace {

using Json = rapidjson::Value;

// Looks up members and remembers the first thing that was wrong.
class Reader {
public:
    const std::string& GetProblem() const { return problem_; }

    void Report(const std::string& key, const char* limit) {
        if (problem_.empty())
            problem_ = key + ": " + limit;
    }

    static const Json* Find(const Json& object, const char* key) {
        const auto member = object.FindMember(key);
        return member == object.MemberEnd() ? nullptr : &member->value;
    }

    std::optional<int> Int(const Json& object, const char* key) {
        const Json* value = Find(object, key);
        if (value == nullptr)
            return std::nullopt;
        if (!value->IsInt()) {
            Report(key, "not an integer of 32 bits");
            return std::nullopt;
        }
        return value->GetInt();
    }

    int RequiredInt(const Json& object, const char* key) {
        const std::optional<int> value = Int(object, key);
        if (!value)
            Report(key, "missing");
        return value.value_or(0);
    }

    std::uint64_t Uint64(const Json& object, const char* key) {
        const Json* value = Find(object, key);
        if (value == nullptr || !value->IsUint64()) {
            Report(key, "not an unsigned integer");
            return 0;
        }
        return value->GetUint64();
    }

    std::uint32_t Uint32(const Json& object, const char* key) {
        const std::uint64_t value = Uint64(object, key);
        if (value > std::numeric_limits<std::uint32_t>::max())
            Report(key, "more than 32 bits");
        return static_cast<std::uint32_t>(value);
    }

    // The array, or null if the key is absent.
    const Json* Array(const Json& object, const char* key) {
        const Json* value = Find(object, key);
        if (value != nullptr && !value->IsArray()) {
            Report(key, "not an array");
            return nullptr;
        }
        return value;
    }

    std::vector<std::byte> Hex(const Json& object, const char* key) {
        const Json* value = Find(object, key);
        std::vector<std::byte> bytes;
        if (value == nullptr || !value->IsString() || value->GetStringLength() % 2 != 0) {
            Report(key, "not an even number of hexadecimal digits");
            return bytes;
        }
        unsigned pending = 0;
        for (rapidjson::SizeType i = 0; i < value->GetStringLength(); ++i) {
            const char c = value->GetString()[i];
            unsigned digit = 0;
            if (c >= '0' && c <= '9')
                digit = static_cast<unsigned>(c - '0');
            else if (c >= 'a' && c <= 'f')
                digit = static_cast<unsigned>(c - 'a') + 10;
            else if (c >= 'A' && c <= 'F')
                digit = static_cast<unsigned>(c - 'A') + 10;
            else
                Report(key, "not hexadecimal");
            if (i % 2 == 0)
                pending = digit;
            else
                bytes.push_back(static_cast<std::byte>(pending * 16 + digit));
        }
        return bytes;
    }

private:
    std::string problem_;
};

void ReadWeights(Reader& reader, const Json& root, const char* key, std::optional<WeightExpectation>& weights,
                 bool& absent) {
    const Json* value = Reader::Find(root, key);
    if (value == nullptr)
        return;
    if (value->IsNull()) {
        absent = true;
        return;
    }
    if (!value->IsObject()) {
        reader.Report(key, "not an object");
        return;
    }
    weights = WeightExpectation{reader.Uint64(*value, "weightBytes"), reader.Uint32(*value, "weightCrc32"),
                                reader.Hex(*value, "constants")};
}

void ReadRanges(Reader& reader, const Json& root, std::vector<RangeExpectation>& ranges) {
    const Json* array = reader.Array(root, "streamRanges");
    if (array == nullptr)
        return;
    for (const Json& entry : array->GetArray()) {
        if (!entry.IsObject()) {
            reader.Report("streamRanges", "not an array of objects");
            return;
        }
        ranges.push_back({reader.RequiredInt(entry, "firstMip"), reader.RequiredInt(entry, "numMips"),
                          reader.Uint64(entry, "offset"), reader.Uint64(entry, "size")});
    }
}

void ReadFusedMips(Reader& reader, const Json& root, std::vector<std::array<int, 2>>& fusedMips) {
    const Json* array = reader.Array(root, "fusedMips");
    if (array == nullptr)
        return;
    for (const Json& entry : array->GetArray()) {
        if (!entry.IsArray() || entry.Size() != 2 || !entry[0].IsInt() || !entry[1].IsInt()) {
            reader.Report("fusedMips", "not an array of pairs of integers");
            return;
        }
        fusedMips.push_back({entry[0].GetInt(), entry[1].GetInt()});
    }
}

} // namespace

Expected<Expectations> ReadExpectations(std::span<const std::byte> json) {
    rapidjson::Document root;
    root.Parse<rapidjson::kParseIterativeFlag>(reinterpret_cast<const char*>(json.data()), json.size());
    if (root.HasParseError())
        return Fail(Status::FileUnrecognized, "JSON: syntax error at byte %zu", root.GetErrorOffset());
    if (!root.IsObject())
        return Fail(Status::FileUnrecognized, "JSON: not an object");

    Reader reader;
    Expectations result;
    result.width = reader.Int(root, "width");
    result.height = reader.Int(root, "height");
    result.channels = reader.Int(root, "channels");
    result.mips = reader.Int(root, "mips");
    result.networkVersion = reader.Int(root, "networkVersion");
    result.latentImages = reader.Int(root, "latentImages");
    if (const Json* shape = Reader::Find(root, "latentShape")) {
        if (shape->IsObject())
            result.latentShape = Expectations::Shape{
                reader.RequiredInt(*shape, "highResFeatures"), reader.RequiredInt(*shape, "lowResFeatures"),
                reader.RequiredInt(*shape, "highResQuantBits"), reader.RequiredInt(*shape, "lowResQuantBits"),
                reader.Int(*shape, "gridSizeScale")};
        else
            reader.Report("latentShape", "not an object");
    }
    if (Reader::Find(root, "validChannelMask") != nullptr)
        result.validChannelMask = reader.Uint32(root, "validChannelMask");
    if (const Json* spaces = reader.Array(root, "channelColorSpaces")) {
        for (const Json& entry : spaces->GetArray()) {
            if (!entry.IsInt())
                reader.Report("channelColorSpaces", "not an array of integers");
            result.channelColorSpaces.push_back(entry.IsInt() ? entry.GetInt() : -1);
        }
    }
    ReadFusedMips(reader, root, result.fusedMips);
    ReadRanges(reader, root, result.streamRanges);
    ReadWeights(reader, root, "GenericInt8", result.int8, result.int8Absent);
    ReadWeights(reader, root, "GenericFP8", result.fp8, result.fp8Absent);
    if (!reader.GetProblem().empty())
        return Fail(Status::FileUnrecognized, "%s", reader.GetProblem().c_str());
    return result;
}

} // namespace openntc::conformance
