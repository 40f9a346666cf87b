// SPDX-License-Identifier: MIT
#include "Interrupt.h"

#include "Failure.h"

#include <csignal>

namespace openntc::tool {

namespace {

volatile std::sig_atomic_t interrupted = 0;

void HandleInterrupt(int signal) {
    interrupted = 1;
    std::signal(signal, SIG_DFL);
}

} // namespace

void InstallInterruptHandler() {
    std::signal(SIGINT, HandleInterrupt);
    std::signal(SIGTERM, HandleInterrupt); // what build farms and shutdowns send
#if defined(SIGXFSZ)
    std::signal(SIGXFSZ, SIG_IGN); // a file size limit is then a failed write, which is reported
#endif
}

bool IsInterrupted() noexcept {
    return interrupted != 0;
}

void ThrowIfInterrupted() {
    if (IsInterrupted())
        throw CommandError(ExitCode::Failed, "cancelled", "interrupted");
}

} // namespace openntc::tool
