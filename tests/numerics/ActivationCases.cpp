// SPDX-License-Identifier: MIT
// The activation, exhaustively and through whole decoders: a row with zero weights, bias 1 and scale z makes the value z.
#include "Decoders.h"
#include "HardCases.h"

#include "openntc/core/Crc32.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace numerics {

namespace {

using namespace openntc;
using conformance::RoundToBinary32;
using conformance::RoundToHalf;
using conformance::WidenHalf;

// Format specification, network 3.3 and 3.4, in double precision.
int GetByte(double z, bool half, bool contracted = false) {
    const auto round = [half](double x) { return half ? RoundToHalf(x) : RoundToBinary32(x); };
    const double third = half ? 0.333251953125 : static_cast<double>(std::bit_cast<float>(0x3eaaaaabu));
    z = round(z);
    if (z <= -1.5)
        return -113;
    if (z >= 3)
        return 127;
    const double gate =
        std::clamp(contracted ? round(std::fma(third, z, 0.5)) : round(round(third * z) + 0.5), 0.0, 1.0);
    const double y = round(z * gate);
    const double t = contracted ? round(std::fma(y, 80.0, -113.0)) : round(round(y * 80) - 113);
    return static_cast<int>(std::nearbyint(t));
}

std::vector<float> ListHalves() {
    std::vector<float> values;
    for (const unsigned sign : {0u, 0x8000u}) {
        for (unsigned code = 0; code < 0x7C00; ++code)
            values.push_back(static_cast<float>(WidenHalf(sign | code)));
    }
    return values;
}

// Runs the values through all decoders, 32 in a texture set. Returns the largest difference of an activation.
double MeasureThroughDecoders(std::span<const float> values, DecodeMath math) {
    conformance::EditableSet editable = MakeOneTexelSet();
    PrepareActivations(editable);
    const TestSet set(conformance::WriteSet(editable));
    const tool::DecodeData base = set.GetData(math);
    const Texel texel;
    double worst = 0;
    for (TestDecoder& decoder : GetDecoders()) {
        for (std::size_t first = 0; first < values.size(); first += 32) {
            std::array<float, 32> z{};
            std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(first),
                        std::min<std::size_t>(32, values.size() - first), z.begin());
            auto data = std::make_shared<tool::DecodeData>(base);
            SetActivations(*data, z);
            if (!decoder.Take(data))
                break;
            const Outputs outputs = decoder.Decode({math, false}, set, std::span(&texel, 1)).front();
            for (std::size_t c = 0; c < 16; ++c) {
                const bool half = math == DecodeMath::Int8Half;
                const int expected = GetByte(static_cast<double>(z[c]), half) +
                                     15 * GetByte(static_cast<double>(z[16 + c]), half);
                // Up to 2048 integers are exact in binary16.
                worst = std::max(worst, std::fabs(static_cast<double>(outputs[c]) - expected));
            }
        }
    }
    return worst;
}

Measurement MeasureEveryHalf() {
    const std::vector<float> halves = ListHalves();
    std::vector<std::byte> bytes;
    std::vector<std::byte> floatBytes;
    for (const float z : halves) {
        bytes.push_back(static_cast<std::byte>(GetByte(static_cast<double>(z), true) & 255));
        floatBytes.push_back(static_cast<std::byte>(GetByte(static_cast<double>(z), false) & 255));
    }
    // The format specification's CRC-32s of both epilogues over all finite halves.
    if (Crc32(bytes) != 0xb7293f8e || Crc32(floatBytes) != 0xd67d5454)
        return {256, "the formula here is not the specification's"};
    return {MeasureThroughDecoders(halves, DecodeMath::Int8Half), std::to_string(halves.size()) + " halves"};
}

// Every binary32 at which the integer changes, with its neighbours: on either side of the minimum at -3/4 the integer is
// monotone, so bisection over bit patterns finds them all.
Measurement MeasureBoundaries() {
    std::vector<float> values = {0.0f, -0.0f, -0.75f, 1.5f, 3.0f, -1.5f, 0x1p-149f, 3e38f, -3e38f};
    const auto addBoundaries = [&values](double from, double to) {
        const int first = GetByte(from, false);
        const int last = GetByte(to, false);
        const int step = first < last ? 1 : -1;
        for (int byte = first; byte != last; byte += step) {
            double low = from;
            double high = to;
            for (int i = 0; i < 60; ++i) {
                const double middle = RoundToBinary32((low + high) / 2);
                ((GetByte(middle, false) - byte) * step > 0 ? high : low) = middle;
            }
            float value = static_cast<float>(low);
            for (int i = 0; i < 4; ++i)
                value = std::nextafterf(value, static_cast<float>(from));
            for (int i = 0; i < 9; ++i) {
                values.push_back(value);
                value = std::nextafterf(value, static_cast<float>(to));
            }
        }
    };
    addBoundaries(-1.4999, -0.75);
    addBoundaries(-0.75, 2.9999);
    return {MeasureThroughDecoders(values, DecodeMath::Int8), std::to_string(values.size()) + " values"};
}

// binary32 numbers half-way between two halves, and beside: rounding to half twice or by truncation differs.
Measurement MeasureHalfConversion() {
    std::vector<float> values = {65504.0f, 65519.996f, 65520.0f, 1e6f, -65504.0f, -65520.0f, -1e6f, 0x1p-25f};
    for (unsigned code = 0x2C00; code < 0x4200; code += 11) {
        for (const float sign : {1.0f, -1.0f}) {
            const float middle = sign * static_cast<float>((WidenHalf(code) + WidenHalf(code + 1)) / 2);
            for (const float value :
                 {middle, std::nextafterf(middle, 10.0f), std::nextafterf(middle, -10.0f)})
                values.push_back(value);
        }
    }
    return {MeasureThroughDecoders(values, DecodeMath::Int8Half), std::to_string(values.size()) + " values"};
}

