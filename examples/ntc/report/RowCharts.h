// SPDX-License-Identifier: MIT
// What charts with rows share.
#pragma once

#include "report/ChartScript.h"

#include <cstddef>
#include <string>
#include <vector>

namespace openntc::report {

/// Points of one colour share an offset within their rows, so that no point covers another's.
struct Series {
    std::string name;
    std::string color;
    int shape; ///< gnuplot's point type
    std::string rows;
};

struct Row {
    std::string label;
    std::string figure; ///< at the right end
};

inline constexpr int kHeadPixels = 104; // title, legend, heading of the figures
inline constexpr int kShapes[] = {7,  5, 9, 13, 11,
                                  15, 7, 5, 9}; // filled: circle, square, triangles, diamonds
static_assert(std::size(kShapes) == kColorCount);

/// Of a series of `count` within its row.
double GetOffset(std::size_t series, std::size_t count);

/// Rows from the top down, row i at -i, with a heading for the figures; the chart is `height` pixels high.
void AddRows(ChartScript& script, const std::vector<Row>& rows, const char* figures, int height);

/// What `plot` draws: rows of x, y and the ends of a bar.
std::string PlotSeries(ChartScript& script, const std::vector<Series>& series);

/// A row of a series: the median at `y`, the quartiles as the ends of a bar.
std::string MakePoint(const CaseRecord& c, const TimeUnit& unit, double y);

/// The size of `series` if there is none of that name.
std::size_t FindSeries(const std::vector<Series>& series, const std::string& name);

} // namespace openntc::report
