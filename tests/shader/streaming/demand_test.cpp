// SPDX-License-Identifier: MIT
// Page table, requests and demand-loaded textures on the device: every result, and every word of launch state
// and feedback, against the C++ build of the same source, which unit_streaming holds to a model.
#include "StreamingDevice.h"

#include "streaming_hlsl_shaders.h"
#include "streaming_shaders.h"

#include <doctest/doctest.h>

using namespace openntc;
using namespace openntc::harness;
using namespace openntc_tests;

namespace {

/// Which: GLSL without and with subgroups in feedback, HLSL.
std::span<const std::uint32_t> GetShader(int which, int networkVersion = NTC_NETWORK_SMALL) {
    const std::string defines = "NETWORK_VERSION=" + std::to_string(networkVersion) + " NTC_MATH=1";
    const auto words =
        which < 2 ? streaming_shaders::FindShader("Streaming.comp",
                                                  defines + " NTC_FEEDBACK_SUBGROUP=" + std::to_string(which))
                  : streaming_hlsl_shaders::FindShader("Streaming.hlsl", defines);
    REQUIRE_MESSAGE(words.has_value(), std::string(words.error().GetText()));
    return *words;
}

/// Runs items on the device and in C++ with a clean state, and compares everything.
void CheckItems(Context& context, StreamingScene& scene, std::span<const StreamingItem> items,
                const NtcStreamingConstants& launch, int which) {
    scene.ClearState();
    std::fill(scene.feedback.begin(), scene.feedback.end(), 0u);
    CheckRun(scene, items, launch, RunOnDevice(context, scene, items, launch, GetShader(which)));
}

std::vector<StreamingItem> MakeSetTexels(const StreamingScene& scene, std::mt19937& random) {
    std::vector<StreamingItem> items;
    const SceneTexture& set = scene.textures.back();
    for (int i = 0; i < 2000; ++i) {
        StreamingItem item{};
        item.kind = i % 2 == 0 ? CASE_SET_TEXEL : CASE_RECORD_TEXEL;
        item.textureId = set.id;
        item.c = static_cast<int>(random() % static_cast<unsigned>(set.desc.mips + 2)) - 1;
        const int mip = std::min(std::max(item.c, 0), set.desc.mips - 1);
        item.a = static_cast<int>(random() % static_cast<unsigned>(set.GetWidth(mip) + 2)) - 1;
        item.b = static_cast<int>(random() % static_cast<unsigned>(set.GetHeight(mip) + 2)) - 1;
        items.push_back(item);
    }
    return items;
}

} // namespace

TEST_CASE("demand case 41: shaders of both languages ask for the same tiles at the same coordinates") {
    OPENNTC_REQUIRE_DEVICE(context);
    // Fragment and ray-generation shaders: the cases "streaming in …", against the same C++ build.
    std::mt19937 random(41);
    StreamingScene scene;
    AddAllTextures(scene);
    MapSome(scene, random, 0.3);
    const std::vector<StreamingItem> items = MakeSamples(scene, random, CASE_DEMAND, 4000);
    const NtcStreamingConstants launch = scene.GetTable().MakeConstants(4);
    scene.ClearState();
    scene.Run(items, launch);
    const TileSet expected = GetQueue(scene, scene.state); // of the C++ build
    CHECK(expected.size() > 50);
    for (const int which : {0, 2}) { // GLSL, HLSL
        CAPTURE(which);
        scene.ClearState();
        CHECK(GetQueue(scene, RunOnDevice(*context, scene, items, launch, GetShader(which)).state) ==
              expected);
    }
}

