// SPDX-License-Identifier: MIT
// Textures that are decoded on demand: how they are cut, that pictures end as those of on-load, that short memory and short
// time coarsen them and nothing else.
#include "shader/renderer/Rendering.h"

#include "renderer/gpu/FeedbackTiles.h"
#include "renderer/scene/SampleScene.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdlib>
#include <numeric>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace {

using namespace openntc;
using namespace openntc::renderer;
using namespace openntc_tests;

struct FeedbackResult {
    Picture picture;
    FeedbackStatistics statistics;
    FeedbackMemory memory;
    std::uint64_t textureBytes = 0; ///< of on-load
};

/// Steps of 255.
double GetMeanDifference(const Picture& a, const Picture& b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i)
        sum += std::abs(static_cast<int>(a[i]) - static_cast<int>(b[i]));
    return sum / static_cast<double>(a.size());
}

/// The mean of `samples` frames.
FeedbackResult RenderSamples(harness::Context& context, const RenderOptions& options, std::uint32_t samples) {
    Scene scene = MakeSampleScene();
    Renderer renderer(context, GetShaders(), scene, options);
    for (std::uint32_t frame = 0; frame < samples; ++frame)
        renderer.Render(scene.cameras.front(), frame, samples > 1);
    FeedbackResult result;
    result.picture = renderer.ReadPicture();
    const MemoryUse memory = renderer.GetTextures().GetMemory();
    result.textureBytes = memory.decodedTextures + memory.blockTextures;
    if (const FeedbackStore* const feedback = renderer.GetTextures().GetFeedback()) {
        result.statistics = feedback->GetStatistics();
        result.memory = feedback->GetMemory();
    }
    return result;
}

RenderOptions MakeFeedbackOptions() {
    RenderOptions options = MakeSmallOptions(Mode::OnFeedback);
    options.tileSize = 16;
    return options;
}

/// Every texel of every mip in one part, parts of a tile inside it and apart from each other.
void CheckParts(const TextureSetDesc& set, int tileSize) {
    CAPTURE(set.width);
    CAPTURE(set.height);
    CAPTURE(tileSize);
    const Expected<TileLayout> made = MakeFeedbackLayout(set, tileSize);
    REQUIRE(made);
    std::set<std::vector<int>> texels; // mip, x, y
    int count = 0;
    for (std::uint32_t tile = 0; tile < static_cast<std::uint32_t>(made->GetTileCount()); ++tile) {
        std::set<std::pair<int, int>> blocks;
        for (const TilePart& part : GetTileParts(*made, tile)) {
            CHECK((part.left % 4 == 0 && part.top % 4 == 0));
            CHECK((part.rect.left % 4 == 0 && part.rect.top % 4 == 0));
            const int blocksWide = (part.rect.width + 3) / 4, blocksHigh = (part.rect.height + 3) / 4;
            CHECK(part.left + 4 * blocksWide <= tileSize);
            CHECK(part.top + 4 * blocksHigh <= tileSize);
            for (int i = 0; i < blocksWide * blocksHigh; ++i)
                CHECK(blocks.emplace(part.left / 4 + i % blocksWide, part.top / 4 + i / blocksWide).second);
            // A rectangle that ends inside its mip has whole blocks.
            const bool endsX = part.rect.left + part.rect.width == std::max(set.width >> part.mip, 1);
            const bool endsY = part.rect.top + part.rect.height == std::max(set.height >> part.mip, 1);
            CHECK((endsX || part.rect.width % 4 == 0));
            CHECK((endsY || part.rect.height % 4 == 0));
            for (int y = 0; y < part.rect.height; ++y) {
                for (int x = 0; x < part.rect.width; ++x, ++count)
                    texels.insert({part.mip, part.rect.left + x, part.rect.top + y});
            }
        }
    }
    int expected = 0;
    for (int mip = 0; mip < set.mips; ++mip)
        expected += std::max(set.width >> mip, 1) * std::max(set.height >> mip, 1);
    CHECK(count == expected);
    CHECK(texels.size() == static_cast<std::size_t>(expected));
}

} // namespace

TEST_CASE("feedback tiles: parts cover every texel once, in whole blocks") {
    CheckParts({64, 64, 8, 7}, 16);
    CheckParts({100, 37, 8, 7}, 32);
    CheckParts({37, 100, 8, 7}, 16);
    CheckParts({16, 1, 4, 5}, 16);
    CheckParts({1, 1, 4, 1}, 64);
    CheckParts({64, 32, 8, 1}, 16); // no tail
    CHECK(CountPinnedTiles(*MakeFeedbackLayout({64, 32, 8, 1}, 16)) == 8);
    CHECK(CountPinnedTiles(*MakeFeedbackLayout({64, 32, 8, 7}, 16)) == 1);
}

