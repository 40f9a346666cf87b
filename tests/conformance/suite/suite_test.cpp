// SPDX-License-Identifier: MIT
// The exported suite: deterministic files, passed by every decoder of ours and by an independent model, and failed by
// each planted mistake on the case that is meant for it. Adapters that crash, hang or talk nonsense fail and nothing else.
#include "cli/Program.h"
#include "models/FP8Interval.h"
#include "support/Vectors.h"
#include "unit/decode/ModeSets.h"

#include "Failure.h"
#include "conformance/Runner.h"

#include <doctest/doctest.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>
#include <string>
#include <vector>

using namespace openntc;
using namespace openntc::conformance;
namespace fs = std::filesystem;

namespace {

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

const ExportedSuite& GetSuite() {
    static const ExportedSuite suite;
    return suite;
}

struct Run {
    Totals totals;
    std::map<std::string, CaseResult> cases;
    std::string problems; // lines of what did not pass
};

Run RunAll(Subject& subject, const std::string& folder, bool mustPassOnly = false) {
    Run run;
    run.totals = RunFolder(folder, subject, mustPassOnly, [&](const CaseResult& result) {
        run.cases[result.name] = result;
        if (result.outcome != Outcome::Pass)
            run.problems += result.GetLine() + "\n";
    });
    return run;
}

std::unique_ptr<Subject> MakeAdapter(std::vector<std::string> command, double timeoutSeconds = 60) {
    return MakeAdapterSubject({std::move(command), timeoutSeconds});
}

std::map<std::string, std::string> ReadFolder(const std::string& folder) {
    std::map<std::string, std::string> files;
    for (const auto& entry : fs::directory_iterator(folder)) {
        std::ifstream file(entry.path(), std::ios::binary);
        files[entry.path().filename().string()] = {std::istreambuf_iterator<char>(file),
                                                   std::istreambuf_iterator<char>()};
    }
    return files;
}

// FP8 as an NVIDIA H100 evaluates it; `offset` is added to what it returns.
class HardwareSubject final : public Subject {
public:
    explicit HardwareSubject(float offset)
        : offset_(offset), interval_({.halfInputs = true, .block = 16, .contraction = false}) {}
    std::string GetName() const override { return "hardware"; }
    Arithmetic GetArithmetic() const override { return Arithmetic::Vulkan; }
    Capabilities GetCapabilities() override {
        Capabilities capabilities;
        capabilities.math[static_cast<std::size_t>(DecodeMath::FP8)] = true;
        return capabilities;
    }
    void Open(const std::string& path) override { set_.emplace(tool::ReadAll(path)); }
    std::vector<Outputs> DecodeTexels(std::span<const tool::Texel> texels, const DecodeOptions&) override {
        const DecodeSource source = set_->GetSource(DecodeWeights::FP8);
        std::vector<Outputs> values(texels.size());
        for (std::size_t i = 0; i < texels.size(); ++i) {
            const auto bounds =
                interval_.Decode({source.constants, source.latents, source.weights, source.networkVersion},
                                 texels[i].mip, texels[i].x, texels[i].y);
            for (std::size_t c = 0; c < 16; ++c)
                values[i][c] = static_cast<float>(bounds[c].low) + offset_;
        }
        return values;
    }

private:
    float offset_;
    models::FP8Interval interval_;
    std::optional<test::ModeSet> set_;
};

} // namespace

TEST_CASE("export is deterministic and small, and says what it wrote") {
    const openntc_tests::Folder folder;
    const openntc_tests::ProgramResult second =
        openntc_tests::RunProgram(folder, "conformance export vectors --json");
    CHECK(second.code == 0);
    const auto files = ReadFolder(GetSuite().GetPath());
    CHECK(files == ReadFolder((folder / "vectors").string()));
    const rapidjson::Document said = openntc_tests::ParseValid(second.output, "conformance-export");
    CHECK(said["folder"].GetString() == std::string("vectors"));
    rapidjson::Document suite;
    suite.Parse(files.at(kSuiteFile).c_str());
    CHECK(said["cases"].GetUint() == suite["cases"].Size());
    CHECK(said["files"].Size() == files.size());
    for (const rapidjson::Value& file : said["files"].GetArray())
        CHECK(files.contains(fs::path(file.GetString()).filename().string()));
    std::size_t bytes = 0;
    for (const auto& [name, content] : files)
        bytes += content.size();
    CHECK(bytes < (2u << 20));
    CHECK(files.at("mustpass.txt").find("bilinear-weights\n") != std::string::npos);
}

