// SPDX-License-Identifier: MIT
// Latents as a texture: its size, and copies that put every texel of a file where samplers look for it.
#include "support/SpecificationVectors.h"

#include "openntc/inference/LatentTextures.h"
#include "openntc/inference/ReadLatents.h"
#include "openntc/inference/Synthesis.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <vector>

using namespace openntc;
using namespace openntc_tests;

namespace {

std::vector<std::byte> MakeSet(int network, const TextureSetDesc& desc, const LatentShape& shape) {
    SynthesisDesc synthesis;
    synthesis.desc = desc;
    synthesis.networkVersion = network;
    synthesis.shape = shape;
    return MakeFile(synthesis);
}

} // namespace

TEST_CASE("latents as a texture: levels, layers and copies") {
    // Odd sizes: latent mips of 25 x 15, 12 x 7, … texels in three layers, some of which end at odd multiples of 2 bytes.
    for (const int network : {NTC_NETWORK_GENERATION_2, NTC_NETWORK_GENERATION_3}) {
        CAPTURE(network);
        const std::vector<std::byte> file = MakeSet(network, {100, 60, 16, 6}, MakeLayeredShape(4, 12));
        ReadOnlyMemoryStream stream(file);
        const auto set = TextureSetMetadata::Load(stream);
        REQUIRE_MESSAGE(set.has_value(), std::string(set.error().GetText()));
        const auto size = GetLatentTextureSize(*set);
        REQUIRE(size);
        CHECK(size->width == 25);
        CHECK(size->height == 15);
        CHECK(size->layers == 3);
        CHECK(size->levels == set->GetLatentMips().size());
        REQUIRE(size->levels == 4);

        for (const int first : {0, 3}) {
            const int count = 6 - first;
            std::vector<std::byte> bytes(*GetLatentBufferBytes(*set, first, count));
            REQUIRE(ReadLatents(*set, stream, first, count, bytes));
            const auto copies = GetLatentTextureCopies(*set, first, count);
            REQUIRE(copies);
            std::uint32_t level = first == 0 ? 0 : 2; // colour mips 3 and up read latent mips 2 and 3
            for (const LatentTextureCopy& copy : *copies) {
                CAPTURE(copy.level);
                CHECK(copy.level == level++);
                CHECK(copy.width == std::max(25u >> copy.level, 1u)); // what Vulkan makes the level
                CHECK(copy.height == std::max(15u >> copy.level, 1u));
                CHECK(copy.layers == 3);
                CHECK(copy.offset % 4 == 0);
                const LatentMip& mip = set->GetLatentMips()[copy.level];
                const std::size_t layer = std::size_t{2} * copy.width * copy.height;
                for (std::size_t l = 0; l < copy.layers; ++l) {
                    // The synthesised file stores layers as they are.
                    const auto at = static_cast<std::ptrdiff_t>(mip.layerData[l].range.offset);
                    CHECK(
                        std::equal(bytes.begin() + static_cast<std::ptrdiff_t>(copy.offset + l * layer),
                                   bytes.begin() + static_cast<std::ptrdiff_t>(copy.offset + (l + 1) * layer),
                                   file.begin() + at));
                }
            }
            CHECK(level == 4);
        }
        const auto outside = GetLatentTextureCopies(*set, 3, 4);
        REQUIRE_FALSE(outside);
        CHECK(outside.error().GetStatus() == Status::OutOfRange);
    }
    const std::vector<std::byte> file = MakeSet(NTC_NETWORK_SMALL, {32, 32, 4, 1}, {4, 4, 8, 2, 4});
    ReadOnlyMemoryStream stream(file);
    const auto set = TextureSetMetadata::Load(stream);
    REQUIRE(set);
    CHECK(GetLatentTextureSize(*set).error().GetStatus() == Status::Unsupported);
    CHECK(GetLatentTextureCopies(*set, 0, 1).error().GetStatus() == Status::Unsupported);
}
