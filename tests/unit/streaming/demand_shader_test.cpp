// SPDX-License-Identifier: MIT
// The demand loader with the shaders' own requests, compiled as C++: the tiles that filters, wrap modes and
// footprints ask for, many threads at once, and pictures that converge to what is there when all is resident.
// shader_streaming has the same functions on a device.
#include "DemandTestKit.h"

#include "openntc/decode/ReferenceDecoder.h"
#include "openntc/streaming/Demand.h"

#include <cmath>
#include <limits>
#include <random>
#include <tuple>

using namespace demand_test;

namespace {

struct ShaderSample {
    shader::float4 color{};
    bool resident = false;
    int mip = -1;
};

/// One launch's shaders, on the device's memory.
class ShaderLaunch {
public:
    ShaderLaunch(Device& device, const Launch& launch)
        : table_(launch.table), state_(device.GetState()), slots_(device.GetSlots()) {
        memory_.pageTable = {table_.data(), table_.size()};
        memory_.launchState = {state_.data(), state_.size()};
        pool_ = {slots_.data(), slots_.size()};
        memory_.pools = &pool_;
        memory_.poolCount = 1;
        context_ = shader::NtcMakeStreamingContext(launch.constants, 1u, memory_);
    }
    ShaderSample Sample(std::uint32_t texture, float u, float v, float ddx, float ddy = -1) const {
        ShaderSample sample;
        const shader::float2 x(ddx, 0.0f), y(0.0f, ddy < 0 ? ddx : ddy);
        sample.color = shader::NtcDemandGradMip(context_, texture, shader::float2(u, v), x, y,
                                                sample.resident, sample.mip);
        return sample;
    }
    bool Page(std::uint32_t pages, std::uint32_t page, std::uint32_t& value) const {
        bool resident = false;
        value = shader::NtcDemandPage(context_, pages, page, resident);
        return resident;
    }

private:
    std::vector<std::uint32_t> table_;
    std::vector<std::uint32_t>& state_;
    std::vector<std::uint32_t>& slots_;
    shader::NtcStreamingWords pool_;
    shader::NtcStreamingMemory memory_;
    shader::NtcStreamingContext context_{};
};

struct ShaderScene {
    explicit ShaderScene(int width, int height, TileFilter filter, TileWrap wrap = TileWrap::Repeat,
                         int anisotropy = 1, std::uint32_t slots = 512)
        : options(MakeOptions(slots)), loader(MakeLoader(options)), device(options),
          source(MakeSource(MakeLayout(width, height, 16), 77)) {
        TiledTextureDesc desc;
        desc.format = TileFormat::RGBA8;
        desc.filter = filter;
        desc.wrapU = desc.wrapV = wrap;
        desc.maxAnisotropy = anisotropy;
        desc.hasFeedback = false;
        const auto made = loader.CreateTexture(source, desc);
        REQUIRE(made.has_value());
        id = *made;
    }
    /// Tiles of the regular levels that one sample asks for in an empty scene, as positions.
    std::set<std::tuple<int, int, int>> Ask(float u, float v, float ddx, float ddy = -1) {
        const Launch launch = device.Prepare(loader);
        ShaderLaunch(device, launch).Sample(id.index, u, v, ddx, ddy);
        device.Read(loader);
        REQUIRE(loader.AbandonLaunch(launch.context).has_value());
        std::set<std::tuple<int, int, int>> tiles;
        for (const auto& [texture, tile] : device.lastRequests) {
            CHECK(texture == id.index);
            const auto position = source->GetLayout().GetTilePosition(tile);
            REQUIRE(position.has_value());
            CHECK(tiles.insert({position->level, position->x, position->y}).second);
        }
        return tiles;
    }

    DemandLoaderOptions options;
    DemandLoader loader;
    Device device;
    Shared<NumberSource> source;
    DemandId id;
};

using TileKeys = std::set<std::tuple<int, int, int>>;

} // namespace

TEST_CASE("demand case 5: 64 threads on one tile make one entry of the queue") {
    ShaderScene scene(128, 128, TileFilter::Point);
    const Launch launch = scene.device.Prepare(scene.loader);
    const ShaderLaunch shaders(scene.device, launch);
    std::atomic<int> arrived{0};
    std::vector<std::thread> threads;
    for (int i = 0; i < 64; ++i) {
        threads.emplace_back([&, i] {
            ++arrived;
            while (arrived < 64)
                std::this_thread::yield();
            shaders.Sample(scene.id.index, (40.5f + static_cast<float>(i % 8)) / 128, 40.5f / 128,
                           1.0f / 128);
        });
    }
    for (std::thread& thread : threads)
        thread.join();
    scene.device.Process(scene.loader, launch);
    REQUIRE(scene.device.lastRequests.size() == 1);
    CHECK(*scene.source->GetLayout().GetTilePosition(scene.device.lastRequests[0].second) ==
          TilePosition{0, 2, 2});
}

