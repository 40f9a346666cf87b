// SPDX-License-Identifier: MIT
// What the suite promises to cover: the ends of every field of the format, and pairs that share code.
#include "SuiteCoverage.h"

#include "../Output.h"

#include <limits>

namespace openntc::conformance {

using tool::Format;

std::vector<std::string> ListPromises() {
    std::vector<std::string> list;
    const auto add = [&](std::string what) { list.push_back(std::move(what)); };
    for (const int generation : {1, 2, 3})
        add(Format("generation: %d", generation));
    for (const char* axis : {"width", "height"}) {
        for (const char* value : {"1", "16384", "odd", "even"})
            add(std::string(axis) + ": " + value);
    }
    for (const char* what : {"wide", "high", "square"})
        add(what);
    for (const int channels : {1, 3, 10, 16})
        add(Format("channels: %d", channels));
    for (const int mips : {1, 2, 3, 15})
        add(Format("mips: %d", mips));
    for (const int images : {1, 2, 3, 4, 8})
        add(Format("latent images: %d", images));
    for (int image = 0; image < 8; ++image)
        add(Format("latent image: %d", image));
    for (int mip = 0; mip < 15; ++mip)
        add(Format("mip: %d", mip));
    add("latent image before that of a finer mip");
    for (int scale = 2; scale <= 8; ++scale)
        add(Format("grid scale %d with several latent images", scale));

    struct Factor {
        const char* name;
        std::vector<int> values;
    };
    const Factor factors[] = {{"high features", {4, 8, 12, 16}},
                              {"high bits", {1, 2, 4, 8}},
                              {"low features", {4, 8, 12, 16}},
                              {"low bits", {1, 2, 4, 8}},
                              {"network", {1, 2, 3, 4}}};
    for (std::size_t a = 0; a < std::size(factors); ++a) {
        for (std::size_t b = a + 1; b < std::size(factors); ++b) {
            for (const int x : factors[a].values) {
                for (const int y : factors[b].values) {
                    if (a != 0 || b != 4 || x <= 4 * y) // the network has room for them
                        add(Format("%s %d with %s %d", factors[a].name, x, factors[b].name, y));
                }
            }
        }
    }
    for (const char* grid : {"high grid", "low grid"}) {
        for (const int side : {1, 2}) {
            add(Format("%s width: %d", grid, side));
            add(Format("%s height: %d", grid, side));
        }
        add(std::string(grid) + ": finer than the image");
        for (const int bits : {1, 2, 4, 8}) {
            for (int code = 0; code < 1 << bits; ++code)
                add(Format("%s code of %d bits: %d", grid, bits, code));
        }
    }
    for (const char* grid :
         {"high grid width: 8192", "high grid height: 8192", "low grid width: 4096", "low grid height: 4096"})
        add(grid);
    add("high grid: rows of broken bytes");
    add("low grid: rows of broken bytes");
    add("high grid: more than 65536 bytes");
    for (int layer = 0; layer < 4; ++layer) {
        const auto addOf = [&](const char* what, const std::string& value) {
            add(Format("layer %d %s: %s", layer, what, value.c_str()));
        };
        for (int weight = -128; weight < 128; ++weight)
            addOf("weight", std::to_string(weight));
        for (const char* bias : {"-2147483648", "2147483647"})
            addOf("bias", bias);
        for (const float scale :
             {std::numeric_limits<float>::max(), -std::numeric_limits<float>::max(),
              std::numeric_limits<float>::min(), -std::numeric_limits<float>::min(), 0.0f, -0.0f})
            addOf("scale", NameFloat(scale));
        addOf("scale", "negative");
        for (int code = 0; layer < 3 && code < 256; ++code) {
            if ((code & 127) != 127) // NaN: readers refuse it
                addOf("E4M3 weight", Format("%02x", static_cast<unsigned>(code)));
        }
        for (const char* bias : {"7bff", "fbff", "0001", "8001", "03ff", "0400", "8000"}) {
            if (layer < 3)
                addOf("half bias", bias);
        }
    }
    add("layer 3 scale: subnormal");
    for (const char* end : {"below -1", "negative", "0", "0 to 1", "1", "above 1", "above 448"})
        add(std::string("positionLod: ") + end);
    for (const char* end : {"negative", "0", "below 1", "1", "above 1", "2^100"})
        add(std::string("positionScale: ") + end);
    for (const char* column : {"before", "first", "inside", "last", "beyond"}) {
        for (const char* row : {"before", "first", "inside", "last", "beyond"}) {
            add(std::string("texel: column ") + column + ", row " + row);
        }
    }
    for (const char* what :
         {"texel: column only, row only", "texel: column only, row inside", "texel: column inside, row only",
          "texel: x above 16000", "texel: y above 16000"})
        add(what);
    for (const char* math : {"int8", "int8_half", "fp8", "fp16", "fp32"}) {
        for (int network = 1; network <= 4; ++network)
            add(Format("%s in network %d", math, network));
    }
    for (const char* math : {"int8", "int8_half"}) {
        for (const char* kind : {"texels", "mip", "slice", "slice_mips", "outside"})
            add(std::string(math) + " by " + kind);
        add(std::string(math) + " linear");
        for (const char* value : {"inf", "-inf", "0", "-0", "65504"})
            add(std::string(math) + " output: " + value);
    }
    add("int8 output: " + NameFloat(std::numeric_limits<float>::max()));
    for (int channel = 0; channel < 16; ++channel) {
        for (int space = 0; space < 3; ++space)
            add(Format("channel %d in colour space %d, linear", channel, space));
        if (channel > 0)
            add(Format("channel %d undeclared, linear", channel));
    }
    for (const char* form :
         {"data before JSON", "JSON before data", "gap between chunks", "no gap between chunks", "NUL",
          "no NUL", "views out of order", "gap between views"})
        add(std::string("form: ") + form);
    for (const char* member : {"lacks /mlp",
                               "lacks /mlpVersions",
                               "has /mlpVersions",
                               "lacks /channels",
                               "lacks /textures",
                               "lacks /numColorMips",
                               "lacks /mlp/layers/scaleView",
                               "lacks /mlp/layers/weightType",
                               "lacks /mlp/activation",
                               "lacks /colorMips/positionLod",
                               "lacks /colorMips/positionScale",
                               "lacks /colorMips/width",
                               "has /mlp/weightType",
                               "has /mlp/scaleBiasType",
                               "has /mlp/layers/scaleBiasType",
                               "has /channels/scale",
                               "has /channels/bias",
                               "has /x-vendor",
                               "/mlp/layers/weightType: FloatE4M3",
                               "/mlp/layers/weightType: Int8",
                               "/mlp/scaleBiasType: Float32",
                               "/mlp/layers/scaleBiasType: Float32",
                               "/mlpVersions/layers/biasType: Float32"})
        add(member);
    for (const char* format : {"UNKNOWN", "UNORM8", "UNORM16", "FLOAT16", "FLOAT32", "UINT32"})
        add(std::string("/textures/channelFormat: ") + format);
    for (const char* format : {"None", "BC1", "BC2", "BC3", "BC4", "BC5", "BC6", "BC7"})
        add(std::string("/textures/bcFormat: ") + format);
    for (const char* space : {"Linear", "sRGB", "HLG"}) {
        add(std::string("/textures/rgbColorSpace: ") + space);
        add(std::string("/textures/alphaColorSpace: ") + space);
    }
    return list;
}

} // namespace openntc::conformance
