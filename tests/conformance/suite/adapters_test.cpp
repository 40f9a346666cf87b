// SPDX-License-Identifier: MIT
// Adapters that crash, hang, talk nonsense or claim too much: the case at fault fails, with the reason, and no other.
#include "ExportedSuite.h"

#include <chrono>

using namespace openntc_tests;

namespace {

std::vector<SuiteCase> ChooseFirst(std::size_t count) {
    std::vector<SuiteCase> cases = ChooseCases([](const std::string& name) {
        return name.starts_with("latents-") || name.starts_with("shape-") || name == "network-small-fp16";
    });
    cases.resize(std::min(count, cases.size()));
    return cases;
}

} // namespace

TEST_CASE("adapters that crash, hang, exit or talk nonsense fail with the reason") {
    const std::pair<const char*, const char*> kManners[] = {
        {"crash", "adapter: ended by signal 11"},
        {"exit", "adapter: ended with exit code 3"},
        {"garbage", "adapter: garbage: \"segmentation imminent\" instead of `ok`"},
        {"endless", "adapter: a line of more than 65536 characters"}};
    for (const auto& expected : kManners) {
        const std::string manner = expected.first;
        const std::string reason = expected.second;
        CAPTURE(manner);
        const Run run = RunCases(*MakeAdapter({WRONG_DECODER, manner}), ChooseFirst(6));
        CHECK(run.totals.passed == 0);
        CHECK(run.totals.skipped == 1); // fp16 is not claimed
        for (const auto& entry : run.cases) {
            if (entry.second.outcome == Outcome::Fail)
                CHECK(entry.second.reason.find(reason) == 0);
        }
    }
    CHECK_THROWS_AS(MakeAdapter({"./no-such-adapter"}), tool::CommandError);
}

TEST_CASE("after two timeouts nothing more is run, and nothing more fails") {
    const std::vector<SuiteCase> cases = ChooseFirst(6);
    const Run run = RunCases(*MakeAdapter({WRONG_DECODER, "hang"}, 0.5), cases);
    CHECK(run.totals.failed == 2);
    CHECK(run.cases.at("network-small-fp16").reason == "not supported: fp16");
    CHECK(run.cases.at(cases[1].name).reason == "adapter: no answer within 0.5 s");
    CHECK(run.cases.at(cases[2].name).reason == "adapter: no answer within 0.5 s");
    for (std::size_t i = 3; i < cases.size(); ++i) {
        CHECK(run.cases.at(cases[i].name).outcome == Outcome::Skip);
        CHECK(run.cases.at(cases[i].name).reason == "not run: the adapter did not answer 2 times");
    }
}

TEST_CASE("what comes after an answer is blamed on the case that was answered") {
    for (const auto& expected : {std::pair<std::string, std::string>(
                                     "extra_line", "adapter: a line that was not asked for: \"00000000 "),
                                 {"crash_after_answer", "adapter: ended by signal 11"}}) {
        const std::string manner = expected.first;
        const std::string reason = expected.second;
        CAPTURE(manner);
        const std::vector<SuiteCase> cases = ChooseFirst(5);
        const Run run = RunCases(*MakeAdapter({WRONG_DECODER, manner}), cases);
        CHECK(run.totals.failed == 4);
        for (const auto& entry : run.cases) {
            const CaseResult& result = entry.second;
            if (entry.first == "network-small-fp16")
                continue;
            CAPTURE(result.reason);
            CHECK(result.outcome == Outcome::Fail);
            CHECK(result.reason.find(reason) == 0);
            CHECK(result.reason.find(", after its answer") != std::string::npos);
        }
    }
}

TEST_CASE("a crash that needs an earlier set is called state") {
    const std::vector<SuiteCase> cases = ChooseFirst(4);
    const Run run = RunCases(*MakeAdapter({WRONG_DECODER, "crash_at_second_set"}), cases);
    CHECK(run.cases.at(cases[1].name).outcome == Outcome::Pass);
    const std::string reason = run.cases.at(cases[2].name).reason;
    CHECK(reason.find("adapter: ended by signal 11") == 0);
    CHECK(reason.find("passes alone in a fresh process: state of an earlier set") != std::string::npos);
}

TEST_CASE("--mustpass fails what is claimed and called unsupported") {
    const std::vector<std::string> command = {WRONG_DECODER, "unsupported_when_hard"};
    const Run lenient = RunAll(*MakeAdapter(command), GetSuite().GetPath());
    CHECK(lenient.totals.failed == 0);
    CHECK(lenient.totals.skipped > 100);
    const Run strict = RunAll(*MakeAdapter(command), GetSuite().GetPath(), true);
    CHECK(strict.totals.failed > 100);
    CHECK(strict.cases.at("latents-4x4").outcome == Outcome::Fail);
    CHECK(strict.cases.at("latents-4x4").reason ==
          "not supported: too hard, although it claims what the case needs");
    CHECK(strict.cases.at("outside").reason == "not supported: outside"); // not claimed
    CHECK(strict.cases.at("outside").outcome == Outcome::Skip);
}
