// SPDX-License-Identifier: MIT
// Slices of generations 2 and 3: every texel of the rectangle, and of what lies below it, decodes to the bits that the whole
// set gives, from stored and from compressed latents; and no more latents are taken than the border explains.
#include "openntc/decode/ReferenceDecoder.h"
#include "openntc/inference/PartialInference.h"
#include "openntc/inference/ReadLatents.h"
#include "support/SpecificationVectors.h"
#include "support/TestSeed.h"

#include <doctest/doctest.h>

#include <cstring>
#include <random>
#include <string>
#include <vector>

using namespace openntc;

namespace {

struct LayeredSlices {
    std::vector<std::byte> file;
    Expected<TextureSetMetadata> set;
    std::vector<std::byte> latents;
    NtcTextureSetConstants constants;

    LayeredSlices(int version, TextureSetDesc desc, int scale, bool isCompressed)
        : file(Make(version, desc, scale, isCompressed)), set(Load(file)) {
        ReadOnlyMemoryStream stream(file);
        REQUIRE(set);
        latents.resize(*GetLatentBufferBytes(*set, 0, desc.mips));
        REQUIRE(ReadLatents(*set, stream, 0, desc.mips, latents));
        constants = *MakeInferenceData(*set, 0, desc.mips, InferenceWeightType::GenericInt8);
    }

    static std::vector<std::byte> Make(int version, TextureSetDesc desc, int scale, bool isCompressed) {
        SynthesisDesc synthesis;
        synthesis.seed = 5;
        synthesis.desc = desc;
        synthesis.networkVersion = version;
        synthesis.shape = MakeLayeredShape(scale, 12);
        synthesis.compression = {isCompressed, false, 1, 2.0f};
        return openntc_tests::MakeFile(synthesis);
    }
    static Expected<TextureSetMetadata> Load(const std::vector<std::byte>& file) {
        ReadOnlyMemoryStream stream(file);
        return TextureSetMetadata::Load(stream);
    }

    std::vector<float> Decode(const NtcTextureSetConstants& c, std::span<const std::byte> bytes, int mip,
                              Rect rect) const {
        std::vector<float> outputs(static_cast<std::size_t>(rect.width) *
                                   static_cast<std::size_t>(rect.height) * 16);
        const DecodeSource source{&c, bytes, *set->GetInferenceWeights(InferenceWeightType::GenericInt8),
                                  set->GetNetworkVersion(), DecodeWeights::Int8};
        const auto decoded = DecodeReference(source, mip, rect, {}, outputs);
        REQUIRE_MESSAGE(decoded, std::string(decoded.error().GetText()));
        return outputs;
    }

    /// Decodes a slice and all mips of it, and compares.
    void Check(const SliceDesc& desc) const {
        ReadOnlyMemoryStream stream(file);
        std::vector<std::byte> slice(static_cast<std::size_t>(*GetPartialLatentBufferSize(*set, desc)));
        const auto data =
            MakePartialInferenceData(*set, stream, desc, InferenceWeightType::GenericInt8, slice);
        REQUIRE_MESSAGE(data, std::string(data.error().GetText()));
        for (int level = 0; level < desc.numMips; ++level) {
            const int mip = desc.firstMip + level;
            const ColorMip& size = set->GetColorMips()[static_cast<std::size_t>(mip)];
            const int left = std::min(desc.rect.left >> level, size.width - 1);
            const int top = std::min(desc.rect.top >> level, size.height - 1);
            const auto end = [level](int last) { return (last + (1 << level) - 1) >> level; };
            const int right = std::min(std::max(end(desc.rect.left + desc.rect.width), left + 1), size.width);
            const int bottom =
                std::min(std::max(end(desc.rect.top + desc.rect.height), top + 1), size.height);
            const Rect rect{left, top, right - left, bottom - top};
            const std::vector<float> expected = Decode(constants, latents, mip, rect);
            const std::vector<float> outputs = Decode(data->constants, slice, mip, rect);
            REQUIRE(std::memcmp(expected.data(), outputs.data(), 4 * outputs.size()) == 0);
        }
        // One texel on each side of those that are read; whole grids where that is more than there is.
        const LatentMipSliceLayout layout = *GetLatentMipSlices(*set, desc);
        const ColorMip& first = set->GetColorMips()[static_cast<std::size_t>(desc.firstMip)];
        for (const LatentMipSlice& part : layout.GetParts()) {
            const LatentMip& latent = set->GetLatentMips()[static_cast<std::size_t>(part.latentMip)];
            const std::int64_t texels = desc.rect.width + 2 * ((std::int64_t{1} << desc.numMips) - 1);
            CHECK(part.width <= texels * latent.width / first.width + 6);
            CHECK(part.width <= latent.width);
        }
    }
};

} // namespace

