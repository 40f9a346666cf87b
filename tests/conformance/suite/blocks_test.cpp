// SPDX-License-Identifier: MIT
// The suite's cases of block compression: every format and level, mistakes named, capabilities, damaged lists.
#include "ExportedSuite.h"

#include "conformance/BlockRunner.h"

#include <set>

using namespace openntc_tests;

namespace {

Run RunBlocks(Subject& subject, const std::vector<BlockSuiteCase>& cases, bool mustPassOnly = false) {
    Run run;
    RunBlockCases(GetSuite().GetPath(), cases, subject, mustPassOnly,
                  [&](const CaseResult& result) { run.Take(result); });
    return run;
}

/// The independent model's manners, with another encoder of blocks.
class BlockSubject : public Subject {
public:
    std::string GetName() const override { return "blocks"; }
    Capabilities GetCapabilities() override {
        Capabilities capabilities;
        capabilities.blocks = true;
        return capabilities;
    }
    Arithmetic GetArithmetic() const override { return Arithmetic::Host; }
    void Open(const std::string&) override {}
    std::vector<Outputs> DecodeTexels(std::span<const tool::Texel>, const DecodeOptions&) override {
        return {};
    }
    std::vector<std::byte> EncodeBlocks(const BlockRequest& request) override {
        std::vector<std::byte> blocks = EncodeBlockRequest(request);
        Spoil(blocks);
        return blocks;
    }

protected:
    virtual void Spoil(std::vector<std::byte>&) {}
};

} // namespace

TEST_CASE("blocks: every format at every level has a case that must pass") {
    std::set<std::string> names;
    std::set<std::pair<int, int>> kinds;
    for (const BlockSuiteCase& blockCase : GetBlockCases()) {
        CHECK(names.insert(blockCase.name).second);
        kinds.emplace(static_cast<int>(blockCase.format), static_cast<int>(blockCase.level));
        CHECK(blockCase.mustPass);
        CHECK(blockCase.width % 4 != 0); // edges within blocks
        CHECK(blockCase.height % 4 != 0);
    }
    CHECK(kinds.size() == 30);
    const std::string mustPass = ReadFolder(GetSuite().GetPath()).at("mustpass.txt");
    CHECK(mustPass.find("blocks-bc7-best\n") != std::string::npos);
}

TEST_CASE(
    "blocks: each planted mistake fails on the case meant for it, with its cause, and no other is blamed") {
    for (const BlockMistakeInfo& info : ListBlockMistakes()) {
        CAPTURE(std::string(info.name));
        const Run run = RunBlocks(*MakeModelSubject(info.mistake), GetBlockCases());
        CHECK(run.totals.passed + run.totals.failed == static_cast<int>(GetBlockCases().size()));
        CheckBlamed(run, info.caseName, info.cause);
    }
}

TEST_CASE("blocks: behind the protocol, right and wrong ones; other capabilities do not matter") {
    const std::vector<BlockSuiteCase>& cases = GetBlockCases();
    const Run right = RunBlocks(*MakeAdapter({WRONG_DECODER}), cases);
    CHECK(right.problems.empty());
    const Run wrong = RunBlocks(*MakeAdapter({WRONG_DECODER, "blocks_zero_border"}), cases);
    CHECK(wrong.totals.failed == static_cast<int>(cases.size()));
    CHECK(wrong.cases.at("blocks-bc5-normal").suite.cause.find("beyond the edge") != std::string::npos);
    // A decoder that claims nothing of it is not asked, in --mustpass neither.
    const Run none = RunBlocks(*MakeAdapter({WRONG_DECODER, "crash"}), cases, true);
    CHECK(none.totals.skipped == static_cast<int>(cases.size()));
    CHECK(none.cases.at("blocks-bc1-fast").reason == "not supported: blocks");
}

TEST_CASE("blocks: one wrong bit fails without a cause; a wrong number of bytes and what is not supported "
          "are said") {
    class OneBit final : public BlockSubject {
        void Spoil(std::vector<std::byte>& blocks) override { blocks.back() ^= std::byte{1}; }
    };
    OneBit oneBit;
    const std::vector<BlockSuiteCase> one = {GetBlockCases().back()};
    const CaseResult wrong = RunBlocks(oneBit, one).cases.begin()->second;
    CHECK(wrong.outcome == Outcome::Fail);
    CHECK(wrong.reason.find("block (5, 4): ") == 0);
    CHECK(wrong.reason.find("; 1 of 30 blocks differ; covers: ") != std::string::npos);
    class Short final : public BlockSubject {
        void Spoil(std::vector<std::byte>& blocks) override { blocks.pop_back(); }
    };
    Short tooShort;
    CHECK(RunBlocks(tooShort, one).cases.begin()->second.reason == "239 bytes of blocks: expected 240");
    class Refuses final : public BlockSubject {
        void Spoil(std::vector<std::byte>&) override {
            throw SubjectError(SubjectError::Kind::NotSupported, "no such format");
        }
    };
    Refuses refuses;
    CHECK(RunBlocks(refuses, one).totals.skipped == 1);
    CHECK(RunBlocks(refuses, one, true).totals.failed == 1);
    // A picture that is not as long as suite.json says.
    std::vector<BlockSuiteCase> larger = one;
    larger.front().width += 1;
    BlockSubject subject;
    CHECK(RunBlocks(subject, larger).cases.begin()->second.reason.find("suite.json wants") !=
          std::string::npos);
}

TEST_CASE("blocks: damaged lists are refused without a crash") {
    const auto read = [](const std::string& text) { return ReadBlockCases(std::as_bytes(std::span(text))); };
    CHECK(read(R"({"version":4,"cases":[]})")->empty());
    CHECK_FALSE(read(R"({"blocks":1})"));
    CHECK_FALSE(read(R"({"blocks":[1]})"));
    CHECK_FALSE(read("[]"));
    const auto readOne = [&](const std::string& members) {
        return read(R"({"blocks":[{"name":"a","texels":"t","blocks":"b","about":"",)" + members + "}]}");
    };
    const std::string good =
        R"("format":"bc7","level":"best","alphaThreshold":-1,"width":4,"height":1024,"mustPass":true)";
    REQUIRE(readOne(good));
    CHECK(readOne(good)->front().mustPass);
    for (const auto& [from, to] : {std::pair<const char*, const char*>{"bc7", "bc8"},
                                   {"best", "bests"},
                                   {":-1", ":256"},
                                   {":4", ":0"},
                                   {"1024", "1025"},
                                   {"\"width\"", "\"widt\""}}) {
        std::string bad = good;
        bad.replace(bad.find(from), std::string(from).size(), to);
        CAPTURE(bad);
        CHECK_FALSE(readOne(bad));
    }
    CHECK_FALSE(read(R"({"blocks":[{"name":"a","texels":"../t","blocks":"b","about":"",)" + good + "}]}"));
    const std::string suite = ReadFolder(GetSuite().GetPath()).at(kSuiteFile);
    CHECK_FALSE(read(suite.substr(0, suite.size() - 10)));
}
