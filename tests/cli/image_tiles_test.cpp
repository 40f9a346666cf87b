// SPDX-License-Identifier: MIT
// Images of files as tiles: through the demand loader and the shaders' filter, with every wrap mode, against
// the numbers that were written; and what a bad file is answered with.
#include "cli/ImageFiles.h"
#include "cli/Program.h"
#include "unit/streaming/DemandTestKit.h"

#include "Failure.h"
#include "ImageTiles.h"

#include "openntc/image/ColorEncoding.h"
#include "openntc/streaming/Demand.h"

#include <doctest/doctest.h>

#include <array>
#include <cmath>

using namespace openntc;
using namespace openntc_tests;
namespace shader = openntc::shader;

namespace {

constexpr int kWide = 37, kHigh = 21, kTile = 8;

/// Whole 255ths and, divided by 256, halves; alpha is at least a third.
float GetLevel(int x, int y, int c) {
    const int level = (x * 7 + y * 13 + c * 50) % 256;
    return static_cast<float>(c == 3 ? 85 + level % 171 : level);
}

TestImage MakeTiled(int channels, float divisor) {
    TestImage image{kWide, kHigh, channels, {}};
    for (int y = 0; y < kHigh; ++y)
        for (int x = 0; x < kWide; ++x)
            for (int c = 0; c < channels; ++c)
                image.samples.push_back(GetLevel(x, y, channels == 2 && c == 1 ? 3 : c) / divisor);
    return image;
}

int AddressByHand(int texel, int size, TileWrap wrap) {
    if (wrap == TileWrap::Clamp)
        return std::min(std::max(texel, 0), size - 1);
    const int period = wrap == TileWrap::Mirror ? 2 * size : size;
    const int inside = ((texel % period) + period) % period;
    return inside < size ? inside : period - 1 - inside;
}

/// The loader, with everything loaded that was asked for.
class TiledImage {
public:
    TiledImage(const Shared<tool::ImageTileSource>& source, TileFilter filter, TileWrap wrap)
        : options_(MakeSizedOptions(*source)), loader_(demand_test::MakeLoader(options_)), device_(options_) {
        TiledTextureDesc desc;
        desc.format = source->GetFormat();
        desc.filter = filter;
        desc.wrapU = desc.wrapV = wrap;
        desc.hasFeedback = false;
        const auto made = loader_.CreateTexture(source, desc);
        REQUIRE_MESSAGE(made.has_value(), std::string(made.error().GetText()));
        id_ = made->index;
    }
    /// A sample at a texel centre of a mip, in texels of that mip from the upper left corner on.
    std::array<float, 4> Sample(float x, float y, int mip) {
        const float width = static_cast<float>(std::max(kWide >> mip, 1));
        const float height = static_cast<float>(std::max(kHigh >> mip, 1));
        // The gradient of mip 0's texels that makes this mip.
        const float step = std::ldexp(1.0f, mip) / static_cast<float>(kWide);
        for (int round = 0; round < 20; ++round) {
            const demand_test::Launch launch = device_.Prepare(loader_);
            std::vector<std::uint32_t> table = launch.table;
            shader::NtcStreamingMemory memory;
            memory.pageTable = {table.data(), table.size()};
            memory.launchState = {device_.GetState().data(), device_.GetState().size()};
            const shader::NtcStreamingWords pool{device_.GetSlots().data(), device_.GetSlots().size()};
            memory.pools = &pool;
            memory.poolCount = 1;
            const auto context = shader::NtcMakeStreamingContext(launch.constants, 1u, memory);
            bool resident = false;
            const shader::float4 color =
                shader::NtcDemandGrad(context, id_, shader::float2(x / width, y / height),
                                      shader::float2(step, 0.0f), shader::float2(0.0f, 0.0f), resident);
            device_.Process(loader_, launch);
            if (resident)
                return {color.x, color.y, color.z, color.w};
        }
        FAIL("did not become resident");
        return {};
    }

private:
    static DemandLoaderOptions MakeSizedOptions(const TileSource& source) {
        DemandLoaderOptions options = demand_test::MakeOptions(128);
        options.slotBytes = static_cast<std::uint32_t>((source.GetLargestTileBytes() + 15) / 16 * 16);
        return options;
    }