TEST_CASE("streaming on the device: samples, texels, feedback and residency against the C++ build") {
    OPENNTC_REQUIRE_DEVICE(context);
    std::mt19937 random(3);
    StreamingScene scene;
    AddAllTextures(scene);
    MapSome(scene, random, 0.6);
    FillResidency(scene, random);
    for (int which = 0; which < 3; ++which) {
        CAPTURE(which);
        for (const std::uint32_t kind :
             {CASE_DEMAND, CASE_RECORD, CASE_RECORD_LOD, CASE_RESIDENCY, CASE_MATHS}) {
            if (which == 1 && kind != CASE_RECORD)
                continue; // subgroups matter to feedback only
            CAPTURE(kind);
            auto items = MakeSamples(scene, random, kind, 3000);
            for (StreamingItem& item : items) {
                if (random() % 50 == 0)
                    item.textureId = static_cast<std::uint32_t>(12 + random() % 30); // does not exist
                if (kind == CASE_MATHS) {
                    item.a = static_cast<int>(1 + random() % 65536);
                    item.b = static_cast<int>(random() % 3);
                    item.c = static_cast<int>(random());
                    item.u = std::bit_cast<float>(static_cast<std::uint32_t>(random()));
                    item.v = std::bit_cast<float>(static_cast<std::uint32_t>(random()));
                }
            }
            CheckItems(*context, scene, items, scene.GetTable().MakeConstants(5), which);
            CheckItems(*context, scene, items, scene.GetTable().MakeConstants(6, 0.25, 1.0 / 16), which);
        }
        CheckItems(*context, scene, MakeSetTexels(scene, random), scene.GetTable().MakeConstants(7), which);
    }
    // Pages of a resource, beside textures and where there is nothing.
    const std::uint32_t pages = *scene.GetTable().AddPages(100);
    for (std::uint32_t page = 0; page < 100; page += 3)
        REQUIRE(scene.GetTable().SetPage(pages, page, page * 1000));
    std::vector<StreamingItem> requests(500);
    for (StreamingItem& item : requests) {
        item.kind = CASE_PAGE;
        item.textureId = pages + static_cast<std::uint32_t>(random() % 8 == 0) -
                         static_cast<std::uint32_t>(random() % 8 == 0);
        item.a = static_cast<int>(random() % 110) - 5;
    }
    CheckItems(*context, scene, requests, scene.GetTable().MakeConstants(8), 0);
    CHECK(scene.GetRequests().GetCount() > 40);
    // A table in which nothing is, and one in which everything is.
    StreamingScene empty;
    AddAllTextures(empty);
    CheckItems(*context, empty, MakeSamples(empty, random, CASE_DEMAND, 1000),
               empty.GetTable().MakeConstants(1), 0);
    for (const SceneTexture& texture : empty.textures)
        empty.MapAll(texture);
    CheckItems(*context, empty, MakeSamples(empty, random, CASE_DEMAND, 1000),
               empty.GetTable().MakeConstants(2), 0);
}

TEST_CASE("streaming on the device: a set of generation 3 in both languages, against C++ and the whole set") {
    OPENNTC_REQUIRE_DEVICE(context);
    std::mt19937 random(51);
    StreamingScene scene;
    const SceneTexture& set =
        scene.AddSet(61, 45, 8, TileFilter::Trilinear, TileWrap::Repeat, NTC_NETWORK_GENERATION_3);
    MapSome(scene, random, 0.6);
    scene.MapTail(set);
    std::vector<StreamingItem> items = MakeSamples(scene, random, CASE_DEMAND, 1000);
    const std::vector<StreamingItem> texels = MakeSetTexels(scene, random);
    items.insert(items.end(), texels.begin(), texels.end());
    const NtcStreamingConstants launch = scene.GetTable().MakeConstants(9);
    for (const int which : {0, 2}) { // GLSL, HLSL
        CAPTURE(which);
        scene.ClearState();
        std::fill(scene.feedback.begin(), scene.feedback.end(), 0u);
        const DeviceRun run =
            RunOnDevice(*context, scene, items, launch, GetShader(which, NTC_NETWORK_GENERATION_3));
        CheckRun(scene, items, launch, run);
        std::size_t compared = 0, different = 0;
        for (std::size_t i = 0; i < items.size(); ++i) {
            const StreamingItem& item = items[i];
            const std::uint32_t* const r = run.results.data() + i * CASE_WORDS;
            if (item.kind != CASE_SET_TEXEL || r[4] == 0 || item.a < 0 || item.a >= set.GetWidth(item.c) ||
                item.b < 0 || item.b >= set.GetHeight(item.c))
                continue;
            const auto texel = static_cast<std::size_t>(item.b * set.GetWidth(item.c) + item.a);
            const float* const whole = scene.setTexels[static_cast<std::size_t>(item.c)].data() + 16 * texel;
            for (const std::size_t channel : {0u, 1u, 2u, 3u, 7u}) {
                const std::uint32_t word = r[channel];
                different += word != std::bit_cast<std::uint32_t>(whole[channel]);
            }
            ++compared;
        }
        CHECK(compared > 100);
        CHECK(different == 0);
    }
}
