// SPDX-License-Identifier: MIT
// Work done by child processes, so that what crashes there is an answer here. On Windows, which has no fork, by threads.
#pragma once

#include <cstddef>
#include <functional>
#include <string>

namespace openntc::shader_compiler {

/// What came of one piece of work: its bytes, or how its process ended instead.
struct Answer {
    std::string bytes;
    std::string crash; ///< "Segmentation fault", "exit code 1"; empty if there are bytes
};

/// Calls work(0) … work(count - 1) in child processes of this one, `processes` at a time, begun in this order; `work` must not
/// throw. `done` gets each answer here, on the calling thread, in the order in which they come; after it has returned false or an
/// answer is a crash nothing more is begun, and what was begun is waited for.
/// Throws Failure(Output) when the system gives no process.
void RunInProcesses(std::size_t count, std::size_t processes,
                    const std::function<std::string(std::size_t)>& work,
                    const std::function<bool(std::size_t, Answer)>& done);

} // namespace openntc::shader_compiler
