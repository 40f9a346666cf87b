// SPDX-License-Identifier: MIT
// Tables and numbers of HTML pages.
#pragma once

#include "Output.h"
#include "report/Report.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace openntc::report {

/// Infinities are "exact": what is measured is then without error.
inline std::string Number(double value, int digits) {
    if (std::isinf(value))
        return "exact";
    return std::isnan(value) ? "–" : tool::Format("%.*f", digits, value);
}

/// Three significant digits without an exponent.
inline std::string Short(double value) {
    if (!(std::fabs(value) < 1e12))
        return "–";
    const double size = std::fabs(value);
    const int digits = size == 0 ? 0 : std::max(0, 2 - static_cast<int>(std::floor(std::log10(size))));
    return tool::Format("%.*f", std::min(digits, 6), value);
}

/// Median (quartiles).
inline std::string DescribeTime(const Spread& time) {
    return Short(time.median) + " (" + Short(time.lowerQuartile) + " – " + Short(time.upperQuartile) + ")";
}

/// A table of an HTML page; cells are text.
class Table {
public:
    /// A heading that starts with '<' is for text, with '~' for text of several lines.
    explicit Table(const std::vector<std::string>& headings, bool isDense = false) {
        html_ = isDense ? "<table class=dense><tr>" : "<table><tr>";
        for (const std::string& heading : headings) {
            const char mark = heading.empty() ? ' ' : heading[0];
            const bool isText = mark == '<' || mark == '~';
            html_ += std::string(isText ? "<th class=text>" : "<th>") +
                     tool::EscapeMarkup(heading.substr(isText ? 1 : 0)) + "</th>";
            cells_.push_back(mark == '<' ? "<td class=text>" : mark == '~' ? "<td class=note>" : "<td>");
        }
        html_ += "</tr>\n";
    }
    void Add(const std::vector<std::string>& cells, const char* rowClass = "") {
        html_ += *rowClass != '\0' ? "<tr class=" + std::string(rowClass) + ">" : "<tr>";
        for (std::size_t i = 0; i < cells.size(); ++i)
            html_ += cells_[i] + tool::EscapeMarkup(cells[i]) + "</td>";
        html_ += "</tr>\n";
    }
    std::string Take() { return html_ + "</table>\n"; }

private:
    std::string html_;
    std::vector<std::string> cells_;
};

} // namespace openntc::report
