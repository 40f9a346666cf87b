// SPDX-License-Identifier: MIT
// Help in plain words: examples and exit codes under each command, `ntc help [COMMAND]`.
#pragma once

#include "Commands.h"

namespace openntc::tool {

/// Before the commands are added: they take the format of option lists from `app`.
void UsePlainHelp(CLI::App& app);

/// After the commands are added: examples, exit codes, and the command `help`.
void AddHelpCommand(CLI::App& app, Action& action);

} // namespace openntc::tool
