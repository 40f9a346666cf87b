// SPDX-License-Identifier: MIT
// The exported suite, made once for all test cases, and runs over it.
#pragma once

#include "cli/Program.h"

#include "Failure.h"
#include "conformance/Runner.h"
#include "conformance/SuiteRunner.h"

#include <doctest/doctest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <vector>

namespace openntc_tests {

using namespace openntc;
using namespace openntc::conformance;
namespace fs = std::filesystem;

// Exported once for all test cases.
class ExportedSuite {
public:
    ExportedSuite()
        : path_(fs::temp_directory_path() / ("openntc-suite-" + std::to_string(std::random_device()()))) {
        ExportSuite(path_);
    }
    ~ExportedSuite() {
        std::error_code ignored;
        fs::remove_all(path_, ignored);
    }
    ExportedSuite(const ExportedSuite&) = delete;
    ExportedSuite& operator=(const ExportedSuite&) = delete;
    std::string GetPath() const { return path_.string(); }

private:
    fs::path path_;
};

inline const ExportedSuite& GetSuite() {
    static const ExportedSuite suite;
    return suite;
}

struct Run {
    Totals totals;
    std::map<std::string, CaseResult> cases;
    std::string problems; // lines of what did not pass

    void Take(const CaseResult& result) {
        cases[result.name] = result;
        totals.Add(result.outcome);
        if (result.outcome != Outcome::Pass)
            problems += result.GetLine() + "\n";
    }
};

/// A planted mistake failed on the case meant for it, with its cause, and no other cause is named anywhere.
inline void CheckBlamed(const Run& run, const std::string& caseName, const std::string& cause) {
    const CaseResult& result = run.cases.at(caseName);
    CHECK(result.outcome == Outcome::Fail);
    CHECK_MESSAGE(result.GetLine().find("looks like: " + cause) != std::string::npos, result.GetLine());
    for (const auto& entry : run.cases) {
        CAPTURE(entry.first);
        if (!entry.second.suite.cause.empty())
            CHECK(entry.second.suite.cause == cause);
    }
}

inline Run RunAll(Subject& subject, const std::string& folder, bool mustPassOnly = false) {
    Run run;
    run.totals = RunFolder(folder, subject, mustPassOnly, [&](const CaseResult& result) {
        run.cases[result.name] = result;
        if (result.outcome != Outcome::Pass)
            run.problems += result.GetLine() + "\n";
    });
    return run;
}

inline std::unique_ptr<Subject> MakeAdapter(std::vector<std::string> command, double timeoutSeconds = 60) {
    return MakeAdapterSubject({std::move(command), timeoutSeconds});
}

inline std::map<std::string, std::string> ReadFolder(const std::string& folder) {
    std::map<std::string, std::string> files;
    for (const auto& entry : fs::directory_iterator(folder)) {
        std::ifstream file(entry.path(), std::ios::binary);
        files[entry.path().filename().string()] = {std::istreambuf_iterator<char>(file),
                                                   std::istreambuf_iterator<char>()};
    }
    return files;
}

/// The cases of suite.json.
inline const std::vector<SuiteCase>& GetCases() {
    static const std::vector<SuiteCase> cases =
        *ReadSuite(tool::ReadAll((fs::path(GetSuite().GetPath()) / kSuiteFile).string()));
    return cases;
}

inline const std::vector<BlockSuiteCase>& GetBlockCases() {
    static const std::vector<BlockSuiteCase> cases =
        *ReadBlockCases(tool::ReadAll((fs::path(GetSuite().GetPath()) / kSuiteFile).string()));
    return cases;
}

/// Some cases in the order given, without metadata.
inline Run RunCases(Subject& subject, const std::vector<SuiteCase>& cases) {
    Run run;
    SuiteRunner(GetSuite().GetPath(), subject, false).Run(cases, [&](const CaseResult& result) {
        run.Take(result);
    });
    return run;
}

/// Those whose names `choose` takes.
template <typename Choose>
std::vector<SuiteCase> ChooseCases(Choose choose) {
    std::vector<SuiteCase> chosen;
    for (const SuiteCase& suiteCase : GetCases()) {
        if (choose(suiteCase.name))
            chosen.push_back(suiteCase);
    }
    return chosen;
}

} // namespace openntc_tests
