// SPDX-License-Identifier: MIT
// Every public shader function on the device against the C++ build of the same source: bit for bit, except
// colour maths (cases 15 and 16), which are compared with a binary64 model within the error that Vulkan
// allows.
#include "shader/TestDevice.h"
#include "unit/decode/SpecificationSets.h"

#include "entries/FunctionCases.h"
#include "function_shaders.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>

using namespace openntc;
using namespace openntc::harness;

namespace {

constexpr std::uint32_t kExactCases = 15; // 0 ... 14
constexpr std::uint32_t kColorCase = 15;
constexpr std::uint32_t kColorSelectCase = 16;

struct Case {
    std::uint32_t number, a, b, c, d;
};

/// Edges of floats and integers: zeros, subnormals, thresholds and their neighbours, infinities, NaN of both
/// signs.
constexpr std::uint32_t kEdges[] = {
    0,          1,          2,          127,        128,        255,        0x007FFFFF,
    0x00800000, 0x33000000, 0x33800000, 0x387FC000, 0x38800000, 0x3B4D2E1C, 0x3D25AEE6,
    0x3E800000, 0x3EFFFFFF, 0x3F000000, 0x3F800000, 0x3FBFFFFF, 0x3FC00000, 0x403FFFFF,
    0x40400000, 0x42FE0000, 0x43000000, 0x477FE000, 0x477FEFFF, 0x477FF000, 0x4AFFFFFF,
    0x4B000000, 0x4F000000, 0x7F7FFFFF, 0x7F800000, 0x7F800001, 0x7FC00000, 0x7FFFFFFF,
    0x80000000, 0x80000001, 0x80800000, 0xBF000000, 0xBFBFFFFF, 0xBFC00000, 0xBFC00001,
    0xC0400000, 0xC3000000, 0xFF7FFFFF, 0xFF800000, 0xFF800001, 0xFFC00000, 0xFFFFFFFF};

/// True where FunctionCases.h returns a float: subnormal numbers may be flushed there and NaN has no fixed
/// payload.
bool IsFloatResult(std::uint32_t number, std::size_t word) {
    switch (number) {
    case 0:
    case 3:
    case 4:
    case 6:
        return word == 0;
    case 8:
        return word == 2;
    case 13:
        return word >= 1;
    case 14:
        return word >= 2;
    default:
        return false;
    }
}

std::uint32_t GetComparable(std::uint32_t bits, bool isFloat) {
    if (isFloat && (bits & 0x7FFFFFFFu) > 0x7F800000u)
        return 0x7FC00000u;
    return isFloat && (bits & 0x7F800000u) == 0 ? bits & 0x80000000u : bits;
}

bool IsSubnormal(std::uint32_t bits) {
    return (bits & 0x7F800000u) == 0 && (bits & 0x007FFFFFu) != 0;
}

/// True where the languages fix the result: a device may take subnormal factors as zero, and converting NaN or
/// an infinity to an integer gives anything. Positions come from NtcTexelCenter: finite, at most 2^22.
bool IsResultFixed(const Case& item) {
    const auto isPosition = [](std::uint32_t bits) {
        const float position = std::bit_cast<float>(bits);
        return position >= -0x1p22f && position <= 0x1p22f;
    };
    switch (item.number) {
    case 0:
        return !IsSubnormal(item.a) && !IsSubnormal(item.b);
    case 8:
        return isPosition(item.a);
    case 9:
        return isPosition(item.a) && isPosition(item.b);
    default:
        return true;
    }
}

std::vector<Case> MakeExactCases() {
    std::vector<Case> cases;
    std::uint32_t state = 12345;
    const auto next = [&state] {
        state = state * 1664525u + 1013904223u;
        return (state >> 16) | (state * 747796405u & 0xFFFF0000u);
    };
    for (std::uint32_t number = 0; number < kExactCases; ++number) {
        const int count = number >= 12 ? 600 : 3000; // whole network evaluations are slow
        for (const std::uint32_t edge : kEdges)
            cases.push_back({number, edge, kEdges[next() % std::size(kEdges)], next(), next()});
        for (int i = 0; i < count; ++i) {
            // Half of the first words are floats of moderate size, the rest any bits.
            const std::uint32_t a =
                i % 2 == 0 ? (next() & 0x807FFFFFu) | ((110u + next() % 30u) << 23) : next();
            const std::uint32_t b = next();
            // Of the second words of grids, which are positions too, three in four.
            const std::uint32_t position = (b & 0x807FFFFFu) | ((110u + b % 30u) << 23);
            cases.push_back({number, a, number == 9 && i % 4 != 0 ? position : b, next(), next()});
        }
    }
    return cases;
}

std::vector<std::uint32_t> RunOnDevice(Context& context, const decode_test::SpecificationSet& set,
                                       std::span<const Case> cases, const char* defines) {
    const auto words = function_shaders::FindShader("Functions.comp", defines);
    REQUIRE_MESSAGE(words.has_value(), std::string(words.error().GetText()));
    const std::uint32_t count = static_cast<std::uint32_t>(cases.size());
    const auto constants = context.CreateBuffer(std::as_bytes(std::span(&set.constants, 1)),
                                                BufferKind::Uniform, BufferMemory::HostVisible);
    const auto latents = context.CreateBuffer(set.latents, BufferKind::Storage, BufferMemory::HostVisible);
    const auto weights = context.CreateBuffer(set.weights, BufferKind::Storage, BufferMemory::HostVisible);
    const auto input =
        context.CreateBuffer(std::as_bytes(cases), BufferKind::Storage, BufferMemory::HostVisible);
    const auto output =
        context.CreateBuffer(cases.size() * 16, BufferKind::Storage, BufferMemory::HostVisible);
    REQUIRE((constants && latents && weights && input && output));
    const BufferSlot slots[] = {{0, BufferKind::Uniform},
                                {1, BufferKind::Storage},
                                {2, BufferKind::Storage},
                                {3, BufferKind::Storage},
                                {4, BufferKind::Storage}};
    const auto pipeline = context.CreateComputePipeline(*words, slots, 4);
    REQUIRE_MESSAGE(pipeline.has_value(), std::string(pipeline.error().GetText()));
    const BoundBuffer bound[] = {
        {0, &*constants}, {1, &*latents}, {2, &*weights}, {3, &*input}, {4, &*output}};
    DispatchRequest request;
    request.pipeline = &*pipeline;
    request.buffers = bound;
    request.pushConstants = std::as_bytes(std::span(&count, 1));
    request.groups[0] = (count + 63) / 64;
    const auto timing = context.Dispatch(request);
    REQUIRE_MESSAGE(timing.has_value(), std::string(timing.error().GetText()));
    std::vector<std::uint32_t> results(cases.size() * 4);
    REQUIRE(context.Read(*output, 0, std::as_writable_bytes(std::span(results))));
    return results;
}

std::vector<std::uint32_t> RunInCpp(const decode_test::SpecificationSet& set, std::span<const Case> cases) {
    std::vector<std::uint32_t> results;
    for (const Case& item : cases) {
        std::uint32_t r[4];
        shader::RunCase(set.constants, {set.latents.data(), set.latents.size()},
                        {set.weights.data(), set.weights.size()}, item.number, item.a, item.b, item.c, item.d,
                        r);
        results.insert(results.end(), r, r + 4);
    }
    return results;
}

/// A binary64 value with the largest error a conforming device may make.
struct Bounded {
    double value, error;
};

// Vulkan's precision (specification, "Precision and Operation of SPIR-V Instructions"), with u = 2^-23 for
// one ULP: division 2.5 u; exp and exp2 (3 + 2|x|) u; log and log2 3 u, but 2^-21 absolute in [0.5, 2];
// pow(x, y) = exp2(y log2 x); sqrt = 1 / inversesqrt: 2 u + 2.5 u; +, -, * u/2. First-order sums of these
// follow, times 1.01 for second order. Subnormal inputs may be flushed: an absolute 2^-63 (sqrt of 2^-126)
// covers that.
constexpr double kU = 0x1p-23;
constexpr double kSlack = 0x1p-63;

double GetLogError(double logarithm) {
    return std::max(3 * kU * std::fabs(logarithm), 0x1p-21);
}

/// pow(base, exponent) where base and exponent have the relative errors given.
Bounded GetPow(double base, double baseError, double exponent, double exponentError) {
    const double logarithm = std::log2(base);
    const double x = exponent * logarithm;
    const double xError = std::fabs(exponent) * (baseError / std::log(2.0) + GetLogError(logarithm)) +
                          std::fabs(x) * (exponentError + kU / 2);
    const double value = std::exp2(x);
    return {value, value * (std::log(2.0) * xError + (3 + 2 * std::fabs(x)) * kU)};
}

Bounded DecodeSrgb(double c) {
    if (c <= double{0.04045f})
        return {c / double{12.92f}, std::fabs(c) * kU};
    return GetPow((c + double{0.055f}) / double{1.055f}, 3 * kU, double{2.4f}, 0);
}

Bounded EncodeSrgb(double e) {
    if (e <= double{0.0031308f})
        return {e * double{12.92f}, std::fabs(e) * 13 * kU};
    // The exponent 1 / 2.4 is folded by the compiler in binary32 or better.
    const Bounded power = GetPow(e, 0, 1.0 / double{2.4f}, kU);
    const double value = double{1.055f} * power.value;
    return {value - double{0.055f}, double{1.055f} * power.error + value * kU};
}

Bounded DecodeHlg(double h) {
    const double m = std::fabs(h);
    const double sign = h < 0 ? -1 : 1;
    if (m < 0.5)
        return {sign * 4 * m * m, 4 * m * m * kU};
    const double t = (m - double{0.55991073f}) / double{0.17883277f};
    const double power = std::exp(t);
    return {sign * (power + double{0.28466892f}),
            power * (3 * kU * std::fabs(t) + (3 + 2 * std::fabs(t)) * kU) + (power + 1) * kU};
}

Bounded EncodeHlg(double e) {
    const double m = std::fabs(e);
    const double sign = e < 0 ? -1 : 1;
    if (m < 1)
        return {sign * 0.5 * std::sqrt(m), std::sqrt(m) * 0.5 * 5 * kU};
    const double logarithm = std::log(m - double{0.28466892f});
    const double value = double{0.17883277f} * logarithm + double{0.55991073f};
    return {sign * value, 0.18 * (kU + GetLogError(logarithm) + std::fabs(logarithm) * kU) + value * kU};
}

bool IsWithin(std::uint32_t bits, const Bounded& expected) {
    const double value = static_cast<double>(std::bit_cast<float>(bits));
    if (std::fabs(expected.value) + expected.error >= static_cast<double>(std::numeric_limits<float>::max()))
        return true; // may or may not overflow
    return std::fabs(value - expected.value) <= 1.01 * expected.error + kSlack;
}

std::vector<Case> MakeColorCases(std::uint32_t number) {
    std::vector<Case> cases;
    const auto add = [&](float x) {
        cases.push_back({number, std::bit_cast<std::uint32_t>(x), static_cast<std::uint32_t>(cases.size()),
                         static_cast<std::uint32_t>(cases.size() / 4), 0});
    };
    for (int i = -4000; i <= 8000; ++i)
        add(static_cast<float>(i) / 4000.0f);
    for (const float edge : {0.04045f, 0.0031308f, 0.5f, 1.0f, 12.0f, 0.0f, -0.0f}) {
        add(std::nextafter(edge, -1e30f));
        add(edge);
        add(std::nextafter(edge, 1e30f));
    }
    for (float x = 1e-30f; x < 1e30f; x *= 1.7f) {
        add(x);
        add(-x);
    }
    return cases;
}

} // namespace