// Sums +-2^31 times scales +-3e38: infinities in binary32 and, from 65520 on, in binary16.
Measurement MeasureInfinities() {
    conformance::EditableSet set = MakeOneTexelSet();
    PrepareActivations(set);
    for (std::size_t row = 0; row < 32; ++row) {
        set.SetInt8Bias(2, row, row % 2 == 0 ? std::numeric_limits<std::int32_t>::min() : 1 << 30);
        set.SetInt8Scale(2, row, row % 4 < 2 ? 3e38f : row % 8 < 4 ? -3e38f : 1e-4f);
    }
    const TestSet written(conformance::WriteSet(set));
    const Texel texel;
    return {std::max(Compare(written, DecodeMath::Int8, std::span(&texel, 1)),
                     Compare(written, DecodeMath::Int8Half, std::span(&texel, 1))),
            {}};
}

// How much contraction would change: the exhaustive count is the specification's order of magnitude, and bit-equal
// decoders do not do it.
Measurement MeasureContraction() {
    int changed = 0;
    int largest = 0;
    for (const float z : ListHalves()) {
        const int difference =
            std::abs(GetByte(static_cast<double>(z), true, true) - GetByte(static_cast<double>(z), true));
        changed += difference != 0 ? 1 : 0;
        largest = std::max(largest, difference);
    }
    return {static_cast<double>(largest),
            std::to_string(changed) + " of 63488 halves would change, by at most " + std::to_string(largest)};
}

// The activation in binary32 with every operation rounded in one direction, over all halves: how far the integer may be
// from the specified one on a device that rounds so. The requantisation's addition of 1.5 * 2^23 then truncates too.
Measurement MeasureRoundingDirection() {
    const auto towardZero = [](double x) {
        const float nearest = static_cast<float>(x);
        return std::fabs(static_cast<double>(nearest)) > std::fabs(x)
                   ? static_cast<double>(std::nextafterf(nearest, 0.0f))
                   : static_cast<double>(nearest);
    };
    const double third = static_cast<double>(std::bit_cast<float>(0x3eaaaaabu));
    int changed = 0;
    int largest = 0;
    for (const float half : ListHalves()) {
        const double z = static_cast<double>(half);
        if (z <= -1.5 || z >= 3)
            continue; // settled by comparison
        const double gate = std::clamp(towardZero(towardZero(third * z) + 0.5), 0.0, 1.0);
        const double t = towardZero(towardZero(towardZero(z * gate) * 80) - 113);
        const int byte = static_cast<int>(towardZero(t + 12582912.0) - 12582912.0);
        const int difference = std::abs(byte - GetByte(z, false));
        changed += difference != 0 ? 1 : 0;
        largest = std::max(largest, difference);
    }
    return {static_cast<double>(largest),
            std::to_string(changed) + " of 63488 halves would change, by at most " + std::to_string(largest)};
}

constexpr HardCase kActivationCases[] = {
    {"every-half",
     "All 63 488 finite halves through activation and requantisation of the half epilogue; 1 333 are exact "
     "ties.",
     "round() that rounds half away (666 changes), conversions that truncate.",
     "The integer comes from adding 1.5 * 2^23, which rounds to nearest even on any IEEE device.", 0,
     MeasureEveryHalf},
    {"requantisation-boundaries",
     "Every binary32 at which the float epilogue's integer changes, and four neighbours on both sides.",
     "Contraction, reassociation, a third that is not 0x3eaaaaab, offset -112.",
     "Precise qualifiers; every operation rounded once.", 0, MeasureBoundaries},
    {"half-conversion",
     "Numbers half-way between halves, beside them, at the overflow to infinity and below the subnormals.",
     "f32 to f16 conversion, whose rounding shading languages leave to the driver; double rounding.",
     "Conversion is done with integer operations, not by the driver.", 0, MeasureHalfConversion},
    {"infinite-activations",
     "-infinity times a gate of 0 is NaN, and NaN to integer is 0 on one device and INT_MIN on another: y = "
     "1.41 in place "
     "of 0.",
     "LibNTC's half epilogue beyond 65504.",
     "z <= -1.5 gives -113 by comparison. Files whose sums stay below 65504 do not notice.", 0,
     MeasureInfinities},
    {"contraction",
     "A fused multiply-add in the activation. The bound is what a contracting decoder may differ by in one "
     "activation.",
     "Compilers are free to fuse unless told not to.",
     "Every OpFAdd and OpFSub of every decoding shader, in GLSL and HLSL, is NoContraction, but for three of "
     "the "
     "conversions to linear light, which have a bound of their own: a test reads it out of the SPIR-V "
     "(tests/shader/modes_float_controls_test.cpp). Separate statements in C++.",
     1, MeasureContraction},
    {"rounding-direction",
     "Operations that round toward zero. The bound is what such a device may differ by in one activation.",
     "Vulkan lets a device round to either neighbour unless a shader asks for RoundingModeRTE; hosts whose "
     "rounding mode was changed.",
     "Cannot differ by construction: latents and their weights, dot products and biases (integers), texel "
     "coordinates (the quotient is corrected by integers), binary16 (rounded by integer operations), "
     "minimum, maximum "
     "and comparisons, conversions of sums below 2^24. Rounded by the device: the product with the scale, "
     "and "
     "the activation with its requantisation. INT8 and INT8_HALF keep their bits with RoundingModeRTE "
     "declared, "
     "which is dispatched wherever the device offers it; declare it where the default is in doubt.",
     1, MeasureRoundingDirection},
};

} // namespace

std::span<const HardCase> ListActivationCases() {
    return kActivationCases;
}

} // namespace numerics
