// SPDX-License-Identifier: MIT
// A deliberately wrong decoder that speaks the adapter protocol: `wrong_decoder MISTAKE`. It tests the conformance suite.
// Without a mistake it is the independent model. The words crash, hang, exit, garbage and endless misbehave instead.
#include "conformance/Subject.h"

#include <chrono>
#include <csignal>
#include <cstdio>
#include <string>
#include <thread>

namespace {

using namespace openntc::conformance;

// Answers the greeting, then misbehaves at the first texels.
class Misbehaving final : public Subject {
public:
    explicit Misbehaving(std::string manner) : manner_(std::move(manner)) {}
    std::string GetName() const override { return "misbehaves: " + manner_; }
    Capabilities GetCapabilities() override { return {{true, true, true, true, true}, true, true}; }
    Arithmetic GetArithmetic() const override { return Arithmetic::Host; }
    void Open(const std::string&) override {}
    std::vector<Outputs> DecodeTexels(std::span<const openntc::tool::Texel> texels,
                                      const openntc::DecodeOptions&) override {
        if (manner_ == "crash")
            std::raise(SIGSEGV);
        if (manner_ == "exit")
            std::exit(3);
        if (manner_ == "hang")
            std::this_thread::sleep_for(std::chrono::hours(1));
        if (manner_ == "garbage")
            std::printf("segmentation imminent\n");
        while (manner_ == "endless")
            std::printf("0000000000000000");
        return std::vector<Outputs>(texels.size());
    }

private:
    std::string manner_;
};

} // namespace

int main(int argc, char** argv) {
    const std::string word = argc > 1 ? argv[1] : "";
    std::unique_ptr<Subject> subject;
    for (const MistakeInfo& info : ListMistakes()) {
        if (word == info.name)
            subject = MakeModelSubject(info.mistake);
    }
    if (word.empty())
        subject = MakeModelSubject(Mistake::None);
    for (const char* manner : {"crash", "hang", "exit", "garbage", "endless"}) {
        if (word == manner)
            subject = std::make_unique<Misbehaving>(word);
    }
    if (subject == nullptr) {
        for (const MistakeInfo& info : ListMistakes())
            std::fprintf(stderr, "%s: %s\n", info.name, info.cause);
        return 2;
    }
    ServeSubject(*subject);
    return 0;
}
