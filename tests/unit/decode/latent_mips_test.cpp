// SPDX-License-Identifier: MIT
// Inputs and networks of generations 2 and 3 against a model of its own: exact positions, sums in double, layers in
// 64-bit integers.
#include "LatentMipSets.h"

#include "openntc/core/Half.h"
#include "openntc/decode/ReferenceDecoder.h"

#include <array>
#include <bit>
#include <cmath>
#include <limits>

namespace shader = openntc::shader;
using namespace openntc;
using decode_test::LatentMipSet;
using decode_test::LatentMipShape;

namespace {

/// floor(a / b) and the remainder, b > 0.
struct Quotient {
    std::int64_t whole, rest;
};
Quotient DivideFloor(std::int64_t a, std::int64_t b) {
    const std::int64_t rest = (a % b + b) % b;
    return {(a - rest) / b, rest};
}

/// Taps and weight (of 256, of the second) of a texel of a mip of `size` in a latent mip of `grid`: the exact place
/// is ((2 x + 1) grid - size) / (2 size).
struct Place {
    int first, second;
    double weight;
};
Place FindPlace(int texel, int size, int grid) {
    texel = static_cast<int>(DivideFloor(texel, size).rest);
    const Quotient at = DivideFloor((2 * std::int64_t{texel} + 1) * grid - size, 2 * std::int64_t{size});
    return {static_cast<int>(DivideFloor(at.whole, grid).rest),
            static_cast<int>(DivideFloor(at.whole + 1, grid).rest),
            256.0 * static_cast<double>(at.rest) / (2.0 * size)};
}

/// Where both sides are such that every place is a multiple of 1/256, the model knows the weights.
bool HasExactPlaces(const LatentMipShape& shape) {
    return std::has_single_bit(static_cast<unsigned>(shape.width)) &&
           std::has_single_bit(static_cast<unsigned>(shape.height)) &&
           std::has_single_bit(static_cast<unsigned>(shape.gridSizeScale));
}

double SampleLatent(const LatentMipSet& set, int latentMip, int feature, const Place& x, const Place& y) {
    const double rows[2] = {set.GetCode(latentMip, feature, x.first, y.first) * (256 - x.weight) +
                                set.GetCode(latentMip, feature, x.second, y.first) * x.weight,
                            set.GetCode(latentMip, feature, x.first, y.second) * (256 - x.weight) +
                                set.GetCode(latentMip, feature, x.second, y.second) * x.weight};
    return (rows[0] * (256 - y.weight) + rows[1] * y.weight) / (15.0 * 65536);
}

int QuantizeLatent(int generation, double q) {
    return static_cast<int>(generation == 2 ? std::trunc(255 * q - 127.5) : std::floor(255 * q - 128));
}

/// trunc(127.5 wave); the wave jumps, so that the position is the format's binary32.
int QuantizeSawtooth(float position) {
    const double t = static_cast<double>(position);
    return static_cast<int>(std::trunc(127.5 * (2 * (t - std::floor(t)) - 1)));
}

std::array<int, 48> GetModelInputs(const LatentMipSet& set, int mip, int x, int y) {
    const LatentMipShape& shape = set.GetShape();
    const NtcTextureSetConstants& c = *set.GetSource(DecodeWeights::Int8).constants;
    const NtcColorMipConstants& color = c.colorMips[mip];
    std::array<int, 48> inputs{};
    for (int half = 0; half < 2; ++half) {
        const int latentMip = color.neuralMip + half;
        const int width = GetLatentMipDimension(shape.width, shape.gridSizeScale, latentMip);
        const int height = GetLatentMipDimension(shape.height, shape.gridSizeScale, latentMip);
        const Place column = FindPlace(x, GetMipDimension(shape.width, mip), width);
        const Place row = FindPlace(y, GetMipDimension(shape.height, mip), height);
        for (int feature = 0; feature < shape.features; ++feature)
            inputs[static_cast<std::size_t>(16 * half + feature)] = QuantizeLatent(
                GetGeneration(shape.networkVersion), SampleLatent(set, latentMip, feature, column, row));
    }
    for (int wave = 0; wave < 3; ++wave) {
        const std::size_t at = 32 + 4 * static_cast<std::size_t>(wave);
        const float column = static_cast<float>(x) * color.positionScale * static_cast<float>(1 << wave);
        const float row = static_cast<float>(y) * color.positionScale * static_cast<float>(1 << wave);
        inputs[at] = QuantizeSawtooth(column);
        inputs[at + 1] = QuantizeSawtooth(row);
        inputs[at + 2] = QuantizeSawtooth(column + 0.25f);
        inputs[at + 3] = QuantizeSawtooth(row + 0.25f);
    }
    inputs[44] = inputs[45] = static_cast<int>(std::trunc(127.5 * static_cast<double>(color.positionLod)));
    return inputs;
}

std::array<int, 48> GetInputs(const LatentMipSet& set, int mip, int x, int y) {
    const DecodeSource source = set.GetSource(DecodeWeights::Int8);
    shader::uint words[NTC_MAX_INPUT_WORDS];
    REQUIRE(shader::NtcPrepareNetworkInputs(source.networkVersion, *source.constants,
                                            {source.latents.data(), source.latents.size()}, 0, {x, y}, mip,
                                            words));
    std::array<int, 48> inputs{};
    for (std::size_t i = 0; i < inputs.size(); ++i)
        inputs[i] = shader::NtcSignedByte(words[i / 4], static_cast<shader::uint>(i % 4));
    return inputs;
}

/// The generation's layers behind these inputs, with the activation written as the format says it.
std::array<float, 16> EvaluateModel(int networkVersion, std::span<const std::byte> weights,
                                    std::array<int, 48> first) {
    const NetworkDescription network = GetNetworkDescription(networkVersion);
    const auto load = [&](int at, auto value) {
        std::memcpy(&value, weights.data() + at, sizeof value);
        return value;
    };
    std::vector<int> x(first.begin(), first.end());
    std::array<float, 16> outputs{};
    for (std::size_t layer = 0; layer < 4; ++layer) {
        std::vector<int> y;
        for (int row = 0; row < network.outputs[layer]; ++row) {
            std::int64_t sum = load(network.int8BiasOffsets[layer] + 4 * row, std::int32_t{});
            for (int i = 0; i < network.inputs[layer]; ++i)
                sum += load(network.weightOffsets[layer] + row * network.inputs[layer] + i, std::int8_t{}) *
                       x[static_cast<std::size_t>(i)];
            float z = static_cast<float>(sum) * load(network.int8ScaleOffsets[layer] + 4 * row, float{});
            if (network.generation == 2)
                z = HalfToFloat(FloatToHalf(z));
            if (layer == 3) {
                outputs[static_cast<std::size_t>(row)] = z;
            } else if (network.generation == 2) {
                y.push_back(static_cast<std::int8_t>(shader::NtcActivateHalf(z)));
            } else {
                volatile float third = z * 0.333333f;
                const float gate = std::clamp(third + 0.5f, 0.0f, 1.0f);
                volatile float activated = std::min(z, 3.0f) * gate;
                y.push_back(static_cast<int>(std::nearbyint(activated * 80.0f)) - 113);
            }
        }
        x = y;
    }
    return outputs;
}

template <typename Visit>
void VisitTexels(const LatentMipShape& shape, Visit visit) {
    for (int mip = 0; mip < shape.mips; ++mip) {
        for (int y = 0; y < GetMipDimension(shape.height, mip); ++y) {
            for (int x = 0; x < GetMipDimension(shape.width, mip); ++x)
                visit(mip, x, y);
        }
    }
}

} // namespace