    DemandLoaderOptions options_;
    DemandLoader loader_;
    demand_test::Device device_;
    std::uint32_t id_ = 0;
};

void CheckTexels(const Shared<tool::ImageTileSource>& source, int channels,
                 const std::function<float(float, int)>& decode) {
    for (const TileWrap wrap : {TileWrap::Repeat, TileWrap::Clamp, TileWrap::Mirror}) {
        TiledImage image(source, TileFilter::Point, wrap);
        for (const auto& place :
             {std::pair{0, 0}, {36, 20}, {8, 7}, {15, 16}, {-1, -1}, {37, 21}, {-40, 25}, {80, -30}}) {
            const int x = place.first, y = place.second;
            CAPTURE(x);
            CAPTURE(y);
            const auto color = image.Sample(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f, 0);
            const int px = AddressByHand(x, kWide, wrap), py = AddressByHand(y, kHigh, wrap);
            for (int c = 0; c < 4; ++c) {
                CAPTURE(c);
                const bool hasAlpha = channels % 2 == 0, isGray = channels < 3;
                const bool isAbsent =
                    c == 3 ? !hasAlpha : channels == 1 && c > 0 && GetTexelBytes(source->GetFormat()) < 4;
                const float expected = c == 3 && !hasAlpha ? 1.0f
                                       : isAbsent          ? 0.0f
                                                  : decode(GetLevel(px, py, isGray && c < 3 ? 0 : c), c);
                CHECK(std::fabs(color[static_cast<std::size_t>(c)] - expected) <= 1e-6f);
            }
        }
    }
}

} // namespace

TEST_CASE("image tiles: a PNG's texels through every wrap mode") {
    const Folder folder;
    const auto linear = [](float level, int) { return level / 255.0f; };
    const auto srgb = [](float level, int c) {
        return c == 3 ? level / 255.0f : image::DecodeColor(ColorSpace::sRGB, level / 255.0f);
    };
    for (const int channels : {1, 2, 3, 4}) {
        CAPTURE(channels);
        const std::string path = (folder / "image.png").string();
        WriteImage(path, MakeTiled(channels, 255));
        const auto stored = tool::ImageTileSource::Open(path, kTile, kTile, false);
        CHECK(stored->GetFormat() == (channels == 1 ? TileFormat::R8 : TileFormat::RGBA8));
        CheckTexels(stored, channels, linear);
        const auto colors = tool::ImageTileSource::Open(path, kTile, kTile, true);
        CHECK(colors->GetFormat() == TileFormat::RGBA8Srgb);
        CheckTexels(colors, channels, srgb);
    }
    const std::string path = (folder / "deep.png").string();
    WriteImage(path, MakeTiled(3, 255), 16);
    const auto deep = tool::ImageTileSource::Open(path, kTile, 5, true);
    CHECK(deep->GetFormat() == TileFormat::RGBA32F);
    CheckTexels(deep, 3, srgb);
}

TEST_CASE("image tiles: an OpenEXR image, halves where they are enough") {
#if defined(OPENNTC_TOOL_HAS_EXR)
    const Folder folder;
    const std::string path = (folder / "image.exr").string();
    WriteImage(path, MakeTiled(4, 16));                                        // up to 16, in halves
    const auto halves = tool::ImageTileSource::Open(path, kTile, kTile, true); // floats are never sRGB
    CHECK(halves->GetFormat() == TileFormat::RGBA16F);
    CheckTexels(halves, 4, [](float level, int) { return level / 16; });
    TestImage image = MakeTiled(4, 16);
    image.samples[5] = 0.1f; // no half
    WriteImage(path, image);
    CHECK(tool::ImageTileSource::Open(path, kTile, kTile, true)->GetFormat() == TileFormat::RGBA32F);
#else
    MESSAGE("SKIP: image tiles: OpenEXR: built without tinyexr");
#endif
}

