// SPDX-License-Identifier: MIT
// What every program's `main` does around its work.
#pragma once

#include "Failure.h"
#include "Interrupt.h"
#include "Output.h"

#include <cstdio>
#include <exception>
#include <new>
#include <string>

namespace openntc::tool {

/// What `run` returns; of what it throws, the exit code, after one line `PROGRAM: SUBJECT: TEXT` on standard
/// error. SIGINT and SIGTERM are requests that ThrowIfInterrupted sees.
template <typename Run>
int RunMain(const char* program, Run run) {
    const auto fail = [program](const CommandError& error) {
        const std::string line = std::string(program) + ": " + error.GetSubject() + ": " + error.what();
        std::fprintf(stderr, "%s\n", Printable(line).c_str());
        return static_cast<int>(error.GetCode());
    };
    InstallInterruptHandler();
    try {
        return run();
    } catch (const CommandError& error) {
        return fail(error);
    } catch (const std::bad_alloc&) {
        return fail(CommandError(ExitCode::Failed, "memory", "allocation: refused by the system"));
    } catch (const std::exception& error) {
        return fail(CommandError(ExitCode::Failed, "internal error", error.what()));
    }
}

} // namespace openntc::tool
