// SPDX-License-Identifier: MIT
// A deliberately wrong decoder that speaks the adapter protocol: `wrong_decoder MISTAKE`. It tests the conformance suite.
// Without a mistake it is the independent model. The words of kManners misbehave instead.
#include "conformance/ModelMistakes.h"
#include "conformance/Subject.h"

#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <thread>

namespace {

using namespace openntc::conformance;

constexpr const char* kManners[] = {
    "crash", // and the next four: at the first texels
    "exit",
    "hang",
    "garbage",
    "endless",
    "extra_line", // one line too many behind every answer
    "crash_after_answer",
    "crash_at_second_set",
    "unsupported_when_hard" // claims everything and decodes the first set alone
};

// The independent model behind a manner.
class Misbehaving final : public Subject {
public:
    explicit Misbehaving(std::string manner) : manner_(std::move(manner)) {}
    std::string GetName() const override { return "misbehaves: " + manner_; }
    // No others: most of the suite must pass or be skipped.
    Capabilities GetCapabilities() override {
        Capabilities capabilities;
        capabilities.math[static_cast<std::size_t>(openntc::DecodeMath::Int8)] = true;
        capabilities.math[static_cast<std::size_t>(openntc::DecodeMath::Int8Half)] = true;
        capabilities.linear = true;
        return capabilities;
    }
    Arithmetic GetArithmetic() const override { return Arithmetic::Host; }
    void Open(const std::string& path) override {
        ++sets_;
        if (sets_ == 2 && manner_ == "crash_at_second_set")
            std::raise(SIGSEGV);
        if (sets_ >= 2 && manner_ == "unsupported_when_hard")
            throw SubjectError(SubjectError::Kind::NotSupported, "too hard");
        model_->Open(path);
    }
    std::vector<Outputs> DecodeTexels(std::span<const openntc::tool::Texel> texels,
                                      const openntc::DecodeOptions& options) override {
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
        std::vector<Outputs> values = model_->DecodeTexels(texels, options);
        if (manner_ == "extra_line")
            values.emplace_back();
        if (manner_ == "crash_after_answer")
            std::fclose(stdin); // ServeSubject ends when it has written the answer
        return values;
    }

private:
    std::string manner_;
    std::unique_ptr<Subject> model_ = MakeModelSubject(Mistake::None);
    int sets_ = 0;
};

} // namespace

int main(int argc, char** argv) {
    const std::string word = argc > 1 ? argv[1] : "";
    std::unique_ptr<Subject> subject;
    std::string all; // mistakes, a line each
    const auto find = [&](auto mistakes) {
        for (const auto& info : mistakes) {
            all += std::string(info.name) + ": " + info.cause + "\n";
            if (word == info.name)
                subject = MakeModelSubject(info.mistake);
        }
    };
    find(ListMistakes());
    find(ListBlockMistakes());
    find(ListTextureMistakes());
    find(ListFilterMistakes());
    if (word.empty())
        subject = MakeModelSubject(Mistake::None);
    for (const char* manner : kManners) {
        if (word == manner)
            subject = std::make_unique<Misbehaving>(word);
    }
    if (subject == nullptr) {
        std::fputs(all.c_str(), stderr);
        return 2;
    }
    ServeSubject(*subject);
    if (word == "crash_after_answer")
        std::raise(SIGSEGV);
    return 0;
}
