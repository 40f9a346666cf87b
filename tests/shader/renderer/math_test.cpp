// SPDX-License-Identifier: MIT
// Which maths mode the renderer decodes with, for devices that are described here; and cooperative vectors: compiled and
// validated where a compiler knows them, and drawn where the device has them.
#include "shader/renderer/Rendering.h"

#include "Failure.h"
#include "GlslangProgram.h"
#include "renderer/gpu/CommandLine.h"
#include "renderer/gpu/MathChoice.h"
#include "renderer/gpu/SelfTest.h"
#include "renderer/scene/SampleScene.h"
#include "renderer/scene/TestScenes.h"
#include "shader_compiler/Compiler.h"

#include "openntc/MathModes.h"
#include "openntc/core/FileStream.h"
#include "openntc/decode/ReferenceDecoder.h"
#include "openntc/inference/Synthesis.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

using namespace openntc;
using namespace openntc::renderer;
using namespace openntc_tests;

namespace {

namespace fs = std::filesystem;

harness::DeviceInfo MakeDevice(bool hasInt8, bool hasE4M3) {
    harness::DeviceInfo device;
    if (hasInt8 || hasE4M3)
        device.cooperativeVectors = {true, hasInt8, hasE4M3};
    else
        device.features.SetAbsence(harness::Feature::CooperativeVectors, "the driver does not have it");
    device.hasFragmentVectors = true;
    return device;
}

MathOffer MakeOffer(const harness::DeviceInfo& device) {
    return {&device, true, true, [] { return std::string(); }};
}

/// The choice where the modes of `wrong` fail the self-test.
MathChoice Choose(int wanted, const MathOffer& offer, const std::vector<int>& wrong = {}) {
    return ChooseMath(wanted, offer, [&](int math) {
        return std::find(wrong.begin(), wrong.end(), math) != wrong.end() ? std::string("wrong numbers")
                                                                          : std::string();
    });
}

/// A set with weights of both kinds.
class SetFile {
public:
    SetFile()
        : path_(fs::temp_directory_path() /
                ("openntc-math-" + std::to_string(std::random_device()()) + ".ntc")) {
        SynthesisDesc synthesis;
        synthesis.desc = {32, 32, 16, 3};
        synthesis.shape = {2, 8, 16, 8, 1};
        synthesis.withFP8 = true;
        auto file = FileWriter::Create(path_.c_str());
        REQUIRE(file);
        REQUIRE(SynthesizeTextureSet(*file, synthesis));
        REQUIRE(file->Commit());
    }
    ~SetFile() {
        std::error_code ignored;
        fs::remove(path_, ignored);
    }
    SetFile(const SetFile&) = delete;
    SetFile& operator=(const SetFile&) = delete;

    std::string GetPath() const { return path_.string(); }

private:
    fs::path path_;
};

struct Shader {
    const char* file;
    std::vector<std::string> defines;
};

/// The shaders that decode a material, in every way to read and to draw it.
std::vector<Shader> ListShaders(const MaterialPlan& plan) {
    std::vector<Shader> shaders;
    const auto add = [&shaders](const char* file, std::vector<std::string> defines, int filter,
                                const char* more = nullptr) {
        defines.push_back("NTCR_FILTER=" + std::to_string(filter));
        if (more != nullptr)
            defines.emplace_back(more);
        shaders.push_back({file, std::move(defines)});
    };
    for (int filter = 0; filter <= 3; ++filter)
        add("ShadeTiles.comp", plan.defines, filter);
    add("Forward.frag", plan.defines, 0, "NTCR_BLENDED=1");
    add("Forward.frag", plan.defines, 1, "NTCR_MASKED=1");
    add("ResolveMasks.comp", plan.maskDefines, 1);
    add("Visibility.frag", plan.maskDefines, 0);
    return shaders;
}

bool Validate(std::span<const std::uint32_t> words, const std::string& validator) {
    const fs::path file =
        fs::temp_directory_path() / ("openntc-math-" + std::to_string(std::random_device()()) + ".spv");
    std::ofstream(file, std::ios::binary)
        .write(reinterpret_cast<const char*>(words.data()), static_cast<std::streamsize>(words.size_bytes()));
    const std::string command = validator + " --target-env vulkan1.3 '" + file.string() + "' >/dev/null 2>&1";
    const int code = std::system(command.c_str()); // NOLINT: as people run it
    fs::remove(file);
    return code == 0;
}

} // namespace

