// SPDX-License-Identifier: MIT
// Other requests than lists of texels inside a mip.
#include "SuiteBuilder.h"

namespace openntc::conformance {

namespace {

void AddWholeMips(SuiteBuilder& builder) {
    builder.AddSet("odd", SynthesizeBytes(Describe(1000, 37, 21, 3, {2, 4, 8, 2, 4})));
    builder.AddWholeMip("whole-mip-odd", DecodeMath::Int8, 0, builder.ListTexels(0, 0, 7),
                        "a whole mip of odd width and height, which blocks do not fill");
    SynthesisDesc synthesis = Describe(1001, 300, 40, 3, {4, 4, 4, 2, 4});
    for (std::uint32_t channel = 0; channel < 16; ++channel)
        synthesis.channelColorSpaces |= (channel + 2) % 3 << (2 * channel);
    builder.AddSet("wide", SynthesizeBytes(synthesis));
    std::vector<tool::Texel> texels = builder.ListFewTexels(40);
    for (const int x : {0, 255, 256, 299}) {
        for (const int y : {3, 31, 32, 39})
            texels.push_back({0, x, y});
    }
    builder
        .AddWholeMip("whole-mip-300x40", DecodeMath::Int8Half, 0, texels,
                     "a whole mip of 300 x 40 texels, converted to linear")
        .linear = true;
    builder.AddWholeMip("whole-mip-2", DecodeMath::Int8, 2, texels, "a whole mip, not the first");
}

void AddSlices(SuiteBuilder& builder) {
    builder.SelectSet("images-scale-2");
    builder.AddSlice("slice", DecodeMath::Int8, 0, {101, 203, 6, 5},
                     "a rectangle of a mip: texels are those of the whole mip");
    builder.AddSlice("slice-mip-4", DecodeMath::Int8, 4, {13, 5, 5, 3}, "a rectangle of a mip of image 1");
    builder.AddSlice("slice-corner", DecodeMath::Int8Half, 0, {507, 509, 5, 3},
                     "a rectangle up to the last texel");
    builder.AddSlice("slice-texel", DecodeMath::Int8, 1, {255, 0, 1, 1}, "a rectangle of one texel");
    builder.SelectSet("wide");
    builder
        .AddSlice("slice-linear", DecodeMath::Int8, 0, {250, 29, 10, 6}, "a rectangle, converted to linear")
        .linear = true;
    builder.SelectSet("shape-4x1-4x1"); // grids of 5 x 5 and 2 x 2 pixels of 4 bits
    builder.AddSlice("slice-half-bytes", DecodeMath::Int8, 0, {3, 2, 5, 6},
                     "a rectangle whose latents are half bytes in rows of odd length");
    builder.AddSlice("slice-half-bytes-right", DecodeMath::Int8, 0, {7, 0, 4, 10},
                     "half bytes in rows of odd length, up to the last column");
    builder.SelectSet("shape-12x1-12x4");
    builder.AddSlice("slice-12-bits", DecodeMath::Int8Half, 0, {2, 3, 4, 5},
                     "a rectangle whose latents take one and a half bytes");
    builder.SelectSet("size-1x64");
    builder.AddSlice("slice-tall", DecodeMath::Int8, 0, {0, 40, 1, 20},
                     "a rectangle further down than the mip is wide");
    builder.SelectSet("texels-on-latents");
    builder.AddSlice("slice-on-latents", DecodeMath::Int8, 0, {40, 12, 21, 9},
                     "a rectangle whose texels lie on latents, in a mip of 100 x 37");
    builder.AddSlice("slice-odd-mip", DecodeMath::Int8Half, 1, {31, 11, 19, 7},
                     "a rectangle up to the last texel of a mip of 50 x 18");
}

void AddSlicesOfMips(SuiteBuilder& builder) {
    builder.SelectSet("images-scale-2");
    builder.AddSliceMips("slice-mips", DecodeMath::Int8, 0, 4, {101, 203, 11, 6},
                         "a slice of four mips: of each the texels that the rectangle lies on");
    builder.AddSliceMips("slice-mips-half", DecodeMath::Int8Half, 1, 3, {250, 5, 6, 9},
                         "a slice of three mips that begins with mip 1, up to the last column");
    builder.AddSliceMips("slice-mips-images", DecodeMath::Int8, 2, 5, {37, 90, 13, 7},
                         "a slice of five mips with several latent images");
    builder.AddSliceMips("slice-mips-last", DecodeMath::Int8, 6, 4, {0, 0, 8, 8},
                         "a slice of the last mips, to 1 x 1");
    builder.SelectSet("wide");
    builder
        .AddSliceMips("slice-mips-linear", DecodeMath::Int8, 0, 3, {250, 29, 7, 6},
                      "a slice of three mips, converted to linear")
        .linear = true;
    builder.AddSet("size-71x16", SynthesizeBytes(Describe(1002, 71, 16, 4, {4, 4, 4, 8, 8})));
    builder.AddSliceMips("slice-mips-odd", DecodeMath::Int8, 0, 4, {64, 5, 7, 6},
                         "a slice of four mips where sizes do not halve: 71, 35, 17, 8");
    builder.SelectSet("size-257x33");
    builder.AddSliceMips("slice-mips-ends", DecodeMath::Int8, 0, 3, {256, 3, 1, 5},
                         "a slice of three mips, the second of which ends before it");
    builder.SelectSet("images-order");
    builder.AddSliceMips("slice-mips-order", DecodeMath::Int8Half, 0, 5, {300, 2, 9, 5},
                         "a slice of five mips whose latent images are in no order");
    builder.SelectSet("shape-12x1-12x4");
    builder.AddSliceMips("slice-mips-12-bits", DecodeMath::Int8, 0, builder.GetMetadata().GetDesc().mips,
                         {3, 2, 5, 6}, "a slice of all mips whose latents take one and a half bytes");
}

void AddOutside(SuiteBuilder& builder) {
    builder.SelectSet("plain");
    std::vector<tool::Texel> texels;
    for (int mip = 0; mip < builder.GetMetadata().GetDesc().mips; ++mip) {
        const ColorMip& size = builder.GetMetadata().GetColorMips()[static_cast<std::size_t>(mip)];
        for (const auto& [x, y] :
             {std::pair(-1, -1), std::pair(-7, 3), std::pair(2, -5), std::pair(size.width, size.height),
              std::pair(size.width + 5, -3), std::pair(-100003, 50021), std::pair(4194303, -4194304)})
            texels.push_back({mip, x, y});
        for (const int y : {-2, 0, size.height / 2, size.height - 1, size.height + 1}) {
            for (const int x : {-3, 0, size.width / 2, size.width - 1, size.width + 2}) {
                const bool isInside = x >= 0 && y >= 0 && x < size.width && y < size.height;
                if (mip % 2 == 0 && !isInside)
                    texels.push_back({mip, x, y});
            }
        }
    }
    builder
        .AddCase("outside", DecodeMath::Int8, texels,
                 "texels outside the mip and negative ones: latents are clamped, positional inputs go on")
        .outside = true;
    builder.AddCase("outside-half", DecodeMath::Int8Half, texels, "texels outside the mip and negative ones")
        .outside = true;
}

} // namespace

void AddRequests(SuiteBuilder& builder) {
    AddWholeMips(builder);
    AddSlices(builder);
    AddSlicesOfMips(builder);
    AddOutside(builder);
}

} // namespace openntc::conformance
