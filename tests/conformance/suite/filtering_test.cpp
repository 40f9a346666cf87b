// SPDX-License-Identifier: MIT
// The suite's cases of filtering: what they cover, mistakes named, capabilities, damaged files.
#include "ExportedSuite.h"

#include "conformance/FilterRunner.h"

#include <algorithm>
#include <cmath>
#include <set>

using namespace openntc_tests;

namespace {

std::vector<FilterSuiteCase> GetFilterCases() {
    return *ReadFilterCases(tool::ReadAll((fs::path(GetSuite().GetPath()) / kSuiteFile).string()));
}

Run RunFilters(Subject& subject, const std::vector<FilterSuiteCase>& cases, bool mustPassOnly = false) {
    Run run;
    RunFilterCases(GetSuite().GetPath(), cases, subject, mustPassOnly,
                   [&](const CaseResult& result) { run.Take(result); });
    return run;
}

/// The header's taps, which are then changed.
class FilterSubject : public Subject {
public:
    std::string GetName() const override { return "filter"; }
    Capabilities GetCapabilities() override {
        Capabilities capabilities;
        capabilities.filtering = true;
        return capabilities;
    }
    Arithmetic GetArithmetic() const override { return Arithmetic::Host; }
    void Open(const std::string&) override {}
    std::vector<Outputs> DecodeTexels(std::span<const tool::Texel>, const DecodeOptions&) override {
        return {};
    }
    FilterTaps FilterLookups(const FilterRequest& request, std::span<const FilterLookup> lookups) override {
        FilterTaps taps = RunFilter(request, lookups);
        Spoil(taps);
        return taps;
    }

protected:
    virtual void Spoil(FilterTaps&) {}
};

std::vector<FilterSuiteCase> ChooseFilter(const std::string& name) {
    for (const FilterSuiteCase& filterCase : GetFilterCases()) {
        if (filterCase.name == name)
            return {filterCase};
    }
    return {};
}

} // namespace

TEST_CASE(
    "filtering: every kernel, way and kind of coordinates has a case, and lookups that read both mips") {
    std::set<std::string> facts;
    for (const FilterSuiteCase& filterCase : GetFilterCases()) {
        const FilterRequest& request = filterCase.request;
        CHECK(facts.insert(filterCase.name).second);
        CHECK(filterCase.mustPass);
        CHECK(request.IsValid());
        facts.insert(std::string(GetFilterWayWord(request.way)) + " " + GetKernelWord(request.kernel));
        facts.insert(std::string("x ") + GetWrapWord(request.wrapX));
        facts.insert(std::string("y ") + GetWrapWord(request.wrapY));
        facts.insert(std::string("mips ") + GetMipsWord(request.mips));
        std::set<int> mips;
        const FilterFile file =
            *ReadFilterFile(tool::ReadAll((fs::path(GetSuite().GetPath()) / filterCase.lookups).string()));
        for (const std::vector<FilterTap>& taps : file.taps) {
            for (const FilterTap& tap : taps) {
                facts.insert(tap.isBorder ? "border" : tap.scale < 0 ? "negative" : "plain");
                mips.insert(tap.mip);
            }
        }
        if (filterCase.name == "filtering-trilinear")
            CHECK(mips.size() >= 3);
    }
    for (const char* kernel : {"nearest", "bilinear", "cubic", "catmull_rom", "gaussian"})
        CHECK(facts.contains(std::string("one ") + kernel));
    for (const char* kernel : {"bilinear", "cubic", "catmull_rom", "mitchell", "gaussian"})
        CHECK(facts.contains(std::string("all ") + kernel));
    for (const char* fact :
         {"pair catmull_rom", "pair mitchell", "x repeat", "x clamp", "x mirror", "x border", "y repeat",
          "y clamp", "y mirror", "y border", "mips nearest", "mips linear", "border", "negative", "plain"})
        CHECK_MESSAGE(facts.contains(fact), fact);
}

TEST_CASE("filtering: each planted mistake fails on the case meant for it, with its cause, and no other is "
          "blamed") {
    for (const FilterMistakeInfo& info : ListFilterMistakes()) {
        CAPTURE(std::string(info.name));
        const Run run = RunFilters(*MakeModelSubject(info.mistake), GetFilterCases());
        CheckBlamed(run, info.caseName, info.cause);
    }
}