TEST_CASE("demand case 6: a bilinear tap asks for the four tiles at a corner, two at an edge, one inside") {
    ShaderScene scene(128, 128, TileFilter::Bilinear);
    const float texel = 1.0f / 128;
    CHECK(scene.Ask(32 * texel, 48 * texel, texel) == TileKeys{{0, 1, 2}, {0, 2, 2}, {0, 1, 3}, {0, 2, 3}});
    CHECK(scene.Ask(32 * texel, 40.5f * texel, texel) == TileKeys{{0, 1, 2}, {0, 2, 2}});
    CHECK(scene.Ask(40.25f * texel, 48 * texel, texel) == TileKeys{{0, 2, 2}, {0, 2, 3}});
    CHECK(scene.Ask(40.25f * texel, 40.75f * texel, texel) == TileKeys{{0, 2, 2}});
    CHECK(scene.Ask(31.5f * texel, 40.5f * texel, texel) == TileKeys{{0, 1, 2}}); // no weight beyond
}

TEST_CASE("demand case 7: repeated odd sizes ask for the tiles of both ends") {
    ShaderScene scene(100, 37, TileFilter::Bilinear); // 7 × 3 tiles
    const float y = 8.5f / 37;
    CHECK(scene.Ask(0.0f, y, 1.0f / 100) == TileKeys{{0, 0, 0}, {0, 6, 0}});
    CHECK(scene.Ask(1.0f, y, 1.0f / 100) == TileKeys{{0, 0, 0}, {0, 6, 0}});
    CHECK(scene.Ask(-3.0f, y, 1.0f / 100) == TileKeys{{0, 0, 0}, {0, 6, 0}});
    CHECK(scene.Ask(8.5f / 100, 0.0f, 1.0f / 100) == TileKeys{{0, 0, 0}, {0, 0, 2}});
}

TEST_CASE("demand case 8: clamped and mirrored samples ask for what they touch, and nothing beyond a texel") {
    std::mt19937 random(8);
    for (const TileWrap wrap : {TileWrap::Clamp, TileWrap::Mirror, TileWrap::Repeat}) {
        ShaderScene scene(100, 70, TileFilter::Bilinear, wrap);
        for (int i = 0; i < 300; ++i) {
            const float u = static_cast<float>(random() % 4000) / 1000 - 1.5f;
            const float v = static_cast<float>(random() % 4000) / 1000 - 1.5f;
            const TileKeys asked = scene.Ask(u, v, 1.0f / 100, 1.0f / 70);
            // Brute force in binary64: texels with weight, and those a texel farther.
            const auto address = [&](int texel, int size) {
                if (wrap == TileWrap::Clamp)
                    return std::clamp(texel, 0, size - 1);
                const int period = wrap == TileWrap::Mirror ? 2 * size : size;
                const int inside = (texel % period + period) % period;
                return inside < size ? inside : 2 * size - 1 - inside;
            };
            TileKeys touched, dilated;
            const double x = static_cast<double>(u) * 100 - 0.5, y = static_cast<double>(v) * 70 - 0.5;
            for (int dy = -1; dy <= 2; ++dy) {
                for (int dx = -1; dx <= 2; ++dx) {
                    const int tx = static_cast<int>(std::floor(x)) + dx,
                              ty = static_cast<int>(std::floor(y)) + dy;
                    const std::tuple<int, int, int> tile = {0, address(tx, 100) / 16, address(ty, 70) / 16};
                    dilated.insert(tile);
                    // Fractions have 16 bits: what is nearer to a texel's middle may have no weight.
                    if (std::abs(tx - x) < 1 - 1e-3 && std::abs(ty - y) < 1 - 1e-3)
                        touched.insert(tile);
                }
            }
            CAPTURE(u);
            CAPTURE(v);
            CHECK(std::includes(asked.begin(), asked.end(), touched.begin(), touched.end()));
            CHECK(std::includes(dilated.begin(), dilated.end(), asked.begin(), asked.end()));
        }
    }
}

TEST_CASE("demand case 9: trilinear between two mips asks for tiles of both") {
    ShaderScene scene(256, 256, TileFilter::Trilinear);
    const TileKeys asked = scene.Ask(40.5f / 256, 40.5f / 256, std::exp2(1.5f) / 256);
    CHECK(asked == TileKeys{{1, 1, 1}, {2, 0, 0}});
}

TEST_CASE("demand case 10: an anisotropic footprint over three tiles asks for all three") {
    ShaderScene fine(256, 256, TileFilter::Point, TileWrap::Repeat, 16);
    // 16 taps over 22.4 texels, 1.4 wide: mip 0, from texel 30 to 51, of tiles 1 to 3. The published loader
    // asks for the two at the corners.
    const TileKeys row = fine.Ask(40.5f / 256, 40.5f / 256, 16.0f * 1.4f / 256, 1.4f / 256);
    CHECK(row.contains({0, 1, 2}));
    CHECK(row.contains({0, 2, 2}));
    CHECK(row.contains({0, 3, 2}));
    for (const auto& [level, x, y] : row)
        CHECK((level == 0 && y == 2 && x >= 1 && x <= 3));
}

