// SPDX-License-Identifier: MIT
// Trees of small materials for `ntc bake`, and how a bake is interrupted.
#pragma once

#include "cli/ImageFiles.h"
#include "cli/Program.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <string_view>

namespace openntc_tests {

/// An image that differs from those of other numbers and has to be trained.
inline void WriteSource(const fs::path& path, int number, int side = 8, int channels = 3) {
    fs::create_directories(path.parent_path());
    WriteImage(path, MakeImage(side, side, channels, [&](float u, float v, int c) {
                   return 0.5f +
                          0.4f * std::sin(7.0f * u + static_cast<float>(number + c)) * std::cos(5.0f * v);
               }));
}

/// Steps of a training that is still running when it is interrupted after its first state. With sanitizers
/// each takes many times as long.
#ifdef OPENNTC_TEST_SANITIZED
inline const std::string kLongSteps = " --steps 50 ";
#else
inline const std::string kLongSteps = " --steps 200 ";
#endif

/// Bytes of all texture sets under a folder, by their path in it.
inline std::map<std::string, std::string> ReadSets(const fs::path& folder) {
    std::map<std::string, std::string> sets;
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
        if (entry.path().extension() == ".ntc")
            sets[entry.path().lexically_relative(folder).generic_string()] = ReadText(entry.path());
    }
    return sets;
}

/// How many files under a folder end so.
inline int CountFiles(const fs::path& folder, std::string_view end) {
    return static_cast<int>(
        std::count_if(fs::recursive_directory_iterator(folder), fs::recursive_directory_iterator(),
                      [&](const auto& entry) { return entry.path().string().ends_with(end); }));
}

/// Runs the program in the background until `count` files match `pattern` under out, waits for `milliseconds` more, and sends the
/// signal. The exit code is the program's, with what the shell adds for a signal that ended it.
inline ProgramResult RunInterrupted(const Folder& folder, const std::string& arguments,
                                    const std::string& pattern, int count, int milliseconds,
                                    const std::string& signal) {
    const std::string wait =
        "[ $(find out -name '" + pattern + "' 2>/dev/null | wc -l) -lt " + std::to_string(count) + " ]";
    return RunProgram(folder, "--version >/dev/null; '" NTC_PROGRAM "' " + arguments +
                                  " & p=$!; while kill -0 $p 2>/dev/null && " + wait +
                                  "; do sleep 0.02; done; sleep " + std::to_string(milliseconds / 1000.0) +
                                  "; kill -" + signal + " $p 2>/dev/null; wait $p");
}

} // namespace openntc_tests
