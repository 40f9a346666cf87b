// SPDX-License-Identifier: MIT
#include "renderer/gpu/Stats.h"

#include "Json.h"

#include <algorithm>

namespace openntc::renderer {

namespace {

using tool::JsonWriter;

constexpr const char* kPassNames[kPassCount] = {"visibility", "masks",   "sky",    "shade",    "blend",
                                                "accumulate", "resolve", "decode", "transcode"};

double GetMedian(std::vector<double> values) {
    if (values.empty())
        return 0.0;
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

void WriteTimes(JsonWriter& json, const RunRecord& run) {
    const std::size_t first = run.frames.size() > 1 ? 1 : 0;
    json.Key("milliseconds");
    json.BeginObject();
    std::vector<double> totals;
    for (std::size_t i = first; i < run.frames.size(); ++i) {
        double total = 0.0;
        for (const double seconds : run.frames[i])
            total += seconds;
        totals.push_back(1e3 * total);
    }
    json.Member("frame", GetMedian(totals));
    for (std::size_t pass = 0; pass < kPassCount; ++pass) {
        std::vector<double> times;
        for (std::size_t i = first; i < run.frames.size(); ++i)
            times.push_back(1e3 * run.frames[i][pass]);
        json.Member(GetPassName(static_cast<Pass>(pass)), GetMedian(times));
    }
    json.Member("framesMeasured", static_cast<std::uint64_t>(totals.size()));
    json.Key("frames"); // those measured, in their order
    json.BeginArray();
    for (const double total : totals)
        json.Value(total);
    json.EndArray();
    json.EndObject();
}

void WriteMemory(JsonWriter& json, const Renderer& renderer) {
    json.Key("bytes");
    json.BeginObject();
    for (const BytesOfKind& kind : ListBytes(renderer))
        json.Member(kind.name, kind.bytes);
    json.EndObject();
}

/// Of on-feedback: tiles and passes.
void WriteFeedback(JsonWriter& json, const RenderOptions& options, const FeedbackStatistics& tiles) {
    json.Key("tiles");
    json.BeginObject();
    json.Member("size", options.tileSize);
    json.Member("perFrame", options.tilesPerFrame);
    json.Member("budgetBytes", static_cast<std::uint64_t>(options.budgetMiB * 1048576.0));
    json.Member("all", tiles.tiles);
    json.Member("slots", tiles.slots);
    json.Member("mostSlots", tiles.mostSlots);
    json.Member("requested", tiles.wanted);
    json.Member("resident", tiles.resident);
    json.Member("waiting", tiles.waiting);
    json.Member("decoded", tiles.decoded);
    json.Member("evicted", tiles.evicted);
    json.Member("thrashed", tiles.thrashed);
    json.Member("complete", tiles.isComplete);
    json.Member("passes", tiles.passes);
    json.Member("passesUntilSettled", tiles.passesUntilSettled);
    json.Member("resolveMilliseconds", 1e3 * tiles.seconds.resolve);
    json.Member("decodeMilliseconds", 1e3 * tiles.seconds.decode);
    json.Member("transcodeMilliseconds", 1e3 * tiles.seconds.transcode);
    json.Key("decodedPerPass");
    json.BeginArray();
    for (const std::uint32_t count : tiles.decodedPerPass)
        json.Value(count);
    json.EndArray();
    json.EndObject();
}

void WriteMaterials(JsonWriter& json, const Scene& scene, const Renderer& renderer) {
    json.Key("materials");
    json.BeginArray();
    for (std::size_t i = 0; i < scene.materials.size(); ++i) {
        const MaterialPlan& plan = renderer.GetPlans()[i];
        json.BeginObject();
        json.Member("name", std::string_view(scene.materials[i].name));
        json.Member("shown", plan.isPlanned);
        json.Member("lookups", static_cast<std::uint64_t>(plan.lookups.size()));
        json.Key("effects");
        json.BeginObject();
        for (std::size_t e = 0; e < kMaterialEffectCount && plan.isPlanned; ++e)
            json.Member(kMaterialEffects[e].name.data(), (plan.effects >> e & 1u) != 0);
        json.EndObject();
        json.Member("decoder", std::string_view(plan.decoder));
        json.Member("multiplicationsPerTexel", plan.multiplications);
        json.EndObject();
    }
    json.EndArray();
}

void WriteShaders(JsonWriter& json, const ShaderCache& shaders) {
    json.Key("permutations");
    json.BeginArray();
    for (const auto& [key, entry] : shaders.GetEntries()) {
        json.BeginObject();
        json.Member("file", std::string_view(entry.file));
        json.Member("defines", std::string_view(entry.defines));
        json.Member("words", static_cast<std::uint64_t>(entry.words.size()));
        json.Member("compileMilliseconds", entry.milliseconds);
        json.EndObject();
    }
    json.EndArray();
}

} // namespace

const char* GetPassName(Pass pass) {
    return kPassNames[static_cast<std::size_t>(pass)];
}

std::vector<BytesOfKind> ListBytes(const Renderer& renderer) {
    const MemoryUse& memory = renderer.GetTextures().GetMemory();
    const std::uint64_t textures = memory.sourceTextures + memory.decodedTextures + memory.blockTextures +
                                   memory.latents + memory.weights + memory.feedback.GetSum();
    return {{"sourceTextures", memory.sourceTextures},
            {"decodedTextures", memory.decodedTextures},
            {"blockTextures", memory.blockTextures},
            {"latents", memory.latents},
            {"weights", memory.weights},
            {"atlases", memory.feedback.atlases},
            {"pageTable", memory.feedback.pageTable},
            {"feedback", memory.feedback.feedback},
            {"scratch", memory.feedback.scratch},
            {"textures", textures},
            {"geometry", renderer.GetGeometryBytes()},
            {"targets", renderer.GetTargetBytes()}};
}

std::string MakeStats(const CommandLine& line, const Scene& scene, const harness::DeviceInfo& device,
                      const Renderer& renderer, const ShaderCache& shaders, const RunRecord& run) {
    const RenderOptions& options = line.render;
    JsonWriter json;
    json.BeginObject();
    json.Member("scene", std::string_view(scene.name));
    json.Member("device", std::string_view(device.name));
    json.Member("driver", std::string_view(device.driver));
    json.Member("mode", GetName(options.mode));
    json.Member("filter", GetName(options.filter));
    json.Member("stf", GetName(options.stochastic));
    const MathChoice& math = renderer.GetTextures().GetMath();
    json.Member("math", GetMathName(math.math));
    json.Member("mathWanted", GetMathName(options.math));
    json.Member("mathReason", std::string_view(math.reason)); // why it is another one
    json.Member("path", GetName(options.path));
    json.Member("masks", GetName(options.masks));
    json.Key("forcedEffects");
    json.BeginArray();
    for (std::size_t e = 0; e < kMaterialEffectCount; ++e) {
        if ((options.forcedEffects >> e & 1u) != 0)
            json.Value(kMaterialEffects[e].name);
    }
    json.EndArray();
    json.Member("width", options.width);
    json.Member("height", options.height);
    json.Member("samples", line.samples);
    json.Member("pictures", line.frames);
    WriteTimes(json, run);
    json.Member("loadSeconds", run.loadSeconds);
    json.Member("decodeOnLoadMilliseconds", 1e3 * renderer.GetTextures().GetDecodeSeconds());
    json.Member("compressOnLoadMilliseconds", 1e3 * renderer.GetTextures().GetTranscodeSeconds());
    const double pixels = static_cast<double>(options.width) * options.height *
                          static_cast<double>(std::max<std::size_t>(run.frames.size(), 1));
    json.Member("texelsPerPixel", static_cast<double>(run.texels.read) / pixels);
    json.Member("texelsDecodedPerPixel", static_cast<double>(run.texels.decoded) / pixels);
    WriteMemory(json, renderer);
    if (const FeedbackStore* const feedback = renderer.GetTextures().GetFeedback())
        WriteFeedback(json, options, feedback->GetStatistics());
    WriteMaterials(json, scene, renderer);
    WriteShaders(json, shaders);
    json.EndObject();
    return json.Take();
}

} // namespace openntc::renderer