TEST_CASE("exact shader functions: the device against the C++ build, bit for bit") {
    OPENNTC_REQUIRE_DEVICE(context);
    const decode_test::SpecificationSet set = decode_test::MakeSpecificationSet(decode_test::GetV2Shape());
    const std::vector<Case> cases = MakeExactCases();
    const std::vector<std::uint32_t> expected = RunInCpp(set, cases);
    std::size_t compared = 0;
    for (const char* defines : {"", " NTC_DOT4_SPIRV=1"}) {
        if (*defines != 0 && !context->GetDevice().features.Has(Feature::IntegerDotProduct))
            continue;
        const std::vector<std::uint32_t> results = RunOnDevice(
            *context, set, cases, (std::string("NETWORK_VERSION=3 NTC_MATH=1") + defines).c_str());
        int different[kExactCases] = {};
        for (std::size_t i = 0; i < results.size(); ++i) {
            const Case& item = cases[i / 4];
            const bool isFloat = IsFloatResult(item.number, i % 4);
            if (!IsResultFixed(item))
                continue;
            ++compared;
            if (GetComparable(results[i], isFloat) == GetComparable(expected[i], isFloat))
                continue;
            if (++different[item.number] <= 3) {
                MESSAGE("case " << item.number << " word " << i % 4 << " of " << std::hex << item.a << " "
                                << item.b << " " << item.c << " " << item.d << ": device " << results[i]
                                << ", C++ " << expected[i]);
            }
        }
        for (std::uint32_t number = 0; number < kExactCases; ++number) {
            CAPTURE(number);
            CHECK(different[number] == 0);
        }
    }
    MESSAGE("exact function results compared: " << compared);
    CHECK(compared > expected.size() * 3 / 4); // of each of the two builds; most inputs have a fixed result
}

