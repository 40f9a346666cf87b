// SPDX-License-Identifier: MIT
// The effects of shaders that read tiles: what is switched off is neither in the SPIR-V nor done, what is
// left gives the same results, and the switches at their defaults change no word.
#include "StreamingDevice.h"

#include "tile_effect_shaders.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <string>

using namespace openntc;
using namespace openntc::harness;
using namespace openntc_tests;

namespace {

const std::string kBase = "NETWORK_VERSION=1 NTC_MATH=1";
const std::string kNone =
    kBase + " NTC_TILE_FALLBACK=0 NTC_TILE_REQUESTS=0 NTC_TILE_STAMPS=0 NTC_TILE_FEEDBACK=0 NTC_TILE_RATES=0";

std::span<const std::uint32_t> FindTileEffect(const std::string& defines) {
    const auto words = tile_effect_shaders::FindShader("Streaming.comp", defines);
    REQUIRE_MESSAGE(words.has_value(), std::string(words.error().GetText()));
    return *words;
}

/// Instructions of one kind.
std::size_t CountInstructions(std::span<const std::uint32_t> words, std::uint32_t opcode) {
    std::size_t count = 0;
    for (std::size_t at = 5; at < words.size(); at += std::max<std::size_t>(words[at] >> 16, 1))
        count += (words[at] & 0xFFFFu) == opcode ? 1u : 0u;
    return count;
}

/// Is a buffer bound at `binding` of the streaming set (1)? There are others at the same numbers of set 0.
bool HasStreamingBuffer(std::span<const std::uint32_t> words, std::uint32_t binding) {
    constexpr std::uint32_t kDecorate = 71, kBinding = 33, kDescriptorSet = 34;
    std::set<std::uint32_t> bound, inSet;
    for (std::size_t at = 5; at < words.size(); at += std::max<std::size_t>(words[at] >> 16, 1)) {
        if ((words[at] & 0xFFFFu) != kDecorate || words[at] >> 16 != 4)
            continue;
        if (words[at + 2] == kBinding && words[at + 3] == binding)
            bound.insert(words[at + 1]);
        if (words[at + 2] == kDescriptorSet && words[at + 3] == 1)
            inSet.insert(words[at + 1]);
    }
    return std::any_of(bound.begin(), bound.end(), [&](std::uint32_t id) { return inSet.count(id) != 0; });
}

constexpr std::uint32_t kAtomicIAdd = 234, kAtomicOr = 241;

std::vector<StreamingItem> MakeEffectItems(const StreamingScene& scene, std::mt19937& random) {
    std::vector<StreamingItem> items = MakeSamples(scene, random, CASE_DEMAND, 1500);
    const std::vector<StreamingItem> records = MakeSamples(scene, random, CASE_RECORD, 500);
    items.insert(items.end(), records.begin(), records.end());
    return items;
}

struct EffectRun {
    DeviceRun run;
    std::span<const std::uint32_t> GetItem(std::size_t i) const {
        return std::span<const std::uint32_t>(run.results).subspan(i * CASE_WORDS, CASE_WORDS);
    }
};

} // namespace

TEST_CASE("tile effects: switches at their defaults change no word of SPIR-V") {
    const auto plain = FindTileEffect(kBase);
    const auto named = FindTileEffect(kBase + " NTC_TILE_FALLBACK=1 NTC_TILE_REQUESTS=1 NTC_TILE_STAMPS=1 "
                                              "NTC_TILE_FEEDBACK=1 NTC_TILE_RATES=1");
    CHECK(std::equal(plain.begin(), plain.end(), named.begin(), named.end()));
}

TEST_CASE("tile effects: what is switched off is not in the shader") {
    const auto all = FindTileEffect(kBase);
    const auto requests = FindTileEffect(kBase + " NTC_TILE_REQUESTS=0");
    const auto stamps = FindTileEffect(kBase + " NTC_TILE_STAMPS=0");
    const auto feedback = FindTileEffect(kBase + " NTC_TILE_FEEDBACK=0");
    const auto none = FindTileEffect(kNone);
    // The queue's counter and its overflow; the request bit and the region's word.
    CHECK(CountInstructions(all, kAtomicIAdd) == 2);
    CHECK(CountInstructions(all, kAtomicOr) == 2);
    CHECK(CountInstructions(requests, kAtomicIAdd) == 0);
    CHECK(CountInstructions(requests, kAtomicOr) == 1);
    CHECK(CountInstructions(feedback, kAtomicIAdd) == 2);
    CHECK(CountInstructions(feedback, kAtomicOr) == 1);
    CHECK(CountInstructions(none, kAtomicIAdd) + CountInstructions(none, kAtomicOr) == 0);
    for (const char* effect : {"FALLBACK", "REQUESTS", "STAMPS", "FEEDBACK", "RATES"}) {
        CAPTURE(effect);
        const auto one = FindTileEffect(kBase + " NTC_TILE_" + effect + "=0");
        CHECK(one.size() < all.size());
        CHECK(none.size() < one.size());
    }
    // Buffers that nothing uses are not declared: 0 page table, 1 launch state, 2 feedback.
    for (const auto& [shader, state, regions] : {std::tuple{all, true, true},
                                                 {requests, true, true},
                                                 {stamps, true, true},
                                                 {feedback, true, false},
                                                 {none, false, false}}) {
        CHECK(HasStreamingBuffer(shader, 0));
        CHECK(HasStreamingBuffer(shader, 1) == state);
        CHECK(HasStreamingBuffer(shader, 2) == regions);
    }
}