TEST_CASE("feedback tiles: a budget is shared, never exceeded, and refused below the coarsest tiles") {
    const PoolDemand pools[] = {{1000, 1, 11}, {300, 2, 102}, {7, 3, 3}};
    CHECK(ShareBudget(pools, 0) == std::vector<std::uint32_t>{11, 102, 3});
    CHECK(ShareBudget(pools, 1u << 30) == std::vector<std::uint32_t>{11, 102, 3});
    for (const std::uint64_t bytes : {1621u, 5000u, 20000u, 41621u}) {
        const std::vector<std::uint32_t> layers = ShareBudget(pools, bytes);
        std::uint64_t used = 0;
        for (std::size_t i = 0; i < layers.size(); ++i) {
            CHECK(layers[i] >= pools[i].fewest);
            CHECK(layers[i] <= pools[i].most);
            used += layers[i] * pools[i].layerBytes;
        }
        CHECK(used <= bytes);
        CHECK(used + 1000 + 300 > std::min<std::uint64_t>(bytes, 41621)); // less than a layer of each is left
    }
    CHECK_THROWS_AS(ShareBudget(pools, 1620), tool::CommandError);
}

TEST_CASE("on-feedback ends with the bits of on-load: blocks, texels, one tap in fragment shaders") {
    OPENNTC_REQUIRE_DEVICE(context);
    const auto check = [&](RenderOptions options, std::uint32_t samples) {
        options.mode = Mode::OnLoad;
        const FeedbackResult loaded = RenderSamples(*context, options, samples);
        options.mode = Mode::OnFeedback;
        const FeedbackResult streamed = RenderSamples(*context, options, samples);
        CHECK(streamed.picture == loaded.picture);
        const FeedbackStatistics& tiles = streamed.statistics;
        CHECK(tiles.isComplete);
        CHECK(tiles.waiting == 0);
        CHECK(tiles.wanted <= tiles.resident);
        // Only a part is decoded. A mask that gets finer shows other pixels once; then nothing else is asked for.
        CHECK(tiles.resident < tiles.tiles);
        const auto perFrame = static_cast<std::uint64_t>(options.tilesPerFrame);
        CHECK(tiles.passesUntilSettled <= (tiles.wanted + perFrame - 1) / perFrame + 2);
        CHECK(*std::max_element(tiles.decodedPerPass.begin(), tiles.decodedPerPass.end()) <= perFrame);
        CHECK(std::accumulate(tiles.decodedPerPass.begin(), tiles.decodedPerPass.end(), std::uint64_t{0}) ==
              tiles.decoded);
        CHECK(streamed.memory.atlases < loaded.textureBytes);
    };
    RenderOptions blocks = MakeFeedbackOptions();
    blocks.keepsTexels = false;
    blocks.filter = TextureFilter::Trilinear;
    blocks.tilesPerFrame = 7;
    check(blocks, 3);
    RenderOptions oneTap = MakeFeedbackOptions();
    oneTap.stochastic = Stochastic::OneTap;
    oneTap.path = ShadingPath::Fragment;
    check(oneTap, 2);
}

TEST_CASE("on-feedback: frames that do not wait show the coarsest mips, then finer ones") {
    OPENNTC_REQUIRE_DEVICE(context);
    RenderOptions options = MakeFeedbackOptions();
    options.width = 120;
    options.height = 80;
    const Picture whole = RenderSamples(*context, options, 1).picture;
    options.settle = 0;
    options.tilesPerFrame = 1;
    const FeedbackResult first = RenderSamples(*context, options, 1);
    CHECK(first.statistics.passes == 1);
    CHECK_FALSE(first.statistics.isComplete);
    // The picture of the same textures by their coarsest mips: the colours of the place, not garbage. Black or white
    // texels in the place of the textures would be farther from the picture than its own blur.
    const double blurred = GetMeanDifference(first.picture, whole);
    MESSAGE("the coarsest tiles differ by ", blurred, " steps of 255 on average");
    CHECK(first.picture != whole);
    CHECK(blurred < GetMeanDifference(Picture(whole.size(), 128), whole));
    CHECK(RenderSamples(*context, options, 1).picture == first.picture);
}

TEST_CASE("on-feedback: less memory makes coarser pictures, the same ones from run to run") {
    OPENNTC_REQUIRE_DEVICE(context);
    RenderOptions options = MakeFeedbackOptions();
    options.width = 120;
    options.height = 80;
    const FeedbackResult whole = RenderSamples(*context, options, 1);
    options.budgetMiB = 0.5 * static_cast<double>(whole.memory.atlases) / 1048576.0;
    const FeedbackResult half = RenderSamples(*context, options, 1);
    CHECK(half.memory.atlases * 2 <= whole.memory.atlases);
    CHECK_FALSE(half.statistics.isComplete);
    CHECK(half.statistics.waiting > 0);
    CHECK(half.statistics.passesUntilSettled > 0);
    CHECK(RenderSamples(*context, options, 1).picture == half.picture);
    options.settle = 0;
    const FeedbackResult coarsest = RenderSamples(*context, options, 1);
    const double error = GetMeanDifference(half.picture, whole.picture);
    CHECK(error > 0.0);
    CHECK(error < GetMeanDifference(coarsest.picture, whole.picture));
    options.budgetMiB = 1e-6;
    CHECK_THROWS_AS(RenderSamples(*context, options, 1), tool::CommandError);
}
