// SPDX-License-Identifier: MIT
#include "Arguments.h"

#include "Failure.h"
#include "Output.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cstdlib>

namespace openntc::tool {

void FailUsage(const std::string& option, const std::string& text) {
    throw CommandError(ExitCode::Usage, option, text);
}

double ParseNumber(const std::string& option, const std::string& text, const NumberLimits& limits,
                   bool isWhole) {
    char* end = nullptr;
    const double value = std::strtod(text.c_str(), &end);
    const bool isNumber =
        !text.empty() && *end == '\0' && std::isspace(static_cast<unsigned char>(text[0])) == 0;
    if (!isNumber || !IsInside(value, limits, isWhole))
        FailUsage(option, text + ": " + DescribeLimits(limits, isWhole));
    return value;
}

std::string DescribeNumber(const std::string& typeName, const NumberLimits& limits) {
    return typeName + Format(" (%.10g to %.10g)", limits.lowest, limits.highest);
}

const CLI::Validator& GetOutputNameCheck() {
    static const CLI::Validator kCheck(
        [](const std::string& name) -> std::string {
            if (name == "-")
                return "-: standard output is not supported: name a file (./- is a file of that name)";
            return name.empty() ? "empty: a name is needed" : "";
        },
        "", "output name");
    return kCheck;
}

void AddFileArgument(CLI::App& app, std::string& file) {
    app.add_option("FILE", file, "Texture set (.ntc), or - for standard input")->required();
}

void AddFilesArgument(CLI::App& app, std::vector<std::string>& files) {
    app.add_option("FILE", files, "Texture sets (.ntc), or - for standard input")->required();
}

void CheckOneStandardInput(const std::vector<std::string>& files) {
    if (std::count(files.begin(), files.end(), "-") > 1)
        FailUsage("FILE", "-: standard input can be read once");
}

void AddJsonFlag(CLI::App& app, bool& json) {
    app.add_flag("--json", json, "Print JSON (schemas/ describes it)");
}

void AddMathOption(CLI::App& app, std::optional<DecodeMath>& math, BackendOptions* backend) {
    app.add_option_function<std::string>(
           "--math",
           [&math, backend](const std::string& name) {
               static constexpr std::array kLater = {"coopvec_int8", "coopvec_fp8"};
               for (const DecodeMath mode : {DecodeMath::Int8, DecodeMath::Int8Half, DecodeMath::FP8,
                                             DecodeMath::FP16, DecodeMath::FP32}) {
                   if (name == GetName(mode)) {
                       math = mode;
                       if (backend != nullptr)
                           backend->matrices = false;
                       return;
                   }
               }
               if (backend != nullptr && (name == "coopmat_int8" || name == "coopmat_int8_half")) {
                   math = name == "coopmat_int8" ? DecodeMath::Int8 : DecodeMath::Int8Half;
                   backend->matrices = true;
                   return;
               }
               const bool later = std::find(kLater.begin(), kLater.end(), name) != kLater.end();
               FailUsage("--math",
                         name + (later ? ": not in this version" : "") + ": int8, int8_half, fp8, fp16" +
                             (backend != nullptr ? ", fp32, coopmat_int8 or coopmat_int8_half" : " or fp32"));
           },
           std::string("int8 (exact, float epilogue; default, fp8 where the set has no Int8 weights), "
                       "int8_half (half epilogue), fp8 (the set's FP8 "
                       "weights), fp16 or fp32 (Int8 weights, nothing else quantised)") +
               (backend != nullptr
                    ? ", coopmat_int8 or coopmat_int8_half (the numbers of int8 and int8_half, on "
                      "cooperative matrices of a Vulkan device)"
                    : ""))
        ->type_name("MODE");
}

BlockEffort SelectEffort(const std::string& name, BlockEffort whenEmpty) {
    for (const BlockEffort effort : {BlockEffort::Fast, BlockEffort::Normal, BlockEffort::Best}) {
        if (name == GetName(effort))
            return effort;
    }
    if (!name.empty())
        FailUsage("--quality", name + ": fast, normal or best");
    return whenEmpty;
}

void AddBackendOptions(CLI::App& app, BackendOptions& options) {
    app.add_option_function<std::string>(
           "--backend",
           [&options](const std::string& name) {
               if (name == "cpu")
                   options.backend = Backend::Cpu;
               else if (name == "reference")
                   options.backend = Backend::Reference;
               else if (name == "vulkan")
                   options.backend = Backend::Vulkan;
               else
                   FailUsage("--backend", name + ": cpu, reference or vulkan");
           },
           "cpu (fast; default), reference (shader source as C++) or vulkan")
        ->type_name("NAME");
    app.add_option("--device", options.device, "Vulkan device: index or part of its name");
}

Rect ParseRect(const std::string& option, const std::string& text) {
    std::array<int, 4> numbers{};
    const char* at = text.data();
    const char* const end = at + text.size();
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        const auto [next, error] = std::from_chars(at, end, numbers[i]);
        const bool isLast = i + 1 == numbers.size();
        if (error != std::errc() || (isLast ? next != end : next == end || *next != ','))
            FailUsage(option, text + ": must be x,y,w,h, whole numbers in texels of the first mip");
        at = isLast ? next : next + 1;
    }
    return {numbers[0], numbers[1], numbers[2], numbers[3]};
}

} // namespace openntc::tool
