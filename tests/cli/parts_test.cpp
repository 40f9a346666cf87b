// SPDX-License-Identifier: MIT
// Parts of the command line in process: quantisation, vector files, comparison.
#include "Json.h"
#include "Output.h"
#include "Progress.h"
#include "TextureImage.h"
#include "conformance/Comparison.h"
#include "conformance/VectorFiles.h"
#include "report/RepeatedSet.h"
#include "support/SpecificationVectors.h"
#include "unit/decode/ModeSets.h"

#include "openntc/decode/ReferenceDecoder.h"

#include <doctest/doctest.h>

#include <limits>
#include <string>

using namespace openntc;

TEST_CASE("UNORM is floor(clamp(v, 0, 1) * max + 1/2), NaN is 0") {
    const float inf = std::numeric_limits<float>::infinity();
    CHECK(tool::QuantiseUnorm(std::numeric_limits<float>::quiet_NaN(), 255) == 0);
    CHECK(tool::QuantiseUnorm(-inf, 255) == 0);
    CHECK(tool::QuantiseUnorm(inf, 255) == 255);
    CHECK(tool::QuantiseUnorm(-0.5f, 255) == 0);
    CHECK(tool::QuantiseUnorm(1.0f, 65535) == 65535);
    CHECK(tool::QuantiseUnorm(0.5f, 255) == 128); // 127.5 + 0.5
    CHECK(tool::QuantiseUnorm(0.5f, 65535) == 32768);
    CHECK(tool::QuantiseUnorm(0x1.fffffep-2f, 255) == 127); // just below one half: binary32 would round up
    for (int code = 0; code < 256; ++code)
        CHECK(tool::QuantiseUnorm(static_cast<float>(code) / 255.0f, 255) == code);
    for (int code = 0; code < 65536; ++code)
        REQUIRE(tool::QuantiseUnorm(static_cast<float>(code) / 65535.0f, 65535) == code);
}

TEST_CASE("floats print with nine digits and portable names") {
    CHECK(tool::FormatFloat(0.1f) == "0.100000001");
    CHECK(tool::FormatFloat(-std::numeric_limits<float>::quiet_NaN()) == "nan");
    CHECK(tool::FormatFloat(-std::numeric_limits<float>::infinity()) == "-inf");
    CHECK(tool::MakeValidUtf8("a\xff"
                              "b\xC3\xBC\xE0\x80\x80") == "a\xEF\xBF\xBD"
                                                          "b\xC3\xBC\xEF\xBF\xBD\xEF\xBF\xBD\xEF\xBF\xBD");
}

namespace {

std::vector<std::byte> MakeTexels(std::uint32_t version, std::uint32_t channels, std::uint32_t count,
                                  std::size_t bytes) {
    std::vector<std::byte> file(bytes);
    const std::uint32_t header[4] = {0x4C58544Eu, version, channels, count};
    for (std::size_t i = 0; i < 16 && i < bytes; ++i)
        file[i] = static_cast<std::byte>(header[i / 4] >> (8 * (i % 4)));
    return file;
}

} // namespace

TEST_CASE("texel files: hostile headers are errors") {
    using conformance::ReadTexels;
    CHECK(ReadTexels(MakeTexels(1, 16, 2, 16 + 608)));
    CHECK(ReadTexels(MakeTexels(1, 16, 0, 16)));
    CHECK_FALSE(ReadTexels(MakeTexels(2, 16, 2, 16 + 608)));
    CHECK_FALSE(ReadTexels(MakeTexels(1, 15, 2, 16 + 608)));
    CHECK_FALSE(ReadTexels(MakeTexels(1, 16, 3, 16 + 608)));
    CHECK_FALSE(ReadTexels(MakeTexels(1, 16, 0xFFFFFFFFu, 16 + 608)));
    CHECK_FALSE(ReadTexels(MakeTexels(1, 16, 14128182u, 16 + 608))); // wraps to 608 bytes in 32 bits
    for (std::size_t size = 0; size < 16 + 304; ++size)
        REQUIRE_FALSE(ReadTexels(MakeTexels(1, 16, 1, size)));
}

TEST_CASE("expectations: wrong types are errors, absent parts are not") {
    const auto read = [](std::string_view text) {
        return conformance::ReadExpectations(std::as_bytes(std::span(text.data(), text.size())));
    };
    CHECK(read("{}"));
    CHECK(read(R"({"GenericFP8":null})")->fp8Absent);
    CHECK(read(R"({"width":64,"fusedMips":[[0,3]]})")->width == 64);
    CHECK_FALSE(read(""));
    CHECK_FALSE(read("[]"));
    CHECK_FALSE(read(R"({"width":"64"})"));
    CHECK_FALSE(read(R"({"fusedMips":[[0]]})"));
    CHECK_FALSE(read(R"({"streamRanges":[{"firstMip":0}]})"));
    CHECK_FALSE(read(R"({"GenericInt8":{"weightBytes":1,"weightCrc32":4294967296,"constants":"00"}})"));
    CHECK_FALSE(read(R"({"GenericInt8":{"weightBytes":1,"weightCrc32":1,"constants":"0g"}})"));
    CHECK_FALSE(read(std::string(100000, '[')));
}