TEST_CASE("colour spaces: the device and the C++ build against a binary64 model") {
    OPENNTC_REQUIRE_DEVICE(context);
    const decode_test::SpecificationSet set = decode_test::MakeSpecificationSet(decode_test::GetV2Shape());
    std::vector<Case> cases = MakeColorCases(kColorCase);
    const std::vector<Case> select = MakeColorCases(kColorSelectCase);
    cases.insert(cases.end(), select.begin(), select.end());
    const std::vector<std::uint32_t> device =
        RunOnDevice(*context, set, cases, "NETWORK_VERSION=3 NTC_MATH=1");
    const std::vector<std::uint32_t> cpp = RunInCpp(set, cases);
    int outside = 0;
    for (std::size_t i = 0; i < cases.size(); ++i) {
        const Case& item = cases[i];
        const double x = static_cast<double>(std::bit_cast<float>(item.a));
        Bounded expected[4] = {DecodeSrgb(x), EncodeSrgb(x), DecodeHlg(x), EncodeHlg(x)};
        if (item.number == kColorSelectCase) {
            const std::uint32_t space = item.b & 3u;
            const Bounded same = {x, 0};
            const Bounded linear = space == 1 ? expected[0] : space == 2 ? expected[2] : same;
            expected[1] = space == 1 ? expected[1] : space == 2 ? expected[3] : same;
            expected[0] = linear;
            expected[2] = same;
            expected[3] = linear;
        }
        for (std::size_t k = 0; k < 4; ++k) {
            for (const std::uint32_t bits : {device[4 * i + k], cpp[4 * i + k]}) {
                if (!IsWithin(bits, expected[k]) && ++outside <= 5) {
                    MESSAGE("case " << item.number << " word " << k << " of " << x << ": "
                                    << std::bit_cast<float>(bits) << ", not " << expected[k].value << " +- "
                                    << expected[k].error);
                }
            }
        }
    }
    CHECK(outside == 0);
    MESSAGE("colour results compared: " << cases.size() * 4);
}
