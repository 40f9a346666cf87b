// SPDX-License-Identifier: MIT
// The pass DecompressGDeflate in both languages: the CPU's bytes, the CPU's verdict on tiles that are corrupt, and nothing
// written beyond a tile.
#include "gdeflate_pass_hlsl_shaders.h"
#include "gdeflate_pass_shaders.h"
#include "shader/TestDevice.h"
#include "support/CompressedSets.h"
#include "support/GDeflateTiles.h"
#include "vulkan_harness/Vulkan.h"

#include "openntc/passes/GDeflateConstants.h"
#include "openntc/passes/GDeflateLanes.h"
#include "openntc/passes/GDeflatePass.h"

#include <doctest/doctest.h>

#include <cstring>
#include <initializer_list>
#include <string>
#include <vector>

using namespace openntc;
using namespace openntc::harness;
using namespace openntc_tests;

namespace {

using Bytes = std::vector<std::byte>;

constexpr std::byte kGuard{0xA5};
constexpr std::size_t kGuardBytes = 64;

/// One tile of compressed words, and what became of it.
struct TileCase {
    Bytes compressed; ///< a multiple of 4, 128 or more
    std::size_t bytes = 0;
    Bytes output; ///< of the pass, with guards behind it
};

struct PassRunner {
    Context* context;
    bool isHlsl;

    ComputePipeline MakePipeline() const {
        static constexpr BufferSlot kSlots[] = {{0, BufferKind::Storage},
                                                {1, BufferKind::Storage},
                                                {2, BufferKind::Storage},
                                                {3, BufferKind::Storage}};
        const auto shader = isHlsl ? gdeflate_pass_hlsl_shaders::FindShader("DecompressGDeflate.hlsl", "")
                                   : gdeflate_pass_shaders::FindShader("DecompressGDeflate.comp", "");
        REQUIRE(shader);
        auto pipeline = context->CreateComputePipeline(*shader, kSlots, sizeof(NtcGDeflateConstants));
        REQUIRE_MESSAGE(pipeline, std::string(pipeline.error().GetText()));
        return std::move(*pipeline);
    }

    Buffer MakeStorage(std::span<const std::byte> contents) const {
        auto buffer = context->CreateBuffer(contents, BufferKind::Storage, BufferMemory::HostVisible);
        REQUIRE(buffer);
        return std::move(*buffer);
    }

    /// Fills the outputs and returns how many tiles the pass calls corrupt.
    std::uint32_t Run(const ComputePipeline& pipeline, std::vector<TileCase>& cases) const {
        Bytes compressed;
        Bytes output;
        std::vector<NtcGDeflateTile> tiles;
        for (const TileCase& tile : cases) {
            tiles.push_back({static_cast<std::uint32_t>(compressed.size() / 4),
                             static_cast<std::uint32_t>(tile.compressed.size() / 4),
                             static_cast<std::uint32_t>(output.size() / 4),
                             static_cast<std::uint32_t>(tile.bytes)});
            compressed.insert(compressed.end(), tile.compressed.begin(), tile.compressed.end());
            output.insert(output.end(), (tile.bytes + 3) / 4 * 4 + kGuardBytes, kGuard);
        }
        const Buffer tileBuffer = MakeStorage(std::as_bytes(std::span(tiles)));
        const Buffer source = MakeStorage(compressed);
        const Buffer target = MakeStorage(output);
        const Buffer corrupt = MakeStorage({});
        const BoundBuffer bound[] = {{0, &tileBuffer}, {1, &source}, {2, &target}, {3, &corrupt}};
        const NtcGDeflateConstants constants{0, static_cast<std::uint32_t>(tiles.size())};
        DispatchRequest request;
        request.pipeline = &pipeline;
        request.buffers = bound;
        request.pushConstants = std::as_bytes(std::span(&constants, 1));
        request.groups[0] = constants.tiles;
        const auto done = context->Dispatch(request);
        REQUIRE_MESSAGE(done, std::string(done.error().GetText()));
        REQUIRE(context->Read(target, 0, output));
        for (std::size_t i = 0; i < cases.size(); ++i) {
            const auto begin =
                output.begin() + static_cast<std::ptrdiff_t>(std::size_t{4} * tiles[i].outputWord);
            cases[i].output.assign(
                begin, begin + static_cast<std::ptrdiff_t>((cases[i].bytes + 3) / 4 * 4 + kGuardBytes));
        }
        Bytes word(4);
        REQUIRE(context->Read(corrupt, 0, word));
        std::uint32_t count = 0;
        std::memcpy(&count, word.data(), 4);
        return count;
    }
};

/// The first tile of a stream of such data.
TileCase MakeTile(LatentBytes kind, std::size_t bytes) {
    const Bytes stream = MakeGDeflateStream(MakeLatentBytes(kind, bytes, 5), 0);
    const auto header = *container::DecodeGDeflateHeader(stream);
    const auto range = *container::FindGDeflateTile(header, stream, stream.size(), 0);
    TileCase tile;
    tile.bytes = header.GetTileBytes(0);
    tile.compressed.assign(stream.begin() + static_cast<std::ptrdiff_t>(range.offset),
                           stream.begin() + static_cast<std::ptrdiff_t>(range.offset + range.size));
    REQUIRE(tile.compressed.size() % 4 == 0);
    return tile;
}

/// How many tiles the CPU calls corrupt; the bytes of the others, and all guards, must be right.
std::uint32_t CompareWithCpu(const std::vector<TileCase>& cases) {
    std::uint32_t corrupt = 0;
    for (std::size_t i = 0; i < cases.size(); ++i) {
        const TileCase& tile = cases[i];
        Bytes expected(tile.bytes);
        const bool isRight = container::DecompressGDeflateTile(tile.compressed, expected, 0).has_value();
        corrupt += isRight ? 0 : 1;
        const auto end = tile.output.begin() + static_cast<std::ptrdiff_t>(tile.bytes);
        if (isRight)
            CHECK_MESSAGE(std::equal(expected.begin(), expected.end(), tile.output.begin(), end), i);
        const auto guard = tile.output.end() - static_cast<std::ptrdiff_t>(kGuardBytes);
        CHECK(std::all_of(guard, tile.output.end(), [](std::byte b) { return b == kGuard; }));
    }
    return corrupt;
}

} // namespace