TEST_CASE("generation 3: requantisation of every finite half equals the format specification's CRC") {
    std::vector<std::byte> bytes;
    for (const std::uint32_t sign : {0u, 0x8000u}) {
        for (std::uint32_t magnitude = 0; magnitude < 0x7C00u; ++magnitude)
            bytes.push_back(static_cast<std::byte>(shader::NtcActivateFloatThenRound(
                HalfToFloat(static_cast<std::uint16_t>(sign | magnitude)))));
    }
    CHECK(Crc32(bytes) == 0x93390bfbu);
    const float infinity = std::numeric_limits<float>::infinity();
    const float nan = std::numeric_limits<float>::quiet_NaN();
    for (const float z : {-infinity, -3e38f, nan, -nan})
        CHECK(static_cast<std::int8_t>(shader::NtcActivateFloatThenRound(z)) == -113);
    for (const float z : {infinity, 3e38f, 3.0f})
        CHECK(static_cast<std::int8_t>(shader::NtcActivateFloatThenRound(z)) == 127);
}

TEST_CASE("generations 2 and 3: a flat field of a code gives the byte of the code") {
    for (unsigned code = 0; code < 16; ++code) {
        const shader::NtcLatentTexels texels = {code * 0x1111u, code * 0x1111u, code * 0x1111u,
                                                code * 0x1111u};
        for (const shader::uint weight : {0u, 1u, 128u, 255u, 256u}) {
            const auto weights = shader::NtcMakeLatentWeights(weight, 256u - weight / 2u);
            const shader::uint third =
                shader::NtcBlendLatentTexels(NTC_NETWORK_GENERATION_3, texels, weights);
            const shader::uint second =
                shader::NtcBlendLatentTexels(NTC_NETWORK_GENERATION_2, texels, weights);
            for (shader::uint i = 0; i < 4; ++i) {
                CHECK(shader::NtcSignedByte(third, i) == 17 * static_cast<int>(code) - 128);
                CHECK(shader::NtcSignedByte(second, i) ==
                      static_cast<int>(17 * static_cast<int>(code) - 127.5));
            }
        }
    }
}

