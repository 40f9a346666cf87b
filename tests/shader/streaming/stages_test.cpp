// SPDX-License-Identifier: MIT
// Streaming in fragment shaders, with derivatives, helper lanes and `discard`, and in ray-generation shaders: results,
// requests and feedback against the C++ build of the same source, which has no helper lanes.
#include "StreamingDevice.h"

#include "triangle_shaders.h"

#include <doctest/doctest.h>

#include <fstream>
#include <iterator>

using namespace openntc;
using namespace openntc::harness;
using namespace openntc_tests;

namespace {

constexpr std::uint32_t kFragmentWords = 17; // results, inputs, and 1 where the pixel is discarded or 2
constexpr std::uint32_t kWidth = 96, kHeight = 80;

struct TrianglePush {
    std::uint32_t kind, textureId, width;
    float scale;
};

/// What the pixels of a picture sampled.
struct Picture {
    std::vector<StreamingItem> items;    ///< of pixels that are covered
    std::vector<std::uint32_t> results;  ///< of those
    std::vector<StreamingItem> recorded; ///< feedback of those that are not discarded
    std::vector<StreamingItem> helpers; ///< what helper lanes would sample, by the derivatives of a neighbour
};

std::uint32_t GetSeed(std::uint32_t x, std::uint32_t y) {
    return shader::NtcGetQuadSeed(shader::int2(static_cast<int>(x), static_cast<int>(y)));
}

Picture ReadPicture(const std::vector<std::uint32_t>& words, const TrianglePush& push) {
    Picture picture;
    const auto at = [&](std::uint32_t x, std::uint32_t y) {
        return words.data() + std::size_t{kFragmentWords} * (std::size_t{y} * kWidth + x);
    };
    const auto isCovered = [&](std::uint32_t x, std::uint32_t y) {
        return at(x, y)[kFragmentWords - 1] != 0;
    };
    const auto read = [&](std::uint32_t x, std::uint32_t y) {
        const std::uint32_t* const inputs = at(x, y) + CASE_WORDS;
        StreamingItem item{};
        item.kind = push.kind;
        item.textureId = push.textureId;
        float* const numbers[] = {&item.u, &item.v, &item.dudx, &item.dvdx, &item.dudy, &item.dvdy};
        for (std::size_t i = 0; i < 6; ++i)
            *numbers[i] = std::bit_cast<float>(inputs[i]);
        item.a = static_cast<int>(inputs[6]);
        item.b = static_cast<int>(inputs[7]);
        item.seed = GetSeed(x, y);
        return item;
    };
    for (std::uint32_t y = 0; y < kHeight; ++y) {
        for (std::uint32_t x = 0; x < kWidth; ++x) {
            if (isCovered(x, y)) {
                StreamingItem item = read(x, y);
                picture.items.push_back(item);
                picture.results.insert(picture.results.end(), at(x, y), at(x, y) + CASE_WORDS);
                item.kind = CASE_RECORD;
                if (at(x, y)[kFragmentWords - 1] == 2)
                    picture.recorded.push_back(item);
                continue;
            }
            for (const std::uint32_t other : {0u, 1u, 2u, 3u}) { // of the quad
                const std::uint32_t nx = (x & ~1u) + (other & 1u), ny = (y & ~1u) + other / 2;
                if (!isCovered(nx, ny))
                    continue;
                StreamingItem item = read(nx, ny);
                const float dx = static_cast<float>(x) - static_cast<float>(nx);
                const float dy = static_cast<float>(y) - static_cast<float>(ny);
                item.u += item.dudx * dx + item.dudy * dy;
                item.v += item.dvdx * dx + item.dvdy * dy;
                item.a = static_cast<int>(std::floor(item.u * 187));
                item.b = static_cast<int>(std::floor(item.v * 130));
                picture.helpers.push_back(item);
                break;
            }
        }
    }
    return picture;
}

DeviceRun DrawTriangles(Context& context, StreamingScene& scene, const NtcStreamingConstants& launch,
                        const TrianglePush& push, const char* defines) {
    const auto vertex = triangle_shaders::FindShader("Triangles.vert", defines);
    const auto fragment = triangle_shaders::FindShader("Triangles.frag", defines);
    REQUIRE_MESSAGE(vertex.has_value(), std::string(vertex.error().GetText()));
    REQUIRE_MESSAGE(fragment.has_value(), std::string(fragment.error().GetText()));
    scene.ClearState();
    std::fill(scene.feedback.begin(), scene.feedback.end(), 0u);
    const SceneOnDevice buffers(context, scene, launch, {}, std::size_t{kWidth} * kHeight * kFragmentWords);
    const auto pipeline =
        context.CreateDrawPipeline(*vertex, *fragment, buffers.GetSlots(), sizeof(TrianglePush));
    REQUIRE_MESSAGE(pipeline.has_value(), std::string(pipeline.error().GetText()));
    const std::vector<BoundBuffer> bound = buffers.GetBound();
    const auto drawn =
        context.Draw({&*pipeline, bound, std::as_bytes(std::span(&push, 1)), kWidth, kHeight, 12});
    REQUIRE_MESSAGE(drawn.has_value(), std::string(drawn.error().GetText()));
    return buffers.Read(scene);
}

/// Results of another launch, in the order of a picture.
DeviceRun Reorder(DeviceRun run, const Picture& picture) {
    run.results = picture.results;
    run.results.resize(run.results.size() + picture.recorded.size() * CASE_WORDS);
    return run;
}

} // namespace

