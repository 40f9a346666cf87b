// SPDX-License-Identifier: MIT
// Files of generation 3: they load, decode to what training reports, and depend on seed and steps alone.
#include "DecodedSet.h"
#include "Train.h"

#include "openntc/encode/Kernels.h"

#include <string>

using namespace openntc;
using namespace openntc::encode;

namespace {

/// Two textures, one of them constant, of a size whose latent mips have odd sides.
Material MakeTwoTextures(int width, int height) {
    Material material = *Material::Create(width, height);
    std::vector<float> color;
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const float u = static_cast<float>(x) / 32.0f, v = static_cast<float>(y) / 24.0f;
            for (float phase : {0.0f, 1.0f, 2.0f})
                color.push_back(0.5f + 0.4f * std::sin(6.3f * u + phase) * std::cos(6.3f * v));
        }
    }
    const std::vector<float> constant(color.size() / 3, -0.3f);
    REQUIRE(material.AddTexture({.name = "Color",
                                 .firstChannel = 1,
                                 .channels = 3,
                                 .rgbColorSpace = ColorSpace::sRGB,
                                 .bcFormat = BlockCompressedFormat::BC7},
                                color));
    REQUIRE(material.AddTexture({.name = "Constant", .firstChannel = 9, .channels = 1}, constant));
    material.GenerateMips();
    return material;
}

EncodeOptions MakeGenerationOptions(std::uint64_t steps) {
    EncodeOptions options;
    options.networkVersion = NTC_NETWORK_GENERATION_3;
    options.steps = steps;
    options.threads = 2;
    return options;
}

} // namespace

TEST_CASE("generation 3: the file has both networks, its chain of latent mips, and decodes to the PSNR that "
          "training reports") {
    for (const float bits : {1.11f, 6.67f, 20.0f}) {
        CAPTURE(bits);
        const Material material = MakeTwoTextures(45, 31);
        EncodeOptions options = MakeGenerationOptions(test::Steps(200, 20));
        options.bitsPerPixel = bits;
        const auto result = test::Train(material, options);
        REQUIRE_MESSAGE(result.has_value(), std::string(result ? "" : result.error().GetText()));
        CHECK(result->steps == options.steps);
        const test::DecodedSet set(result->file, DecodeMath::Int8);
        CHECK(set.metadata.GetGeneration() == 3);
        CHECK(set.metadata.GetLatentShape() == result->latentShape);
        const int scale = result->latentShape.gridSizeScale;
        const auto latents = set.metadata.GetLatentMips();
        REQUIRE(static_cast<int>(latents.size()) == GetLatentMipCount(set.metadata.GetDesc(), scale));
        for (int n = 0; n < static_cast<int>(latents.size()); ++n) {
            const LatentMip& latent = latents[static_cast<std::size_t>(n)];
            CHECK(latent.width == GetLatentMipDimension(45, scale, n));
            CHECK(latent.height == GetLatentMipDimension(31, scale, n));
        }
        for (int m = 0; m < set.metadata.GetDesc().mips; ++m) {
            const ColorMip& mip = set.metadata.GetColorMips()[static_cast<std::size_t>(m)];
            CHECK(mip.neuralMip == GetLatentMipForColorMip(m, scale, static_cast<int>(latents.size())));
            const LatentMip& latent = latents[static_cast<std::size_t>(mip.neuralMip)];
            CHECK(mip.positionScale ==
                  GetLatentPositionScale(mip.width, mip.height, latent.width, latent.height));
            CHECK(mip.positionLod == GetLatentPositionLod(mip.positionScale));
        }
        CHECK(set.metadata.GetTextures()[0].bcFormat == BlockCompressedFormat::BC7);
        // The arithmetic is the decoder's bit for bit; what remains are the 16-bit references of training.
        const auto decoded = test::DecodeFile(result->file);
        CHECK(std::fabs(test::MeasurePsnr(material, decoded) - result->psnr) < 0.01);
        CHECK(std::fabs(test::MeasurePsnr(material, test::DecodeFp8(result->file)) - result->fp8Psnr) < 0.01);
        // Latents that a decoder reads elsewhere, or weights of a wrong layout, decode to less than 15 dB.
#ifndef OPENNTC_TEST_SANITIZED
        CHECK(result->psnr > 25.0);
#endif
        for (std::size_t i = 0; i < decoded[0].size(); i += 16) {
            REQUIRE(decoded[0][i + 9] == -0.3f); // the constant channel, bit for bit
            REQUIRE(decoded[0][i] == 0.0f);      // a channel that no texture declares
        }
    }
}

