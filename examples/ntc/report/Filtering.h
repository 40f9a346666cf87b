// SPDX-License-Identifier: MIT
// What accuracy costs in time where texture sets are filtered: every filter with all its texels, with one
// that is drawn, shared among neighbours, or divided among the lanes of a wave.
#pragma once

#include "report/Encodings.h"
#include "report/Report.h"

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace openntc::report {

/// How many texels of a filter a pixel decodes.
enum class FilterTexels { One, Shared, Together, All };

/// A point of the axis of filtering.
struct FilteringCase {
    const char* filter; ///< "B-spline"
    bool isFloor;       ///< a floor that runs to the horizon, or a texture whose texels are 4 pixels wide
    FilterTexels texels;

    std::string GetId() const;
    const char* GetTexelsName() const;
};

/// `quick`: two filters.
std::vector<FilteringCase> ListFilteringCases(bool quick);

/// Frames whose mean is judged.
inline constexpr int kFilteringFrames[] = {1, 4, 16, 64};

/// All cases in turns, without their device; `advance` is called after each judgement.
std::vector<FilteringRecord> MeasureFiltering(const std::vector<FilteringCase>& cases,
                                              const Encoding& encoding, bool quick,
                                              const std::function<void()>& advance);

/// Draws a small picture of a set, whose texels are those of the C++ decoder, and compares it with the one of
/// all the filter's texels. Waves have 8 lanes and are emulated. Everything but the times is the same in each
/// run.
class FilteringMeasurement {
public:
    FilteringMeasurement(const Encoding& encoding, bool quick);
    ~FilteringMeasurement();
    FilteringMeasurement(const FilteringMeasurement&) = delete;
    FilteringMeasurement& operator=(const FilteringMeasurement&) = delete;

    /// All but the times.
    FilteringRecord Judge(const FilteringCase& c);
    /// Nanoseconds per pixel to decode the texels of one frame, one by one, on one thread of the C++ decoder:
    /// the processor's time. After Judge.
    double Time(const FilteringCase& c);

private:
    class Scene;
    std::unique_ptr<Scene> scene_;
};

} // namespace openntc::report
