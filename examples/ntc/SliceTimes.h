// SPDX-License-Identifier: MIT
// Timing of slices that are cut out of a file in memory, and of copies of as many bytes.
#pragma once

#include "openntc/inference/SliceLayout.h"

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace openntc::tool {

/// A file in memory, slices of it, and a place for each.
struct SliceJob {
    std::string path; ///< of the file, for errors
    std::vector<std::byte> file;
    TextureSetMetadata set;
    std::vector<SliceDesc> slices;
    std::vector<std::size_t> places; ///< one more than slices
    std::vector<std::byte> buffer;
};

/// Square slices of `size` texels side by side from the upper left corner of mip firstMip on. The caller has checked
/// mips and size. Throws CommandError(BadInput) naming `path`.
SliceJob MakeSliceJob(std::vector<std::byte> file, TextureSetMetadata&& set, const SliceDesc& first,
                      const std::string& path);

struct SliceTimes {
    const char* name;
    const char* text;            ///< what was done, for people
    std::vector<double> seconds; ///< of each run, in increasing order
};

/// Cuts `slices` slices in turns, `repeat` times with each method, one thread, after a run that is not counted. The
/// job's buffer holds the slices afterwards. Throws CommandError(BadInput) naming the file, and if the user interrupts.
std::vector<SliceTimes> TimeSlices(SliceJob& job, int slices, int repeat);

} // namespace openntc::tool
