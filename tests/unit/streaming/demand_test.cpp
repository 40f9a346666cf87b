// SPDX-License-Identifier: MIT
// The shaders' page table and demand-loaded textures, as C++, against the model. shader_streaming runs the
// same samples on a device.
#include "support/streaming/StreamingItems.h"

#include <doctest/doctest.h>

#include <bit>

using namespace openntc;
using namespace openntc_tests;

namespace {

/// Runs one item with a clean launch state; checks everything that it did against the model.
bool CheckDemand(StreamingScene& scene, const StreamingItem& item) {
    const ModelResult expected = DemandByModel(scene, item);
    if (!expected.isSure)
        return false;
    scene.ClearState();
    const NtcStreamingConstants launch = scene.GetTable().MakeConstants(9);
    const std::vector<std::uint32_t> r = scene.Run(std::span(&item, 1), launch);
    CAPTURE(item.textureId);
    CAPTURE(item.u);
    CAPTURE(item.v);
    CAPTURE(item.dudx);
    CAPTURE(item.dvdx);
    CAPTURE(item.dudy);
    CAPTURE(item.dvdy);
    CHECK(r[4] == (expected.resident ? 1u : 0u));
    CHECK(static_cast<int>(r[5]) == expected.sampledMip);
    for (std::size_t c = 0; c < 4; ++c) {
        CAPTURE(c);
        const double value = static_cast<double>(std::bit_cast<float>(r[c]));
        CHECK(std::fabs(value - expected.color[c]) <= expected.tolerance);
    }
    const RequestList requests = scene.GetRequests();
    TileSet requested;
    for (std::size_t i = 0; i < requests.GetCount(); ++i)
        requested.insert({requests[i].textureId, requests[i].tile});
    CHECK(requested.size() == requests.GetCount()); // each once
    CHECK(requested == expected.missing);
    CHECK(requests.overflow == 0);
    std::set<std::uint32_t> stamped;
    for (std::uint32_t slot = 0; slot < StreamingScene::kSlots; ++slot) {
        const std::uint32_t stamp = scene.state[launch.stampsWord + slot];
        if (stamp != 0) {
            CHECK(stamp == 9);
            stamped.insert(slot);
        }
    }
    CHECK(stamped == expected.slots);
    CHECK(scene.AreGuardsWhole());
    return true;
}

} // namespace

TEST_CASE("demand: samples of every kind of texture against the model") {
    std::mt19937 random(11);
    StreamingScene scene;
    AddAllTextures(scene);
    MapSome(scene, random, 0.6);
    std::size_t sure = 0;
    const auto items = MakeSamples(scene, random, CASE_DEMAND, 3000);
    for (const StreamingItem& item : items)
        sure += CheckDemand(scene, item) ? 1u : 0u;
    MESSAGE("sure: " << sure << " of " << items.size());
    CHECK(sure > items.size() * 8 / 10);
}
