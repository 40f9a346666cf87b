// SPDX-License-Identifier: MIT
// `ntc sample`: raw network outputs of listed texels.
#include "Arguments.h"
#include "Commands.h"
#include "Failure.h"
#include "Interrupt.h"
#include "Json.h"
#include "Output.h"
#include "Progress.h"
#include "TexelList.h"

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <optional>

namespace openntc::tool {

namespace {

struct SampleOptions {
    std::string file;
    std::string texels;
    bool csv = false;
    bool json = false;
    BackendOptions backend;
    std::optional<DecodeMath> math;
    bool linear = false;
};

void PrintCsv(std::span<const Texel> texels, std::span<const std::array<float, 16>> values) {
    std::string text = "mip,x,y";
    for (int channel = 0; channel < 16; ++channel)
        text += ",c" + std::to_string(channel);
    text += '\n';
    for (std::size_t i = 0; i < texels.size(); ++i) {
        text += Format("%d,%d,%d", texels[i].mip, texels[i].x, texels[i].y);
        for (const float value : values[i]) {
            text += ',';
            text += FormatFloat(value);
        }
        text += '\n';
        if (text.size() > 1u << 16) {
            WriteOutput(text);
            text.clear();
        }
    }
    WriteOutput(text);
}

void PrintJson(std::span<const Texel> texels, std::span<const std::array<float, 16>> values) {
    JsonWriter json;
    json.BeginObject();
    json.Key("texels");
    json.BeginArray();
    for (std::size_t i = 0; i < texels.size(); ++i) {
        json.BeginObject();
        json.Member("mip", texels[i].mip);
        json.Member("x", texels[i].x);
        json.Member("y", texels[i].y);
        json.Key("values");
        json.BeginArray();
        for (const float value : values[i])
            json.Value(value);
        json.EndArray();
        json.EndObject();
    }
    json.EndArray();
    json.EndObject();
    WriteOutput(json.Take());
}

int RunSample(const SampleOptions& options) {
    if (options.file == "-" && options.texels == "-")
        FailUsage("--texels", "-: standard input is the texture set already");
    TextureSet set = LoadTextureSet(options.file);
    const std::vector<Texel> texels = ReadTexelList(options.texels, set.metadata);
    DecodeOptions decode;
    decode.convertToLinear = options.linear;
    decode.math =
        ChooseMath(set, options.math, [&](const std::string& text) { PrintWarning(text, options.json); });
    const DecodeData data = LoadDecodeData(set, decode.math);
    const std::unique_ptr<Decoder> decoder = RequireDecoder(options.file, data, options.backend);
    Progress progress("sample", texels.size(), options.json);
    const std::vector<std::array<float, 16>> values =
        DecodeTexels(*decoder, set.metadata, texels, decode, options.file, &progress);
    if (options.json)
        PrintJson(texels, values);
    else
        PrintCsv(texels, values);
    return 0;
}

} // namespace

void AddSampleCommand(CLI::App& app, Action& action) {
    auto options = std::make_shared<SampleOptions>();
    CLI::App* command = app.add_subcommand("sample", "Decode listed texels: all 16 outputs, unclamped");
    AddFileArgument(*command, options->file);
    command->add_option("--texels", options->texels, "Text file of `mip x y` lines, or - for standard input")
        ->required()
        ->type_name("FILE");
    CLI::Option* csv = command->add_flag("--csv", options->csv, "Print CSV (default)");
    AddJsonFlag(*command, options->json);
    csv->excludes("--json");
    command->add_flag("--linear", options->linear, "Convert to linear colour");
    AddMathOption(*command, options->math, &options->backend);
    AddBackendOptions(*command, options->backend);
    command->callback([options, &action] { action = [options] { return RunSample(*options); }; });
}

} // namespace openntc::tool
