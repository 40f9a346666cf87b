// SPDX-License-Identifier: MIT
// OPENNTC_SIMD_CAP: its names, what each takes away, and that this process obeys it. (The stage `caps` of tests/run.sh runs
// this under each.)
#include "openntc/core/Processor.h"

#include <doctest/doctest.h>

#include <cstdlib>
#include <cstring>
#include <string>

using namespace openntc;

namespace {

/// One digit per instruction set.
std::string Describe(const ProcessorFeatures& f) {
    std::string text;
    for (const bool has :
         {f.avx2, f.fma, f.avxVnni, f.avx512, f.avx512Vnni, f.avx512Bf16, f.amxInt8, f.amxBf16, f.neonBf16})
        text += has ? '1' : '0';
    return text;
}

} // namespace

TEST_CASE("names of SIMD caps") {
    constexpr struct {
        const char* name;
        SimdCap cap;
        const char* allowed;
    } kCaps[] = {{"none", SimdCap::None, "000000000"},       {"avx2", SimdCap::Avx2, "110000001"},
                 {"avxvnni", SimdCap::AvxVnni, "111000001"}, {"avx512", SimdCap::Avx512, "111111001"},
                 {"amx", SimdCap::Amx, "111111111"},         {"", SimdCap::Amx, "111111111"},
                 {nullptr, SimdCap::Amx, "111111111"}};
    constexpr ProcessorFeatures kAll{true, true, true, true, true, true, true, true, true};
    for (const auto& expected : kCaps) {
        const Expected<SimdCap> cap = ParseSimdCap(expected.name);
        REQUIRE(cap.has_value());
        CHECK(*cap == expected.cap);
        CHECK(Describe(LimitFeatures(kAll, *cap)) == expected.allowed);
        CHECK(Describe(LimitFeatures({}, *cap)) == "000000000");
    }
    for (const char* name : {"avx3", "AVX2", "avx2 ", "0", "best"}) {
        const Expected<SimdCap> cap = ParseSimdCap(name);
        REQUIRE_FALSE(cap.has_value());
        CHECK(cap.error().GetStatus() == Status::InvalidArgument);
        CHECK(cap.error().GetText() ==
              std::string("OPENNTC_SIMD_CAP: ") + name + ": must be none, avx2, avxvnni, avx512 or amx");
    }
}

TEST_CASE("this process uses what the processor has and OPENNTC_SIMD_CAP allows") {
    const Expected<SimdCap> cap = ParseSimdCap(std::getenv("OPENNTC_SIMD_CAP"));
    REQUIRE(cap.has_value());
    REQUIRE(GetSimdCap().has_value());
    CHECK(*GetSimdCap() == *cap);
    const std::string has = Describe(detail::ReadProcessor());
    CHECK(Describe(GetProcessorFeatures()) == Describe(LimitFeatures(detail::ReadProcessor(), *cap)));
    MESSAGE("avx2 fma avxvnni avx512 avx512vnni avx512bf16 amx-int8 amx-bf16 neon-bf16: ", has);
#if OPENNTC_DETECT_X86
    // Independent of our reading of CPUID.
    CHECK(detail::ReadProcessor().fma == (__builtin_cpu_supports("fma") && __builtin_cpu_supports("avx2")));
    CHECK(detail::ReadProcessor().avx512Vnni ==
          (__builtin_cpu_supports("avx512vnni") && __builtin_cpu_supports("avx512bw") &&
           __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq")));
#else
    CHECK(has.substr(0, 8) == "00000000");
#endif
}
