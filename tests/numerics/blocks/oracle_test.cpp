// SPDX-License-Identifier: MIT
// BC1 and BC4 at their best level against the exact optimum, on a sample of the blocks of FlightHelmet's textures: BC4 by
// exhaustion on every 16th, BC1 by branch and bound on every 60th. OPENNTC_BC_ORACLE=all takes all of them (an hour).
#include "openntc/bc/BlockDecoder.h"
#include "openntc/bc/BlockEncoder.h"

#include "encode/PngReader.h"
#include "support/Files.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace {

using namespace openntc;
using namespace openntc::bc;

using OracleBlock = std::array<std::uint8_t, 64>; ///< RGBA

/// Every step-th block of the textures, RGBA with alpha 255; for BC4 green of colours and ORM, red of normals, in red.
std::vector<OracleBlock> LoadOracleBlocks(std::size_t step, bool isForBc4) {
    std::vector<OracleBlock> blocks;
    const char* all = std::getenv("OPENNTC_BC_ORACLE");
    if (all != nullptr && std::string(all) == "all")
        step = 1;
    const std::filesystem::path folder =
        openntc_tests::GetConformanceFolder().parent_path() / "assets" / "FlightHelmet";
    std::error_code error;
    std::vector<std::filesystem::path> files;
    for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end;
         entry.increment(error)) {
        if (entry->path().extension() == ".png")
            files.push_back(entry->path());
    }
    std::sort(files.begin(), files.end());
    std::size_t number = 0;
    for (const std::filesystem::path& file : files) {
        const std::string name = file.filename().string();
        if (isForBc4 && name.find("LensesMat_BaseColor") != std::string::npos)
            continue;
        const tool::PngImage image = tool::ReadPng(openntc_tests::ReadBytes(file), name, 4096);
        REQUIRE(image.bits == 8);
        REQUIRE(image.channels >= 3);
        for (int y = 0; y + 3 < image.height; y += 4) {
            for (int x = 0; x + 3 < image.width; x += 4) {
                // Scattered, so that no column of an image is taken more often.
                if ((number++ * 2654435761U >> 8) % step != 0)
                    continue;
                OracleBlock block{};
                for (int t = 0; t < 16; ++t) {
                    const auto at =
                        static_cast<std::size_t>(((y + t / 4) * image.width + x + t % 4) * image.channels);
                    for (std::size_t c = 0; c < 3; ++c)
                        block[static_cast<std::size_t>(4 * t) + c] = image.samples[at + c];
                    if (isForBc4 && name.find("Normal") == std::string::npos)
                        block[static_cast<std::size_t>(4 * t)] = image.samples[at + 1];
                    block[static_cast<std::size_t>(4 * t) + 3] = 255;
                }
                blocks.push_back(block);
            }
        }
    }
    return blocks;
}

std::vector<std::int64_t> GetBestErrors(BlockFormat format, std::span<const OracleBlock> blocks,
                                        std::size_t channels) {
    std::vector<std::int64_t> errors;
    for (const OracleBlock& texels : blocks) {
        BlockOptions options;
        options.quality = BlockQuality::Best;
        options.threads = 1;
        std::byte block[16] = {};
        const BlockImage image{std::as_bytes(std::span(texels)), 4, 4, 0, 4, TexelType::Unsigned8};
        REQUIRE(EncodeBlocks(format, image, {0, 0, 1, 1}, options, block).has_value());
        std::int32_t exact[64];
        DecodeBlockExact(format, block, exact);
        std::int64_t error = 0;
        for (std::size_t i = 0; i < 64; ++i) {
            const std::int64_t difference = exact[i] - std::int64_t{210} * texels[i];
            error += i % 4 < channels ? difference * difference : 0;
        }
        errors.push_back(error);
    }
    return errors;
}

/// The least error of red over all pairs of endpoints, in the units of DecodeBlockExact; at most `known`.
std::int64_t FindOptimum4(const OracleBlock& block, std::int64_t known) {
    int x[16];
    for (std::size_t t = 0; t < 16; ++t)
        x[t] = block[4 * t];
    for (int a = 0; a < 256; ++a) {
        for (int b = 0; b <= a; ++b) {
            for (const int parts : {7, 5}) {
                if (parts == 7 && a == b)
                    continue;
                const std::int64_t unit = 210 / parts;
                const int range = a - b;
                std::int64_t error = 0;
                for (int t = 0; t < 16 && error < known; ++t) {
                    const int along = std::clamp((x[t] - b) * parts, 0, range * parts);
                    const int level = range == 0 ? 0 : (2 * along + range) / (2 * range);
                    int rest = std::abs((x[t] - b) * parts - level * range);
                    if (parts == 5)
                        rest = std::min({rest, 5 * x[t], 5 * (255 - x[t])});
                    error += rest * rest * unit * unit;
                }
                known = std::min(known, error);
            }
        }
    }
    return known;
}

/// One channel's pairs of endpoints: errors by texel and index, and what all texels cost at least.
struct ChannelPairs {
    struct Pair {
        std::array<std::array<std::int32_t, 4>, 16> errors;
        std::int32_t least;
    };
    std::vector<Pair> pairs; ///< the cheapest first