TEST_CASE("image tiles: mips are averages in linear light, weighed by alpha; filters blend them") {
    const Folder folder;
    // 2 x 2 blocks of white and black, opaque and clear: mip 1 has one colour.
    TestImage image{kWide, kHigh, 4, {}};
    for (int y = 0; y < kHigh; ++y)
        for (int x = 0; x < kWide; ++x) {
            const float white = (x + y) % 2 == 0 ? 1.0f : 0.0f;
            image.samples.insert(image.samples.end(), {white, white, 1.0f, y % 2 == 0 ? 1.0f : 0.0f});
        }
    const std::string path = (folder / "blocks.png").string();
    WriteImage(path, image);
    const auto source = tool::ImageTileSource::Open(path, kTile, kTile, true);
    TiledImage points(source, TileFilter::Point, TileWrap::Clamp);
    // Two opaque texels of a block, one white and one black: half of the light, in a 255th of its sRGB code;
    // at odd sizes texels overlap three, so it lies between a third and two thirds.
    const auto mip = points.Sample(9.5f, 5.5f, 1);
    CHECK(mip[0] > 1.0f / 3 - 0.01f);
    CHECK(mip[0] < 2.0f / 3 + 0.01f);
    CHECK(mip[0] == mip[1]);
    CHECK(mip[2] == 1.0f);
    CHECK(mip[3] > 0.3f);
    CHECK(mip[3] < 0.7f);
    // Between the centres of two texels of mip 0 a bilinear sample is their mean, in linear light.
    TiledImage bilinear(source, TileFilter::Bilinear, TileWrap::Repeat);
    // Fractions have 16 bits, so that a coordinate rounded down moves 2^-16 of the weight.
    const auto between = bilinear.Sample(8.0f, 4.5f, 0);
    CHECK(std::fabs(between[0] - 0.5f) <= 1e-4f);
    CHECK(std::fabs(between[3] - 1.0f) <= 2e-5f);
    // Over the edge, columns 36 and 0: both are white in even rows.
    CHECK(std::fabs(bilinear.Sample(0.0f, 4.5f, 0)[0] - 1.0f) <= 2e-5f);
}

TEST_CASE("bench loader: PNG and OpenEXR images; a bad one is refused once") {
    const Folder folder;
    WriteImage(folder / "color.png", MakeTiled(3, 255));
    const ProgramResult result =
        RunProgram(folder, "bench loader color.png --tile 8 --threads 0,2 --repeat 2 --limit 5 --json");
    CAPTURE(result.errors);
    REQUIRE(result.code == 0);
    const auto json = ParseValid(result.output, "bench-loader");
    CHECK(std::string(json["format"].GetString()) == "RGBA8Srgb");
    REQUIRE(json["results"].Size() == 2);
    CHECK(std::string(json["results"][1]["source"].GetString()) == "memory");
    CHECK(json["tiles"].GetInt() > 5 * 3); // mip 0 alone
#if defined(OPENNTC_TOOL_HAS_EXR)
    WriteImage(folder / "light.exr", MakeTiled(4, 16));
    const ProgramResult exr =
        RunProgram(folder, "bench loader light.exr --tile 8 --textures 3 --threads 1 --repeat 1");
    CHECK(exr.code == 0);
    CHECK(exr.output.find("3 textures (RGBA16F)") != std::string::npos);
    WriteText(folder / "cut.exr", ReadText(folder / "light.exr").substr(0, 100));
    CheckFails(RunProgram(folder, "bench loader cut.exr"), 3);
#endif
    WriteText(folder / "cut.png", ReadText(folder / "color.png").substr(0, 200));
    const ProgramResult cut = RunProgram(folder, "bench loader cut.png");
    CheckFails(cut, 3);
    CHECK(cut.errors.starts_with("ntc: cut.png: "));
}
