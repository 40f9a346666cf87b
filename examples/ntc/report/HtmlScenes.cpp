// SPDX-License-Identifier: MIT
#include "report/HtmlScenes.h"

#include "Output.h"
#include "report/Analysis.h"
#include "report/HtmlTable.h"
#include "report/Scenes.h"

#include <algorithm>

namespace openntc::report {

using tool::EscapeMarkup;
using tool::Format;

namespace {

bool IsRow(const SceneRecord& r) {
    return r.effects == "derived" && r.scene != kEverything;
}

std::string Kibibytes(std::uint64_t bytes) {
    return Format("%.1f", static_cast<double>(bytes) / 1024);
}

/// Kinds that anything has, in the order of the renderer.
std::vector<std::string> ListKinds(const std::vector<const SceneRecord*>& rows) {
    std::vector<std::string> kinds;
    for (const SceneRecord* r : rows) {
        for (const SceneBytes& b : r->bytes) {
            if (b.bytes > 0 && b.kind != "textures" &&
                std::find(kinds.begin(), kinds.end(), b.kind) == kinds.end())
                kinds.push_back(b.kind);
        }
    }
    return kinds;
}

std::string WriteDeliveries(const ReportRecord& report, const std::vector<const SceneRecord*>& rows) {
    std::vector<std::string> headings = {"<delivery",    "<filter",  "ms a frame, median (quartiles)",
                                         "visibility",   "shading",  "texels read",
                                         "decoded",      "PSNR, dB", "FLIP",
                                         "textures, KiB"};
    const std::vector<std::string> kinds = ListKinds(rows);
    for (const std::string& kind : kinds)
        headings.push_back(kind + ", KiB");
    headings.emplace_back("<front");
    Table table(headings, true);
    for (const SceneRecord* r : rows) {
        std::vector<std::string> cells = {DescribeDelivery(*r),
                                          r->filter,
                                          DescribeTime(r->time),
                                          Short(r->visibility),
                                          Short(r->shading),
                                          Format("%.2f", r->texelsRead),
                                          Format("%.2f", r->texelsDecoded),
                                          Number(r->psnr, 2),
                                          Format("%.4f", r->flip),
                                          Kibibytes(r->GetBytes("textures"))};
        for (const std::string& kind : kinds)
            cells.push_back(Kibibytes(r->GetBytes(kind.c_str())));
        cells.emplace_back(IsOnSceneFront(report, *r) ? "yes" : "");
        table.Add(cells);
    }
    return table.Take();
}

/// Every effect on beside the derived set.
std::string WriteEffects(const ReportRecord& report, const std::string& device) {
    Table table({"<scene", "<effects", "~on", "permutations", "SPIR-V, KiB", "compiled, ms",
                 "ms a frame, median (quartiles)", "visibility", "shading", "texels read", "decoded",
                 "textures, KiB", "PSNR, dB", "<picture"},
                true);
    bool isEmpty = true;
    for (const SceneRecord& r : report.scenes) {
        const auto isForced = [&](const SceneRecord& other) { // of the same case, skipped or not
            return other.device == device && other.id.starts_with(r.id + " effects ");
        };
        const bool isDerived = r.effects == "derived";
        if (r.device != device || !r.skipped.empty() ||
            (isDerived && std::none_of(report.scenes.begin(), report.scenes.end(), isForced)))
            continue;
        std::string on;
        for (const std::string& effect : r.effectsOn)
            on += (on.empty() ? "" : ", ") + effect;
        table.Add({r.scene, isDerived ? "that it calls for" : "and " + r.effects, isDerived ? on : "",
                   std::to_string(r.permutations), Kibibytes(4 * r.shaderWords), Short(r.compileMilliseconds),
                   DescribeTime(r.time), Short(r.visibility), Short(r.shading), Format("%.2f", r.texelsRead),
                   Format("%.2f", r.texelsDecoded), Kibibytes(r.GetBytes("textures")), Number(r.psnr, 2),
                   isDerived ? ""
                   : r.otherPixels == 0
                       ? "the same bits"
                       : Format("%llu pixels differ", static_cast<unsigned long long>(r.otherPixels))});
        isEmpty = false;
    }
    if (isEmpty)
        return {};
    return "<h3 id=effects>Effects: those that the scene calls for, and all</h3>\n" + table.Take() +
           "<p class=small>One permutation of a shader is compiled for each set of effects that a material "
           "has. "
           "With all on, a material reads textures that it does not have (one white texel), decodes all "
           "channels, "
           "clamps texels and looks for slices.</p>\n";
}

std::string WriteSkipped(const ReportRecord& report, const std::string& device) {
    std::string skipped;
    std::size_t count = 0;
    for (const SceneRecord& r : report.scenes) {
        if (r.device == device && !r.skipped.empty()) {
            skipped += "<li>" + EscapeMarkup(r.id + ": " + r.skipped) + "</li>\n";
            ++count;
        }
    }
    return count == 0 ? ""
                      : Format("<details><summary>Not drawn here: %zu</summary><ul class=small>", count) +
                            skipped + "</ul></details>\n";
}

} // namespace

std::vector<const SceneRecord*> ListDeliveries(const ReportRecord& report, const std::string& device) {
    std::vector<const SceneRecord*> rows;
    for (const SceneRecord& r : report.scenes) {
        if (r.device == device && r.skipped.empty() && IsRow(r))
            rows.push_back(&r);
    }
    return rows;
}

bool IsOnSceneFront(const ReportRecord& report, const SceneRecord& record) {
    for (const SceneRecord& other : report.scenes) {
        if (&other == &record || !other.skipped.empty() || !IsRow(other) || other.device != record.device ||
            other.scene != record.scene || other.filter != record.filter || other.width != record.width)
            continue;
        const bool isEqual = IsEqualWithinSpread(other.time, record.time);
        const bool isFaster = other.time.median < record.time.median && !isEqual;
        const std::uint64_t bytes = record.GetBytes("textures"), otherBytes = other.GetBytes("textures");
        if ((isFaster || isEqual) && other.psnr >= record.psnr && otherBytes <= bytes &&
            (isFaster || other.psnr > record.psnr || otherBytes < bytes))
            return false;
    }
    return true;
}

std::string DescribeDelivery(const SceneRecord& record) {
    std::string text = record.mode;
    if (!record.blocks.empty())
        text += record.blocks == "none" ? ", texels" : ", blocks";
    const std::pair<const char*, const char*> kNames[] = {{"off", "all texels"},
                                                          {"one-tap", "one texel"},
                                                          {"2x2", "2 × 2 share"},
                                                          {"collaborative", "waves collaborate"}};
    for (const auto& [name, words] : kNames) {
        if (record.stf == name)
            text += std::string(", ") + words;
    }
    return text + (record.math.empty() ? "" : ", " + record.math);
}

std::string WriteScenes(const ReportRecord& report,
                        const std::function<std::string(const std::string&)>& getFigure) {
    if (report.scenes.empty())
        return {};
    std::string html = "<h2 id=scenes>Scenes: filter, delivery and what the effects cost</h2>\n";
    std::size_t number = 0;
    for (const DeviceRecord& device : report.devices) {
        const std::vector<const SceneRecord*> rows = ListDeliveries(report, device.name);
        const std::string skipped = WriteSkipped(report, device.name);
        const std::string effects = WriteEffects(report, device.name);
        if (rows.empty() && skipped.empty() && effects.empty())
            continue;
        html += "<h3>" + EscapeMarkup(device.name) + "</h3>\n";
        if (!rows.empty()) {
            const SceneRecord& first = *rows.front();
            html += Format("<p>Scene %s, %d × %d pixels, the mean of %d frames, drawn by ntc-renderer.</p>\n",
                           EscapeMarkup(first.scene).c_str(), first.width, first.height, first.frames) +
                    getFigure(Format("scenes-%zu", ++number)) + WriteDeliveries(report, rows);
        }
        html += effects + skipped;
    }
    return html + "<p class=small>Milliseconds are the device's, of the frames after the first. Texels are "
                  "per pixel and "
                  "frame. PSNR and FLIP: of the mean of the frames, against the reference mode (source "
                  "images, mips of "
                  "the same filter) with all texels of the same filter and the same jitter. Front: no other "
                  "row of the "
                  "same filter is as fast, as close and as small and better in one of these.</p>\n";
}

} // namespace openntc::report
