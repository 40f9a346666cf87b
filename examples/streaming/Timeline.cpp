// SPDX-License-Identifier: MIT
#include "Timeline.h"

#include "Json.h"
#include "Output.h"
#include "TextureSizes.h"
#include "report/ChartScript.h"

#include <algorithm>

namespace openntc::landscape {

using tool::Format;
using tool::FormatBytes;

namespace {

constexpr double kMebibyte = 1048576.0;

void WriteFrame(tool::JsonWriter& json, const FrameRecord& frame) {
    json.BeginObject();
    json.Member("passes", frame.passes);
    json.Member("complete", frame.isComplete);
    json.Member("wantedTiles", frame.wanted);
    json.Member("missingTiles", frame.missing);
    json.Member("residentTiles", frame.resident);
    json.Member("loadedTiles", frame.loaded);
    json.Member("evictedTiles", frame.evicted);
    json.Member("requests", frame.requested);
    json.Member("residentBytes", frame.residentBytes);
    json.Member("milliseconds", frame.milliseconds);
    json.Member("passMilliseconds", frame.passMilliseconds);
    json.Member("loaderMilliseconds", frame.loaderMilliseconds);
    json.Member("waitMilliseconds", frame.waitMilliseconds);
    json.Member("checkedTexels", frame.checkedTexels);
    json.Member("wrongTexels", frame.wrongTexels);
    json.EndObject();
}

/// A column for every curve; the first is the frame's number.
std::string MakeRows(const Report& report) {
    std::string rows;
    for (std::size_t i = 0; i < report.frames.size(); ++i) {
        const FrameRecord& f = report.frames[i];
        rows += Format("%zu %u %u %llu %llu %d %g %g %g %g\n", i, f.wanted, f.resident,
                       static_cast<unsigned long long>(f.loaded), static_cast<unsigned long long>(f.evicted),
                       f.passes, static_cast<double>(f.residentBytes) / kMebibyte, f.milliseconds,
                       f.passMilliseconds, f.loaderMilliseconds);
    }
    return rows;
}

} // namespace

std::uint64_t Report::GetWrongTexels() const noexcept {
    std::uint64_t wrong = 0;
    for (const FrameRecord& frame : frames)
        wrong += frame.wrongTexels;
    return wrong;
}

std::uint64_t Report::GetCheckedTexels() const noexcept {
    std::uint64_t checked = 0;
    for (const FrameRecord& frame : frames)
        checked += frame.checkedTexels;
    return checked;
}

std::string MakeJson(const Report& report) {
    tool::JsonWriter json;
    json.BeginObject();
    json.Member("device", std::string_view(report.device));
    json.Member("driver", std::string_view(report.driver));
    json.Member("columns", report.landscape.columns);
    json.Member("rows", report.landscape.rows);
    json.Member("setSize", report.landscape.setSize);
    json.Member("tileSize", report.landscape.tileSize);
    json.Member("width", report.width);
    json.Member("height", report.height);
    json.Member("texels", report.texels);
    json.Member("tiles", report.tiles);
    json.Key("memory");
    json.BeginObject();
    json.Member("budgetBytes", report.budgetBytes);
    json.Member("slots", report.slots);
    json.Member("slotBytes", report.slotBytes);
    json.Member("tableBytes", report.tableBytes);
    json.Member("allResidentBytes", report.allResidentBytes);
    json.Member("blockCompressedBytes", report.blockCompressedBytes);
    std::uint64_t most = 0;
    for (const FrameRecord& frame : report.frames)
        most = std::max(most, frame.residentBytes);
    json.Member("mostResidentBytes", most);
    json.EndObject();
    json.Key("frames");
    json.BeginArray();
    for (const FrameRecord& frame : report.frames)
        WriteFrame(json, frame);
    json.EndArray();
    json.Member("checkedTexels", report.GetCheckedTexels());
    json.Member("wrongTexels", report.GetWrongTexels());
    if (report.comparison) {
        json.Key("comparison");
        json.BeginObject();
        json.Member("pixels", report.comparison->pixels);
        json.Member("differentPixels", report.comparison->differentPixels);
        json.EndObject();
    }
    json.Member("seconds", report.seconds);
    json.Key("files");
    json.BeginArray();
    for (const std::string& file : report.files)
        json.Value(std::string_view(file));
    json.EndArray();
    json.EndObject();
    return json.Take();
}

std::string MakeText(const Report& report) {
    std::uint64_t most = 0, loaded = 0, evicted = 0;
    int passes = 0, complete = 0;
    for (const FrameRecord& frame : report.frames) {
        most = std::max(most, frame.residentBytes);
        loaded += frame.loaded;
        evicted += frame.evicted;
        passes += frame.passes;
        complete += frame.isComplete ? 1 : 0;
    }
    std::string text = Format("%s, driver %s\n", tool::Printable(report.device).c_str(),
                              tool::Printable(report.driver).c_str());
    text += Format("  landscape  %d x %d sets of %d x %d texels: %.2f Gitexels, %u tiles\n",
                   report.landscape.columns, report.landscape.rows, report.landscape.setSize,
                   report.landscape.setSize, static_cast<double>(report.texels) / 1073741824.0, report.tiles);
    text += Format("  memory     at most %s in tiles, of a pool of %s; page table and launch state %s\n",
                   FormatBytes(most).c_str(), FormatBytes(report.budgetBytes).c_str(),
                   FormatBytes(report.tableBytes).c_str());
    text += Format("  instead    all latents %s, all textures in BC7, BC5 and BC4 %s\n",
                   FormatBytes(report.allResidentBytes).c_str(),
                   FormatBytes(report.blockCompressedBytes).c_str());
    text += Format("  frames     %zu of %d x %d, %d of them complete, in %d passes\n", report.frames.size(),
                   report.width, report.height, complete, passes);
    text += Format("  tiles      %llu loaded, %llu evicted\n", static_cast<unsigned long long>(loaded),
                   static_cast<unsigned long long>(evicted));
    text += Format("  checked    %llu texels against the C++ decoder: %llu differ\n",
                   static_cast<unsigned long long>(report.GetCheckedTexels()),
                   static_cast<unsigned long long>(report.GetWrongTexels()));
    if (report.comparison)
        text += Format("  compared   %llu pixels with all latents resident: %llu differ\n",
                       static_cast<unsigned long long>(report.comparison->pixels),
                       static_cast<unsigned long long>(report.comparison->differentPixels));
    text += Format("  time       %.1f s\n", report.seconds);
    return text;
}

std::string DrawTimeline(const Report& report, const std::filesystem::path& folder) {
    report::ChartScript script(folder);
    const std::string title =
        Format("%d sets of %d x %d texels, streamed", report.landscape.columns * report.landscape.rows,
               report.landscape.setSize, report.landscape.setSize);
    script.Begin("timeline", title,
                 "Tiles, bytes, milliseconds and passes of each frame along the camera's path.", 1160);
    const std::string data = script.MakeBlock(MakeRows(report));
    const std::string with = " with lines lw 2 lc rgb ";
    const auto curve = [&](int column, const char* color, const char* name) {
        return data + " using 1:" + std::to_string(column) + with + "'" + color + "' title '" + name + "'";
    };
    const auto level = [&](double mebibytes, const char* color, const std::string& name) {
        return Format("%g", mebibytes) + with + "'" + color + "' dt 2 title '" + name + "'";
    };
    const auto toMebibytes = [](std::uint64_t bytes) { return static_cast<double>(bytes) / kMebibyte; };
    script.Add(
        "set multiplot layout 4,1\nset lmargin 11\nset rmargin 3\nset key outside top center horizontal\n" +
        Format("set xrange [0:%zu]\n", std::max<std::size_t>(report.frames.size(), 2) - 1));
    script.Add("set ylabel 'tiles'\nset yrange [0:*]\nplot " + curve(3, "#1f6fb4", "resident") + ", " +
               curve(2, "#5a5a5a", "wanted") + ", " + curve(4, "#17a2a2", "loaded") + ", " +
               curve(5, "#d1495b", "evicted") + "\nset title ''\n");
    script.Add("set ylabel 'MiB (logarithmic)'\nset logscale y\nset yrange [*:*]\nplot " +
               level(toMebibytes(report.blockCompressedBytes), "#b0436e", "all textures block-compressed") +
               ", " + level(toMebibytes(report.allResidentBytes), "#8e6bbf", "all latents") + ", " +
               level(toMebibytes(report.budgetBytes), "#e08a00", "budget") + ", " +
               curve(7, "#1f6fb4", "resident latents") + "\nunset logscale y\n");
    script.Add("set ylabel 'ms per frame'\nset yrange [0:*]\nplot " + curve(8, "#5a5a5a", "frame") + ", " +
               curve(9, "#1f6fb4", "passes on the device") + ", " +
               curve(10, "#d1495b", "loader and uploads") + "\n");
    script.Add("set ylabel 'passes to completion'\nset xlabel 'frame'\nplot " + data +
               " using 1:6 with steps lw 2 lc rgb '#1f6fb4' notitle\nunset multiplot\n");
    return script.Run().front().svg;
}

} // namespace openntc::landscape
