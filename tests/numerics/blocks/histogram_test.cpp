// SPDX-License-Identifier: MIT
// What the list of modes and partitions that generation 1 stores for each texture is worth for BC7, beside a map of every
// block: every 16th block of FlightHelmet's textures, by modes that the list allows and by its most frequent choices.
#include "openntc/bc/BlockDecoder.h"
#include "openntc/bc/BlockEncoder.h"
#include "openntc/bc/BlockHints.h"

#include "encode/PngReader.h"
#include "support/Files.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace {

using namespace openntc;
using namespace openntc::bc;

/// Blocks side by side, four rows of RGBA with alpha 255.
struct BlockStrip {
    std::uint32_t blocks = 0;
    std::vector<std::uint8_t> texels;
};

BlockStrip LoadStrip(const std::filesystem::path& file, std::size_t step) {
    const tool::PngImage image =
        tool::ReadPng(openntc_tests::ReadBytes(file), file.filename().string(), 4096);
    std::vector<std::pair<int, int>> corners;
    std::size_t number = 0;
    for (int y = 0; y + 3 < image.height; y += 4)
        for (int x = 0; x + 3 < image.width; x += 4)
            if ((number++ * 2654435761U >> 8) % step == 0)
                corners.emplace_back(x, y);
    BlockStrip strip;
    strip.blocks = static_cast<std::uint32_t>(corners.size());
    for (int row = 0; row < 4; ++row)
        for (const auto& [x, y] : corners)
            for (int t = 0; t < 4; ++t) {
                const auto at = static_cast<std::size_t>(((y + row) * image.width + x + t) * image.channels);
                for (std::size_t c = 0; c < 3; ++c)
                    strip.texels.push_back(static_cast<std::uint8_t>(image.samples[at + c]));
                strip.texels.push_back(255);
            }
    return strip;
}

/// One way to make blocks of all textures.
struct ModeTrial {
    double seconds = 0.0; // of the processor
    double squares = 0.0;

    /// Of R, G and B.
    double GetPsnr(double texels) const { return 10.0 * std::log10(255.0 * 255.0 * 3.0 * texels / squares); }
};

std::vector<std::byte> EncodeStrip(const BlockStrip& strip, const BlockOptions& options, ModeTrial& trial) {
    std::vector<std::byte> blocks(std::size_t{16} * strip.blocks);
    const BlockImage image{
        std::as_bytes(std::span(strip.texels)), 4 * strip.blocks, 4, 0, 4, TexelType::Unsigned8};
    const std::clock_t start = std::clock();
    REQUIRE(EncodeBlocks(BlockFormat::Bc7, image, {0, 0, strip.blocks, 1}, options, blocks).has_value());
    trial.seconds += static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    return blocks;
}

std::vector<double> GetBlockSquares(const BlockStrip& strip, const std::vector<std::byte>& blocks) {
    std::vector<double> squares;
    for (std::size_t b = 0; b < strip.blocks; ++b) {
        std::uint8_t texels[64];
        DecodeBlockBytes(BlockFormat::Bc7, blocks.data() + 16 * b, texels);
        int sum = 0;
        for (std::size_t t = 0; t < 16; ++t)
            for (std::size_t c = 0; c < 3; ++c) {
                const std::size_t at = 4 * (t / 4 * 4 * strip.blocks + 4 * b + t % 4) + c;
                const int difference = strip.texels[at] - texels[4 * t + c];
                sum += difference * difference;
            }
        squares.push_back(sum);
    }
    return squares;
}

double Sum(const std::vector<double>& values) {
    double sum = 0.0;
    for (const double value : values)
        sum += value;
    return sum;
}

} // namespace

