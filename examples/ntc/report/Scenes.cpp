// SPDX-License-Identifier: MIT
#include "report/Scenes.h"

#include "Failure.h"
#include "Flip.h"
#include "Interrupt.h"
#include "Output.h"
#include "TextureSet.h"
#include "conformance/ChildProcess.h"
#include "encode/ComparedSet.h"
#include "renderer/gpu/MaterialEffects.h"
#include "report/Device.h"
#include "report/RendererStats.h"

#include <algorithm>
#include <cmath>
#include <system_error>

namespace openntc::report {

namespace fs = std::filesystem;
using tool::Format;

namespace {

constexpr const char* kModes[] = {"on-load", "on-sample", "on-feedback"}; // of texture sets
constexpr const char* kFilters[] = {"nearest",     "bilinear", "trilinear", "cubic",
                                    "catmull-rom", "mitchell", "gaussian",  "anisotropic"};
constexpr const char* kStfs[] = {"off", "one-tap", "2x2", "collaborative"};
constexpr const char* kMaths[] = {"int8", "int8_half", "fp8", "fp16", "fp32", "coopvec_int8", "coopvec_fp8"};

SceneCase MakeCase(const char* mode, const char* stf, const char* filter = kSceneFilter,
                   const char* math = kMaths[0]) {
    SceneCase c;
    c.mode = mode;
    c.stf = stf;
    c.filter = filter;
    c.math = c.mode == "on-sample" ? math : "";
    return c;
}

/// Those effects that the scene calls for, with all, or each by itself, on too.
std::vector<SceneCase> ListEffectCases(const char* scene, bool isEach) {
    std::vector<std::string> forced = {"", "all"};
    for (const renderer::MaterialEffectInfo& effect : renderer::kMaterialEffects) {
        if (isEach && effect.canForce)
            forced.emplace_back(effect.name);
    }
    std::vector<SceneCase> cases;
    for (const std::string& name : forced) {
        cases.push_back(MakeCase("on-sample", "one-tap"));
        cases.back().scene = scene;
        cases.back().forced = name;
    }
    return cases;
}

bool KeepsTextures(const SceneCase& c) {
    return c.mode == "on-load" || c.mode == "on-feedback";
}

double MeasurePsnr(const std::vector<float>& a, const std::vector<float>& b) {
    tool::ChannelDifference difference;
    difference.texels = static_cast<double>(a.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
        const double d = static_cast<double>(a[i]) - static_cast<double>(b[i]);
        difference.squares += d * d;
    }
    return difference.Psnr();
}

std::uint64_t CountOtherPixels(const std::vector<float>& a, const std::vector<float>& b) {
    std::uint64_t count = 0;
    for (std::size_t i = 0; i < a.size(); i += 3)
        count += std::equal(a.begin() + static_cast<std::ptrdiff_t>(i),
                            a.begin() + static_cast<std::ptrdiff_t>(i + 3),
                            b.begin() + static_cast<std::ptrdiff_t>(i))
                     ? 0
                     : 1;
    return count;
}

} // namespace

std::string SceneCase::GetId() const {
    std::string id = "scene " + scene + " " + mode;
    if (KeepsTextures(*this))
        id += hasBlocks ? " blocks" : " texels";
    id += " " + filter + " " + stf + (math.empty() ? "" : " " + math);
    return id + (forced.empty() ? "" : " effects " + forced);
}

std::vector<SceneCase> ListSceneCases(bool quick) {
    std::vector<SceneCase> cases;
    const auto add = [&cases](SceneCase c) { // once: lines cross
        const auto isSame = [&](const SceneCase& other) { return other.GetId() == c.GetId(); };
        if (std::none_of(cases.begin(), cases.end(), isSame))
            cases.push_back(std::move(c));
    };
    if (quick) {
        add(MakeCase("reference", "off"));
        for (const char* mode : kModes)
            add(MakeCase(mode, "one-tap"));
    } else {
        for (const char* filter : kFilters) {
            add(MakeCase("reference", "off", filter));
            for (const char* mode : kModes) {
                add(MakeCase(mode, "off", filter));
                add(MakeCase(mode, "one-tap", filter));
            }
        }
        for (const char* stf : kStfs) {
            add(MakeCase("reference", stf));
            for (const char* mode : kModes)
                add(MakeCase(mode, stf));
        }
        for (const char* math : kMaths) {
            add(MakeCase("on-sample", "off", kSceneFilter, math));
            add(MakeCase("on-sample", "one-tap", kSceneFilter, math));
        }
        SceneCase texels = MakeCase("on-load", "off");
        texels.hasBlocks = false;
        add(texels);
    }
    for (const SceneCase& c : ListEffectCases("sample", !quick))
        add(c);
    for (const SceneCase& c : ListEffectCases(kEverything, false))
        add(c);
    return cases;
}

std::string FindRenderer() {
    std::error_code error;
    const fs::path renderer = fs::read_symlink("/proc/self/exe", error).parent_path() / "ntc-renderer";
    return fs::is_regular_file(renderer, error) ? renderer.string() : "";
}

std::string DescribeScene(const SceneRecord& record) {
    const std::string name = record.device + ": " + record.id + ": ";
    if (!record.skipped.empty())
        return name + "skipped: " + record.skipped;
    return name + Format("%.4g ms a frame, %.2f texels read, %.2f decoded, %.2f dB, FLIP %.4f",
                         record.time.median, record.texelsRead, record.texelsDecoded, record.psnr,
                         record.flip);
}

SceneMeasurement::SceneMeasurement(const SceneSettings& settings, const DeviceRecord& device, bool isSlow)
    : settings_(settings), device_(device), width_(settings.width), height_(settings.height),
      frames_(settings.quick ? 2
              : isSlow       ? 4
                             : 16),
      warmUp_(settings.quick || isSlow ? 0 : 1000), picture_(settings.scratch / ".ntc-scene.png"),
      stats_(settings.scratch / ".ntc-scene.json") {
    if (width_ <= 0 || height_ <= 0) {
        width_ = settings.quick ? 48 : isSlow ? 160 : 1920;
        height_ = width_ * 9 / 16;
    }
}

SceneMeasurement::~SceneMeasurement() {
    std::error_code ignored;
    fs::remove(picture_, ignored);
    fs::remove(stats_, ignored);
}

SceneRecord SceneMeasurement::Measure(const SceneCase& c) {
    SceneCase reference = MakeCase("reference", "off", c.filter.c_str());
    reference.scene = c.scene;
    const Drawn& wanted = Draw(reference);
    Drawn& drawn = Draw(c);
    SceneRecord& record = drawn.record;
    if (!record.skipped.empty())
        return record;
    if (!wanted.record.skipped.empty()) {
        record.skipped = "the reference mode: " + wanted.record.skipped;
        return record;
    }
    record.psnr = MeasurePsnr(wanted.colors, drawn.colors);
    record.flip = tool::ComputeFlip(wanted.colors, drawn.colors, width_, height_).mean;
    if (!c.forced.empty()) {
        SceneCase derived = c;
        derived.forced.clear();
        const Drawn& other = Draw(derived);
        if (other.record.skipped.empty())
            record.otherPixels = CountOtherPixels(other.colors, drawn.colors);
    }
    return record;
}

SceneMeasurement::Drawn& SceneMeasurement::Draw(const SceneCase& c) {
    const auto [found, isNew] = drawn_.try_emplace(c.GetId());
    Drawn& drawn = found->second;
    if (!isNew)
        return drawn;
    SceneRecord& record = drawn.record;
    record.id = c.GetId();
    record.device = device_.name;
    record.scene = c.scene == "sample" && !settings_.model.empty()
                       ? fs::path(settings_.model).filename().string()
                       : c.scene;
    record.mode = c.mode;
    record.blocks = !KeepsTextures(c) ? "" : c.hasBlocks ? "auto" : "none";
    record.filter = c.filter;
    record.stf = c.stf;
    record.math = c.math;
    record.effects = c.forced.empty() ? "derived" : c.forced;
    record.width = width_;
    record.height = height_;
    record.frames = frames_;
    std::string warning;
    record.skipped = RunRenderer(c, warning);
    if (!record.skipped.empty())
        return drawn;
    ReadRendererStats(stats_.string(), record);
    if (!record.skipped.empty())
        return drawn;
    if (c.mode != "reference" && record.GetBytes("textures") == record.GetBytes("sourceTextures")) {
        record.skipped = "no texture set could be used: " + warning; // the picture is the reference mode's
        return drawn;
    }
    const tool::ComparedSet picture = tool::LoadComparedSet(picture_.string());
    drawn.colors = tool::InterleaveColors(picture.mips[0], 0);
    return drawn;
}

/// Why there is no picture, or nothing. `warning`: the first that the program gave.
std::string SceneMeasurement::RunRenderer(const SceneCase& c, std::string& warning) const {
    if (device_.kind == "C++ decoder")
        return "the renderer needs a Vulkan device";
    if (c.math.starts_with("coopvec") && !device_.hasCoopVec)
        return "device or feature absent: cooperative vectors";
    if (settings_.renderer.empty())
        return "ntc-renderer: it is not beside this program: name it with --renderer";
    std::vector<std::string> command = {settings_.renderer,
                                        "--device",
                                        device_.name,
                                        "--sources",
                                        settings_.sources,
                                        "--size",
                                        Format("%dx%d", width_, height_),
                                        "--samples",
                                        std::to_string(frames_),
                                        "--warm-up",
                                        std::to_string(warmUp_),
                                        "--mode",
                                        c.mode,
                                        "--stf",
                                        c.stf,
                                        "--filter",
                                        c.filter,
                                        "-o",
                                        picture_.string(),
                                        "--stats",
                                        stats_.string()};
    const auto add = [&command](const char* option, const std::string& value) {
        command.insert(command.end(), {option, value});
    };
    if (!c.math.empty())
        add("--math", c.math);
    if (!settings_.glslang.empty())
        add("--glslang", settings_.glslang);
    if (KeepsTextures(c))
        add("--bc", c.hasBlocks ? "auto" : "none");
    if (c.forced == "all")
        command.emplace_back("--all-effects");
    else if (!c.forced.empty())
        add("--force-effects", c.forced);
    if (c.scene != "sample")
        add("--test-scene", c.scene);
    else if (!settings_.model.empty())
        command.push_back(settings_.model);
    if (c.scene == "sample" && !settings_.materialDir.empty())
        add("--material-dir", settings_.materialDir);

    std::error_code ignored;
    fs::remove(stats_, ignored);
    conformance::ChildProcess process;
    constexpr double kSeconds = 900; // collaboration on drivers that compile to the CPU
    const auto deadline = conformance::ChildProcess::Clock::now() + std::chrono::seconds(900);
    if (const Expected<void> started = process.Start(command, true); !started)
        return settings_.renderer + ": " + started.error().GetText();
    std::string said;
    Expected<std::string> line = process.ReadLine(deadline, kSeconds);
    for (; line; line = process.ReadLine(deadline, kSeconds)) {
        if (line->starts_with("ntc-renderer: warning: "))
            warning = warning.empty() ? *line : warning;
        else if (line->starts_with("ntc-renderer: "))
            said = *line;
    }
    tool::ThrowIfInterrupted();
    if (fs::is_regular_file(stats_, ignored)) // written last
        return {};
    return said.empty() ? std::string("ntc-renderer: ") + line.error().GetText() : said;
}

} // namespace openntc::report