TEST_CASE("comparison knows NaN, infinities and flushed subnormals") {
    using namespace conformance;
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const float inf = std::numeric_limits<float>::infinity();
    CHECK(IsSame(nan, -nan, 0));
    CHECK_FALSE(IsSame(nan, 0, 1));
    CHECK_FALSE(IsSame(0.0f, -0.0f, 0));
    CHECK(IsSame(1e-40f, 0, 0x1p-126f));
    CHECK_FALSE(IsSame(1e-40f, 0, 0));
    CHECK(GetDistance(nan, nan) == 0);
    CHECK(GetDistance(nan, 1) == std::numeric_limits<double>::infinity());
    CHECK(GetDistance(inf, inf) == 0);
    CHECK(GetDistance(inf, -inf) == std::numeric_limits<double>::infinity());
    // Guards: the bound stays far below one step of an 8-bit image, and grows from host to Vulkan.
    for (const ColorSpace space : {ColorSpace::sRGB, ColorSpace::HLG}) {
        for (int i = -100; i <= 100; ++i) {
            const float stored = static_cast<float>(i) / 100.0f;
            CHECK(GetLinearBound(space, stored, Arithmetic::Host) < 2e-5);
            CHECK(GetLinearBound(space, stored, Arithmetic::Vulkan) < 2e-4);
            CHECK(GetLinearBound(space, stored, Arithmetic::Vulkan) >=
                  GetLinearBound(space, stored, Arithmetic::Host));
        }
    }
    CHECK(GetLinearBound(ColorSpace::Linear, 0.5f, Arithmetic::Vulkan) == 0);
}

TEST_CASE("a log shows that work goes on: soon, then ever more rarely, at least every five minutes") {
    // Ten hours, looked at four times a second.
    tool::LogPace pace;
    int lines = 0;
    double last = 0.0, lastGap = 0.0;
    for (int quarter = 0; quarter <= 10 * 3600 * 4; ++quarter) {
        const double seconds = quarter / 4.0;
        if (!pace.IsDue(seconds)) {
            CHECK(seconds - last <= 300.25);
            continue;
        }
        CHECK((lines > 0 || seconds == 10.0));
        if (lines > 1)
            CHECK(seconds - last >= lastGap - 0.5); // looks are a quarter of a second apart
        lastGap = seconds - last;
        last = seconds;
        ++lines;
        if (seconds <= 600.0)
            CHECK(lines <= 11); // ten minutes: 10, 15, 22.5, … seconds
        CHECK_FALSE(pace.IsDue(seconds));
    }
    CHECK(lines > 120);
    CHECK(lines < 140);
}

TEST_CASE("report: a set repeated downwards has its texels in every copy, away from the seams") {
    constexpr int kWidth = 32, kCopies = 3;
    for (const int network : {NTC_NETWORK_MEDIUM, NTC_NETWORK_GENERATION_3}) {
        CAPTURE(network);
        const int height = network == NTC_NETWORK_MEDIUM ? 16 : 64;
        openntc::SynthesisDesc layered;
        layered.desc = {kWidth, height, 16, 1};
        layered.networkVersion = network;
        layered.shape = MakeLayeredShape(4, 12);
        const decode_test::ModeSet set = network == NTC_NETWORK_MEDIUM
                                             ? decode_test::MakeModeSet(network, kWidth, height)
                                             : decode_test::ModeSet(openntc_tests::MakeFile(layered));
        const DecodeSource source = set.GetSource(DecodeWeights::Int8);
        tool::DecodeData data{*source.constants,
                              {source.latents.begin(), source.latents.end()},
                              {source.weights.begin(), source.weights.end()},
                              network};
        const report::RepeatedSet repeated = report::RepeatBelow(data, kCopies);
        REQUIRE(repeated.constants.imageHeight == height * kCopies);
        const DecodeSource all = {&repeated.constants, repeated.latents, data.weights, network};
        const auto decode = [&](const DecodeSource& from, int top, int rows) {
            std::vector<float> outputs(16 * kWidth * static_cast<std::size_t>(rows));
            REQUIRE(DecodeReference(from, 0, {0, top, kWidth, rows}, {}, outputs));
            return outputs;
        };
        // Taps of the coarser grid reach less than one of its pixels beyond a texel.
        const int grid = static_cast<int>(source.constants->lowResNeuralMips[0].imageWidthHeight >> 16);
        const int seam = (height + grid - 1) / grid;
        const int rows = height - 2 * seam;
        REQUIRE(rows > 0);
        for (int copy = 0; copy < kCopies; ++copy)
            CHECK(decode(all, copy * height + seam, rows) == decode(source, seam, rows));
        CHECK(report::RepeatBelow(data, 1 << 16).latents.empty()); // higher than the format allows
    }
}
