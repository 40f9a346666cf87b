// SPDX-License-Identifier: MIT
// What became of the materials of a bake, for people and as JSON.
#pragma once

#include "bake/BakePlan.h"

#include <optional>
#include <span>
#include <string>

namespace openntc::tool {

enum class BakeStatus { Unchanged, Due, Made, Failed, Interrupted };

const char* GetName(BakeStatus status);

/// One material when it is finished with.
struct BakeOutcome {
    std::string name;
    BakeStatus status = BakeStatus::Due;
    std::string reason; ///< why it was made or is due
    std::string error;  ///< one line, for Failed
    std::optional<BakeRecord> record;
};

/// Prints all of it, failures last. Returns the exit code: 1 if a material failed or the bake was interrupted.
int PrintResult(const BakeOptions& options, std::span<const BakeOutcome> outcomes,
                std::span<const BakeRecord> vanished);

} // namespace openntc::tool
