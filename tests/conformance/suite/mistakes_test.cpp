// SPDX-License-Identifier: MIT
// Every planted mistake fails on the case that is meant for it, with its cause and no other.
#include "ExportedSuite.h"

#include "conformance/ModelMistakes.h"

#include "openntc/decode/ReferenceDecoder.h"

using namespace openntc_tests;

namespace {

std::vector<SuiteCase> ChooseCase(const std::string& name) {
    return ChooseCases([&](const std::string& other) { return other == name; });
}

} // namespace

TEST_CASE("every planted mistake fails on the case meant for it, with its cause") {
    CHECK(ListMistakes().size() >= 100);
    for (const MistakeInfo& info : ListMistakes()) {
        if (info.kind == MistakeKind::State)
            continue;
        CAPTURE(std::string(info.name));
        const std::vector<SuiteCase> cases = ChooseCase(info.caseName);
        REQUIRE(cases.size() == 1);
        const Run run = RunCases(*MakeModelSubject(info.mistake), cases);
        const CaseResult& result = run.cases.at(info.caseName);
        const std::string line = result.GetLine();
        CAPTURE(line);
        CHECK(result.outcome == Outcome::Fail);
        CHECK(result.GetWorstError() > 0);
        CHECK(line.find(std::string("looks like: ") + info.cause) != std::string::npos);
    }
}

TEST_CASE("no other mistake is blamed anywhere") {
    std::size_t number = 0;
    for (const MistakeInfo& info : ListMistakes()) {
        if (info.kind == MistakeKind::State)
            continue;
        CAPTURE(std::string(info.name));
        // A tenth of the suite, another for each mistake; all of it took minutes and found no more.
        std::size_t index = 0;
        ++number;
        const Run run =
            RunCases(*MakeModelSubject(info.mistake),
                     ChooseCases([&](const std::string&) { return index++ % 10 == number % 10; }));
        for (const auto& entry : run.cases) {
            CAPTURE(entry.first);
            if (!entry.second.suite.cause.empty())
                CHECK(entry.second.suite.cause == info.cause);
        }
    }
}

TEST_CASE("what is left of the set before is called state") {
    const std::vector<SuiteCase> row =
        ChooseCases([](const std::string& name) { return name.starts_with("state-"); });
    CHECK(row.size() == 11);
    for (const MistakeInfo& info : ListMistakes()) {
        if (info.kind != MistakeKind::State)
            continue;
        CAPTURE(std::string(info.name));
        const Run run = RunCases(*MakeModelSubject(info.mistake), row);
        const CaseResult& result = run.cases.at(info.caseName);
        const std::string line = result.GetLine();
        CAPTURE(line);
        CHECK(result.outcome == Outcome::Fail);
        CHECK(line.find("passes alone in a fresh process: state of an earlier set") != std::string::npos);
        CHECK(run.cases.at("state-first").outcome == Outcome::Pass);
    }
    // The same behind the protocol: the program is started again.
    const Run run = RunCases(*MakeAdapter({WRONG_DECODER, "kept_biases"}), row);
    CHECK(run.cases.at("state-biases").reason.find("state of an earlier set") != std::string::npos);
}

TEST_CASE("slices cut as LibNTC cuts them are named where sizes do not halve") {
    class Published final : public Subject {
    public:
        std::string GetName() const override { return "published cut"; }
        Capabilities GetCapabilities() override {
            return {{false, true, true}, true, true, true, true, true};
        }
        Arithmetic GetArithmetic() const override { return Arithmetic::Host; }
        void Open(const std::string& path) override { set_.emplace(tool::LoadTextureSet(path)); }
        std::vector<Outputs> DecodeTexels(std::span<const tool::Texel>, const DecodeOptions&) override {
            throw SubjectError(SubjectError::Kind::Failed, "only slices");
        }
        std::vector<Outputs> DecodeSlice(const SliceRequest& slice, const DecodeOptions& options) override {
            const tool::DecodeData data = tool::LoadSliceData(
                *set_, options.math,
                {slice.firstMip, static_cast<int>(slice.parts.size()), slice.rect, SliceCoverage::Published});
            std::vector<Outputs> values;
            int mip = slice.firstMip;
            for (const Rect& part : slice.parts) {
                std::vector<Outputs> some(static_cast<std::size_t>(part.width * part.height));
                if (!some.empty())
                    CHECK(DecodeReference(data.GetSource(), mip, part, options,
                                          {some.data()->data(), 16 * some.size()}));
                values.insert(values.end(), some.begin(), some.end());
                ++mip;
            }
            return values;
        }

    private:
        std::optional<tool::TextureSet> set_;
    };
    Published subject;
    const Run run =
        RunCases(subject, ChooseCases([](const std::string& name) { return name.starts_with("slice"); }));
    CHECK(run.totals.failed >= 1);
    CHECK(run.totals.passed >= 15);
    CHECK(run.cases.at("slice-mips").outcome == Outcome::Pass);
    CHECK(run.cases.at("slice-mips-odd").outcome == Outcome::Fail);
    CHECK(run.cases.at("slice-mips-odd").suite.cause.find("their coarsest mip needs") != std::string::npos);
}

TEST_CASE("channels in any order are named") {
    class Shuffled final : public Subject {
    public:
        std::string GetName() const override { return "shuffled"; }
        Capabilities GetCapabilities() override { return model_->GetCapabilities(); }
        Arithmetic GetArithmetic() const override { return Arithmetic::Host; }
        void Open(const std::string& path) override { model_->Open(path); }
        std::vector<Outputs> DecodeTexels(std::span<const tool::Texel> texels,
                                          const DecodeOptions& options) override {
            std::vector<Outputs> values = model_->DecodeTexels(texels, options);
            for (Outputs& outputs : values) {
                const Outputs right = outputs;
                for (std::size_t c = 0; c < 16; ++c)
                    outputs[c] = right[(7 * c + 3) % 16];
            }
            return values;
        }

    private:
        std::unique_ptr<Subject> model_ = MakeModelSubject(Mistake::None);
    };
    Shuffled subject;
    for (const char* name : {"outputs", "network-small-int8", "srgb"}) {
        const Run run = RunCases(subject, ChooseCase(name));
        CHECK(run.cases.at(name).suite.cause ==
              "channels are in another order: 3 10 1 8 15 6 13 4 11 2 9 0 7 14 5 12");
    }
}

TEST_CASE("wrong values that no mistake explains name no cause") {
    class Offset final : public Subject {
    public:
        std::string GetName() const override { return "offset"; }
        Capabilities GetCapabilities() override { return model_->GetCapabilities(); }
        Arithmetic GetArithmetic() const override { return Arithmetic::Host; }
        void Open(const std::string& path) override { model_->Open(path); }
        std::vector<Outputs> DecodeTexels(std::span<const tool::Texel> texels,
                                          const DecodeOptions& options) override {
            std::vector<Outputs> values = model_->DecodeTexels(texels, options);
            for (Outputs& outputs : values)
                outputs[14] += 0.0625f;
            return values;
        }

    private:
        std::unique_ptr<Subject> model_ = MakeModelSubject(Mistake::None);
    };
    Offset subject;
    const Run run = RunCases(subject, ChooseCases([](const std::string& name) {
                                 return name.starts_with("network-") || name == "srgb" || name == "hlg" ||
                                        name == "accumulator";
                             }));
    CHECK(run.totals.passed == 0);
    for (const auto& entry : run.cases) {
        CAPTURE(entry.first);
        CHECK(entry.second.suite.cause == "");
        CHECK(entry.second.reason.find("; covers: ") != std::string::npos);
    }
}
