// SPDX-License-Identifier: MIT
#include "report/Changes.h"
#include "report/Analysis.h"

#include "Output.h"

#include <cmath>

namespace openntc::report {

const char* const kChangeRule = "A time has changed when the ranges of its repeats (slowest to fastest) do "
                                "not overlap and the medians differ by more "
                                "than 5 %; everything else counts as noise. Accuracy has changed when PSNR "
                                "differs by more than 0.005 dB or the worst "
                                "error by more than 0.005 LSB.";

namespace {

constexpr double kNoise = 0.05;
constexpr double kAccuracy = 0.005;

const CaseRecord* Find(const ReportRecord& report, const CaseRecord& wanted) {
    for (const CaseRecord& c : report.cases) {
        if (c.id == wanted.id && c.device == wanted.device && IsMeasured(c))
            return &c;
    }
    return nullptr;
}

double GetDifference(double a, double b) {
    return a == b ? 0 : a - b; // also for two infinite ones
}

bool Differs(double difference) {
    return !(std::fabs(difference) <= kAccuracy);
}

ChangeRecord Compare(const CaseRecord& a, const CaseRecord& b) {
    ChangeRecord change;
    change.id = b.id;
    change.device = b.device;
    change.oldMedian = a.time.median;
    change.newMedian = b.time.median;
    change.ratio = b.time.median / a.time.median;
    const bool overlap = a.time.minimum <= b.time.maximum && b.time.minimum <= a.time.maximum;
    change.changed = !overlap && std::fabs(change.ratio - 1) > kNoise;
    change.psnrChange = GetDifference(b.accuracy.psnrSource, a.accuracy.psnrSource);
    change.worstLsbChange = GetDifference(b.accuracy.worstLsbFp32, a.accuracy.worstLsbFp32);
    change.accuracyChanged = Differs(change.psnrChange) || Differs(change.worstLsbChange);
    return change;
}

ChangeRecord MakeMissing(const CaseRecord& c, const char* what) {
    ChangeRecord change;
    change.id = c.id;
    change.device = c.device;
    (what[0] == 'n' ? change.newMedian : change.oldMedian) = c.time.median;
    change.missing = what;
    return change;
}

} // namespace

void CompareReports(const ReportRecord& old, ReportRecord& report) {
    report.comparedWith = old.date;
    report.changes.clear();
    for (const CaseRecord& c : report.cases) {
        if (!IsMeasured(c))
            continue;
        const CaseRecord* before = Find(old, c);
        report.changes.push_back(before != nullptr ? Compare(*before, c) : MakeMissing(c, "new"));
    }
    for (const CaseRecord& c : old.cases) {
        if (IsMeasured(c) && Find(report, c) == nullptr)
            report.changes.push_back(MakeMissing(c, "gone"));
    }
}

std::string DescribeChanges(const ReportRecord& report) {
    std::size_t compared = 0, changed = 0, accuracy = 0;
    std::string lines;
    for (const ChangeRecord& c : report.changes) {
        compared += c.missing.empty();
        changed += c.changed;
        accuracy += c.accuracyChanged;
        if (c.changed)
            lines += tool::Format("changed: %s: %s: %.4g -> %.4g ns/texel, x %.3f\n", c.device.c_str(),
                                  c.id.c_str(), c.oldMedian, c.newMedian, c.ratio);
        if (c.accuracyChanged)
            lines += tool::Format("accuracy: %s: %s: PSNR %+.3f dB, worst error %+.3f LSB\n",
                                  c.device.c_str(), c.id.c_str(), c.psnrChange, c.worstLsbChange);
    }
    return tool::Format("compared with %s: %zu cases, %zu times changed, accuracy of %zu changed\n",
                        report.comparedWith.c_str(), compared, changed, accuracy) +
           lines;
}

} // namespace openntc::report