TEST_CASE(
    "demand case 11: levels beyond the last, gradients of 0, infinity and NaN stay inside the texture") {
    ShaderScene scene(256, 256, TileFilter::Trilinear, TileWrap::Repeat, 4);
    const float infinity = std::numeric_limits<float>::infinity();
    const float nan = std::numeric_limits<float>::quiet_NaN();
    for (const float gradient : {1.0f, 100.0f, 1e30f, infinity, nan}) {
        CAPTURE(gradient);
        CHECK(scene.Ask(0.3f, 0.3f, gradient).empty()); // the tail, which is there
        const Launch launch = scene.device.Prepare(scene.loader);
        CHECK(ShaderLaunch(scene.device, launch).Sample(scene.id.index, 0.3f, 0.3f, gradient).resident);
        scene.device.Process(scene.loader, launch);
    }
    CHECK(scene.Ask(40.5f / 256, 40.5f / 256, 0.0f) == TileKeys{{0, 2, 2}});
    for (const float place : {nan, infinity, -infinity, 1e30f}) {
        for (const auto& [level, x, y] : scene.Ask(place, place, 0.001f))
            CHECK((level >= 0 && level < 4 && x >= 0 && y >= 0 && x < 16 && y < 16));
    }
}

TEST_CASE(
    "demand cases 13 to 16 and 21 with the shaders' filters: every picture converges to the resident one") {
    struct Case {
        TileFilter filter;
        int anisotropy;
        std::uint32_t slots;
    };
    // 119 + 32 + 8 + 2 tiles and the tail; anisotropic poses see most of level 0.
    for (const auto& [filter, anisotropy, slots] :
         {Case{TileFilter::Point, 1, 10}, Case{TileFilter::Trilinear, 1, 10},
          Case{TileFilter::Trilinear, 8, 162}}) {
        ShaderScene all(257, 100, filter, TileWrap::Mirror, anisotropy);
        ShaderScene some(257, 100, filter, TileWrap::Mirror, anisotropy, slots);
        // Everything resident: asked for tile by tile.
        all.device.Converge(all.loader, [&](const Launch& launch) {
            for (int tile = 0; tile < all.source->GetLayout().GetTileCount(); ++tile)
                if (all.device.GetEntry(launch, all.id.index, static_cast<std::uint32_t>(tile)) ==
                    NTC_TILE_MISSING)
                    all.device.Request(launch, all.id.index, static_cast<std::uint32_t>(tile));
        });
        const Launch whole = all.device.Prepare(all.loader);
        const ShaderLaunch reference(all.device, whole);
        for (int pose = 0; pose < 6; ++pose) {
            const float left = static_cast<float>(pose % 3) * 0.35f, zoom = pose < 3 ? 0.3f : 1.1f;
            bool isComplete = false;
            for (int round = 0; round < 40 && !isComplete; ++round) {
                const Launch launch = some.device.Prepare(some.loader);
                const ShaderLaunch shaders(some.device, launch);
                isComplete = true;
                bool isDifferent = false;
                for (int y = 0; y < 24; ++y) {
                    for (int x = 0; x < 32; ++x) {
                        const float u = left + zoom * static_cast<float>(x) / 32;
                        const float v = zoom * static_cast<float>(y) / 24;
                        const ShaderSample sample =
                            shaders.Sample(some.id.index, u, v, zoom / 32, zoom / 24 * 0.4f);
                        CHECK(sample.mip >= 0); // the tail is always there
                        isComplete = isComplete && sample.resident;
                        const ShaderSample expected =
                            reference.Sample(all.id.index, u, v, zoom / 32, zoom / 24 * 0.4f);
                        if (sample.resident)
                            isDifferent = isDifferent || std::memcmp(&sample.color, &expected.color, 16) != 0;
                    }
                }
                CHECK_FALSE(isDifferent);
                some.device.Process(some.loader, launch);
                CHECK(some.loader.GetStatistics().slotsInUse <= slots);
            }
            CHECK(isComplete);
        }
        CHECK((slots == 162) == (some.loader.GetStatistics().freed == 0));
        CheckSums(some.loader);
    }
}

TEST_CASE("demand case 42: pages of a resource in shaders") {
    DemandLoaderOptions options = MakeOptions(4);
    DemandLoader loader = MakeLoader(options);
    Device device(options);
    const auto id = loader.CreateResource(5000, {[](void*, std::uint32_t page) -> Expected<PageRead> {
                                                     return PageRead{TileAnswer::Ready, page * 3};
                                                 },
                                                 nullptr});
    REQUIRE(id.has_value());
    std::uint32_t value = 0;
    Launch launch = device.Prepare(loader);
    {
        const ShaderLaunch shaders(device, launch);
        CHECK_FALSE(shaders.Page(id->index, 4321, value));
        CHECK_FALSE(shaders.Page(id->index, 5000, value)); // no such page: asks for nothing
        CHECK_FALSE(shaders.Page(7, 0, value));
    }
    device.Process(loader, launch);
    CHECK(device.lastRequests.size() == 1);
    launch = device.Prepare(loader);
    CHECK(ShaderLaunch(device, launch).Page(id->index, 4321, value));
    CHECK(value == 12963);
}
