// SPDX-License-Identifier: MIT
#include "report/Html.h"

#include "Output.h"
#include "report/Analysis.h"
#include "report/Cases.h"
#include "report/Changes.h"
#include "report/HtmlBlocks.h"
#include "report/HtmlFiltering.h"
#include "report/HtmlGenerations.h"
#include "report/HtmlScenes.h"
#include "report/HtmlTable.h"
#include "report/HtmlTraining.h"

#include <algorithm>
#include <cmath>

namespace openntc::report {

using tool::Format;

namespace {

constexpr const char* kStyle = R"(
:root { color-scheme: light; }
body { font: 16px/1.5 system-ui, 'Helvetica Neue', Arial, sans-serif; color: #1c1c1c; background: #fff; margin: 0 auto;
  max-width: 1132px; padding: 24px; }
h1 { font-size: 30px; margin: 0 0 4px; } h2 { font-size: 23px; margin: 48px 0 8px; border-bottom: 2px solid #1f6fb4; }
h3 { font-size: 18px; margin: 28px 0 6px; }
p { max-width: 860px; } .small, figcaption { color: #555; font-size: 14px; }
nav a { margin-right: 16px; }
figure { margin: 16px 0 28px; } figure svg { width: 100%; height: auto; border: 1px solid #ddd; background: #fff; }
table { border-collapse: collapse; font-size: 14px; margin: 12px 0; display: block; overflow-x: auto; }
th, td { padding: 4px 9px; border-bottom: 1px solid #ddd; text-align: right; white-space: nowrap; }
th { background: #f2f5f8; white-space: normal; vertical-align: bottom; }
table.dense { font-size: 11px; } .dense th, .dense td { padding: 2px 4px; } .dense td.text { white-space: normal; min-width: 120px; }
.warning { color: #b00000; font-weight: bold; } td.text, th.text { text-align: left; } td.note { text-align: left; white-space: normal; min-width: 150px; }
.changed { background: #fff0d6; } .bad { background: #fbdcdc; }
.pictures { display: flex; flex-wrap: wrap; gap: 12px; } .pictures figure { margin: 0; width: 288px; }
.pictures img { width: 288px; height: auto; image-rendering: pixelated; border: 1px solid #ccc; }
)";

std::string GetName(const CaseRecord& c) {
    return c.math + ", " + c.network + Format(", %g bpp", c.bitsPerPixel);
}

/// Names of cases; of many the first ones.
std::string ListNames(const std::vector<const CaseRecord*>& cases) {
    constexpr std::size_t kMost = 4;
    std::string text;
    for (std::size_t i = 0; i < std::min(kMost, cases.size()); ++i)
        text += (i > 0 ? "; " : "") + GetName(*cases[i]);
    return cases.size() > kMost ? text + Format("; and %zu more", cases.size() - kMost) : text;
}

class Page {
public:
    Page(const ReportRecord& report, const std::vector<Chart>& charts) : report_(report), charts_(charts) {}

    std::string Write() {
        html_ =
            "<!DOCTYPE html>\n<html lang=en><head><meta charset=utf-8><meta name=viewport "
            "content=\"width=device-width\">\n<title>OpenNTC: what accuracy costs in time</title>\n<style>" +
            std::string(kStyle) + "</style></head><body>\n";
        WriteTop();
        for (std::size_t i = 0; i < report_.devices.size(); ++i)
            WriteDevice(report_.devices[i], i + 1);
        WriteStreaming();
        html_ += WriteBlocks(report_, [this](const std::string& name) { return MakeFigure(name); });
        html_ += WriteFiltering(report_, [this](const std::string& name) { return MakeFigure(name); });
        html_ += WriteScenes(report_, [this](const std::string& name) { return MakeFigure(name); });
        html_ += WriteTraining(report_, [this](const std::string& name) { return MakeFigure(name); });
        WriteQuality();
        WritePictures();
        WriteChanges();
        WriteHardCases();
        WriteEncodings();
        WriteAllCases();
        return html_ + "</body></html>\n";
    }

private:
    void WriteChart(const std::string& name) { html_ += MakeFigure(name); }

    std::string MakeFigure(const std::string& name) const {
        for (const Chart& chart : charts_) {
            if (chart.name != name)
                continue;
            const std::size_t start = chart.svg.find("<svg");
            if (start == std::string::npos)
                break;
            // gnuplot gives the parts of every chart the same names; on one page they must differ.
            std::string svg = chart.svg.substr(start);
            for (const std::string& mark :
                 {std::string("id=\""), std::string("href=\"#"), std::string("href='#"), std::string("id='"),
                  std::string("url(#")}) {
                const std::string prefix = mark + name + "-";
                for (std::size_t at = svg.find(mark); at != std::string::npos;
                     at = svg.find(mark, at + prefix.size()))
                    svg.replace(at, mark.size(), prefix);
            }
            return "<figure>" + svg + "<figcaption>" + tool::EscapeMarkup(chart.caption) +
                   "</figcaption></figure>\n";
        }
        return {};
    }

    void WriteTop() {
        html_ += "<h1>What accuracy costs in time</h1>\n<p class=small>" + tool::EscapeMarkup(report_.tool) +
                 ", " + tool::EscapeMarkup(report_.date) + (report_.quick ? ", quick" : "") +
                 (report_.cancelled ? ", cancelled before its end" : "") +
                 ". Host: " + tool::EscapeMarkup(report_.cpu) +
                 Format(", %d hardware threads, load %.1f before. Measured in %.0f s; ", report_.cores,
                        report_.load, report_.seconds) +
                 (report_.cacheFilled > 0 ? Format("%d encodings were trained first, in %.0f s.",
                                                   report_.cacheFilled, report_.cacheSeconds)
                                          : "all encodings came from the cache.") +
                 "</p>\n";
        if (IsOverloaded(report_))
            html_ += Format(
                "<p class=warning>Load %.1f on %d hardware threads: other work ran beside the "
                "measurements, and times include waiting for it. Measure again on an idle machine.</p>\n",
                report_.load, report_.cores);
        html_ += "<nav>";
        for (std::size_t i = 0; i < report_.devices.size(); ++i)
            html_ += Format("<a href=\"#device-%zu\">", i + 1) + tool::EscapeMarkup(report_.devices[i].name) +
                     "</a>";
        if (!report_.streaming.empty())
            html_ += "<a href=\"#streaming\">streaming</a>";
        if (!report_.blocks.empty())
            html_ += "<a href=\"#blocks\">block compression</a>";
        if (!report_.filtering.empty())
            html_ += "<a href=\"#filtering\">filtering</a>";
        if (!report_.training.empty())
            html_ += "<a href=\"#training\">encoding</a>";
        html_ += "<a href=\"#quality\">quality</a><a href=\"#pictures\">pictures</a>";
        if (!report_.changes.empty())
            html_ += "<a href=\"#changes\">changes</a>";
        if (!report_.hardCases.empty())
            html_ += "<a href=\"#hard\">hard cases</a>";
        html_ += "<a href=\"#cases\">all cases</a></nav>\n";
        Table table({"<device", "~driver", "~kind", "~clock", "~features"});
        for (const DeviceRecord& d : report_.devices)
            table.Add({d.name, d.driver, d.kind, d.clock, d.features});
        html_ += table.Take();
        WriteSummary();
    }

    void WriteDevice(const DeviceRecord& device, std::size_t number) {
        html_ += Format("<h2 id=\"device-%zu\">", number) + tool::EscapeMarkup(device.name) + "</h2>\n";
        const std::string suffix = Format("-%zu", number);
        WriteChart("accuracy-time" + suffix);
        WriteAnswers(device);
        WriteChart("error-time" + suffix);
        WriteChart("effects" + suffix);
        WriteChart("maths" + suffix);
        WriteChart("sets" + suffix);
        WriteChart("generations" + suffix);
        html_ += WriteGenerations(report_, device);
    }

    /// A line for each device and maths mode: one material, and several in a workgroup.
    void WriteSummary() {
        Table table({"<device", "<maths mode", "one material: ns a texel, median (quartiles)", "PSNR, dB",
                     "1080p, ms (extrap.)", "1, by index: ns", "2 in a workgroup", "4", "8", "8 : one"});
        for (const DeviceRecord& device : report_.devices) {
            const std::vector<const CaseRecord*> sets = ListAxis(report_, device.name, "sets per workgroup");
            for (const CaseRecord* c : ListComparable(report_, device.name)) {
                if (c->network != "medium" || c->bitsPerPixel != Case{}.bitsPerPixel)
                    continue;
                std::vector<std::string> cells = {device.name, c->math, DescribeTime(c->time),
                                                  Number(c->accuracy.psnrSource, 2),
                                                  Short(c->extrapolated1080pMs)};
                double eight = NAN;
                for (const int count : {1, 2, 4, 8}) {
                    double time = NAN;
                    for (const CaseRecord* many : sets) {
                        if (many->math == c->math && many->sets == count)
                            time = many->time.median;
                    }
                    cells.push_back(Short(time));
                    eight = time;
                }
                cells.push_back(std::isnan(eight) ? "–" : Format("%.1f ×", eight / c->time.median));
                table.Add(cells);
            }
        }
        html_ += "<h3>At a glance: medium network, 4 bits per pixel, 9 outputs</h3>\n" + table.Take() +
                 "<p class=small>Several materials: neighbouring invocations of one workgroup decode "
                 "different sets, "
                 "which is what a frame with many materials does at their borders. “By index”: one set, "
                 "chosen by a "
                 "number that the compiler does not know.</p>\n";
    }

    void WriteAnswers(const DeviceRecord& device) {
        const std::vector<const CaseRecord*> cases = ListComparable(report_, device.name);
        const std::vector<QualityAnswer> qualities = AnswerQualities(cases);
        if (!cases.empty()) {
            html_ += "<h3>I can afford X ms: what is the best I get?</h3>\n";
            Table table({"X: from this on, ms a 1080p frame (extrap.)", "<best", "PSNR, dB",
                         "ns per texel, median (quartiles)", "memory, KiB",
                         "~less accurate, as fast: equal within spread"});
            for (const FrontPoint& point : ListParetoFront(cases)) {
                const CaseRecord& c = *point.best;
                table.Add({Short(c.extrapolated1080pMs), GetName(c), Number(c.accuracy.psnrSource, 2),
                           DescribeTime(c.time), Format("%.1f", static_cast<double>(c.memoryBytes) / 1024),
                           ListNames(point.asFast)});
            }
            html_ += table.Take();
        }
        if (!qualities.empty()) {
            html_ += "<h3>I need Y dB: what does it cost?</h3>\n";
            Table table({"Y, dB", "~fastest (several: equal within spread)", "ns per texel",
                         "1080p, ms (extrap.)", "4K, ms (extrap.)", "memory, KiB", "<smallest", "its KiB"});
            for (const QualityAnswer& a : qualities) {
                if (a.fastest.empty()) // the range ends here
                    continue;
                const CaseRecord& c = *a.fastest.front();
                table.Add({Format("%g", a.psnr), ListNames(a.fastest), DescribeTime(c.time),
                           Short(c.extrapolated1080pMs), Short(c.extrapolated4KMs),
                           Format("%.1f", static_cast<double>(c.memoryBytes) / 1024), GetName(*a.smallest),
                           Format("%.1f", static_cast<double>(a.smallest->memoryBytes) / 1024)});
            }
            html_ += table.Take();
        }
        html_ += "<p class=small>Times whose quartiles overlap are treated as equal: of those the most "
                 "accurate is "
                 "called best, and the first named is the smallest in memory. Frames are extrapolated: "
                 "median time "
                 "per texel × 1920 × 1080 or 3840 × 2160 pixels, one decoded texel each. They were not "
                 "rendered.</p>\n";
    }

    void WriteStreaming() {
        if (report_.streaming.empty())
            return;
        const StreamingRecord& first = report_.streaming.front();
        html_ +=
            "<h2 id=streaming>Streaming: less memory, or fewer tiles a frame</h2>\n" +
            Format(
                "<p>%d texture sets (copies of %s) in tiles, %d frames of a flight from far up down to a "
                "texel a "
                "pixel and up again, after the first picture was there. A budget of all tiles is %.1f KiB of "
                "slots. Shown is the wanted mip, or the finest coarser one whose tile is there.</p>\n",
                first.sets, tool::EscapeMarkup(first.encoding).c_str(), first.frames,
                static_cast<double>(first.allBytes) / 1024);
        WriteChart("streaming");
        Table table({"<case", "budget, tiles", "budget, KiB", "shown as wanted, %", "mips coarser, mean",
                     "PSNR against what was wanted, dB", "tiles loaded a frame", "KiB loaded a frame",
                     "ms a frame, median (quartiles)", "ms, slowest"});
        for (const StreamingRecord& r : report_.streaming)
            table.Add({r.id, std::to_string(r.budgetTiles),
                       Format("%.1f", static_cast<double>(r.budgetBytes) / 1024),
                       Format("%.2f", 100 * r.wantedShare), Format("%.4f", r.mipDeficit), Number(r.psnr, 2),
                       Format("%.1f", r.tilesLoaded), Format("%.1f", r.bytesLoaded / 1024),
                       DescribeTime(r.millisecondsAFrame), Short(r.millisecondsAFrame.maximum)});
        html_ += table.Take() + "<p class=small>Times are the loader's on one thread of the host, reading "
                                "from memory included; pictures "
                                "were not rendered: the texels that pixels show were looked up and compared. "
                                "The first frame that wants a "
                                "tile never has it, so that even a budget of all tiles is not exact while "
                                "the camera moves.</p>\n";
    }

    void WriteQuality() {
        html_ += "<h2 id=quality>Quality against size</h2>\n";
        for (const Chart& chart : charts_) {
            if (chart.name.rfind("quality-", 0) == 0)
                WriteChart(chart.name);
        }
    }

    void WritePictures() {
        html_ += "<h2 id=pictures>The pictures behind the numbers</h2>\n";
        std::string group;
        for (const PictureRecord& p : report_.pictures) {
            if (p.group != group)
                html_ += std::string(group.empty() ? "" : "</div>\n") + "<h3>" + tool::EscapeMarkup(p.group) +
                         "</h3>\n<div class=pictures>\n";
            group = p.group;
            html_ += "<figure><img alt=\"" + tool::EscapeMarkup(p.title + ", " + p.caption) +
                     "\" src=\"data:image/png;base64," + tool::EscapeMarkup(p.png) + "\"><figcaption><b>" +
                     tool::EscapeMarkup(p.title) + "</b><br>" + tool::EscapeMarkup(p.caption) +
                     "</figcaption></figure>\n";
        }
        html_ += group.empty() ? "<p>None in this report.</p>\n" : "</div>\n";
    }

    void WriteChanges() {
        if (report_.changes.empty())
            return;
        html_ += "<h2 id=changes>Against the report of " + tool::EscapeMarkup(report_.comparedWith) +
                 "</h2>\n<p class=small>" + tool::EscapeMarkup(kChangeRule) + "</p>\n";
        Table table({"<case", "<device", "old, ns", "new, ns", "new / old", "<time", "PSNR change, dB",
                     "worst error change, LSB", "<accuracy"});
        for (const ChangeRecord& c : report_.changes) {
            if (!c.missing.empty())
                table.Add(
                    {c.id, c.device, Short(c.oldMedian), Short(c.newMedian), "", c.missing, "", "", ""});
            else
                table.Add({c.id, c.device, Short(c.oldMedian), Short(c.newMedian), Format("%.3f", c.ratio),
                           c.changed ? "changed" : "noise", Format("%+.3f", c.psnrChange),
                           Format("%+.3f", c.worstLsbChange), c.accuracyChanged ? "changed" : "same"},
                          c.changed || c.accuracyChanged ? "changed" : "");
        }
        html_ += table.Take();
    }

    void WriteHardCases() {
        if (report_.hardCases.empty())
            return;
        html_ += "<h2 id=hard>Hard cases</h2>\n<p>Every case of the catalogue (docs/hard-cases.md says what "
                 "each is about), "
                 "with the worst error of all decoders against an independent model and the bound derived "
                 "for it. A bound "
                 "of 0 is bit for bit.</p>\n";
        Table table({"<case", "worst error", "bound", "<", "~note"});
        for (const HardCaseRecord& c : report_.hardCases) {
            const bool within = c.worst <= c.bound;
            table.Add({c.name, Format("%.3g", c.worst), Format("%.3g", c.bound),
                       within ? "within" : "EXCEEDED", c.note},
                      within ? "" : "bad");
        }
        html_ += table.Take();
    }

    void WriteEncodings() {
        html_ += "<h2>Encodings</h2>\n";
        Table table({"<encoding", "size", "mips", "channels", "<latent shape", "steps", "PSNR all mips, dB",
                     "file, bytes", "in memory, bytes", "bits per texel with mips"});
        for (const EncodingRecord& e : report_.encodings) {
            std::string shape;
            for (const int n : e.latentShape)
                shape += (shape.empty() ? "" : ", ") + std::to_string(n);
            table.Add({e.name, Format("%d × %d", e.width, e.height), std::to_string(e.mips),
                       std::to_string(e.channels), shape, std::to_string(e.steps), Number(e.psnr, 2),
                       std::to_string(e.fileBytes), std::to_string(e.memoryBytes),
                       Number(e.trueBitsPerPixel, 2)});
        }
        html_ += table.Take() +
                 "<p class=small>Latent shape: grid scale, features and bits of the high- and low-resolution "
                 "latents. In "
                 "memory: latents of all mips, Int8 weights, constants. Files hold an FP8 network too.</p>\n";
    }

    void WriteAllCases() {
        html_ += "<h2 id=cases>All cases</h2>\n<p class=small>Accuracy is that of mip 0, over the outputs "
                 "that the case reads; "
                 "of linear cases in linear light. LSB: 1/255. “Other bits”: values that differ from the C++ "
                 "decoder of the "
                 "same maths mode. sRGB values above 1 and below 0 count as they are.</p>\n";
        for (const DeviceRecord& device : report_.devices) {
            Table table({"<case", "ns/texel, median", "quartiles", "range", "repeats", "1080p, ms (extrap.)",
                         "4K, ms (extrap.)", "PSNR source", "SSIM", "worst LSB", "PSNR FP32", "SSIM FP32",
                         "worst LSB FP32", "99 % LSB FP32", "other bits", "file, bytes", "memory, bytes"},
                        true);
            std::string skipped;
            for (const CaseRecord& c : report_.cases) {
                if (c.device != device.name)
                    continue;
                if (!c.skipped.empty()) {
                    skipped += "<li>" + tool::EscapeMarkup(c.id + ": " + c.skipped) + "</li>\n";
                    continue;
                }
                const Accuracy& a = c.accuracy;
                table.Add({c.id, Short(c.time.median),
                           Short(c.time.lowerQuartile) + " – " + Short(c.time.upperQuartile),
                           Short(c.time.minimum) + " – " + Short(c.time.maximum),
                           std::to_string(c.time.repeats), Short(c.extrapolated1080pMs),
                           Short(c.extrapolated4KMs), Number(a.psnrSource, 2), Number(a.ssimSource, 4),
                           Number(a.worstLsbSource, 1), Number(a.psnrFp32, 2), Number(a.ssimFp32, 5),
                           Number(a.worstLsbFp32, 3), Number(a.percentile99LsbFp32, 3),
                           Format("%llu of %llu", static_cast<unsigned long long>(a.differentFromReference),
                                  static_cast<unsigned long long>(a.comparedWithReference)),
                           std::to_string(c.fileBytes), std::to_string(c.memoryBytes)});
            }
            html_ += "<h3>" + tool::EscapeMarkup(device.name) + "</h3>\n" + table.Take();
            if (!skipped.empty())
                html_ += "<details><summary>Not measured here</summary><ul class=small>" + skipped +
                         "</ul></details>\n";
        }
    }

    const ReportRecord& report_;
    const std::vector<Chart>& charts_;
    std::string html_;
};

} // namespace

std::string WriteHtml(const ReportRecord& report, const std::vector<Chart>& charts) {
    return Page(report, charts).Write();
}

} // namespace openntc::report