TEST_CASE(
    "renderer maths: the fastest is cooperative vectors where there are any, else what has the same bits") {
    const harness::DeviceInfo none = MakeDevice(false, false), both = MakeDevice(true, true);
    CHECK(Choose(kFastestMath, MakeOffer(both)).math == NTC_MATH_COOPVEC_INT8);
    CHECK(Choose(kFastestMath, MakeOffer(both)).reason.empty());
    // A device that never could is not worth a line.
    MathChoice choice = Choose(kFastestMath, MakeOffer(none));
    CHECK(choice.math == NTC_MATH_INT8);
    CHECK_FALSE(choice.isNotable);
    CHECK(choice.reason.find("coopvec_int8: cooperativeVector: the driver does not have it") == 0);
    // One that could, with another compiler or a better driver, is.
    MathOffer offer = MakeOffer(both);
    offer.whyNoCompiler = [] { return std::string("no compiler"); };
    choice = Choose(kFastestMath, offer);
    CHECK(choice.math == NTC_MATH_INT8);
    CHECK(choice.isNotable);
    CHECK(choice.reason == "coopvec_int8: no compiler");
    choice = Choose(kFastestMath, MakeOffer(both), {NTC_MATH_COOPVEC_INT8});
    CHECK(choice.math == NTC_MATH_INT8);
    CHECK(choice.isNotable);
    // Switched off by people who know.
    offer = MakeOffer(both);
    offer.allowsVectorsInt8 = false;
    choice = Choose(kFastestMath, offer);
    CHECK(choice.math == NTC_MATH_INT8);
    CHECK_FALSE(choice.isNotable);
    harness::DeviceInfo computeOnly = both;
    computeOnly.hasFragmentVectors = false;
    CHECK(Choose(kFastestMath, MakeOffer(computeOnly)).math == NTC_MATH_INT8);
}

TEST_CASE("renderer maths: what was asked for and is not there has a stand-in and a reason") {
    const harness::DeviceInfo none = MakeDevice(false, false), int8 = MakeDevice(true, false),
                              both = MakeDevice(true, true);
    CHECK(Choose(NTC_MATH_COOPVEC_FP8, MakeOffer(both)).math == NTC_MATH_COOPVEC_FP8);
    MathChoice choice = Choose(NTC_MATH_COOPVEC_FP8, MakeOffer(int8));
    CHECK(choice.math == NTC_MATH_COOPVEC_INT8);
    CHECK(choice.isNotable);
    CHECK(choice.reason == "coopvec_fp8: the device has cooperative vectors of other types");
    choice = Choose(NTC_MATH_COOPVEC_FP8, MakeOffer(none)); // one reason for both
    CHECK(choice.math == NTC_MATH_INT8);
    CHECK(choice.reason == "coopvec_fp8: cooperativeVector: the driver does not have it");
    choice = Choose(NTC_MATH_COOPVEC_FP8, MakeOffer(both), {NTC_MATH_COOPVEC_FP8});
    CHECK(choice.math == NTC_MATH_COOPVEC_INT8);
    CHECK(choice.reason == "coopvec_fp8: wrong numbers");
    MathOffer offer = MakeOffer(int8);
    offer.allowsVectorsInt8 = false;
    choice = Choose(NTC_MATH_COOPVEC_FP8, offer);
    CHECK(choice.math == NTC_MATH_INT8);
    CHECK(choice.reason == "coopvec_fp8: the device has cooperative vectors of other types; coopvec_int8: "
                           "switched off (--no-coopvec-int8)");
    for (const int math : {NTC_MATH_INT8_HALF, NTC_MATH_FP8, NTC_MATH_FP16, NTC_MATH_FP32}) {
        CHECK(Choose(math, MakeOffer(none)).math == math);
        choice = Choose(math, MakeOffer(none), {math});
        CHECK(choice.math == NTC_MATH_INT8);
        CHECK(choice.reason == std::string(GetMathName(math)) + ": wrong numbers");
        choice = Choose(math, MakeOffer(none), {math, NTC_MATH_INT8});
        CHECK(choice.math == 0);
        CHECK(choice.reason == "wrong numbers");
    }
}

TEST_CASE(
    "renderer maths: the self-test takes the bits of int8 alone, and of FP8 hardware what it may return") {
    const SetFile set;
    tool::TextureSet file = tool::LoadTextureSet(set.GetPath());
    const Rect rect = {3, 5, 8, 3};
    for (const int math : {NTC_MATH_COOPVEC_INT8, NTC_MATH_COOPVEC_FP8}) {
        CAPTURE(math);
        const bool isFP8 = math == NTC_MATH_COOPVEC_FP8;
        const tool::DecodeData data = tool::LoadDecodeData(file, isFP8 ? DecodeMath::FP8 : DecodeMath::Int8);
        std::vector<float> texels(16 * 8 * 3);
        DecodeOptions options;
        options.math = data.math;
        REQUIRE(DecodeReference(data.GetSource(), 1, rect, options, texels));
        CHECK(AreAsPromised(data, math, 1, rect, texels));
        std::vector<float> others = texels;
        others[0] += 0.25f; // a quarter of all that a texture holds
        CHECK_FALSE(AreAsPromised(data, math, 1, rect, others));
        others[0] = std::nanf("");
        CHECK_FALSE(AreAsPromised(data, math, 1, rect, others));
        others[0] = std::nextafterf(texels[0], 2.0f);
        if (!isFP8)
            CHECK_FALSE(AreAsPromised(data, math, 1, rect, others));
    }
}

