// SPDX-License-Identifier: MIT
// What `ntc-renderer --stats` wrote, as far as a report shows it.
#pragma once

#include "report/SceneRecord.h"

#include <string>

namespace openntc::report {

/// Sets times, texels, bytes, effects and permutations of `record`; where another maths mode stood in for its own, `skipped`. Throws CommandError(Failed) naming a member that is not
/// as expected: then the program is of another version.
void ReadRendererStats(const std::string& path, SceneRecord& record);

} // namespace openntc::report
