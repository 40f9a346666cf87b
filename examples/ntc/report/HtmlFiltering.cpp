// SPDX-License-Identifier: MIT
#include "report/HtmlFiltering.h"

#include "Output.h"
#include "report/Analysis.h"
#include "report/HtmlTable.h"

#include <vector>

namespace openntc::report {

using tool::Format;

bool IsOnFilteringFront(const ReportRecord& report, const FilteringRecord& record) {
    for (const FilteringRecord& other : report.filtering) {
        if (other.filter != record.filter || other.scene != record.scene || other.device != record.device ||
            &other == &record)
            continue;
        const bool isAsFast =
            other.time.median < record.time.median || IsEqualWithinSpread(other.time, record.time);
        const bool isCloser = other.rmse.back() < record.rmse.back();
        const bool isAsClose = other.rmse.back() == record.rmse.back();
        const bool isFaster =
            other.time.median < record.time.median && !IsEqualWithinSpread(other.time, record.time);
        if ((isAsFast && isCloser) || (isFaster && isAsClose))
            return false;
    }
    return true;
}

std::string WriteFiltering(const ReportRecord& report,
                           const std::function<std::string(const std::string&)>& getFigure) {
    if (report.filtering.empty())
        return {};
    const FilteringRecord& first = report.filtering.front();
    std::string html =
        "<h2 id=filtering>Filtering: what accuracy costs in time</h2>\n<p>Small pictures of " +
        tool::EscapeMarkup(first.encoding) +
        ": magnified (a texel is 4 pixels wide, turned) and a floor to the horizon. One texel that is drawn "
        "(two where weights are negative), shared among 2 × 2 pixels, all of them decoded together by a wave "
        "of 8 lanes, or each "
        "pixel for itself.</p>\n" +
        getFigure("filtering");
    std::vector<std::string> headings = {"<filter", "<scene", "<texels of a pixel",
                                         "decoded per pixel and frame",
                                         "ns per pixel and frame, median (quartiles)"};
    for (const int frames : first.frames)
        headings.push_back(Format("RMSE, %d frame%s", frames, frames > 1 ? "s" : ""));
    headings.emplace_back("<front");
    Table table(headings, true);
    for (const FilteringRecord& r : report.filtering) {
        std::vector<std::string> cells = {r.filter, r.scene, r.texels, Format("%.2f", r.texelsPerSample),
                                          DescribeTime(r.time)};
        for (const double error : r.rmse)
            cells.push_back(error == 0 ? "exact" : Format("%.4f", error));
        cells.emplace_back(IsOnFilteringFront(report, r) ? "yes" : "");
        table.Add(cells);
    }
    return html + table.Take() +
           "<p class=small>Error: against the same filter with all texels, as stored, over declared "
           "channels, of the mean of "
           "so many frames with numbers of R2. Sharing is biased: its error does not vanish. Time: decoding "
           "the texels of "
           "a frame one by one on one thread of the C++ decoder (the processor's time); choosing them and "
           "the waves, which are "
           "emulated, are not in "
           "it.</p>\n";
}

} // namespace openntc::report