TEST_CASE("GDeflate pass: tiles of every kind and size, in both languages") {
    OPENNTC_REQUIRE_DEVICE(context);
    for (const bool isHlsl : {false, true}) {
        CAPTURE(isHlsl);
        const PassRunner runner{context, isHlsl};
        const ComputePipeline pipeline = runner.MakePipeline();
        std::vector<TileCase> cases;
        for (const LatentBytes kind : {LatentBytes::Noise, LatentBytes::Repeated, LatentBytes::Few})
            for (const std::size_t bytes :
                 std::initializer_list<std::size_t>{1, 2, 31, 32, 33, 127, 1000, 5003, 65536})
                cases.push_back(MakeTile(kind, bytes));
        CHECK(runner.Run(pipeline, cases) == 0);
        CHECK(CompareWithCpu(cases) == 0);
    }
}

TEST_CASE("GDeflate pass: tiles that are corrupt are those that the CPU calls so, and write nothing beyond "
          "themselves") {
    OPENNTC_REQUIRE_DEVICE(context);
    for (const bool isHlsl : {false, true}) {
        CAPTURE(isHlsl);
        const PassRunner runner{context, isHlsl};
        const ComputePipeline pipeline = runner.MakePipeline();
        std::vector<TileCase> cases;
        std::uint32_t state = 99;
        for (const LatentBytes kind : {LatentBytes::Noise, LatentBytes::Repeated, LatentBytes::Few}) {
            const TileCase base = MakeTile(kind, 900);
            for (std::size_t at = 0; at < base.compressed.size(); at += at < 160 ? 1 : 7) {
                TileCase changed = base;
                state = state * 1664525u + 1013904223u;
                changed.compressed[at] ^= static_cast<std::byte>(1u + (state >> 24) % 255u);
                cases.push_back(changed);
            }
            TileCase shortOne = base; // bytes of the output too few, and too many; words cut off
            shortOne.bytes = 899;
            cases.push_back(shortOne);
            shortOne.bytes = 901;
            cases.push_back(shortOne);
            for (std::size_t words = 32; 4 * words < base.compressed.size(); words += 5) {
                TileCase cut = base;
                cut.compressed.resize(4 * words);
                cases.push_back(cut);
            }
            TileCase noise = base;
            noise.compressed = MakeLatentBytes(LatentBytes::Noise, 400, 1 + static_cast<std::uint32_t>(kind));
            cases.push_back(noise);
        }
        for (const std::size_t blocks : {0u, 50u, 300u}) {
            TileCase empty;
            empty.compressed = MakeEmptyBlocks(blocks);
            empty.bytes = 1;
            cases.push_back(empty);
        }
        const std::uint32_t found = runner.Run(pipeline, cases);
        CHECK(found == CompareWithCpu(cases));
        CHECK(found > 100);
        CHECK(found < cases.size());
    }
}

