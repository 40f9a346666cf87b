// SPDX-License-Identifier: MIT
#include "LoadTable.h"

#include "Json.h"
#include "Output.h"
#include "TextureSizes.h"

namespace openntc::load_time {

namespace {

using tool::Format;

std::string FormatStage(double milliseconds) {
    return milliseconds > 0.0 ? Format("%.2f", milliseconds) : std::string("-");
}

std::string Describe(const LoadTimes& times, const LoadOptions& options) {
    return Format("%zu sets, %llu textures, %.2f Mtexel with all mips; ", times.sets.size(),
                  static_cast<unsigned long long>(times.textures), static_cast<double>(times.texels) / 1e6) +
           "decoder " + GetName(options.backend.backend) + " on " + tool::Printable(times.device) +
           ", blocks " + tool::GetName(options.effort) +
           (options.backend.backend == tool::Backend::Vulkan ? " there too" : " on the CPU") +
           (times.hintBytes > 0 ? ", BC7 with hints (" + tool::FormatBytes(times.hintBytes) + ")" : "") +
           (std::string_view(times.decompressor) != "none"
                ? std::string(", latents decompressed by ") + times.decompressor
                : std::string()) +
           Format(", medians of %d runs, files in the system's cache", options.repeat);
}

} // namespace

std::string MakeText(const LoadTimes& times, const LoadOptions& options) {
    std::string text =
        Describe(times, options) + "\n" +
        Format("%-14s %12s %9s %9s %9s %13s %9s %9s %9s %12s\n", "", "on disk", "read ms", "parse ms",
               "upload ms", "decompress ms", "decode ms", "blocks ms", "total ms", "in memory");
    for (const LoadWay& way : times.ways)
        text += Format("%-14s %12s %9s %9s %9s %13s %9s %9s %9.2f %12s\n", way.name,
                       tool::FormatBytes(way.diskBytes).c_str(), FormatStage(way.times.read).c_str(),
                       FormatStage(way.times.parse).c_str(), FormatStage(way.times.upload).c_str(),
                       FormatStage(way.times.decompress).c_str(), FormatStage(way.times.decode).c_str(),
                       FormatStage(way.times.transcode).c_str(), way.times.GetTotal(),
                       tool::FormatBytes(way.memoryBytes).c_str());
    for (const std::string& texture : times.uncompressed)
        text += "not in blocks: " + tool::Printable(texture) + "\n";
    return text;
}

std::string MakeMarkdown(const LoadTimes& times, const LoadOptions& options) {
    std::string text = "| | on disk | read ms | parse ms | upload ms | decompress ms | decode ms | blocks ms "
                       "| total ms | in memory |\n"
                       "|---|---|---|---|---|---|---|---|---|---|\n";
    for (const LoadWay& way : times.ways)
        text += std::string("| ") + way.name + " | " + tool::FormatBytes(way.diskBytes) + " | " +
                FormatStage(way.times.read) + " | " + FormatStage(way.times.parse) + " | " +
                FormatStage(way.times.upload) + " | " + FormatStage(way.times.decompress) + " | " +
                FormatStage(way.times.decode) + " | " + FormatStage(way.times.transcode) + " | " +
                Format("%.2f", way.times.GetTotal()) + " | " + tool::FormatBytes(way.memoryBytes) + " |\n";
    return text + "\n*" + Describe(times, options) + ".*\n";
}

std::string MakeJson(const LoadTimes& times, const LoadOptions& options) {
    tool::JsonWriter json;
    json.BeginObject();
    json.Key("sets");
    json.BeginArray();
    for (const std::string& set : times.sets)
        json.Value(std::string_view(set));
    json.EndArray();
    json.Member("textures", times.textures);
    json.Member("texels", times.texels);
    json.Member("backend", GetName(options.backend.backend));
    json.Member("device", std::string_view(times.device));
    json.Member("decompress", times.decompressor);
    json.Member("quality", tool::GetName(options.effort));
    json.Member("repeat", options.repeat);
    json.Member("hintBytes", times.hintBytes);
    json.Member("blocksCrc32", times.blocksCrc32);
    json.Key("ways");
    json.BeginArray();
    for (const LoadWay& way : times.ways) {
        json.BeginObject();
        json.Member("name", way.name);
        json.Member("diskBytes", way.diskBytes);
        json.Member("memoryBytes", way.memoryBytes);
        json.Member("readMilliseconds", way.times.read);
        json.Member("parseMilliseconds", way.times.parse);
        json.Member("uploadMilliseconds", way.times.upload);
        json.Member("decompressMilliseconds", way.times.decompress);
        json.Member("decodeMilliseconds", way.times.decode);
        json.Member("transcodeMilliseconds", way.times.transcode);
        json.Member("totalMilliseconds", way.times.GetTotal());
        json.EndObject();
    }
    json.EndArray();
    json.Key("uncompressed");
    json.BeginArray();
    for (const std::string& texture : times.uncompressed)
        json.Value(std::string_view(texture));
    json.EndArray();
    json.EndObject();
    return json.Take();
}

} // namespace openntc::load_time
