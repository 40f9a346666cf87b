// SPDX-License-Identifier: MIT
#include "report/HtmlBlocks.h"

#include "Output.h"
#include "report/HtmlTable.h"

#include <algorithm>
#include <vector>

namespace openntc::report {

using tool::Format;

namespace {

std::string WriteSizes(const ReportRecord& report) {
    Table table({"<all textures and mips of", "raw texels, KiB", "blocks, KiB", "blocks : raw",
                 "set in memory, KiB", "set : raw", "file, KiB", "~block formats"});
    for (const BlockSizeRecord& r : report.blockSizes) {
        std::string formats;
        for (const std::string& format : r.formats)
            formats += (formats.empty() ? "" : ", ") + format;
        const auto kib = [](std::uint64_t bytes) {
            return Format("%.1f", static_cast<double>(bytes) / 1024);
        };
        const auto share = [&](std::uint64_t bytes) {
            return Format("%.1f %%", 100 * static_cast<double>(bytes) / static_cast<double>(r.rawBytes));
        };
        table.Add({r.encoding, kib(r.rawBytes), kib(r.blockBytes), share(r.blockBytes), kib(r.memoryBytes),
                   share(r.memoryBytes), kib(r.fileBytes), formats});
    }
    return table.Take();
}

/// The record of a case on one way, or null.
const BlockRecord* FindBlocks(const ReportRecord& report, const std::string& id, const BlockWay& way) {
    for (const BlockRecord& r : report.blocks) {
        if (r.id == id && r.skipped.empty() && BlockWay{r.device, r.threads} == way)
            return &r;
    }
    return nullptr;
}

std::string WriteQuality(const ReportRecord& report, const std::vector<BlockWay>& ways) {
    std::vector<std::string> headings = {"<format",
                                         "<level",
                                         "~texture",
                                         "PSNR against the decoded texels, dB",
                                         "against the source, dB",
                                         "without blocks, dB"};
    for (const BlockWay& way : ways) {
        headings.push_back(way.GetName() + ": Mtexel/s, median (quartiles)");
        headings.push_back("2048 × 2048, ms (extrap.)");
    }
    Table table(headings, true);
    std::vector<std::string> done;
    for (const BlockRecord& r : report.blocks) {
        if (!r.skipped.empty() || std::find(done.begin(), done.end(), r.id) != done.end())
            continue;
        done.push_back(r.id);
        std::vector<std::string> cells = {r.format,
                                          r.level,
                                          r.texture,
                                          Number(r.psnrDecoded, 2),
                                          Number(r.psnrSource, 2),
                                          Number(r.psnrSourceBefore, 2)};
        for (const BlockWay& way : ways) {
            const BlockRecord* found = FindBlocks(report, r.id, way);
            cells.push_back(found == nullptr ? "–"
                                             : Short(1e3 / found->time.median) + " (" +
                                                   Short(1e3 / found->time.upperQuartile) + " – " +
                                                   Short(1e3 / found->time.lowerQuartile) + ")");
            cells.push_back(found == nullptr ? "–" : Short(found->time.median * kTexels2K * 1e-6));
        }
        table.Add(cells);
    }
    return table.Take();
}

std::string WriteNotes(const ReportRecord& report) {
    std::uint64_t compared = 0, different = 0;
    std::string skipped;
    for (const BlockRecord& r : report.blocks) {
        compared += r.comparedWithReference;
        different += r.differentFromReference;
        if (!r.skipped.empty())
            skipped += "<li>" + tool::EscapeMarkup(r.device + ": " + r.id + ": " + r.skipped) + "</li>\n";
    }
    std::string html =
        "<p class=small>“Without blocks”: the decoded texels against the source, which is what neural "
        "compression alone loses; where it loses more than the blocks do, a slower level buys little. Of one "
        "thread the time is the processor's, else the clock's; passes go from buffer to buffer, between "
        "timestamps. Decoding is not in it.</p>\n" +
        Format("<p%s>%llu of %llu blocks differ from those of the C++ encoder with one thread.</p>\n",
               different > 0 ? " class=warning" : " class=small", static_cast<unsigned long long>(different),
               static_cast<unsigned long long>(compared));
    if (!skipped.empty())
        html +=
            "<details><summary>Not measured here</summary><ul class=small>" + skipped + "</ul></details>\n";
    return html;
}

} // namespace

std::string BlockWay::GetName() const {
    return device + (threads == 0 ? "" : threads == 1 ? ", one thread" : Format(", %d threads", threads));
}

std::vector<BlockWay> ListBlockWays(const ReportRecord& report) {
    std::vector<BlockWay> ways;
    for (const BlockRecord& r : report.blocks) {
        const BlockWay way{r.device, r.threads};
        if (r.skipped.empty() && std::find(ways.begin(), ways.end(), way) == ways.end())
            ways.push_back(way);
    }
    return ways;
}

std::string WriteBlocks(const ReportRecord& report,
                        const std::function<std::string(const std::string&)>& getFigure) {
    if (report.blocks.empty())
        return {};
    std::string html = "<h2 id=blocks>Block compression on load: what quality costs in time</h2>\n"
                       "<p>Textures of the base encoding, mip 0 as the INT8 decoder yields it, compressed by "
                       "each encoder at each level.</p>\n";
    const std::vector<BlockWay> ways = ListBlockWays(report);
    for (std::size_t i = 0; i < ways.size(); ++i)
        html += getFigure(Format("blocks-%zu", i + 1));
    return html + WriteQuality(report, ways) + WriteNotes(report) + "<h3>What it takes in memory</h3>\n" +
           WriteSizes(report);
}

} // namespace openntc::report