TEST_CASE("latent mip slices: every texel decodes to the bits of the whole set") {
    const std::uint64_t seed = openntc::test::GetTestSeed();
    MESSAGE("OPENNTC_TEST_SEED=" << seed);
    std::mt19937_64 random(seed);
    const auto below = [&random](int limit) {
        return static_cast<int>(random() % static_cast<unsigned>(limit));
    };
    // Within the image, of at most `side` texels along each axis.
    const auto draw = [&below](const TextureSetMetadata& set, int side) {
        SliceDesc desc;
        desc.firstMip = below(7);
        desc.numMips = 1 + below(7 - desc.firstMip);
        const ColorMip& mip = set.GetColorMips()[static_cast<std::size_t>(desc.firstMip)];
        desc.rect.left = below(mip.width);
        desc.rect.top = below(mip.height);
        desc.rect.width = 1 + below(std::min(mip.width - desc.rect.left, side));
        desc.rect.height = 1 + below(std::min(mip.height - desc.rect.top, side));
        return desc;
    };
    for (const int version : {NTC_NETWORK_GENERATION_2, NTC_NETWORK_GENERATION_3}) {
        for (const int scale : {1, 3, 4}) {
            const LayeredSlices set(version, {131, 77, 4, 7}, scale, version == NTC_NETWORK_GENERATION_3);
            for (int i = 0; i < 12; ++i) {
                const SliceDesc desc = draw(*set.set, 24);
                CAPTURE(scale);
                CAPTURE(i);
                set.Check(desc);
            }
            for (int i = 0; i < 3000; ++i) {
                const SliceDesc desc = draw(*set.set, 131);
                CAPTURE(desc.firstMip);
                CAPTURE(desc.numMips);
                CAPTURE(desc.rect.left);
                CAPTURE(desc.rect.width);
                REQUIRE(GetLatentMipSlices(*set.set, desc)->bytes <=
                        *GetConservativeLatentMipBytes(*set.set, desc.firstMip, desc.numMips, desc.rect.width,
                                                       desc.rect.height));
            }
            set.Check({0, 7, {0, 0, 131, 77}});
            set.Check({0, 1, {0, 0, 1, 1}}); // wraps to the other corner
            set.Check({0, 1, {130, 76, 1, 1}});
        }
    }
}

TEST_CASE("latent mip slices: sizes, wrapping and refusals") {
    const LayeredSlices set(NTC_NETWORK_GENERATION_3, {256, 256, 4, 4}, 4, true);
    const auto layout = GetLatentMipSlices(*set.set, {0, 1, {0, 0, 4, 4}});
    REQUIRE(layout);
    REQUIRE(layout->count == 2);
    // Texels 0 ... 3 lie from -3/8 to 3/8 of a latent texel: cells -1 and 0, so texels -1 ... 1, and one more
    // on each side.
    CHECK(layout->parts[0].left == 62);
    CHECK(layout->parts[0].width == 5);
    CHECK(layout->parts[1].left == 30);
    CHECK(layout->parts[1].dataOffset == 152); // 5 x 5 x 3 texels of 2 bytes, up to a multiple of 4
    const auto whole = GetLatentMipSlices(*set.set, {0, 4, {0, 0, 256, 256}});
    CHECK(whole->bytes == set.latents.size());
    CHECK_FALSE(GetLatentMipSlices(*set.set, {0, 1, {0, 0, 257, 1}}));
    CHECK_FALSE(GetLatentMipSlices(*set.set, {4, 1, {0, 0, 1, 1}}));
    CHECK_FALSE(GetLatentMipSlices(*set.set, {0, 1, {-1, 0, 1, 1}}));
    CHECK_FALSE(GetLatentMipSlices(*set.set, {0, 1, {0, 0, 1, 0}}));
    ReadOnlyMemoryStream stream(set.file);
    std::vector<std::byte> small(static_cast<std::size_t>(layout->bytes) - 1);
    CHECK_FALSE(ReadLatentMipSlices(*set.set, *layout, stream, small));
}