TEST_CASE("filtering: behind the protocol, right and wrong ones; those that claim none are not asked") {
    const std::vector<FilterSuiteCase> cases = GetFilterCases();
    CHECK(RunFilters(*MakeAdapter({WRONG_DECODER}), cases).problems.empty());
    const Run wrong = RunFilters(*MakeAdapter({WRONG_DECODER, "filtering_reused_row"}), cases);
    CHECK(wrong.cases.at("filtering-bilinear").suite.cause.find("draws the row too") != std::string::npos);
    const Run none = RunFilters(*MakeAdapter({WRONG_DECODER, "crash"}), cases, true);
    CHECK(none.totals.skipped == static_cast<int>(cases.size()));
    CHECK(none.cases.at("filtering-edges").reason == "not supported: filtering");
}

TEST_CASE("filtering: taps in any order pass; one wrong bit of a weight fails without a cause") {
    class Reversed final : public FilterSubject {
        void Spoil(FilterTaps& taps) override {
            for (std::vector<FilterTap>& one : taps)
                std::reverse(one.begin(), one.end());
        }
    };
    Reversed reversed;
    CHECK(RunFilters(reversed, GetFilterCases()).problems.empty());
    class OneBit final : public FilterSubject {
        void Spoil(FilterTaps& taps) override {
            taps[1].back().scale = std::nextafter(taps[1].back().scale, 2.0f);
        }
    };
    OneBit oneBit;
    const CaseResult wrong = RunFilters(oneBit, ChooseFilter("filtering-all-cubic")).cases.begin()->second;
    CHECK(wrong.outcome == Outcome::Fail);
    CHECK(wrong.reason.find("lookup 1: texel (") == 0);
    CHECK(wrong.reason.find("; 1 of 4 lookups differ; covers: ") != std::string::npos);
    CHECK(RunFilters(oneBit, ChooseFilter("filtering-all-gaussian")).totals.passed == 1); // within 1e-5
    class Short final : public FilterSubject {
        void Spoil(FilterTaps& taps) override { taps[0].pop_back(); }
    };
    Short tooShort;
    CHECK(RunFilters(tooShort, ChooseFilter("filtering-all-cubic"))
              .cases.begin()
              ->second.reason.find("lookup 0: 15 taps: expected 16") == 0);
}

TEST_CASE("filtering: damaged lists and files are refused without a crash") {
    const auto read = [](const std::string& text) { return ReadFilterCases(std::as_bytes(std::span(text))); };
    CHECK(read(R"({"version":5})")->empty());
    CHECK_FALSE(read(R"({"filtering":[1]})"));
    const std::string good =
        R"({"filtering":[{"name":"a","lookups":"l","about":"","way":"pair","kernel":"mitchell","mips":"linear",)"
        R"("wrapX":"repeat","wrapY":"border","sigma":614,"radius":2,"maxAnisotropy":1,"lodBias":-5,"width":16384,)"
        R"("height":1,"levels":15}]})";
    REQUIRE(read(good));
    CHECK(read(good)->front().request.IsValid());
    for (const auto& [from, to] : {std::pair<const char*, const char*>{"\"l\"", "\"a/l\""},
                                   {"pair", "pairs"},
                                   {"mitchell", "lanczos"},
                                   {"linear", "both"},
                                   {"border", "edge"},
                                   {"614", "100"},
                                   {"\"maxAnisotropy\":1", "\"maxAnisotropy\":17"},
                                   {"16384", "16385"},
                                   {"\"levels\":15", "\"levels\":0"}}) {
        std::string bad = good;
        bad.replace(bad.find(from), std::string(from).size(), to);
        CAPTURE(bad);
        CHECK_FALSE(read(bad));
    }
    const std::vector<std::byte> bytes =
        tool::ReadAll((fs::path(GetSuite().GetPath()) / "filtering-all-trilinear.lookups").string());
    const Expected<FilterFile> file = ReadFilterFile(bytes);
    REQUIRE(file);
    CHECK(WriteFilterFile(*file) == bytes);
    for (std::size_t size = 0; size < bytes.size(); ++size)
        CHECK_FALSE(ReadFilterFile(std::span(bytes).first(size)));
    std::vector<std::byte> longer = bytes;
    longer.push_back(std::byte{0});
    CHECK_FALSE(ReadFilterFile(longer));
    std::vector<std::byte> many = bytes;
    many[53] = std::byte{255}; // taps of the first lookup
    CHECK_FALSE(ReadFilterFile(many));
    std::vector<std::byte> version = bytes;
    version[4] = std::byte{2};
    CHECK_FALSE(ReadFilterFile(version));
}
