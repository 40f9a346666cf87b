// SPDX-License-Identifier: MIT
// Modes of BC7 blocks: the specification's numbers, packing, and files that hold them.
#include "RewrittenFile.h"
#include "openntc/inference/Synthesis.h"
#include "openntc/texture_set/BlockModes.h"
#include "support/SpecificationVectors.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

using namespace openntc;
using namespace openntc_tests;

namespace {

/// Blocks whose first words are these.
std::vector<std::byte> MakeBlocks(const std::vector<std::uint32_t>& words) {
    std::vector<std::byte> blocks(16 * words.size());
    for (std::size_t i = 0; i < words.size(); ++i)
        std::memcpy(blocks.data() + 16 * i, &words[i], 4);
    return blocks;
}

} // namespace

TEST_CASE("block modes: mode and partition of the first bits of a block") {
    // Below the partition's bits stands the mode in unary; above it ones must not count.
    CHECK(GetBlockMode(0xFFFFFFE1u | 5u << 1) == BlockMode{0, 5});
    CHECK(GetBlockMode(2u | 63u << 2) == BlockMode{1, 63});
    CHECK(GetBlockMode(4u | 17u << 3 | 0xFFFFFE00u) == BlockMode{2, 17});
    CHECK(GetBlockMode(8u | 62u << 4) == BlockMode{3, 62});
    CHECK(GetBlockMode(16u | 7u << 5 | 0xFFFFFF00u) == BlockMode{4, 7});
    CHECK(GetBlockMode(32u | 2u << 6 | 0xFFFFFF00u) == BlockMode{5, 2});
    CHECK(GetBlockMode(64u | 0xFFFFFF80u) == BlockMode{6, 0});
    CHECK(GetBlockMode(128u | 33u << 8) == BlockMode{7, 33});
    CHECK(GetBlockMode(0) == BlockMode{7, 0});
    CHECK(GetBlockModeBytes(1) == 4);
    CHECK(GetBlockModeBytes(3) == 4);
    CHECK(GetBlockModeBytes(4) == 8);
    CHECK(GetBlockModeBytes(32) == 36);
}

TEST_CASE("block modes: 9 bits for each block, the lowest first, and a number for mode 0 with partition 0") {
    const std::vector<std::uint32_t> words = {1u, 1u | 9u << 1, 2u | 63u << 2, 64u, 128u | 63u << 8};
    const auto packed = PackBlockModes(MakeBlocks(words));
    REQUIRE(packed);
    REQUIRE(packed->size() == 8);
    const std::uint32_t codes[] = {0x1BF, 9, 64 + 63, 6 * 64, 7 * 64 + 63};
    std::uint64_t bits = 0;
    for (int i = 0; i < 5; ++i)
        bits |= std::uint64_t{codes[i]} << (9 * i);
    CHECK(std::memcmp(packed->data(), &bits, 8) == 0);
    const BlockMode modes[] = {{0, 0}, {0, 9}, {1, 63}, {6, 0}, {7, 63}};
    for (std::size_t i = 0; i < 5; ++i) {
        BlockMode mode;
        CHECK(FindBlockMode(packed->AsSpan(), i, mode));
        CHECK(mode == modes[i]);
    }
    BlockMode none;
    CHECK_FALSE(FindBlockMode(packed->AsSpan(), 5, none)); // zeros
    CHECK_FALSE(PackBlockModes(std::span(packed->data(), 8)));
}

TEST_CASE("block modes: written, read and rewritten in a set, behind the latents") {
    SynthesisDesc synthesis;
    synthesis.desc = {90, 70, 4, 3};
    synthesis.networkVersion = NTC_NETWORK_GENERATION_3;
    synthesis.shape = MakeLayeredShape(4, 8);
    const std::vector<std::byte> plain = MakeFile(synthesis);
    std::vector<std::uint32_t> words(23 * 18);
    for (std::size_t i = 0; i < words.size(); ++i)
        words[i] = 1u << (i % 7) | (i % 64 == 0 ? 0u : 0xFFFFFF00u);
    for (const bool isCompressed : {false, true}) {
        ReadOnlyMemoryStream source(plain);
        const auto before = TextureSetMetadata::Load(source);
        REQUIRE(before);
        auto writable = MakeWritableCopy(*before, source);
        REQUIRE(writable);
        CompressionOptions options;
        options.blockModes = isCompressed;
        REQUIRE(writable->SetCompression(options));
        const auto packed = PackBlockModes(MakeBlocks(words));
        REQUIRE(packed);
        REQUIRE(writable->AddBlockModes(0, 0, packed->AsSpan()));
        CHECK_FALSE(writable->AddBlockModes(0, 3, packed->AsSpan()));
        CHECK_FALSE(writable->AddBlockModes(1, 0, packed->AsSpan()));
        MemoryStream file;
        REQUIRE(writable->Write(file));
        const auto set = TextureSetMetadata::Load(file);
        REQUIRE_MESSAGE(set, std::string(set.error().GetText()));
        REQUIRE(set->GetTextures()[0].blockModes.size() == 1);
        const BlockModeBuffer& modes = set->GetTextures()[0].blockModes[0];
        CHECK(modes.mip == 0);
        CHECK(modes.data.isCompressed == isCompressed);
        CHECK(modes.data.range.offset > set->GetLatentMips().back().layerData[1].range.offset);
        const auto read = ReadBlockModes(modes, file, 90, 70);
        REQUIRE_MESSAGE(read, std::string(read.error().GetText()));
        CHECK(std::equal(read->begin(), read->end(), packed->begin(), packed->end()));
        CHECK_FALSE(ReadBlockModes(modes, file, 100, 70));
        const std::vector<std::byte> bytes(file.GetBytes().begin(), file.GetBytes().end());
        CHECK(Rewrite(bytes).size() == bytes.size());
        auto without = MakeWritableCopy(*set, file, GetDefaultAllocator(), false);
        REQUIRE(without);
        MemoryStream bare;
        REQUIRE(without->Write(bare));
        const std::vector<std::byte> copied = Rewrite(plain);
        CHECK(std::equal(bare.GetBytes().begin(), bare.GetBytes().end(), copied.begin(), copied.end()));
    }
    WritableTextureSet first;
    REQUIRE(first.SetDescription({8, 8, 4, 1}, {4, 4, 4, 1, 1}, 0));
    CHECK_FALSE(first.AddBlockModes(0, 0, {}));
    CHECK_FALSE(first.SetCompression({true, false, 9, 0.95f}));
    CHECK_FALSE(first.AddLatentMip(2, 2, {}));
}
