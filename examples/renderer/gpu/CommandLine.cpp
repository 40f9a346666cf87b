// SPDX-License-Identifier: MIT
#include "renderer/gpu/CommandLine.h"

#include "Arguments.h"
#include "Failure.h"
#include "Output.h"
#include "renderer/gpu/FeedbackTiles.h"
#include "renderer/gpu/MathChoice.h"
#include "renderer/gpu/PictureFile.h"
#include "renderer/shaders/ToneMap.h"
#include "textures/TextureFormat.h"

#include "openntc/MathModes.h"

#include <CLI/CLI.hpp>

#include <bit>
#include <cmath>
#include <sstream>
#include <utility>

namespace openntc::renderer {

namespace {

using tool::AddNumberOption;
using tool::CommandError;
using tool::ExitCode;
using tool::FailUsage;

template <typename T>
struct Choice {
    const char* name;
    T value;
};

constexpr Choice<Mode> kModes[] = {{"reference", Mode::Reference},
                                   {"on-load", Mode::OnLoad},
                                   {"on-sample", Mode::OnSample},
                                   {"on-feedback", Mode::OnFeedback}};
constexpr Choice<TextureFilter> kFilters[] = {
    {"nearest", TextureFilter::Nearest},        {"bilinear", TextureFilter::Bilinear},
    {"trilinear", TextureFilter::Trilinear},    {"cubic", TextureFilter::Cubic},
    {"catmull-rom", TextureFilter::CatmullRom}, {"mitchell", TextureFilter::Mitchell},
    {"gaussian", TextureFilter::Gaussian},      {"anisotropic", TextureFilter::Anisotropic}};
constexpr Choice<Stochastic> kStochastic[] = {{"off", Stochastic::Off},
                                              {"one-tap", Stochastic::OneTap},
                                              {"2x2", Stochastic::Quads},
                                              {"collaborative", Stochastic::Collaborative}};
constexpr Choice<ShadingPath> kPaths[] = {{"compute", ShadingPath::Compute},
                                          {"fragment", ShadingPath::Fragment}};
constexpr Choice<MaskPath> kMasks[] = {{"compute", MaskPath::Compute}, {"fragment", MaskPath::Fragment}};
constexpr Choice<bool> kRandom[] = {{"hash", false}, {"r2", true}};
constexpr Choice<int> kMath[] = {{"fastest", kFastestMath},
                                 {"int8", NTC_MATH_INT8},
                                 {"int8_half", NTC_MATH_INT8_HALF},
                                 {"fp8", NTC_MATH_FP8},
                                 {"fp16", NTC_MATH_FP16},
                                 {"fp32", NTC_MATH_FP32},
                                 {"coopvec_int8", NTC_MATH_COOPVEC_INT8},
                                 {"coopvec_fp8", NTC_MATH_COOPVEC_FP8}};
constexpr Choice<int> kToneCurves[] = {
    {"none", NTCR_TONE_NONE}, {"neutral", NTCR_TONE_NEUTRAL}, {"aces", NTCR_TONE_ACES}};

template <typename T, std::size_t N>
const char* FindName(const Choice<T> (&choices)[N], T value) {
    for (const Choice<T>& choice : choices) {
        if (choice.value == value)
            return choice.name;
    }
    return "?";
}

template <typename T, std::size_t N>
CLI::Option* AddChoice(CLI::App& app, const std::string& name, const Choice<T> (&choices)[N], T& value,
                       const std::string& description) {
    std::string names;
    for (const Choice<T>& choice : choices)
        names += (names.empty() ? "" : "|") + std::string(choice.name);
    return app
        .add_option_function<std::string>(
            "--" + name,
            [&choices, &value, name, names](const std::string& text) {
                for (const Choice<T>& choice : choices) {
                    if (text == choice.name) {
                        value = choice.value;
                        return;
                    }
                }
                FailUsage("--" + name, text + ": one of " + names);
            },
            description)
        ->type_name(names);
}

void ParseSize(const std::string& text, RenderOptions& options) {
    const std::size_t cross = text.find('x');
    if (cross == std::string::npos)
        FailUsage("--size", text + ": WIDTHxHEIGHT");
    options.width = static_cast<int>(tool::ParseNumber("--size", text.substr(0, cross), {1, 16384}, true));
    options.height = static_cast<int>(tool::ParseNumber("--size", text.substr(cross + 1), {1, 16384}, true));
}

void ParseBlocks(const std::string& text, RenderOptions& options) {
    options.keepsTexels = text == "none";
    options.blocks = {};
    if (text == "none" || text == "auto")
        return;
    options.blocks.isAuto = false;
    options.blocks.block = tool::FindBlockFormat(text);
    if (!options.blocks.block || text == "bc4s" || text == "bc5s" || text == "bc6s")
        FailUsage("--bc", text + ": auto, none or bc1 ... bc7");
}

void ParseEffects(const std::string& text, RenderOptions& options) {
    std::istringstream words(text);
    for (std::string word; std::getline(words, word, ',');) {
        std::string names;
        std::size_t found = kMaterialEffectCount;
        for (std::size_t i = 0; i < kMaterialEffectCount; ++i) {
            if (!kMaterialEffects[i].canForce)
                continue;
            found = kMaterialEffects[i].name == word ? i : found;
            names += names.empty() ? "" : ", ";
            names += kMaterialEffects[i].name;
        }
        if (found == kMaterialEffectCount)
            FailUsage("--force-effects", tool::Format("%s: one of %s", word.c_str(), names.c_str()));
        options.forcedEffects |= EffectSet{1} << found;
    }
}

void AddRenderOptions(CLI::App& app, CommandLine& line, std::string& quality) {
    RenderOptions& render = line.render;
    AddChoice(app, "mode", kModes, render.mode,
              "Where texels come from (default: on-load where the model has texture sets, else reference)");
    AddChoice(app, "filter", kFilters, render.filter, "Texture filter (default trilinear)");
    AddChoice(app, "stf", kStochastic, render.stochastic,
              "All texels of the filter (off, the default), one at random, one shared by 2 x 2 pixels, or "
              "all, divided among the lanes of a wave");
    AddChoice(app, "random", kRandom, render.randomR2,
              "Random numbers that are independent (the default), or fill their range over frames");
    AddChoice(app, "path", kPaths, render.path,
              "Shade a visibility buffer in compute shaders (the default), or in fragment shaders");
    AddChoice(app, "masks", kMasks, render.masks,
              "With --path compute: decode alpha masks in compute shaders too (the default), or in the "
              "fragment shaders of the visibility buffer; the same picture");
    AddChoice(
        app, "math", kMath, render.math,
        "Maths mode of on-sample (default fastest: the first of coopvec_int8 and int8 that the device and "
        "the compiler have; the same bits)");
    AddChoice(app, "tone-map", kToneCurves, render.toneCurve, "Tone curve (default none: clamped)");
    app.add_option_function<std::string>(
           "--bc", [&render](const std::string& text) { ParseBlocks(text, render); },
           "Block compression of on-load and on-feedback (default auto: what each texture asks for)")
        ->type_name("auto|none|FORMAT");
    app.add_option("--quality", quality, "Of block compression (default fast)")
        ->type_name("fast|normal|best");
    app.add_option_function<std::string>(
           "--size", [&render](const std::string& text) { ParseSize(text, render); },
           "Size of the picture (default 640x480)")
        ->type_name("WIDTHxHEIGHT");
    AddNumberOption(app, "--seed", render.seed, {0, 16777215}, "Of random numbers (default 0)");
    app.add_option_function<std::string>(
           "--exposure",
           [&render](const std::string& text) {
               render.exposure =
                   std::exp2(static_cast<float>(tool::ParseNumber("--exposure", text, {-24, 24}, false)));
           },
           "Exposure (default 0)")
        ->type_name("EV");
    app.add_flag_function(
        "--all-effects", [&render](std::int64_t) { render.forcedEffects = GetForceableEffects(); },
        "Every effect on, whether or not a material calls for it: the same picture, to see what that costs");
    app.add_option_function<std::string>(
           "--force-effects", [&render](const std::string& text) { ParseEffects(text, render); },
           "The same of some effects (a wrong name lists them)")
        ->type_name("NAME,...");
}

void AddFeedbackOptions(CLI::App& app, RenderOptions& render) {
    AddNumberOption(app, "--budget", render.budgetMiB, {0.001, 1048576},
                    "Of on-feedback: memory for decoded tiles (default: for all that pictures read)", "MiB");
    app.add_option_function<std::string>(
           "--tile-size",
           [&render](const std::string& text) {
               const auto size = static_cast<unsigned>(
                   tool::ParseNumber("--tile-size", text, {kSmallestTile, kLargestTile}, true));
               if (!std::has_single_bit(size))
                   FailUsage("--tile-size", text + ": must be a power of two");
               render.tileSize = static_cast<int>(size);
           },
           "Of on-feedback: texels of a tile's side (default 64)")
        ->type_name("16 ... 1024");
    AddNumberOption(app, "--tiles-per-frame", render.tilesPerFrame, {1, 65536},
                    "Of on-feedback: tiles decoded after a frame at most (default 64)");
    AddNumberOption(app, "--settle", render.settle, {0, 65535},
                    "Of on-feedback: how often a frame is drawn again at most until its tiles are there "
                    "(default: until they are)");
}

void AddCameraOptions(CLI::App& app, CommandLine& line) {
    app.add_option("--camera", line.camera,
                   "Camera by name or number, or orbit (default: the file's first one, if it has any)")
        ->type_name("NAME");
    AddNumberOption(app, "--azimuth", line.azimuth, {-3600, 3600}, "Of the orbit camera (default 30)",
                    "DEGREES");
    AddNumberOption(app, "--elevation", line.elevation, {-90, 90}, "Of the orbit camera (default 15)",
                    "DEGREES");
    AddNumberOption(app, "--distance", line.distance, {0.01, 100}, "Of the orbit camera (default 1)",
                    "FACTOR");
}

void AddSampleOption(CLI::App& app, CommandLine& line) {
    AddNumberOption(
        app, "--samples", line.samples, {1, 65535},
        tool::Format("Frames averaged in a picture, the first unjittered (default %d)", line.samples));
}

void AddSceneOptions(CLI::App& app, CommandLine& line) {
    app.add_option("MODEL", line.model, "Model (.gltf or .glb; default: the sample scene)")->type_name("");
    app.add_option("--test-scene", line.testScene,
                   "A generated scene in the place of a model (a wrong name lists them)")
        ->excludes("MODEL")
        ->type_name("NAME");
    app.add_option("--material-dir,--materialDir", line.materialDir,
                   "Folder of texture sets and materials.json (default: beside the model)")
        ->type_name("DIR");
    AddNumberOption(app, "--scene", line.scene, {0, 65535}, "Scene of the file (default: the file's)");
    app.add_option("--device,--adapter", line.device,
                   "Vulkan device: its number or part of its name (`ntc devices`)")
        ->type_name("NAME");
    app.add_option("--sources", line.sources, "Folder of OpenNTC's source, for its shaders")
        ->type_name("DIR");
    app.add_option("--glslang", line.glslang,
                   "A glslang program that knows GL_NV_cooperative_vector (default: $OPENNTC_GLSLANG, or "
                   "glslang on the path)")
        ->type_name("FILE");
    app.add_flag("--debug", line.debug, "Vulkan's validation layer; its errors end the program");
}

void AddHeadlessOptions(CLI::App& app, CommandLine& line, bool& window) {
    AddNumberOption(app, "--frames", line.frames, {1, 100000},
                    "Pictures; the orbit camera goes round once (default 1)");
    app.add_option("-o,--screenshot", line.output,
                   "Picture to write, .png, .jpg, .bmp or .tga; of several the last one")
        ->check(tool::GetOutputNameCheck())
        ->type_name("FILE");
    app.add_option("--stats", line.stats, "JSON to write: times, texels, bytes, effects, permutations")
        ->check(tool::GetOutputNameCheck())
        ->type_name("FILE");
    AddNumberOption(
        app, "--warm-up", line.warmUp, {0, 60000},
        "How long the first frame is drawn again before others are timed, for a GPU's clock to rise "
        "(default 0)",
        "MS");
    app.add_flag("--window", window, "A window: ntc-viewer with the other options");
}

void AddWindowOptions(CLI::App& app, CommandLine& line) {
    app.add_option("-o,--screenshot", line.output,
                   "Picture that F12 writes, .png, .jpg, .bmp or .tga (default ntc-viewer.png)")
        ->check(tool::GetOutputNameCheck())
        ->type_name("FILE");
    app.add_option(
           "--play", line.play,
           "A script: lines of options, frames N, screenshot FILE, capture FILE, minimize, restore, quit")
        ->type_name("FILE");
}

void TakeOnce(CLI::App& app) {
    for (CLI::Option* option : app.get_options([](CLI::Option*) { return true; }))
        option->disable_flag_override();
}

} // namespace

CommandLine::CommandLine() {
    render.math = kFastestMath;
}

bool ParseCommandLine(int argc, char** argv, CommandLine& line, Program program) {
    const bool isWindow = program == Program::Window;
    CLI::App app(isWindow ? "Shows a glTF model whose materials are neural texture sets"
                          : "Renders a glTF model whose materials are neural texture sets",
                 isWindow ? "ntc-viewer" : "ntc-renderer");
    std::string quality;
    bool isReference = false, noOnLoad = false, noOnSample = false, noOnFeedback = false, noBlocks = false,
         window = false, noCoopVec = false, noCoopVecInt8 = false, noCoopVecFP8 = false;
    AddSceneOptions(app, line);
    AddCameraOptions(app, line);
    if (isWindow) {
        line.samples = 1024;
        AddWindowOptions(app, line);
    } else {
        AddHeadlessOptions(app, line, window);
    }
    AddSampleOption(app, line);
    AddRenderOptions(app, line, quality);
    AddFeedbackOptions(app, line.render);
    app.add_flag("--reference-materials,--referenceMaterials", isReference, "As --mode reference");
    app.add_flag("--no-on-load,--no-inferenceOnLoad", noOnLoad, "Without on-load");
    app.add_flag("--no-on-sample,--no-inferenceOnSample", noOnSample, "Without on-sample");
    app.add_flag("--no-on-feedback,--no-inferenceOnFeedback", noOnFeedback, "Without on-feedback");
    app.add_flag("--no-coopvec,--no-coopVec", noCoopVec, "Cooperative vectors stay off on the device");
    app.add_flag("--no-coopvec-int8,--no-coopVecInt8", noCoopVecInt8, "Without coopvec_int8");
    app.add_flag("--no-coopvec-fp8,--no-coopVecFP8", noCoopVecFP8, "Without coopvec_fp8");
    app.add_flag("--no-block-compression,--no-blockCompression", noBlocks, "As --bc none");
    TakeOnce(app);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        if (error.get_exit_code() != static_cast<int>(CLI::ExitCodes::Success))
            throw CommandError(ExitCode::Usage, "command line", error.what());
        app.exit(error); // help, on standard output
        tool::FinishOutput();
        return false;
    }
    line.choosesMode = app.count("--mode") == 0 && !isReference;
    line.allowsCoopVec = !noCoopVec;
    line.render.allowsVectorsInt8 = !noCoopVec && !noCoopVecInt8;
    line.render.allowsVectorsFP8 = !noCoopVec && !noCoopVecFP8;
    line.allowsOnLoad = !noOnLoad;
    line.allowsOnSample = !noOnSample;
    line.allowsOnFeedback = !noOnFeedback;
    if (isReference && app.count("--mode") > 0 && line.render.mode != Mode::Reference)
        FailUsage("--reference-materials",
                  std::string("--mode ") + GetName(line.render.mode) + " excludes it");
    const Mode mode = line.render.mode;
    if (!line.choosesMode && ((noOnLoad && mode == Mode::OnLoad) || (noOnSample && mode == Mode::OnSample) ||
                              (noOnFeedback && mode == Mode::OnFeedback)))
        FailUsage("--mode", std::string(GetName(mode)) + ": switched off by another option");
    if ((line.render.math == NTC_MATH_COOPVEC_INT8 && !line.render.allowsVectorsInt8) ||
        (line.render.math == NTC_MATH_COOPVEC_FP8 && !line.render.allowsVectorsFP8))
        FailUsage("--math", std::string(GetMathName(line.render.math)) + ": switched off by another option");
    line.render.effort = tool::SelectEffort(quality, tool::BlockEffort::Fast);
    line.render.keepsTexels = line.render.keepsTexels || noBlocks;
    line.render.counts = !line.stats.empty();
    if (isWindow && line.output.empty())
        line.output = "ntc-viewer.png";
    if (line.output.empty() && line.stats.empty())
        FailUsage("-o", "missing: name a picture, or a file of numbers with --stats");
    if (!line.output.empty())
        CheckPictureName("-o", line.output);
    return true;
}

void ApplyOptions(const std::string& options, CommandLine& line) {
    CLI::App app;
    std::string quality;
    CommandLine changed = line;
    AddCameraOptions(app, changed);
    AddSampleOption(app, changed);
    AddRenderOptions(app, changed, quality);
    AddFeedbackOptions(app, changed.render);
    TakeOnce(app);
    try {
        app.parse(options);
    } catch (const CLI::ParseError& error) {
        throw CommandError(ExitCode::Usage, "options", error.what());
    }
    if (!quality.empty())
        changed.render.effort = tool::SelectEffort(quality, changed.render.effort);
    line = std::move(changed);
}

const char* GetName(Mode mode) {
    return FindName(kModes, mode);
}
const char* GetName(TextureFilter filter) {
    return FindName(kFilters, filter);
}
const char* GetName(Stochastic stochastic) {
    return FindName(kStochastic, stochastic);
}
const char* GetName(ShadingPath path) {
    return FindName(kPaths, path);
}
const char* GetName(MaskPath masks) {
    return FindName(kMasks, masks);
}
const char* GetMathName(int math) {
    return FindName(kMath, math);
}

} // namespace openntc::renderer
