// SPDX-License-Identifier: MIT
#include "report/Analysis.h"

#include "report/Cases.h"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace openntc::report {

bool IsMeasured(const CaseRecord& record) {
    return record.skipped.empty() && record.time.repeats > 0;
}

std::vector<const CaseRecord*> ListComparable(const ReportRecord& report, const std::string& device) {
    const Case base;
    std::vector<const CaseRecord*> cases;
    for (const CaseRecord& c : report.cases) {
        if (IsMeasured(c) && c.device == device && c.material == base.material && c.outputs == base.outputs &&
            c.linear == base.linear && c.sets == base.sets && c.weights == GetWeightsName(base.weights) &&
            c.instructions.empty() && c.latents.empty())
            cases.push_back(&c);
    }
    std::sort(cases.begin(), cases.end(),
              [](const CaseRecord* a, const CaseRecord* b) { return a->time.median < b->time.median; });
    return cases;
}

bool IsOverloaded(const ReportRecord& report) {
    return report.cores > 0 && report.load > report.cores;
}

bool IsEqualWithinSpread(const Spread& a, const Spread& b) {
    return a.lowerQuartile <= b.upperQuartile && b.lowerQuartile <= a.upperQuartile;
}

std::vector<FrontPoint> ListParetoFront(const std::vector<const CaseRecord*>& comparable) {
    std::vector<FrontPoint> front;
    double reached = -INFINITY;
    const auto isBetter = [&reached](const CaseRecord* c) { return c->accuracy.psnrSource > reached; };
    for (;;) {
        const auto fastest = std::find_if(comparable.begin(), comparable.end(), isBetter);
        if (fastest == comparable.end())
            return front;
        FrontPoint point{*fastest, {}};
        for (const CaseRecord* c : comparable) {
            if (IsEqualWithinSpread(c->time, (*fastest)->time) &&
                c->accuracy.psnrSource > point.best->accuracy.psnrSource)
                point.best = c;
        }
        for (const CaseRecord* c : comparable) {
            if (c != point.best && IsEqualWithinSpread(c->time, (*fastest)->time) && isBetter(c))
                point.asFast.push_back(c);
        }
        reached = point.best->accuracy.psnrSource;
        front.push_back(std::move(point));
    }
}

std::vector<const CaseRecord*> ListAxis(const ReportRecord& report, const std::string& device,
                                        const std::string& axis) {
    std::vector<const CaseRecord*> cases;
    for (const CaseRecord& c : report.cases) {
        if (IsMeasured(c) && c.device == device &&
            std::find(c.axes.begin(), c.axes.end(), axis) != c.axes.end())
            cases.push_back(&c);
    }
    std::stable_sort(cases.begin(), cases.end(), [](const CaseRecord* a, const CaseRecord* b) {
        return std::tie(a->outputs, a->sets, a->bitsPerPixel) <
               std::tie(b->outputs, b->sets, b->bitsPerPixel);
    });
    return cases;
}

const CaseRecord* FindBase(const ReportRecord& report, const std::string& device) {
    const std::string id = Case{}.GetId();
    for (const CaseRecord& c : report.cases) {
        if (IsMeasured(c) && c.device == device && c.id == id)
            return &c;
    }
    return nullptr;
}

std::vector<QualityAnswer> AnswerQualities(const std::vector<const CaseRecord*>& comparable) {
    std::vector<QualityAnswer> answers;
    double least = INFINITY, most = -INFINITY;
    for (const CaseRecord* c : comparable) {
        least = std::min(least, c->accuracy.psnrSource);
        most = std::max(most, c->accuracy.psnrSource);
    }
    if (!std::isfinite(least) || !std::isfinite(most))
        return answers;
    const double step = std::max(1.0, std::ceil((most - least) / 12));
    for (double psnr = std::floor(least); psnr <= most; psnr += step) {
        QualityAnswer answer{psnr, {}, nullptr};
        for (const CaseRecord* c : comparable) {
            if (c->accuracy.psnrSource < psnr)
                continue;
            if (answer.fastest.empty() || IsEqualWithinSpread(c->time, answer.fastest.front()->time))
                answer.fastest.push_back(c);
            if (answer.smallest == nullptr || c->memoryBytes < answer.smallest->memoryBytes)
                answer.smallest = c;
        }
        std::stable_sort(
            answer.fastest.begin(), answer.fastest.end(),
            [](const CaseRecord* a, const CaseRecord* b) { return a->memoryBytes < b->memoryBytes; });
        answers.push_back(std::move(answer));
    }
    return answers;
}

const char* const kPublishedSource = "measured by this project with LibNTC's own encoder on an NVIDIA H100, "
                                     "100 000 steps, Int8 network, decoded by its own "
                                     "decoder: materials of FlightHelmet, 512 x 512, all mips";

const std::vector<PublishedPoint>& ListPublishedPoints() {
    static const std::vector<PublishedPoint> kPoints = {
        {"LibNTC 0.7.2", "LeatherPartsMat", 2, 38.069},    {"LibNTC 0.7.2", "LeatherPartsMat", 4, 40.185},
        {"LibNTC 0.7.2", "LeatherPartsMat", 6, 42.253},    {"LibNTC 0.7.2", "LeatherPartsMat", 8, 43.962},
        {"LibNTC 0.7.2", "GlassPlasticMat", 4, 43.507},    {"LibNTC 0.9.2", "LeatherPartsMat", 1.667, 37.131},
        {"LibNTC 0.9.2", "LeatherPartsMat", 3.75, 39.731}, {"LibNTC 0.9.2", "LeatherPartsMat", 6.667, 41.873},
    };
    return kPoints;
}

} // namespace openntc::report
