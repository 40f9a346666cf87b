// SPDX-License-Identifier: MIT
// What the option tables say, as other programs want it: a manual page, and completions for shells.
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace openntc::tool {

/// The values that a type of CLI11's (`ENUM:value in {json->1,text->0} OR {1,0}`) allows; empty where it is no list.
std::vector<std::string> GetListedValues(const std::string& type);

/// Manual page `ntc.1`, in roff.
std::string MakeManualPage(const CLI::App& app);

/// Completion script for `bash`, `zsh` or `fish`; empty for other names. Subcommands, options, and values where they are a list.
std::string MakeCompletion(const CLI::App& app, const std::string& shell);

} // namespace openntc::tool
