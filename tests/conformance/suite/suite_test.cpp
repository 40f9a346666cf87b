// SPDX-License-Identifier: MIT
// The exported suite: deterministic files, those of version 2 among them as they were, passed by every decoder of ours and
// by an independent model that reads the files itself.
#include "ExportedSuite.h"
#include "Version2Checksums.h"
#include "models/FP8Interval.h"
#include "support/Vectors.h"
#include "unit/decode/ModeSets.h"

#include "conformance/SuiteCoverage.h"

#include "openntc/core/Crc32.h"

using namespace openntc_tests;

namespace {

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
    std::optional<decode_test::ModeSet> set_;
};

} // namespace

TEST_CASE("export is deterministic and small, and says what it wrote") {
    const Folder folder;
    const ProgramResult second = RunProgram(folder, "conformance export vectors --json");
    CHECK(second.code == 0);
    const auto files = ReadFolder(GetSuite().GetPath());
    CHECK(files == ReadFolder((folder / "vectors").string()));
    const rapidjson::Document said = ParseValid(second.output, "conformance-export");
    CHECK(said["folder"].GetString() == std::string("vectors"));
    rapidjson::Document suite;
    suite.Parse(files.at(kSuiteFile).c_str());
    CHECK(said["cases"].GetUint() == suite["cases"].Size() + suite["blocks"].Size() +
                                         suite["textures"].Size() + suite["filtering"].Size());
    CHECK(said["files"].Size() == files.size());
    for (const rapidjson::Value& file : said["files"].GetArray())
        CHECK(files.contains(fs::path(file.GetString()).filename().string()));
    std::size_t bytes = 0;
    for (const auto& [name, content] : files)
        bytes += content.size();
    CHECK(bytes < (9u << 19));
    CHECK(files.at("mustpass.txt").find("bilinear-weights\n") != std::string::npos);
}

TEST_CASE("files of version 2 are as that version exported them") {
    const auto files = ReadFolder(GetSuite().GetPath());
    for (const FileChecksum& file : kVersion2Files) {
        CAPTURE(std::string(file.name));
        REQUIRE(files.contains(file.name));
        CHECK(Crc32(std::as_bytes(std::span(files.at(file.name)))) == file.crc32);
    }
}

TEST_CASE("every end of every field and every pair is covered by a case") {
    const std::vector<CoverageItem> items = MeasureCoverage(MakeSuite());
    CHECK(items.size() > 2800);
    std::string uncovered;
    for (const CoverageItem& item : items)
        uncovered += item.cases.empty() ? item.what + "\n" : "";
    CHECK(uncovered == "");
    CHECK(ReadFolder(GetSuite().GetPath()).at("coverage.txt") == WriteCoverage(items));
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
            // The Vulkan decoder only decodes: the passes and filters are compared in shader_bc, shader_passes and
            // shader_filtering.
            const bool isVulkan = backend.backend == tool::Backend::Vulkan;
            std::istringstream problems(run.problems);
            for (std::string line; std::getline(problems, line);)
                CHECK_MESSAGE(
                    (isVulkan && (line.starts_with("SKIP blocks-") || line.starts_with("SKIP textures-") ||
                                  line.starts_with("SKIP filtering-"))),
                    line);
            CHECK(run.totals.passed > 280);
            CHECK(run.cases.at("plain-metadata").outcome == Outcome::Pass);
            ReportVectors((std::string("suite-") + tool::GetName(backend.backend)).c_str(), run.totals.passed,
                          run.totals.skipped);
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
    for (const char* name : {"slice-mips", "slice-mips-odd", "slice-mips-ends", "slice-mips-order"})
        CHECK(run.cases.at(name).outcome == Outcome::Pass);
    for (const BlockSuiteCase& blockCase : GetBlockCases())
        CHECK(run.cases.at(blockCase.name).outcome == Outcome::Pass);
    for (const char* name : {"textures-placed", "textures-sixteen", "textures-to-hlg", "textures-floats",
                             "filtering-catmull-rom-pair", "filtering-edges", "filtering-all-anisotropic"})
        CHECK(run.cases.at(name).outcome == Outcome::Pass);
}

