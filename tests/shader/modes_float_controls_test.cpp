// SPDX-License-Identifier: MIT
// Float controls: the INT8 and INT8_HALF shaders with execution modes that fix what Vulkan leaves to the device (rounding,
// subnormal numbers, signed zeros), dispatched where the device offers them: the bits are those of the C++ build. And
// contraction: no addition of a shader may be fused with a multiplication, by its decorations.
#include "shader/PassRunner.h"
#include "shader/TestDevice.h"
#include "unit/decode/ModeSets.h"

#include "openntc/MathModes.h"
#include "openntc/decode/ReferenceDecoder.h"

#include "decode_shaders.h"
#include "hlsl_shaders.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <set>
#include <string>
#include <vector>

using namespace openntc;
using namespace openntc_tests;

namespace {

// SPIR-V specification: OpExtension, OpEntryPoint, OpCapability and so on.
constexpr std::uint32_t kOpExtension = 10, kOpEntryPoint = 15, kOpExecutionMode = 16, kOpCapability = 17;
constexpr std::uint32_t kOpExtInst = 12, kOpConstant = 43, kOpDecorate = 71, kOpFAdd = 129, kOpFSub = 131;
// Added in the conversions to linear light, which are compared within a bound and may be contracted.
constexpr std::uint32_t kCurveConstants[] = {std::bit_cast<std::uint32_t>(0.055f),
                                             std::bit_cast<std::uint32_t>(0.55991073f),
                                             std::bit_cast<std::uint32_t>(0.28466892f)};
constexpr std::uint32_t kNoContraction = 42, kGlslFma = 50;

template <typename Visit>
void ForEachOp(std::span<const std::uint32_t> words, Visit visit) {
    for (std::size_t at = 5; at < words.size(); at += words[at] >> 16) {
        if ((words[at] >> 16) == 0 || (words[at] >> 16) > words.size() - at)
            FAIL("not a SPIR-V module");
        visit(words[at] & 0xFFFFu, words.subspan(at, words[at] >> 16));
    }
}

/// The module with an execution mode of SPV_KHR_float_controls for binary32.
std::vector<std::uint32_t> AddFloatControl(std::span<const std::uint32_t> words, std::uint32_t capability,
                                           std::uint32_t executionMode) {
    const char name[24] = "SPV_KHR_float_controls";
    std::vector<std::uint32_t> capabilities;
    std::vector<std::uint32_t> other;
    std::vector<std::uint32_t> rest;
    std::uint32_t entryPoint = 0;
    ForEachOp(words, [&](std::uint32_t op, std::span<const std::uint32_t> all) {
        // Up to the entry points, which execution modes follow.
        std::vector<std::uint32_t>& part = op == kOpCapability                      ? capabilities
                                           : entryPoint != 0 && op != kOpEntryPoint ? rest
                                                                                    : other;
        part.insert(part.end(), all.begin(), all.end());
        if (op == kOpEntryPoint)
            entryPoint = all[2];
    });
    std::vector<std::uint32_t> module(words.begin(), words.begin() + 5);
    module.insert(module.end(), capabilities.begin(), capabilities.end());
    module.insert(module.end(), {2u << 16 | kOpCapability, capability, 7u << 16 | kOpExtension});
    module.resize(module.size() + 6);
    std::memcpy(&module[module.size() - 6], name, sizeof name);
    module.insert(module.end(), other.begin(), other.end());
    module.insert(module.end(), {4u << 16 | kOpExecutionMode, entryPoint, executionMode, 32u});
    module.insert(module.end(), rest.begin(), rest.end());
    return module;
}

} // namespace

TEST_CASE(
    "float controls: the exact modes keep their bits under every execution mode that the device offers") {
    OPENNTC_REQUIRE_DEVICE(context);
    const harness::DeviceInfo& device = context->GetDevice();
    const struct {
        const char* name;
        std::uint32_t capability, mode;
        bool isOffered;
    } kControls[] = {{"DenormPreserve", 4464, 4459, device.hasDenormPreserve},
                     {"DenormFlushToZero", 4465, 4460, device.hasDenormFlushToZero},
                     {"SignedZeroInfNanPreserve", 4466, 4461, device.hasSignedZeroInfNanPreserve},
                     {"RoundingModeRTE", 4467, 4462, device.hasRoundToNearestEven}};
    const decode_test::ModeSet set = decode_test::MakeModeSet(NTC_NETWORK_SMALL, 53, 41);
    const DecodeSource source = set.GetSource(DecodeWeights::Int8);
    for (const auto& control : kControls) {
        const std::string name = control.name;
        CAPTURE(name);
        if (!control.isOffered) {
            MESSAGE("SKIP: " << name << ": the device does not offer it for binary32");
            continue;
        }
        for (const DecodeMath math : {DecodeMath::Int8, DecodeMath::Int8Half}) {
            const int macro = math == DecodeMath::Int8 ? NTC_MATH_INT8 : NTC_MATH_INT8_HALF;
            const auto spirv = decode_shaders::FindShader("DecodeTexels.comp", "NETWORK_VERSION=1 NTC_MATH=" +
                                                                                   std::to_string(macro));
            REQUIRE_MESSAGE(spirv.has_value(), std::string(spirv.error().GetText()));
            const std::vector<std::uint32_t> module =
                AddFloatControl(*spirv, control.capability, control.mode);
            PassRunner runner(*context, source, module);
            for (int mip = 0; mip < source.constants->imageMips; ++mip) {
                const Rect rect = GetMipRect(source, mip);
                std::vector<float> expected(static_cast<std::size_t>(rect.width * rect.height) * 16);
                REQUIRE(
                    DecodeReference(source, mip, rect, {.math = math, .convertToLinear = false}, expected));
                CHECK(CountDifferent(runner.Decode(mip, rect), expected) == 0);
            }
        }
    }
    CHECK(context->GetValidationLog().errors.empty());
}

TEST_CASE("contraction: no addition of a decoding shader may be fused") {
    std::size_t additions = 0;
    for (int version = NTC_NETWORK_SMALL; version <= NTC_NETWORK_XLARGE; ++version) {
        for (int macro = NTC_MATH_INT8; macro <= NTC_MATH_FP32; ++macro) {
            const std::string defines =
                "NETWORK_VERSION=" + std::to_string(version) + " NTC_MATH=" + std::to_string(macro);
            CAPTURE(defines);
            for (const auto& spirv : {decode_shaders::FindShader("DecodeTexels.comp", defines),
                                      hlsl_shaders::FindShader("DecodeTexels.hlsl", defines)}) {
                REQUIRE_MESSAGE(spirv.has_value(), std::string(spirv.error().GetText()));
                std::set<std::uint32_t> precise;
                std::set<std::uint32_t> ofCurves; // additions of constants in NtcDecodeSrgb and NtcDecodeHlg
                int fused = 0;
                ForEachOp(*spirv, [&](std::uint32_t op, std::span<const std::uint32_t> words) {
                    if (op == kOpConstant && std::ranges::count(kCurveConstants, words[3]) != 0)
                        ofCurves.insert(words[2]);
                    if (op == kOpDecorate && words[2] == kNoContraction)
                        precise.insert(words[1]);
                    if (op == kOpExtInst && words[4] == kGlslFma)
                        ++fused;
                    if (op == kOpFAdd || op == kOpFSub) {
                        ++additions;
                        const bool isCurve = ofCurves.contains(words[3]) || ofCurves.contains(words[4]);
                        fused += !isCurve && !precise.contains(words[2]) ? 1 : 0;
                    }
                });
                CHECK(fused == 0);
            }
        }
    }
    CHECK(additions > 1000);
}
