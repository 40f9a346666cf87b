// SPDX-License-Identifier: MIT
// What the charts and tables of the page are computed from.
#pragma once

#include "report/Report.h"

#include <string>
#include <vector>

namespace openntc::report {

/// Whether the case ran and was timed.
bool IsMeasured(const CaseRecord& record);

/// Cases of a device that do the same work, so that their times can be compared: one set, nine outputs as stored, the
/// sample material, the device's default form. Fastest first.
std::vector<const CaseRecord*> ListComparable(const ReportRecord& report, const std::string& device);

/// Whether more processes wanted to run than there are threads: the quartiles then measure them too.
bool IsOverloaded(const ReportRecord& report);

/// Whether two times differ by no more than their spread: the ranges between the quartiles overlap. Such times are treated
/// as equal everywhere below.
bool IsEqualWithinSpread(const Spread& a, const Spread& b);

/// A point of the Pareto front: the most accurate of those that are as fast.
struct FrontPoint {
    const CaseRecord* best = nullptr;
    std::vector<const CaseRecord*> asFast; ///< less accurate ones whose times are equal within spread
};

/// Points that no other beats in both time and PSNR against the source, fastest first. No order is drawn from noise: of
/// cases that are equal within spread the most accurate one stands for all.
std::vector<FrontPoint> ListParetoFront(const std::vector<const CaseRecord*>& comparable);

/// Measured cases of a device on an axis, by outputs, sets and bits per pixel.
std::vector<const CaseRecord*> ListAxis(const ReportRecord& report, const std::string& device,
                                        const std::string& axis);

/// The base point of a device, or null.
const CaseRecord* FindBase(const ReportRecord& report, const std::string& device);

/// "I need Y dB": the fastest and the smallest case that reaches it.
struct QualityAnswer {
    double psnr = 0;
    /// The fastest by its median, and those that are equal to it within spread, smallest in memory first.
    std::vector<const CaseRecord*> fastest;
    const CaseRecord* smallest = nullptr;
};
/// Every whole dB over the range of the cases, twelve at most.
std::vector<QualityAnswer> AnswerQualities(const std::vector<const CaseRecord*>& comparable);

/// A figure of another encoder, with where it comes from.
struct PublishedPoint {
    const char* encoder;
    const char* material;
    double bitsPerPixel;
    double psnr;
};
const std::vector<PublishedPoint>& ListPublishedPoints();
extern const char* const kPublishedSource;

} // namespace openntc::report
