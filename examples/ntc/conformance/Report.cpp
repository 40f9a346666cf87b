// SPDX-License-Identifier: MIT
#include "Report.h"

#include "../Json.h"
#include "../Output.h"

namespace openntc::conformance {

namespace {

using tool::Format;
using tool::JsonWriter;

class TextReport final : public Report {
public:
    std::string Add(const CaseResult& result) override { return result.GetLine() + "\n"; }
    std::string Finish(const Totals& totals) override { return totals.GetLine() + "\n"; }
};

class JsonReport final : public Report {
public:
    explicit JsonReport(const std::string& subject) {
        json_.BeginObject();
        json_.Member("backend", std::string_view(subject));
        json_.Key("cases");
        json_.BeginArray();
    }

    std::string Add(const CaseResult& result) override {
        if (!result.device.empty())
            device_ = result.device;
        json_.BeginObject();
        json_.Member("name", std::string_view(result.name));
        json_.Member("outcome", GetName(result.outcome));
        json_.Member("reason", std::string_view(result.reason));
        json_.Member("mustPass", result.mustPass);
        json_.Member("covers", std::string_view(result.about));
        json_.Member("looksLike", std::string_view(result.suite.cause));
        json_.Member("worstError", result.GetWorstError());
        json_.Member("seconds", result.seconds);
        json_.Member("metadataFields", result.metadata.fields);
        json_.Member("fusedMips", result.metadata.fusedMips);
        json_.Member("streamRanges", result.metadata.streamRanges);
        json_.Member("constants", result.metadata.constants);
        json_.Member("weightBuffers", result.metadata.weights);
        json_.Member("texels", static_cast<std::uint64_t>(result.texels.exact + result.suite.texels));
        json_.Member("worstInt8", result.texels.worstFloat);
        json_.Member("worstInt8Half", result.texels.worstHalf);
        json_.Member("worstLinear", result.texels.worstLinear);
        json_.Member("worstLinearOverBound", result.texels.worstLinearRatio);
        json_.Key("psnr");
        result.texels.psnr ? json_.Value(*result.texels.psnr) : json_.Null();
        json_.Key("psnrOfExactValues");
        result.texels.psnrExact ? json_.Value(*result.texels.psnrExact) : json_.Null();
        json_.EndObject();
        return {};
    }

    std::string Finish(const Totals& totals) override {
        json_.EndArray();
        json_.Member("device", std::string_view(device_));
        json_.Member("passed", totals.passed);
        json_.Member("failed", totals.failed);
        json_.Member("skipped", totals.skipped);
        json_.EndObject();
        return json_.Take();
    }

private:
    JsonWriter json_;
    std::string device_;
};

std::string EscapeXml(std::string_view text) {
    return tool::EscapeMarkup(tool::MakeValidUtf8(tool::Printable(text)));
}

class JunitReport final : public Report {
public:
    JunitReport(const std::string& subject, const std::string& folder) : subject_(subject), folder_(folder) {}

    std::string Add(const CaseResult& result) override {
        seconds_ += result.seconds;
        cases_ += Format("    <testcase classname=\"%s\" name=\"%s\" time=\"%.3f\"", subject_.c_str(),
                         EscapeXml(result.name).c_str(), result.seconds);
        const std::string reason = EscapeXml(result.reason);
        if (result.outcome == Outcome::Fail)
            cases_ += Format(
                ">\n      <failure message=\"%s\" type=\"%s\">worst error %.9g</failure>\n    </testcase>\n",
                reason.c_str(), result.mustPass ? "mustpass" : "optional", result.GetWorstError());
        else if (result.outcome == Outcome::Skip)
            cases_ += Format(">\n      <skipped message=\"%s\"/>\n    </testcase>\n", reason.c_str());
        else
            cases_ += "/>\n";
        return {};
    }

    std::string Finish(const Totals& totals) override {
        const std::string counts =
            Format("tests=\"%d\" failures=\"%d\" skipped=\"%d\" time=\"%.3f\"",
                   totals.passed + totals.failed + totals.skipped, totals.failed, totals.skipped, seconds_);
        return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites " + counts +
               ">\n  <testsuite name=\"" + EscapeXml(folder_) + "\" errors=\"0\" " + counts + ">\n" + cases_ +
               "  </testsuite>\n</testsuites>\n";
    }

private:
    std::string subject_;
    std::string folder_;
    std::string cases_;
    double seconds_ = 0;
};

} // namespace

std::unique_ptr<Report> MakeReport(ReportFormat format, const std::string& subject,
                                   const std::string& folder) {
    switch (format) {
    case ReportFormat::Json:
        return std::make_unique<JsonReport>(subject);
    case ReportFormat::Junit:
        return std::make_unique<JunitReport>(subject, folder);
    case ReportFormat::Text:
        break;
    }
    return std::make_unique<TextReport>();
}

} // namespace openntc::conformance