TEST_CASE("tile effects on the device: what is left gives the same results") {
    OPENNTC_REQUIRE_DEVICE(context);
    std::mt19937 random(21);
    StreamingScene scene;
    AddAllTextures(scene);
    MapSome(scene, random, 0.6);
    const std::vector<StreamingItem> items = MakeEffectItems(scene, random);
    const NtcStreamingConstants launch = scene.GetTable().MakeConstants(6);
    const NtcStreamingConstants rare = scene.GetTable().MakeConstants(6, 1.0 / 64, 1.0 / 64);
    const auto run = [&](const std::string& defines, const NtcStreamingConstants& constants) {
        scene.ClearState();
        std::fill(scene.feedback.begin(), scene.feedback.end(), 0u);
        return EffectRun{RunOnDevice(*context, scene, items, constants, FindTileEffect(defines))};
    };
    scene.ClearState();
    const std::vector<std::uint32_t> untouched = scene.state;
    const EffectRun all = run(kBase, launch);
    const TileSet queue = GetQueue(scene, all.run.state);
    CHECK(queue.size() > 20);
    const auto getStamps = [&](const EffectRun& r) {
        return std::vector<std::uint32_t>(r.run.state.begin() + launch.stampsWord,
                                          r.run.state.begin() + launch.stampsWord +
                                              static_cast<std::ptrdiff_t>(StreamingScene::kSlots));
    };
    const EffectRun requests = run(kBase + " NTC_TILE_REQUESTS=0", launch);
    CHECK(requests.run.results == all.run.results);
    CHECK(GetQueue(scene, requests.run.state).empty());
    CHECK(getStamps(requests) == getStamps(all));

    const EffectRun stamps = run(kBase + " NTC_TILE_STAMPS=0", launch);
    CHECK(stamps.run.results == all.run.results);
    CHECK(GetQueue(scene, stamps.run.state) == queue);
    const auto noStamps = getStamps(stamps);
    CHECK(std::all_of(noStamps.begin(), noStamps.end(), [](std::uint32_t word) { return word == 0; }));

    const EffectRun feedback = run(kBase + " NTC_TILE_FEEDBACK=0", launch);
    CHECK(feedback.run.results == all.run.results);
    CHECK(feedback.run.feedback == std::vector<std::uint32_t>(scene.feedback.size(), 0));
    CHECK(all.run.feedback != feedback.run.feedback);

    const EffectRun rates = run(kBase + " NTC_TILE_RATES=0", rare);
    CHECK(rates.run.results == all.run.results);
    CHECK(GetQueue(scene, rates.run.state) == queue);
    CHECK(rates.run.feedback == all.run.feedback);
    CHECK(GetQueue(scene, run(kBase, rare).run.state) != queue);

    const EffectRun none = run(kNone, launch);
    CHECK(none.run.state == untouched);
    const EffectRun fallback = run(kBase + " NTC_TILE_FALLBACK=0", launch);
    CHECK(GetQueue(scene, fallback.run.state) == queue);
    int missing = 0;
    for (std::size_t i = 0; i < items.size(); ++i) {
        if (items[i].kind != CASE_DEMAND)
            continue;
        CAPTURE(i);
        const auto expected = all.GetItem(i);
        for (const EffectRun* one : {&fallback, &none}) {
            const auto got = one->GetItem(i);
            CHECK(got[4] == expected[4]); // resident
            if (expected[4] != 0)
                CHECK(std::equal(got.begin(), got.end(), expected.begin()));
            else
                CHECK(static_cast<int>(got[5]) == -1);
        }
        missing += expected[4] == 0 ? 1 : 0;
    }
    CHECK(missing > 100);
}
