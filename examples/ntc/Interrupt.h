// SPDX-License-Identifier: MIT
// SIGINT and SIGTERM as a clean cancellation: loops ask between pieces of work.
#pragma once

namespace openntc::tool {

/// Makes the first SIGINT or SIGTERM a request that ThrowIfInterrupted sees; a second one ends the process at
/// once.
void InstallInterruptHandler();

bool IsInterrupted() noexcept;

/// Throws CommandError(Failed) if one arrived.
void ThrowIfInterrupted();

} // namespace openntc::tool