TEST_CASE("generation 3: equal bytes for any threads, from a broken run, and of kernels that multiply in "
          "binary32") {
    const Material material = MakeTwoTextures(32, 24);
    EncodeOptions options = MakeGenerationOptions(test::Steps(60, 20));
    const auto whole = test::Train(material, options);
    REQUIRE(whole.has_value());
    options.threads = 1;
    CHECK(test::Train(material, options)->file == whole->file);
    options.reportSeconds = 0.0;
    const auto part = test::Train(material, options, [](const Progress& p) { return p.fraction < 0.5; });
    REQUIRE(part.has_value());
    REQUIRE(part->cancelled);
    options.resumeState = part->state;
    CHECK(test::Train(material, options)->file == whole->file);
    options = MakeGenerationOptions(5);
    std::vector<std::byte> first;
    for (const KernelChoice kernel : {KernelChoice::Avx2, KernelChoice::Avx512, KernelChoice::Neon}) {
        if (!IsKernelAvailable(kernel))
            continue;
        options.kernel = kernel;
        const auto result = test::Train(material, options);
        REQUIRE(result.has_value());
        CHECK((first.empty() || result->file == first));
        first = result->file;
    }
}

TEST_CASE("generation 3: steps are of 1024 texels, which is better for as many texels") {
    const Material material = MakeTwoTextures(64, 64);
    EncodeOptions options = MakeGenerationOptions(test::Steps(150, 10));
    const auto usual = test::Train(material, options);
    REQUIRE(usual.has_value());
    CHECK(usual->steps == options.steps);
    CHECK(usual->batchTexels == 1024);
    options.batchTexels = 4096;
    const auto large = test::Train(material, options);
    REQUIRE(large.has_value());
    CHECK(large->steps == options.steps);
#ifndef OPENNTC_TEST_SANITIZED
    CHECK(usual->psnr > large->psnr);
#endif
    options.networkVersion = NTC_NETWORK_MEDIUM;
    options.batchTexels = 0;
    options.steps = 4;
    CHECK(test::Train(material, options)->batchTexels == 4096);
}

TEST_CASE("generation 3: compressed latents are smaller and decode to the same") {
    // One colour: latents that nothing trains apart are alike.
    Material material = *Material::Create(128, 128);
    std::vector<float> texels(std::size_t{128} * 128);
    for (std::size_t i = 0; i < texels.size(); ++i)
        texels[i] = i % 128 < 64 ? 0.25f : 0.75f;
    REQUIRE(material.AddTexture({.name = "Steps", .firstChannel = 0, .channels = 1}, texels));
    material.GenerateMips();
    EncodeOptions options = MakeGenerationOptions(test::Steps(400, 10));
    const auto plain = test::Train(material, options);
    options.compress = true;
    const auto compressed = test::Train(material, options);
    REQUIRE(plain.has_value());
    REQUIRE_MESSAGE(compressed.has_value(), std::string(compressed ? "" : compressed.error().GetText()));
    CHECK(compressed->psnr == plain->psnr);
#ifndef OPENNTC_TEST_SANITIZED // whose few steps leave the noise that latents begin with
    CHECK(compressed->file.size() < plain->file.size());
#endif
    CHECK(test::DecodeFile(compressed->file) == test::DecodeFile(plain->file));
}

TEST_CASE("generation 3: what is refused") {
    const Material material = MakeTwoTextures(16, 16);
    EncodeOptions options = MakeGenerationOptions(1);
    options.latentShape = {4, 8, 4, 4, 4};
    CHECK(test::Train(material, options).error().GetStatus() == Status::OutOfRange);
    options = MakeGenerationOptions(1);
    options.networkVersion = NTC_NETWORK_GENERATION_2;
    CHECK(test::Train(material, options).error().GetStatus() == Status::OutOfRange);
    options.networkVersion = NTC_NETWORK_MEDIUM;
    options.compress = true;
    CHECK(test::Train(material, options).error().GetStatus() == Status::OutOfRange);
    options = MakeGenerationOptions(1);
    options.kernel = KernelChoice::Amx;
    CHECK(test::Train(material, options).error().GetStatus() == Status::Unsupported);
}
