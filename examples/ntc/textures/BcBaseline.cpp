// SPDX-License-Identifier: MIT
#include "textures/BcBaseline.h"

#include "Failure.h"
#include "InputFile.h"
#include "Output.h"

#include "openntc/container/RapidJson.h"

#include <rapidjson/document.h>

#include <cinttypes>
#include <limits>
#include <string_view>

namespace openntc::tool {

namespace {

/// A number, or "inf" as JsonWriter writes it.
bool ReadNumber(const rapidjson::Value& row, const char* name, double& number) {
    const auto member = row.FindMember(name);
    if (member == row.MemberEnd())
        return false;
    if (member->value.IsString() && std::string_view(member->value.GetString()) == "inf") {
        number = std::numeric_limits<double>::infinity();
        return true;
    }
    if (!member->value.IsNumber())
        return false;
    number = member->value.GetDouble();
    return true;
}

bool ReadText(const rapidjson::Value& row, const char* name, std::string& text) {
    const auto member = row.FindMember(name);
    if (member == row.MemberEnd() || !member->value.IsString())
        return false;
    text.assign(member->value.GetString(), member->value.GetStringLength());
    return true;
}

[[noreturn]] void FailBaseline(const std::string& path, const std::string& text) {
    throw CommandError(ExitCode::BadInput, path, text + ": not the output of ntc bc-test --json");
}

std::string DescribeRow(const std::string& image, const std::string& format, const std::string& effort) {
    return (image.empty() ? "all images" : image) + ": " + format + " " + effort;
}

} // namespace

BcBaseline::BcBaseline(const std::string& path, int threads) {
    const std::string text = ReadAllText(path);
    rapidjson::Document document;
    document.Parse<rapidjson::kParseIterativeFlag>(text.c_str(), text.size());
    const rapidjson::Document& json = document;
    if (json.HasParseError() || !json.IsObject())
        FailBaseline(path, Format("byte %zu", json.GetErrorOffset()));
    double oldThreads = 0.0;
    if (!ReadNumber(json, "threads", oldThreads))
        FailBaseline(path, "threads");
    if (oldThreads != threads)
        throw CommandError(
            ExitCode::Usage, "--baseline",
            path + Format(": threads: %.0f: speeds of %d cannot be compared with it", oldThreads, threads));
    const auto results = json.FindMember("results");
    if (results == json.MemberEnd() || !results->value.IsArray())
        FailBaseline(path, "results");
    for (const rapidjson::Value& result : results->value.GetArray()) {
        std::string image, format, effort;
        OldRow row;
        double moved = 0.0;
        if (!result.IsObject() || !ReadText(result, "image", image) || !ReadText(result, "format", format) ||
            !ReadText(result, "quality", effort) || !ReadNumber(result, "psnr", row.psnr) ||
            !ReadNumber(result, "megapixelsPerSecond", row.speed) ||
            !ReadNumber(result, "alphaMoved", moved) || !(moved >= 0.0 && moved <= 1e15))
            FailBaseline(path, Format("results[%zu]", rows_.size()));
        row.moved = static_cast<std::uint64_t>(moved);
        if (const auto hinted = result.FindMember("hinted");
            hinted != result.MemberEnd() && hinted->value.IsTrue())
            effort += ", hinted"; // BcRow::GetLevel
        rows_[{image, format, effort}] = row;
    }
}

std::vector<std::string> BcBaseline::Compare(const std::vector<BcRow>& rows, const BcLimits& limits) const {
    std::map<RowKey, OldRow> baseline = rows_;
    std::vector<std::string> worse;
    for (const BcRow& row : rows) {
        const RowKey key{row.image, bc::BlockFormatToString(row.format), row.GetLevel()};
        const auto found = baseline.find(key);
        if (found == baseline.end())
            continue; // new
        const OldRow old = found->second;
        baseline.erase(found);
        const std::string name = DescribeRow(row.image, std::get<1>(key), std::get<2>(key));
        const double psnr = row.measurement.GetPsnr(), speed = row.measurement.GetMegapixelsPerSecond();
        if (psnr < old.psnr - limits.decibels)
            worse.push_back(name + Format(": PSNR: %.3f dB, before %.3f", psnr, old.psnr));
        if (row.measurement.error.moved > old.moved)
            worse.push_back(name + Format(": alpha: %" PRIu64 " texels on the other side, before %" PRIu64,
                                          row.measurement.error.moved, old.moved));
        if (speed < old.speed * (1.0 - limits.percent / 100.0))
            worse.push_back(name + Format(": speed: %.3f Mpixel/s, before %.3f", speed, old.speed));
    }
    for (const auto& [key, old] : baseline)
        worse.push_back(DescribeRow(std::get<0>(key), std::get<1>(key), std::get<2>(key)) +
                        ": missing, before " + Format("%.3f dB", old.psnr));
    return worse;
}

} // namespace openntc::tool