TEST_CASE("BC7: what a texture's list of modes gives, and what a map of its blocks") {
    const std::filesystem::path folder =
        openntc_tests::GetConformanceFolder().parent_path() / "assets" / "FlightHelmet";
    std::vector<std::filesystem::path> files;
    std::error_code error;
    for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end;
         entry.increment(error))
        if (entry->path().extension() == ".png")
            files.push_back(entry->path());
    if (files.empty()) {
        MESSAGE("SKIP: FlightHelmet's textures are not there");
        return;
    }
    std::sort(files.begin(), files.end());
    constexpr std::size_t kCounts[] = {1, 4, 16};
    ModeTrial best, normal, allowed, hinted, byCount[3];
    double texels = 0.0, choices = 0.0;
    for (const std::filesystem::path& file : files) {
        const BlockStrip strip = LoadStrip(file, 16);
        texels += 16.0 * strip.blocks;
        BlockOptions options;
        options.threads = 1;
        options.quality = BlockQuality::Best;
        const std::vector<std::byte> found = EncodeStrip(strip, options, best);
        best.squares += Sum(GetBlockSquares(strip, found));
        std::vector<std::int32_t> hints;
        std::map<std::int32_t, std::size_t> histogram;
        std::size_t ofMode[8] = {};
        for (std::size_t b = 0; b < strip.blocks; ++b) {
            hints.push_back(GetBlockHint(&found[16 * b]));
            ++histogram[hints.back()];
            ++ofMode[hints.back() & 7];
        }
        choices += static_cast<double>(histogram.size());

        options.quality = BlockQuality::Normal;
        const auto encode = [&](ModeTrial& trial) {
            std::vector<double> squares = GetBlockSquares(strip, EncodeStrip(strip, options, trial));
            return squares;
        };
        normal.squares += Sum(encode(normal));
        options.allowedModes = 0;
        for (unsigned mode = 0; mode < 8; ++mode)
            if (ofMode[mode] * 20 >= strip.blocks)
                options.allowedModes |= 1U << mode;
        allowed.squares += Sum(encode(allowed));
        options.allowedModes = 0xFF;
        options.hints = hints;
        hinted.squares += Sum(encode(hinted));

        // The most frequent choices, each for all blocks; of every block the best one counts.
        std::vector<std::pair<std::size_t, std::int32_t>> frequent;
        for (const auto& [hint, count] : histogram)
            frequent.emplace_back(count, hint);
        std::sort(frequent.rbegin(), frequent.rend());
        std::vector<double> least(strip.blocks, 1e9);
        double seconds = 0.0;
        for (std::size_t i = 0, k = 0; k < 3; ++i) {
            if (i < frequent.size()) {
                const std::vector<std::int32_t> one(strip.blocks, frequent[i].second);
                options.hints = one;
                ModeTrial trial;
                const std::vector<double> squares = encode(trial);
                seconds += trial.seconds;
                for (std::size_t b = 0; b < squares.size(); ++b)
                    least[b] = std::min(least[b], squares[b]);
            }
            if (i + 1 == kCounts[k]) {
                byCount[k].seconds += seconds;
                byCount[k++].squares += Sum(least);
            }
        }
    }
    const auto print = [&](const char* name, const ModeTrial& trial) {
        std::printf("BC7, %-52s %.2f dB @ %.2f Mpixel/s\n", name, trial.GetPsnr(texels),
                    texels / std::max(trial.seconds, 1e-9) / 1e6);
    };
    print("best, searching", best);
    print("normal, searching", normal);
    print("normal, searching in modes of 5 % of blocks and more", allowed);
    print("normal, the most frequent choice of the texture", byCount[0]);
    print("normal, the 4 most frequent ones, all tried", byCount[1]);
    print("normal, the 16 most frequent ones, all tried", byCount[2]);
    print("normal, with the map of its blocks", hinted);
    std::printf("BC7, choices that a texture's list has: %.0f\n",
                choices / static_cast<double>(files.size()));
    CHECK(best.squares <= normal.squares);
    CHECK(normal.squares <= allowed.squares);
    CHECK(byCount[1].squares < byCount[0].squares);
    CHECK(byCount[2].squares < byCount[1].squares);
    // Each block's own choice is one that 16 for all of them may lack.
    CHECK(hinted.squares < byCount[2].squares);
    CHECK(hinted.squares < allowed.squares);
}