TEST_CASE(
    "generations 2 and 3: latents of a texture in steps of 1/255, generation 3 with 1/16 of a step above") {
    for (int step = 0; step < 256; ++step) {
        CAPTURE(step);
        const float q = static_cast<float>(step) / 255.0f;
        const float below =
            std::max(static_cast<float>(step) - 0.07f, 0.0f) / 255.0f; // more than 1/16 and 1/256 of a step
        const shader::uint third =
            shader::NtcQuantizeLatents(NTC_NETWORK_GENERATION_3, shader::float4(q, below, q, q));
        CHECK(shader::NtcSignedByte(third, 0) == step - 128);
        CHECK(shader::NtcSignedByte(third, 1) == std::max(step - 1, 0) - 128);
        CHECK(shader::NtcSignedByte(third, 2) == step - 128);
        CHECK(shader::NtcSignedByte(third, 3) == step - 128);
        const shader::uint second =
            shader::NtcQuantizeLatents(NTC_NETWORK_GENERATION_2, shader::float4(q, q, q, q));
        CHECK(shader::NtcSignedByte(second, 0) == static_cast<int>(step - 127.5));
    }
}

TEST_CASE("generations 2 and 3: sawtooth wave and truncation of inputs") {
    const struct {
        float t, wave;
    } waves[] = {{0, -1}, {0.25f, -0.5f}, {0.5f, 0},       {0.75f, 0.5f},
                 {1, -1}, {-0.25f, 0.5f}, {7.125f, -0.75f}};
    for (const auto& check : waves) {
        CAPTURE(check.t);
        CHECK(shader::NtcSawtoothWave(check.t) == check.wave);
    }
    const float infinity = std::numeric_limits<float>::infinity();
    for (const float t : {8388608.0f, infinity, -infinity, std::numeric_limits<float>::quiet_NaN()})
        CHECK(shader::NtcSawtoothWave(t) == -1.0f);
    CHECK(shader::NtcTruncateInput(-1.0f) == 0x81u);
    CHECK(shader::NtcTruncateInput(0.75f) == 95u);
    CHECK(shader::NtcTruncateInput(-0.75f) == (256u - 95u));
    CHECK(shader::NtcTruncateInput(1.5f) == 191u); // not clamped: a byte that wraps
    CHECK(shader::NtcTruncateInput(infinity) == 0u);
    CHECK(shader::NtcTruncateInput(-3e38f) == 0u);
    CHECK(shader::NtcTruncateInput(std::numeric_limits<float>::quiet_NaN()) == 0u);
}

TEST_CASE("generations 2 and 3: inputs are those of the model") {
    for (const LatentMipShape& shape : decode_test::kLatentMipShapes) {
        CAPTURE(shape.seed);
        const LatentMipSet set(shape);
        const bool isExact = HasExactPlaces(shape);
        int differences = 0, largest = 0;
        VisitTexels(shape, [&](int mip, int x, int y) {
            const auto expected = GetModelInputs(set, mip, x, y);
            const auto inputs = GetInputs(set, mip, x, y);
            for (std::size_t i = 0; i < 48; ++i) {
                differences += inputs[i] != expected[i];
                largest = std::max(largest, std::abs(inputs[i] - expected[i]));
            }
        });
        if (isExact)
            CHECK(differences == 0);
        // A weight is half a step of 1/256 off at most, and binary32 less than 2^-8 of that: 255 / 512 of a byte per axis
        // and its product, then the two floors.
        CHECK(largest <= 2);
    }
}