TEST_CASE("renderer maths: every shader compiles with cooperative vectors, and is valid") {
    if (!shader_compiler::KnowsCooperativeVectors()) {
        ShaderCache wrong(OPENNTC_RENDERER_SOURCES, "nowhere/glslang");
        try {
            wrong.WhyNoCooperativeVectors();
            FAIL("a program that is not there was taken");
        } catch (const tool::CommandError& error) {
            CHECK(error.GetSubject() == "--glslang");
            CHECK(std::string(error.what()).starts_with("nowhere/glslang: "));
        }
    }
    const std::string glslang = tool::FindCooperativeVectorGlslang();
    if (glslang.empty()) {
        MESSAGE("SKIP: no glslang that knows GL_NV_cooperative_vector: name one in OPENNTC_GLSLANG");
        return;
    }
    const Scene scene = MakeTestScene("everything");
    auto stream = FileReader::Open(scene.textureSets.at(0).path.c_str());
    REQUIRE(stream);
    const auto metadata = TextureSetMetadata::Load(*stream);
    REQUIRE(metadata);
    RenderOptions options;
    options.mode = Mode::OnSample;
    DeviceFeatures device;
    device.cooperativeVectorInt8 = device.cooperativeVectorFP8 = true;
    ShaderCache cache(OPENNTC_RENDERER_SOURCES, glslang);
    CHECK(cache.WhyNoCooperativeVectors().empty());
    const char* const named = std::getenv("OPENNTC_SPIRV_VAL");
    const std::string validator = named != nullptr ? named : "spirv-val";
    // One that does not know them refuses the least of shaders too.
    const bool knows =
        Validate(cache.Get("DecodeTexels.comp", {"NETWORK_VERSION=1", "NTC_MATH=6"}), validator);
    if (!knows)
        MESSAGE("SKIP: not validated: ", validator, " does not know SPV_NV_cooperative_vector");
    options.math = NTC_MATH_COOPVEC_INT8;
    MaterialPlan plan = PlanMaterial(scene, scene.materials.at(0), {{&*metadata}}, options, device);
    for (const int math : {NTC_MATH_COOPVEC_INT8, NTC_MATH_COOPVEC_FP8}) {
        const std::string define = "NTC_MATH=" + std::to_string(math);
        for (std::vector<std::string>* const defines : {&plan.defines, &plan.maskDefines}) {
            // The scene's set has no FP8 weights; its shaders would be these.
            const auto found = std::find(defines->begin(), defines->end(), "NTC_MATH=6");
            REQUIRE(found != defines->end());
            if (math == NTC_MATH_COOPVEC_FP8)
                *found = define;
        }
        std::vector<Shader> shaders = ListShaders(plan);
        for (int network = 1; network <= 4; ++network)
            shaders.insert(shaders.begin(),
                           {"DecodeTexels.comp", {"NETWORK_VERSION=" + std::to_string(network), define}});
        for (const Shader& shader : shaders) {
            CAPTURE(shader.file);
            const std::span<const std::uint32_t> words = cache.Get(shader.file, shader.defines);
            REQUIRE(words.size() > 5);
            CHECK(words[0] == 0x07230203u);
            CHECK(words[1] == 0x00010600u); // SPIR-V 1.6
            if (knows)
                CHECK(Validate(words, validator));
        }
    }
}

TEST_CASE("renderer maths: cooperative vectors draw the picture of int8, or int8 does") {
    OPENNTC_REQUIRE_DEVICE(context);
    RenderOptions options = MakeSmallOptions(Mode::OnSample);
    const Scene original = MakeSampleScene();
    const Picture picture = Render(*context, original, options).picture;
    const bool hasVectors = context->GetDevice().cooperativeVectors.hasCooperativeVectors &&
                            GetShaders().WhyNoCooperativeVectors().empty();
    Scene scene = original;
    options.math = NTC_MATH_COOPVEC_INT8;
    Renderer renderer(*context, GetShaders(), scene, options);
    const MathChoice& choice = renderer.GetTextures().GetMath();
    CHECK(choice.reason.empty() == hasVectors);
    CHECK(scene.warnings.size() == original.warnings.size() + (hasVectors ? 0 : 1));
    CHECK(choice.math == (hasVectors ? NTC_MATH_COOPVEC_INT8 : NTC_MATH_INT8));
    renderer.Render(scene.cameras.front(), 0, false);
    CHECK(renderer.ReadPicture() == picture);
    if (!hasVectors) {
        MESSAGE("SKIP: cooperative vectors are not drawn: ", choice.reason);
        return;
    }
    if (!context->GetDevice().cooperativeVectors.hasE4M3) {
        MESSAGE("SKIP: no cooperative vectors of E4M3");
        return;
    }
    // Within the intervals of FP8 hardware.
    const SetFile set;
    tool::TextureSet file = tool::LoadTextureSet(set.GetPath());
    CHECK(DecodesAsPromised(*context, GetShaders(), tool::LoadDecodeData(file, DecodeMath::FP8),
                            NTC_MATH_COOPVEC_FP8, false));
}
