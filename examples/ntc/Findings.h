// SPDX-License-Identifier: MIT
// What `ntc validate` finds in a file.
#pragma once

#include "TextureSet.h"

#include <string>
#include <vector>

namespace openntc::tool {

enum class Severity { Error, Warning, Note };

/// Each kind of finding keeps its number for ever: 1xxx errors (the file must not be used), 2xxx warnings
/// (other software may refuse the file, or something in it is odd), 3xxx notes.
struct Finding {
    int number;
    Severity severity;
    std::string text; ///< `field: value: limit`
};

const char* GetName(Severity severity);

/// Findings of a file, errors first. Throws CommandError(BadInput) only for files that cannot be opened.
std::vector<Finding> FindProblems(const std::string& path);

/// Those of them for which LibNTC, of the set's generation, refuses the file: sizes, numbers and mapping of its
/// latents and channels that its encoder does not make.
std::vector<Finding> FindRefusals(const TextureSetMetadata& metadata);

} // namespace openntc::tool
