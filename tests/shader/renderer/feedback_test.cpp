// SPDX-License-Identifier: MIT
// Textures that are decoded on demand: how they are cut, that pictures end as those of on-load, that short memory and short
// time coarsen them and nothing else.
#include "shader/renderer/Rendering.h"

#include "renderer/gpu/FeedbackTiles.h"
#include "renderer/scene/SampleScene.h"

#include <doctest/doctest.h>
#include <glm/gtc/matrix_transform.hpp>

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
FeedbackResult RenderSamples(harness::Context& context, const RenderOptions& options, std::uint32_t samples,
                             Scene scene = MakeSampleScene()) {
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
    // As a window goes on: a tile a frame, until a frame finds everything.
    Scene scene = MakeSampleScene();
    Renderer renderer(*context, GetShaders(), scene, options);
    std::uint64_t frames = 0;
    do {
        renderer.Render(scene.cameras.front(), 0, false);
        ++frames;
    } while (!renderer.IsSettled() && frames < 1000);
    const FeedbackStatistics tiles = renderer.GetTextures().GetFeedback()->GetStatistics();
    CHECK(frames == tiles.decoded + 1);
    CHECK(tiles.isComplete);
    CHECK(renderer.ReadPicture() == whole);
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

namespace {

/// The sample scene's first opaque instance alone.
struct HiddenScene {
    Scene scene = MakeSampleScene();
    int front = -1; ///< material
    int other = -1; ///< material of another set

    HiddenScene() {
        for (std::size_t i = 0; i < scene.materials.size(); ++i) {
            const bool isOpaque = scene.materials[i].alphaMode == AlphaMode::Opaque;
            (isOpaque ? front : other) = static_cast<int>(i);
        }
        const auto first =
            std::find_if(scene.instances.begin(), scene.instances.end(), [&](const Instance& one) {
                return scene.primitives[static_cast<std::size_t>(one.primitive)].material == front;
            });
        scene.instances = {*first};
    }

    /// The same with another material, twice as far from the eye, drawn before.
    void AddBehind(int material) {
        Instance behind = scene.instances.back();
        Primitive primitive = scene.primitives[static_cast<std::size_t>(behind.primitive)];
        primitive.material = material;
        behind.primitive = static_cast<int>(scene.primitives.size());
        scene.primitives.push_back(primitive);
        const glm::vec3 eye(scene.cameras.front().toWorld[3]);
        behind.toWorld = glm::translate(glm::mat4(1.0f), eye) * glm::scale(glm::mat4(1.0f), glm::vec3(2.0f)) *
                         glm::translate(glm::mat4(1.0f), -eye) * behind.toWorld;
        scene.instances.insert(scene.instances.begin(), behind);
    }
};

} // namespace

TEST_CASE("on-feedback: what is hidden asks for no tiles, in compute and in fragment shaders") {
    OPENNTC_REQUIRE_DEVICE(context);
    HiddenScene plain;
    REQUIRE((plain.front >= 0 && plain.other >= 0));
    plain.scene.materials[static_cast<std::size_t>(plain.other)].alphaMode = AlphaMode::Opaque;
    HiddenScene hidden = plain;
    hidden.AddBehind(plain.other);
    HiddenScene shown = plain; // alone, it asks
    shown.scene.primitives[static_cast<std::size_t>(shown.scene.instances[0].primitive)].material =
        plain.other;
    RenderOptions options = MakeFeedbackOptions();
    for (const ShadingPath path : {ShadingPath::Compute, ShadingPath::Fragment}) {
        options.path = path;
        const FeedbackResult without = RenderSamples(*context, options, 1, plain.scene);
        const FeedbackResult with = RenderSamples(*context, options, 1, hidden.scene);
        CHECK(with.picture == without.picture);
        CHECK(without.statistics.wanted > 1);
        CHECK(with.statistics.wanted == without.statistics.wanted + 1); // the coarsest tile of the other set
        CHECK(RenderSamples(*context, options, 1, shown.scene).statistics.wanted > 1);
    }
}

TEST_CASE("on-feedback: materials with one texture set share its tiles") {
    OPENNTC_REQUIRE_DEVICE(context);
    HiddenScene one;
    HiddenScene two = one;
    two.scene.materials.push_back(two.scene.materials[static_cast<std::size_t>(two.front)]);
    two.AddBehind(static_cast<int>(two.scene.materials.size()) - 1);
    std::swap(two.scene.instances[0].toWorld, two.scene.instances[1].toWorld); // the copy is what is seen
    const RenderOptions options = MakeFeedbackOptions();
    const FeedbackResult first = RenderSamples(*context, options, 1, one.scene);
    const FeedbackResult second = RenderSamples(*context, options, 1, two.scene);
    CHECK(second.picture == first.picture);
    CHECK(second.statistics.tiles == first.statistics.tiles);
    CHECK(second.statistics.wanted == first.statistics.wanted);
    CHECK(second.memory.atlases == first.memory.atlases);
}

TEST_CASE("on-feedback: tiles of one view make room for those of another, and come back") {
    OPENNTC_REQUIRE_DEVICE(context);
    // Two places of one texture, each on an instance of its own, far apart; one set, and so one pool.
    HiddenScene scene;
    const auto front = static_cast<std::size_t>(scene.front);
    scene.scene.materials.push_back(scene.scene.materials[front]);
    const std::size_t last = scene.scene.materials.size() - 1;
    scene.AddBehind(static_cast<int>(last));
    const glm::mat4 aside = glm::translate(glm::mat4(1.0f), glm::vec3(1000.0f, 0.0f, 0.0f));
    scene.scene.instances[0].toWorld = aside * scene.scene.instances[1].toWorld;
    for (const std::size_t material : {front, last}) {
        for (MaterialTexture& texture : scene.scene.materials[material].textures) {
            const float offset = material == front ? 0.1f : 0.6f;
            texture.address.transform.row0 = glm::vec3(0.02f, 0.0f, offset);
            texture.address.transform.row1 = glm::vec3(0.0f, 0.02f, offset);
        }
    }
    const Camera near = scene.scene.cameras.front();
    Camera far = near;
    far.toWorld = aside * near.toWorld;
    RenderOptions options = MakeFeedbackOptions();
    options.width = 120;
    options.height = 80;
    std::vector<Picture> wanted;
    std::vector<std::uint64_t> bytes;
    for (const Camera& camera : {near, far}) {
        scene.scene.cameras.front() = camera;
        const FeedbackResult result = RenderSamples(*context, options, 1, scene.scene);
        wanted.push_back(result.picture);
        bytes.push_back(result.memory.atlases);
    }
    REQUIRE(wanted[0] != wanted[1]);
    options.budgetMiB = static_cast<double>(std::max(bytes[0], bytes[1])) / 1048576.0;
    Renderer renderer(*context, GetShaders(), scene.scene, options);
    for (const int view : {0, 1, 0, 1}) {
        renderer.Render(view == 0 ? near : far, 0, false);
        CHECK(renderer.ReadPicture() == wanted[static_cast<std::size_t>(view)]);
        CHECK(renderer.GetTextures().GetFeedback()->GetStatistics().isComplete);
    }
    const FeedbackStatistics tiles = renderer.GetTextures().GetFeedback()->GetStatistics();
    MESSAGE(tiles.evicted, " tiles made room, ", tiles.decoded, " were decoded, ", tiles.thrashed,
            " again soon");
    CHECK(tiles.evicted > 0);
    CHECK(renderer.GetTextures().GetMemory().feedback.atlases == std::max(bytes[0], bytes[1]));
}
