// SPDX-License-Identifier: MIT
// Makes every material of a tree that is not as it should be, several at a time.
#pragma once

#include "bake/BakePlan.h"

namespace openntc::tool {

/// Writes files, records and lists, and prints what was done. Returns the exit code: 0, or 1 if a material failed or the
/// bake was interrupted. Throws CommandError where nothing could be begun.
int RunBake(const BakeOptions& options, MaterialTree tree);

} // namespace openntc::tool