    ChannelPairs(const OracleBlock& block, std::size_t channel, int steps, bool isOrdered,
                 std::int64_t limit) {
        const bool isGreen = channel == 1;
        const int count = isGreen ? 64 : 32;
        const auto widen = [&](int v) { return isGreen ? v << 2 | v >> 4 : v << 3 | v >> 2; };
        for (int a = 0; a < count; ++a) {
            for (int b = isOrdered ? a : 0; b < count; ++b) {
                Pair pair{};
                for (std::size_t t = 0; t < 16; ++t) {
                    std::int32_t least = 0x7FFFFFFF;
                    for (int k = 0; k < 4; ++k) {
                        const int level = std::min(k, steps);
                        const int rest =
                            (steps - level) * widen(a) + level * widen(b) - steps * block[4 * t + channel];
                        pair.errors[t][static_cast<std::size_t>(k)] = rest * rest;
                        least = std::min(least, rest * rest);
                    }
                    pair.least += least;
                }
                if (pair.least < limit)
                    pairs.push_back(pair);
            }
        }
        std::sort(pairs.begin(), pairs.end(), [](const Pair& p, const Pair& q) { return p.least < q.least; });
    }
};

/// The least error of three channels over all pairs of colours, with steps + 1 of them, no transparent ones; in units of
/// 1 / steps^2; at most `known`. A negative number if it would take more than `work` pairs of red and green.
std::int64_t FindOptimum1(const OracleBlock& block, int steps, std::int64_t known, std::int64_t work) {
    const ChannelPairs red(block, 0, steps, true, known);
    const ChannelPairs green(block, 1, steps, false, known);
    const ChannelPairs blue(block, 2, steps, false, known);
    if (red.pairs.empty() || green.pairs.empty() || blue.pairs.empty())
        return known;
    const std::int64_t leastBlue = blue.pairs[0].least;
    for (const auto& r : red.pairs) {
        if (r.least + green.pairs[0].least + leastBlue >= known)
            break;
        for (const auto& g : green.pairs) {
            if (r.least + g.least + leastBlue >= known)
                break;
            if (--work < 0)
                return -1;
            std::array<std::array<std::int32_t, 4>, 16> both;
            std::int64_t bound = leastBlue;
            for (std::size_t t = 0; t < 16; ++t) {
                for (std::size_t k = 0; k < 4; ++k)
                    both[t][k] = r.errors[t][k] + g.errors[t][k];
                bound += std::min({both[t][0], both[t][1], both[t][2], both[t][3]});
            }
            if (bound >= known)
                continue;
            for (const auto& b : blue.pairs) {
                if (bound - leastBlue + b.least >= known)
                    break;
                std::int64_t error = 0;
                for (std::size_t t = 0; t < 16; ++t)
                    error += std::min({both[t][0] + b.errors[t][0], both[t][1] + b.errors[t][1],
                                       both[t][2] + b.errors[t][2], both[t][3] + b.errors[t][3]});
                known = std::min(known, error);
            }
        }
    }
    return known;
}

double ToDecibels(double error, std::size_t numbers) {
    return 10 * std::log10(255.0 * 255.0 * 210 * 210 * static_cast<double>(numbers) / error);
}

} // namespace

TEST_CASE("BC4 oracle: the best level is within 0.05 dB of the optimum on FlightHelmet") {
    const std::vector<OracleBlock> blocks = LoadOracleBlocks(16, true);
    if (blocks.empty()) {
        MESSAGE("SKIP: no FlightHelmet in the shared folder");
        return;
    }
    const std::vector<std::int64_t> errors = GetBestErrors(BlockFormat::Bc4Unsigned, blocks, 1);
    double ours = 0;
    double optimum = 0;
    for (std::size_t i = 0; i < blocks.size(); ++i) {
        ours += static_cast<double>(errors[i]);
        optimum += static_cast<double>(FindOptimum4(blocks[i], errors[i]));
    }
    MESSAGE(blocks.size(), " blocks: ", ToDecibels(ours, 16 * blocks.size()), " dB, optimum ",
            ToDecibels(optimum, 16 * blocks.size()), " dB");
    CHECK(ToDecibels(ours, 16 * blocks.size()) > ToDecibels(optimum, 16 * blocks.size()) - 0.05);
}

TEST_CASE("BC1 oracle: the best level is within 0.05 dB of the optimum on FlightHelmet") {
    const std::vector<OracleBlock> blocks = LoadOracleBlocks(60, false);
    if (blocks.empty()) {
        MESSAGE("SKIP: no FlightHelmet in the shared folder");
        return;
    }
    const std::vector<std::int64_t> errors = GetBestErrors(BlockFormat::Bc1, blocks, 3);
    double ours = 0;
    double optimum = 0;
    std::size_t left = 0;
    std::size_t met = 0;
    for (std::size_t i = 0; i < blocks.size(); ++i) {
        // Ours in ninths (70^2 units each) and in quarters (105^2), rounded up.
        const std::int64_t four = FindOptimum1(blocks[i], 3, (errors[i] + 4899) / 4900, 400000);
        const std::int64_t three = FindOptimum1(blocks[i], 2, (errors[i] + 11024) / 11025, 400000);
        if (four < 0 || three < 0) {
            ++left;
            continue;
        }
        const std::int64_t best = std::min({errors[i], four * 4900, three * 11025});
        met += best == errors[i] ? 1u : 0u;
        ours += static_cast<double>(errors[i]);
        optimum += static_cast<double>(best);
    }
    const std::size_t numbers = 48 * (blocks.size() - left);
    MESSAGE(blocks.size(), " blocks, ", left, " left out, ", met, " met: ", ToDecibels(ours, numbers),
            " dB, optimum ", ToDecibels(optimum, numbers), " dB");
    CHECK(left < blocks.size() / 10);
    CHECK(ToDecibels(ours, numbers) > ToDecibels(optimum, numbers) - 0.05);
}
