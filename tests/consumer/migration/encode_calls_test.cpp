// SPDX-License-Identifier: MIT
// The encoding call that docs/migrating-from-libntc.md shows, compiled and run.
#include "openntc/encode/Encoder.h"

#include <doctest/doctest.h>

#include <string>
#include <vector>

using namespace openntc;

namespace {

// Stands in the page as it is.
Expected<std::vector<std::byte>> Compress(std::span<const float> rgb, int width, int height) {
    OPENNTC_ASSIGN(encode::Material material, encode::Material::Create(width, height));
    encode::MaterialTexture albedo;
    albedo.name = "Albedo";
    albedo.channels = 3;
    albedo.rgbColorSpace = ColorSpace::sRGB;
    OPENNTC_CHECK(material.AddTexture(albedo, rgb));
    material.GenerateMips();
    encode::EncodeOptions options;
    options.bitsPerPixel = 4.0f;
    options.networkVersion = NTC_NETWORK_SMALL;
    options.steps = 1;
    OPENNTC_ASSIGN(encode::EncodeResult result, encode::Encoder::Encode(material, options));
    return std::move(result.file);
}

} // namespace

TEST_CASE("the encoding call of the migration page runs") {
    const std::vector<float> rgb(3 * 16 * 16, 0.5f);
    const auto file = Compress(rgb, 16, 16);
    REQUIRE_MESSAGE(file.has_value(), std::string(file.error().GetText()));
    CHECK(file->size() > 1000);
}