TEST_CASE("generations 2 and 3: texels outside wrap in the latents, and slices decode as the whole") {
    LatentMipSet set({11, NTC_NETWORK_GENERATION_3, 64, 48, 4, 4, 12});
    for (const auto& [x, y] : {std::pair{-1, 0}, {64, 47}, {-129, 500}, {1000003, -4000001}}) {
        const auto outside = GetInputs(set, 0, x, y);
        const auto inside = GetInputs(set, 0, static_cast<int>(DivideFloor(x, 64).rest),
                                      static_cast<int>(DivideFloor(y, 48).rest));
        CHECK(std::equal(outside.begin(), outside.begin() + 32, inside.begin()));
    }
    // A slice of three columns from the last one on, and one of three rows: texels whose taps they hold.
    const LatentMipSet whole = set;
    NtcTextureSetConstants& c = set.GetConstants();
    for (NtcNeuralMipConstants* grid : {&c.highResNeuralMips[0], &c.lowResNeuralMips[0]}) {
        const unsigned width = grid->imageWidthHeight & 0xFFFFu;
        const unsigned height = grid->imageWidthHeight >> 16;
        const unsigned layers = 3, left = width - 1, top = height - 1;
        std::vector<std::byte> slice;
        for (unsigned layer = 0; layer < layers; ++layer) {
            for (unsigned y = 0; y < 3; ++y) {
                for (unsigned x = 0; x < 3; ++x) {
                    const unsigned texel = (layer * height + (top + y) % height) * width + (left + x) % width;
                    const auto at = set.GetLatents().begin() + grid->dataOffset + 2 * texel;
                    slice.insert(slice.end(), at, at + 2);
                }
            }
        }
        grid->dataOffset = static_cast<std::uint32_t>(set.GetLatents().size());
        grid->sliceLeftTop = top << 16 | left;
        grid->sliceWidthHeight = 3u << 16 | 3u;
        set.GetLatents().insert(set.GetLatents().end(), slice.begin(), slice.end());
        set.GetLatents().resize((set.GetLatents().size() + 3) / 4 * 4);
    }
    const DecodeSource source = set.GetSource(DecodeWeights::Int8);
    REQUIRE(ValidateDecodeSource(source));
    for (int y = 0; y < 6; ++y) {
        for (int x = 0; x < 6; ++x)
            CHECK(GetInputs(set, 0, x, y) == GetInputs(whole, 0, x, y));
    }
    for (int x = 0; x < 64; ++x) // beyond: some texels of the slice, and no other memory
        GetInputs(set, 0, x, 40);
}

TEST_CASE("generations 2 and 3: the Int8 network of every texel equals the model") {
    for (const LatentMipShape& shape : decode_test::kLatentMipShapes) {
        CAPTURE(shape.seed);
        const LatentMipSet set(shape);
        const DecodeSource source = set.GetSource(DecodeWeights::Int8);
        int differences = 0;
        VisitTexels(shape, [&](int mip, int x, int y) {
            float outputs[16];
            REQUIRE(DecodeReference(source, mip, {x, y, 1, 1}, {}, outputs));
            const auto expected =
                EvaluateModel(shape.networkVersion, source.weights, GetInputs(set, mip, x, y));
            for (std::size_t c = 0; c < 16; ++c)
                differences +=
                    std::bit_cast<std::uint32_t>(outputs[c]) != std::bit_cast<std::uint32_t>(expected[c]);
        });
        CHECK(differences == 0);
    }
}

TEST_CASE("generations 2 and 3: sources that decoders refuse") {
    LatentMipSet set({12, NTC_NETWORK_GENERATION_3, 32, 32, 4, 4, 8});
    NtcTextureSetConstants& c = set.GetConstants();
    const auto getError = [&] {
        const auto result = ValidateDecodeSource(set.GetSource(DecodeWeights::Int8));
        return result ? std::string() : std::string(result.error().GetText());
    };
    CHECK(getError().empty());
    c.highResEncoding.quantBits = 2;
    CHECK(getError() == "high-res quantBits: 2: must be 4 in generations 2 and 3");
    c.highResEncoding.quantBits = 4;
    c.lowResEncoding.quantizedScale = 17;
    CHECK(getError() == "low-res encoding: scale 17, bias 0: must be 0 and 0");
    c.lowResEncoding.quantizedScale = 0;
    c.lowResEncoding.numFeatures = 4;
    CHECK(getError() == "low-res features: 4: must be the 8 of the finer latent mip");
    c.lowResEncoding.numFeatures = 8;
    c.lowResNeuralMips[0].sliceLeftTop = 4;
    CHECK(getError() == "latent image 0 low-res slice: 4,0,4,4: must lie inside the grid (4x4)");
    c.lowResNeuralMips[0].sliceLeftTop = 3; // wraps
    CHECK(getError().empty());
    c.lowResNeuralMips[0].dataOffset += 4u * static_cast<unsigned>(set.GetLatents().size());
    CHECK(getError().starts_with("latent image 0 low-res end:"));
}