TEST_CASE("streaming in fragment shaders: derivatives, helper lanes and discard") {
    OPENNTC_REQUIRE_DEVICE(context);
    if (!context->GetDevice().features.Has(Feature::FragmentStores)) {
        MESSAGE(
            "SKIP: fragment shaders: " << context->GetDevice().features.GetAbsence(Feature::FragmentStores));
        return;
    }
    std::mt19937 random(11);
    StreamingScene scene;
    AddAllTextures(scene);
    MapSome(scene, random, 0.3);
    FillResidency(scene, random);
    std::size_t telling = 0, tellingFeedback = 0;
    for (const char* defines : {"NETWORK_VERSION=1 NTC_MATH=1 NTC_FEEDBACK_SUBGROUP=0 FRAGMENT_WORDS=17",
                                "NETWORK_VERSION=1 NTC_MATH=1 NTC_FEEDBACK_SUBGROUP=1 FRAGMENT_WORDS=17"}) {
        for (const std::uint32_t kind : {CASE_DEMAND, CASE_SET_TEXEL, CASE_RESIDENCY}) {
            for (const SceneTexture& texture : scene.textures) {
                if (kind == CASE_SET_TEXEL && !texture.IsSet())
                    continue;
                if (kind == CASE_RESIDENCY && texture.id % 4 != 0) // the same for any texture
                    continue;
                CAPTURE(defines);
                CAPTURE(kind);
                CAPTURE(texture.id);
                const TrianglePush push{kind, texture.id, kWidth, texture.id % 2 == 0 ? 1.1f : 0.2f};
                const bool isSome = texture.id % 3 == 2; // requests and feedback of some quads
                const NtcStreamingConstants launch = isSome
                                                         ? scene.GetTable().MakeConstants(6, 0.25, 1.0 / 16)
                                                         : scene.GetTable().MakeConstants(5);
                const DeviceRun run = DrawTriangles(*context, scene, launch, push, defines);
                const Picture picture = ReadPicture(run.results, push);
                REQUIRE(picture.items.size() > kWidth * kHeight / 4);
                REQUIRE(picture.helpers.size() > 200);
                CHECK(picture.recorded.size() < picture.items.size());
                std::vector<StreamingItem> items = picture.items;
                items.insert(items.end(), picture.recorded.begin(), picture.recorded.end());
                DeviceRun compared = Reorder(run, picture);
                for (std::size_t i = picture.items.size(); i < items.size(); ++i)
                    compared.results[i * CASE_WORDS + 5] = 0xFFFFFFFFu; // what recording returns
                CheckRun(scene, items, launch, compared);
                // Helper lanes would have left more behind: this test sees them.
                const std::vector<std::uint32_t> state = scene.state, feedback = scene.feedback;
                std::vector<StreamingItem> helpers = picture.helpers;
                scene.Run(helpers, launch);
                telling += GetQueue(scene, scene.state) != GetQueue(scene, state) ? 1 : 0;
                for (StreamingItem& item : helpers)
                    item.kind = CASE_RECORD;
                scene.Run(helpers, launch);
                tellingFeedback += scene.feedback != feedback ? 1 : 0;
            }
        }
    }
    CHECK(telling >= 4);
    CHECK(tellingFeedback >= 4);
}

TEST_CASE("streaming in ray-generation shaders") {
    OPENNTC_REQUIRE_DEVICE(context);
    if (!context->GetDevice().features.Has(Feature::RayTracing)) {
        MESSAGE("SKIP: shader_streaming: ray-tracing shaders on a device: "
                << context->GetDevice().features.GetAbsence(Feature::RayTracing));
        return;
    }
    std::ifstream file(STREAMING_RAYS, std::ios::binary);
    const std::vector<char> bytes(std::istreambuf_iterator<char>(file), {});
    REQUIRE(bytes.size() % 4 == 0);
    REQUIRE_FALSE(bytes.empty());
    std::vector<std::uint32_t> spirv(bytes.size() / 4);
    std::memcpy(spirv.data(), bytes.data(), bytes.size());
    std::mt19937 random(12);
    StreamingScene scene;
    AddAllTextures(scene);
    MapSome(scene, random, 0.6);
    FillResidency(scene, random);
    const SceneTexture& set = scene.textures.back();
    for (const std::uint32_t kind :
         {CASE_DEMAND, CASE_RECORD, CASE_RECORD_LOD, CASE_RESIDENCY, CASE_SET_TEXEL}) {
        CAPTURE(kind);
        std::vector<StreamingItem> items = MakeSamples(scene, random, kind, 3000);
        for (StreamingItem& item : items) {
            if (kind != CASE_SET_TEXEL)
                continue;
            item.textureId = set.id;
            item.c = static_cast<int>(random() % static_cast<unsigned>(set.desc.mips));
            item.a = static_cast<int>(random() % static_cast<unsigned>(set.GetWidth(item.c)));
            item.b = static_cast<int>(random() % static_cast<unsigned>(set.GetHeight(item.c)));
        }
        for (const NtcStreamingConstants& launch :
             {scene.GetTable().MakeConstants(5), scene.GetTable().MakeConstants(6, 0.25, 1.0 / 16)}) {
            scene.ClearState();
            std::fill(scene.feedback.begin(), scene.feedback.end(), 0u);
            CheckRun(scene, items, launch,
                     RunOnDevice(*context, scene, items, launch, spirv, DeviceStage::Rays));
        }
    }
}
