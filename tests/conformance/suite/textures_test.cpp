// SPDX-License-Identifier: MIT
// The suite's cases of textures: what they cover, mistakes named, capabilities, damaged lists.
#include "ExportedSuite.h"

#include "conformance/TextureRunner.h"

#include <set>

using namespace openntc_tests;

namespace {

std::vector<TextureSuiteCase> GetTextureCases() {
    return *ReadTextureCases(tool::ReadAll((fs::path(GetSuite().GetPath()) / kSuiteFile).string()));
}

Run RunTextures(Subject& subject, const std::vector<TextureSuiteCase>& cases, bool mustPassOnly = false) {
    Run run;
    RunTextureCases(GetSuite().GetPath(), cases, subject, mustPassOnly,
                    [&](const CaseResult& result) { run.Take(result); });
    return run;
}

/// The independent model, whose textures are then changed.
class TextureSubject : public Subject {
public:
    std::string GetName() const override { return "textures"; }
    Capabilities GetCapabilities() override { return model_->GetCapabilities(); }
    Arithmetic GetArithmetic() const override { return Arithmetic::Host; }
    void Open(const std::string& path) override { model_->Open(path); }
    std::vector<Outputs> DecodeTexels(std::span<const tool::Texel>, const DecodeOptions&) override {
        return {};
    }
    Textures MakeTextures(const TextureRequest& request) override {
        Textures textures = model_->MakeTextures(request);
        Spoil(textures);
        return textures;
    }

protected:
    virtual void Spoil(Textures&) {}

private:
    std::unique_ptr<Subject> model_ = MakeModelSubject(Mistake::None);
};

} // namespace

TEST_CASE(
    "textures: rectangles, places, every number of channels, colour spaces, codes and floats have cases") {
    std::set<std::string> facts;
    for (const TextureSuiteCase& textureCase : GetTextureCases()) {
        const TextureRequest& request = textureCase.request;
        CHECK(facts.insert(textureCase.name).second);
        CHECK(textureCase.mustPass);
        facts.insert(request.mip > 0 ? "coarser mip" : "mip 0");
        if (request.destinationLeft != request.rect.left && request.textureWidth > request.rect.width)
            facts.insert("placed");
        facts.insert("outputs " + std::to_string(request.outputs.size()));
        for (const TextureOutput& output : request.outputs) {
            facts.insert("channels " + std::to_string(output.channels));
            facts.insert("bits " + std::to_string(output.bits));
            facts.insert(std::string("rgb ") + GetColorSpaceWord(output.rgb));
            facts.insert(std::string("alpha ") + GetColorSpaceWord(output.alpha));
            if (output.firstChannel + output.channels == 16)
                facts.insert("channel 15");
        }
    }
    for (const char* fact :
         {"coarser mip", "mip 0", "placed", "outputs 16", "outputs 2", "channels 1", "channels 2",
          "channels 3", "channels 4", "bits 0", "bits 8", "bits 16", "rgb linear", "rgb srgb", "rgb hlg",
          "alpha linear", "alpha srgb", "alpha hlg", "channel 15"})
        CHECK_MESSAGE(facts.contains(fact), fact);
}

TEST_CASE(
    "textures: each planted mistake fails on the case meant for it, with its cause, and no other is blamed") {
    for (const TextureMistakeInfo& info : ListTextureMistakes()) {
        CAPTURE(std::string(info.name));
        const Run run = RunTextures(*MakeModelSubject(info.mistake), GetTextureCases());
        CheckBlamed(run, info.caseName, info.cause);
    }
}

TEST_CASE("textures: behind the protocol, right and wrong ones; those that claim none are not asked") {
    const std::vector<TextureSuiteCase> cases = GetTextureCases();
    CHECK(RunTextures(*MakeAdapter({WRONG_DECODER}), cases).problems.empty());
    const Run wrong = RunTextures(*MakeAdapter({WRONG_DECODER, "textures_destination"}), cases);
    CHECK(wrong.cases.at("textures-placed").suite.cause.find("at its own place") != std::string::npos);
    const Run none = RunTextures(*MakeAdapter({WRONG_DECODER, "crash"}), cases, true);
    CHECK(none.totals.skipped == static_cast<int>(cases.size()));
    CHECK(none.cases.at("textures-codes").reason == "not supported: textures");
}

TEST_CASE(
    "textures: one wrong code fails without a cause; a wrong number of bytes and what is refused are said") {
    const std::vector<TextureSuiteCase> one = {GetTextureCases().front()};
    class OneCode final : public TextureSubject {
        void Spoil(Textures& textures) override { textures.front()[4 * 9 + 2] ^= std::byte{2}; }
    };
    OneCode oneCode;
    const CaseResult wrong = RunTextures(oneCode, one).cases.begin()->second;
    CHECK(wrong.outcome == Outcome::Fail);
    CHECK(wrong.reason.find("output 0 texel (0, 1) component 2: ") == 0);
    CHECK(wrong.reason.find("; 1 of 504 components differ; covers: ") != std::string::npos);
    class Short final : public TextureSubject {
        void Spoil(Textures& textures) override { textures.back().pop_back(); }
    };
    Short tooShort;
    CHECK(RunTextures(tooShort, one).cases.begin()->second.reason ==
          "textures: not as many bytes as they have");
    class Refuses final : public TextureSubject {
        void Spoil(Textures&) override {
            throw SubjectError(SubjectError::Kind::NotSupported, "no such format");
        }
    };
    Refuses refuses;
    CHECK(RunTextures(refuses, one).totals.skipped == 1);
    CHECK(RunTextures(refuses, one, true).totals.failed == 1);
    std::vector<TextureSuiteCase> outside = one; // of a mip that is 25 wide
    outside.front().request.rect.left = 17;
    TextureSubject subject;
    CHECK(RunTextures(subject, outside).cases.begin()->second.reason.find("outside the mip") !=
          std::string::npos);
}

TEST_CASE("textures: damaged lists are refused without a crash") {
    const auto read = [](const std::string& text) {
        return ReadTextureCases(std::as_bytes(std::span(text)));
    };
    CHECK(read(R"({"version":5})")->empty());
    CHECK_FALSE(read(R"({"textures":1})"));
    CHECK_FALSE(read(R"({"textures":[1]})"));
    const std::string good =
        R"({"textures":[{"name":"a","set":"s.ntc","values":"v","about":"","math":"int8","mip":0,"rect":[0,0,4,4],)"
        R"("destination":[1,0],"size":[5,4],"outputs":[{"firstChannel":13,"channels":3,"rgb":"srgb",)"
        R"("alpha":"hlg","bits":16}]}]})";
    REQUIRE(read(good));
    CHECK(read(good)->front().request.outputs.front().alpha == ColorSpace::HLG);
    for (const auto& [from, to] : {std::pair<const char*, const char*>{"s.ntc", "../s"},
                                   {"int8", "int9"},
                                   {"\"mip\":0", "\"mip\":16"},
                                   {"[0,0,4,4]", "[0,0,4]"},
                                   {"[0,0,4,4]", "[0,0,0,4]"},
                                   {"[1,0]", "[2,0]"},
                                   {"[5,4]", "[5,1025]"},
                                   {"13", "14"},
                                   {"srgb", "rgb"},
                                   {"\"bits\":16", "\"bits\":9"},
                                   {"[{\"firstChannel\"", "[1,{\"firstChannel\""}}) {
        std::string bad = good;
        bad.replace(bad.find(from), std::string(from).size(), to);
        CAPTURE(bad);
        CHECK_FALSE(read(bad));
    }
}
