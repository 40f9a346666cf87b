// SPDX-License-Identifier: MIT
// What accuracy costs in time where latents are streamed: a camera path with less memory than all tiles need,
// or with fewer tiles a frame than it wants.
#pragma once

#include "report/Encodings.h"
#include "report/Report.h"

#include <functional>
#include <string>
#include <vector>

namespace openntc::report {

/// A point of the streaming axis.
struct StreamingCase {
    int budgetParts = 1; ///< the budget is all tiles divided by this
    int tilesAFrame = 0; ///< read at most; 0: all that are asked for

    std::string GetId() const;
};

/// `quick`: fewer.
std::vector<StreamingCase> ListStreamingCases(bool quick);

/// Flies the path over a plane of 4 x 4 texture sets (copies of one encoding, each with tiles of its own),
/// with the demand loader reading in the calling thread. Pictures are not rendered: the texel of each pixel
/// is looked up in the loader's page table, as shaders do, and its value is the C++ decoder's. Accuracy is
/// that of what was shown against the texels that were wanted, over the declared outputs; times are the
/// loader's alone. Everything but the times is the same in each run.
StreamingRecord MeasureStreaming(const StreamingCase& c, const Encoding& encoding, bool quick);

} // namespace openntc::report