TEST_CASE("GDeflate pass: dispatches of plans, in two dimensions where there are many tiles") {
    LatentDecompression plan;
    plan.workBytes = plan.latentBytes = 1 << 20;
    for (std::uint32_t i = 0; i < 32769; ++i)
        REQUIRE(plan.tiles.PushBack({std::uint64_t{4} * i, 8, 128, 100, i % 32769 == 7}));
    const auto pass = MakeGDeflatePass(plan);
    REQUIRE(pass);
    REQUIRE(pass->tiles.size() == 32769);
    CHECK(pass->intoLatents.constants.firstTile == 0);
    CHECK(pass->intoLatents.constants.tiles == 32768);
    CHECK(pass->intoLatents.groups[0] == 32768);
    CHECK(pass->intoLatents.groups[1] == 1);
    CHECK(pass->intoWork.constants.firstTile == 32768);
    CHECK(pass->intoWork.constants.tiles == 1);
    CHECK(pass->tiles[32768].firstWord == 7);
    CHECK(pass->tiles[7].firstWord == 8);
    CHECK(pass->tiles[0].words == 32);
    CHECK(pass->tiles[0].outputWord == 2);
    CHECK(pass->tiles[0].bytes == 100);
    plan.tiles[7].isInWork = false;
    CHECK(MakeGDeflatePass(plan)->intoLatents.groups[1] == 2);
    CHECK(MakeGDeflatePass(plan)->intoWork.groups[0] == 0);
    plan.workBytes = std::uint64_t{4} << 32;
    CHECK_FALSE(MakeGDeflatePass(plan));
}

TEST_CASE("GDeflate pass: a lane's bits are those of 64-bit arithmetic, and symbols those of DEFLATE64") {
    shader::NtcBitLane lane{};
    std::uint64_t bits = 0;
    unsigned count = 0;
    std::uint32_t state = 7;
    const auto random = [&state] { return (state = state * 1664525u + 1013904223u) >> 8; };
    for (int i = 0; i < 2000; ++i) {
        if (lane.count < 32) {
            const std::uint32_t word = random() << 8 | (random() & 255u);
            shader::NtcAppendWord(lane, word);
            bits |= std::uint64_t{word} << count;
            count += 32;
        }
        const unsigned taken = random() % 32u;
        REQUIRE(shader::NtcTakeBits(lane, taken) == (bits & ((std::uint64_t{1} << taken) - 1)));
        bits >>= taken;
        count -= taken;
        REQUIRE(lane.count == count);
    }
    // Codes follow one another without gaps, up to the special ones.
    unsigned length = 3;
    for (unsigned symbol = 257; symbol < 285; ++symbol) {
        const unsigned code = shader::NtcGetLengthCode(symbol);
        CHECK((code & 0xFFFFFu) == length);
        length += 1u << (code >> 20);
    }
    CHECK(length == 259); // the last one's 31 is 258
    CHECK(shader::NtcGetLengthCode(285) == (3u | 16u << 20));
    unsigned distance = 1;
    for (unsigned symbol = 0; symbol < 32; ++symbol) {
        const unsigned code = shader::NtcGetDistanceCode(symbol);
        CHECK((code & 0xFFFFFu) == distance);
        distance += 1u << (code >> 20);
    }
    CHECK(distance == 65537);
    const unsigned order[] = {16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15};
    for (unsigned i = 0; i < 19; ++i)
        CHECK(shader::NtcGetPrecodeSymbol(i) == order[i]);
    for (const auto& [symbol, expected] : {std::pair(0u, 8u),
                                           {143u, 8u},
                                           {144u, 9u},
                                           {255u, 9u},
                                           {256u, 7u},
                                           {279u, 7u},
                                           {280u, 8u},
                                           {287u, 8u},
                                           {288u, 5u},
                                           {319u, 5u}})
        CHECK(shader::NtcGetStaticCodeBits(symbol) == expected);
}