TEST_CASE("our decoders pass in process") {
    const char* device = std::getenv("OPENNTC_TEST_DEVICE");
    const std::string name = device != nullptr ? device : "llvmpipe";
    for (const tool::BackendOptions& backend : {tool::BackendOptions{tool::Backend::Cpu, {}, {}, 0},
                                                {tool::Backend::Reference, {}, {}, 1},
                                                {tool::Backend::Vulkan, name, {}, 0}}) {
        CAPTURE(tool::GetName(backend.backend));
        try {
            const Run run = RunAll(*MakeBackendSubject(backend), GetSuite().GetPath());
            CHECK(run.problems.empty());
            CHECK(run.totals.passed > 120);
            CHECK(run.cases.at("plain-metadata").outcome == Outcome::Pass);
            openntc_tests::ReportVectors((std::string("suite-") + tool::GetName(backend.backend)).c_str(),
                                         run.totals.passed, run.totals.skipped);
        } catch (const tool::CommandError& error) {
            MESSAGE("SKIP: " << error.GetLine());
            CHECK(error.GetCode() == tool::ExitCode::NoDevice);
        }
    }
}

TEST_CASE("metadata is compared with what was exported") {
    const tool::BackendOptions backend{tool::Backend::Reference, {}, {}, 1};
    std::map<std::string, std::string> files = ReadFolder(GetSuite().GetPath());
    const fs::path folder =
        fs::temp_directory_path() / ("openntc-metadata-" + std::to_string(std::random_device()()));
    fs::create_directories(folder);
    std::string& json = files.at("plain.expect.json");
    const auto run = [&] {
        for (const std::string name : {"plain.ntc", "plain.expect.json"})
            std::ofstream(folder / name, std::ios::binary) << files.at(name);
        return RunAll(*MakeBackendSubject(backend), folder.string()).cases.at("plain");
    };
    const CaseResult right = run();
    CHECK(right.outcome == Outcome::Pass);
    CHECK(right.metadata.constants == 2);
    CHECK(right.metadata.streamRanges == 10);
    const std::size_t width = json.find("\"width\": 25");
    REQUIRE(width != std::string::npos);
    json[width + 10] = '6'; // 25 to 26
    const CaseResult wrong = run();
    CHECK(wrong.outcome == Outcome::Fail);
    CHECK(wrong.reason == "width: 25: expected 26");
    std::error_code ignored;
    fs::remove_all(folder, ignored);
}

TEST_CASE("our decoders pass behind the adapter protocol") {
    for (const std::string backend : {"cpu", "reference"}) {
        CAPTURE(backend);
        const Run run = RunAll(*MakeAdapter({NTC_PROGRAM, "conformance", "serve", "--backend", backend}),
                               GetSuite().GetPath());
        CHECK(run.problems.empty());
    }
}

TEST_CASE("an independent model agrees on every value") {
    const Run run = RunAll(*MakeAdapter({WRONG_DECODER}), GetSuite().GetPath());
    CHECK(run.problems.empty());
}

TEST_CASE("the example library passes what it supports and skips the rest") {
    const Run run = RunAll(*MakeAdapter({NTC_PROGRAM, "conformance", "serve", "--library", EXAMPLE_ADAPTER}),
                           GetSuite().GetPath());
    CHECK(run.totals.failed == 0);
    CHECK(run.cases.at("bilinear-weights").outcome == Outcome::Pass);
    CHECK(run.cases.at("network-small-fp16").outcome == Outcome::Skip);
    CHECK(run.cases.at("network-small-fp16").reason == "not supported: fp16");
    CHECK(run.cases.at("bilinear-weights").device == "OpenNTC reference decoder as an example adapter");
}

TEST_CASE("FP8 hardware passes inside the intervals only") {
    HardwareSubject hardware(0);
    const Run right = RunAll(hardware, GetSuite().GetPath());
    HardwareSubject other(1);
    const Run wrong = RunAll(other, GetSuite().GetPath(), true);
    for (const std::string name :
         {"network-small", "network-medium", "network-large", "network-xlarge", "fp8-saturation"}) {
        CAPTURE(name);
        const std::string hardwareName =
            name == "fp8-saturation" ? name + "-hardware" : name + "-fp8-hardware";
        CHECK(right.cases.at(hardwareName).outcome == Outcome::Pass);
        CHECK(right.cases.at(hardwareName).suite.worstAccepted > 0); // not the emulation's results
        CHECK(wrong.cases.at(hardwareName).outcome == Outcome::Fail);
        CHECK(wrong.cases.at(hardwareName).GetWorstError() > 0);
        CHECK(wrong.cases.at(hardwareName).GetLine().find(" or from ") != std::string::npos);
    }
    CHECK(right.cases.at("network-small-fp8").outcome == Outcome::Fail); // bit for bit: optional
    CHECK(wrong.totals.passed == 0);
    const Run unsaturated =
        RunAll(*MakeModelSubject(Mistake::FP8SaturationMissing), GetSuite().GetPath(), true);
    CHECK(unsaturated.cases.at("fp8-saturation-hardware").outcome == Outcome::Fail);
    CHECK(unsaturated.cases.at("fp8-saturation-hardware").suite.cause.find("448") != std::string::npos);
}