TEST_CASE("slices of several mips are asked of those that claim them") {
    // Values of a mip that the slice has not, and a slice that reaches out of the set, are faults of the folder.
    SuiteCase odd;
    for (const SuiteCase& suiteCase : GetCases())
        odd = suiteCase.name == "slice-mips-odd" ? suiteCase : odd;
    REQUIRE(odd.slice);
    CHECK(odd.sliceMip == 0);
    CHECK(odd.sliceMips == 4);
    CHECK(RunCases(*MakeModelSubject(Mistake::None), {odd}).totals.passed == 1);
    SuiteCase fewer = odd;
    fewer.sliceMips = 2; // the values are of three: the fourth ends before the slice
    const auto getReason = [&] {
        const Run run = RunCases(*MakeModelSubject(Mistake::None), {fewer});
        CHECK(run.totals.failed == 1);
        return run.cases.at("slice-mips-odd").reason;
    };
    CHECK(getReason().find("texel: of a mip that the slice has not") != std::string::npos);
    fewer.sliceMips = 13;
    CHECK(getReason().find("slice: mips outside the set") != std::string::npos);
    fewer.sliceMips = 4;
    fewer.slice->width = 8; // of 7 to the edge
    CHECK(getReason().find("slice: outside the mip") != std::string::npos);

    class OneMip final : public Subject {
    public:
        std::string GetName() const override { return "slices of one mip"; }
        Capabilities GetCapabilities() override {
            Capabilities capabilities = model_->GetCapabilities();
            capabilities.sliceMips = false;
            return capabilities;
        }
        Arithmetic GetArithmetic() const override { return Arithmetic::Host; }
        void Open(const std::string& path) override { model_->Open(path); }
        std::vector<Outputs> DecodeTexels(std::span<const tool::Texel> texels,
                                          const DecodeOptions& options) override {
            return model_->DecodeTexels(texels, options);
        }
        std::vector<Outputs> DecodeSlice(const SliceRequest& slice, const DecodeOptions& options) override {
            CHECK(slice.parts.size() == 1);
            return model_->DecodeSlice(slice, options);
        }

    private:
        std::unique_ptr<Subject> model_ = MakeModelSubject(Mistake::None);
    };
    OneMip subject;
    const Run run =
        RunCases(subject, ChooseCases([](const std::string& name) { return name.starts_with("slice"); }));
    CHECK(run.totals.failed == 0);
    CHECK(run.totals.passed >= 11);
    CHECK(run.totals.skipped >= 9);
    CHECK(run.cases.at("slice-mips-images").reason == "not supported: slice_mips");
    CHECK(run.cases.at("slice-odd-mip").outcome == Outcome::Pass);
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

TEST_CASE("damaged suites are refused without a crash") {
    const std::string suite = ReadFolder(GetSuite().GetPath()).at(kSuiteFile);
    const auto read = [](const std::string& text) { return ReadSuite(std::as_bytes(std::span(text))); };
    CHECK(read(suite));
    CHECK_FALSE(read(suite.substr(0, suite.size() / 2)));
    CHECK_FALSE(read("[]"));
    CHECK(read(R"({"version":1,"cases":[]})"));
    CHECK(read(R"({"version":3,"cases":[]})"));
    CHECK(read(R"({"version":7,"cases":[]})"));
    CHECK_FALSE(read(R"({"version":8,"cases":[]})"));
    for (const std::string slice : {"[0,0,1]", "[-1,0,1,1]", "[0,0,0,1]", "[0,0,2000000,1]", "1"})
        CHECK_FALSE(
            read(R"({"version":3,"cases":[{"name":"a","set":"x.ntc","values":"v","math":"int8","about":"",)"
                 R"("slice":)" +
                 slice + "}]}"));
    CHECK_FALSE(read(
        R"({"version":3,"cases":[{"name":"a","set":"x.ntc","values":"v","math":"int8","about":"","wholeMip":true,"slice":[0,0,1,1]}]})"));
    const auto readMips = [&](const std::string& members) {
        return read(
            R"({"version":4,"cases":[{"name":"a","set":"x.ntc","values":"v","math":"int8","about":"",)" +
            members + "}]}");
    };
    const auto several = readMips(R"("slice":[4,0,3,1],"sliceMips":[2,3])");
    REQUIRE(several);
    CHECK(several->front().sliceMip == 2);
    CHECK(several->front().sliceMips == 3);
    for (const std::string mips :
         {"[2]", "[-1,2]", "[0,0]", "[0,17]", "[15,2]", "[0,2147483647]", "[0,\"1\"]", "3"})
        CHECK_FALSE(readMips(R"("slice":[0,0,1,1],"sliceMips":)" + mips));
    CHECK_FALSE(readMips(R"("sliceMips":[0,2])"));
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