TEST_CASE("every planted mistake fails on the case meant for it, with its cause") {
    CHECK(ListMistakes().size() >= 12);
    for (const MistakeInfo& info : ListMistakes()) {
        CAPTURE(info.name);
        // The optional cases take most of the time; those of FP8 mistakes are among them.
        const bool isOptional = std::string(info.caseName).starts_with("fp8");
        const Run run = RunAll(*MakeAdapter({WRONG_DECODER, info.name}), GetSuite().GetPath(), !isOptional);
        const auto found = run.cases.find(info.caseName);
        REQUIRE(found != run.cases.end());
        const std::string line = found->second.GetLine();
        CAPTURE(line);
        CHECK(found->second.outcome == Outcome::Fail);
        CHECK(found->second.GetWorstError() > 0);
        CHECK(line.find(std::string("looks like: ") + info.cause) != std::string::npos);
        for (const auto& [name, result] : run.cases) { // no other mistake is blamed anywhere
            if (!result.suite.cause.empty())
                CHECK(result.suite.cause == info.cause);
        }
    }
}

TEST_CASE("adapters that crash, hang, exit or talk nonsense fail with the reason") {
    const std::pair<const char*, const char*> kManners[] = {
        {"crash", "adapter: ended by signal 11"},
        {"exit", "adapter: ended with exit code 3"},
        {"garbage", "adapter: garbage: \"segmentation imminent\" instead of `ok`"},
        {"endless", "adapter: a line of more than 65536 characters"},
        {"hang", "adapter: no answer within 0.5 s"}};
    for (const auto& expected : kManners) {
        const std::string manner = expected.first;
        const std::string reason = expected.second;
        CAPTURE(manner);
        const auto start = std::chrono::steady_clock::now();
        const Run run =
            RunAll(*MakeAdapter({WRONG_DECODER, manner}, manner == "hang" ? 0.5 : 60), GetSuite().GetPath());
        CHECK(run.totals.passed == 0);
        CHECK(run.totals.skipped == 0);
        CHECK(run.problems.find(reason) != std::string::npos);
        CHECK(std::chrono::steady_clock::now() - start < std::chrono::seconds(120));
    }
    CHECK_THROWS_AS(MakeAdapter({"./no-such-adapter"}), tool::CommandError);
}

TEST_CASE("damaged suites are refused without a crash") {
    const std::string suite = ReadFolder(GetSuite().GetPath()).at(kSuiteFile);
    const auto read = [](const std::string& text) { return ReadSuite(std::as_bytes(std::span(text))); };
    CHECK(read(suite));
    CHECK_FALSE(read(suite.substr(0, suite.size() / 2)));
    CHECK_FALSE(read("[]"));
    CHECK(read(R"({"version":1,"cases":[]})"));
    CHECK_FALSE(read(R"({"version":3,"cases":[]})"));
    CHECK_FALSE(read(
        R"({"version":2,"cases":[{"name":"a","set":"x.ntc","values":"v","math":"fp8","about":"","linear":true,"interval":true}]})"));
    CHECK_FALSE(read(
        R"({"version":1,"cases":[{"name":"a","set":"../x.ntc","values":"v","math":"int8","about":""}]})"));
    CHECK_FALSE(
        read(R"({"version":1,"cases":[{"name":"a","set":"x.ntc","values":"v","math":"int9","about":""}]})"));
    SuiteCase suiteCase;
    const std::vector<std::byte> values = WriteValues(std::vector<ValueRecord>(3), suiteCase);
    REQUIRE(ReadValues(values, suiteCase));
    CHECK(ReadValues(values, suiteCase)->size() == 3);
    for (std::size_t size = 0; size < values.size(); ++size)
        CHECK_FALSE(ReadValues(std::span(values).first(size), suiteCase));
    std::vector<std::byte> count = values;
    count[18] = std::byte{255}; // more records than bytes
    CHECK_FALSE(ReadValues(count, suiteCase));
    suiteCase.math = DecodeMath::FP8;
    CHECK_FALSE(ReadValues(values, suiteCase));
    suiteCase.math = DecodeMath::Int8;
    suiteCase.interval = true;
    CHECK_FALSE(ReadValues(values, suiteCase)); // version 1 has none
    std::vector<ValueRecord> records(2);
    CHECK(ReadValues(WriteValues(records, suiteCase), suiteCase));
    records[1].low[3] = 1; // above the output
    CHECK_FALSE(ReadValues(WriteValues(records, suiteCase), suiteCase));
}
