// SPDX-License-Identifier: MIT
// Devices that compute other numbers than they promise: emulated by shaders whose dot product is wrong.
#include "Failure.h"
#include "renderer/scene/SampleScene.h"
#include "shader/renderer/Rendering.h"

#include "openntc/MathModes.h"

#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

using namespace openntc;
using namespace openntc::renderer;
using namespace openntc_tests;

namespace {

namespace fs = std::filesystem;

/// A copy of the shaders that can be changed.
class ShaderCopy {
public:
    ShaderCopy()
        : folder_(fs::temp_directory_path() / ("openntc-lies-" + std::to_string(std::random_device()()))) {
        const fs::path sources = OPENNTC_RENDERER_SOURCES;
        for (const char* const part : {"shaders", "examples/renderer/shaders"}) {
            fs::create_directories(folder_ / part);
            fs::copy(sources / part, folder_ / part, fs::copy_options::recursive);
        }
    }
    ~ShaderCopy() {
        std::error_code ignored;
        fs::remove_all(folder_, ignored);
    }
    ShaderCopy(const ShaderCopy&) = delete;
    ShaderCopy& operator=(const ShaderCopy&) = delete;

    void Replace(const char* file, const std::string& from, const std::string& to) const {
        std::ifstream input(folder_ / file, std::ios::binary);
        std::string text{std::istreambuf_iterator<char>(input), {}};
        input.close();
        const std::size_t at = text.find(from);
        REQUIRE(at != std::string::npos);
        std::ofstream(folder_ / file, std::ios::binary) << text.replace(at, from.size(), to);
    }
    const fs::path& GetPath() const { return folder_; }

private:
    fs::path folder_;
};

constexpr const char* kFile = "shaders/openntc/Portability.h";

/// What the sample scene's renderer says beside what the scene has to say itself.
std::vector<std::string> ListNewWarnings(const Scene& scene, const Scene& original) {
    return {scene.warnings.begin() + static_cast<std::ptrdiff_t>(original.warnings.size()),
            scene.warnings.end()};
}

} // namespace

TEST_CASE("renderer: a device that lies about integer dot products is found out and used without them") {
    OPENNTC_REQUIRE_DEVICE(context);
    if (!context->GetDevice().features.Has(harness::Feature::IntegerDotProduct)) {
        MESSAGE("SKIP: no integer dot products");
        return;
    }
    const RenderOptions options = MakeSmallOptions(Mode::OnSample);
    const Scene original = MakeSampleScene();
    const Picture honest = Render(*context, original, options).picture;
    const ShaderCopy copy;
    copy.Replace(kFile, "#define NtcDot4(a, b) NtcOpSDot(a, b, 0)",
                 "#define NtcDot4(a, b) (NtcOpSDot(a, b, 0) + 1)");
    {
        ShaderCache lies(copy.GetPath());
        Scene scene = original;
        Renderer renderer(*context, lies, scene, options);
        const std::vector<std::string> said = ListNewWarnings(scene, original);
        REQUIRE(said.size() == 1);
        CHECK(said[0].find("self-test: integer dot products") != std::string::npos);
        CHECK_FALSE(renderer.GetTextures().GetFeatures().integerDotProduct);
        renderer.Render(scene.cameras.front(), 0, false);
        CHECK(renderer.ReadPicture() == honest);
    }
    copy.Replace(kFile, "return NtcSignedByte(a, 0u) *", "return 1 + NtcSignedByte(a, 0u) *");
    ShaderCache lies(copy.GetPath());
    Scene scene = original;
    try {
        const Renderer renderer(*context, lies, scene, options);
        FAIL("decodes wrong numbers and says nothing");
    } catch (const tool::CommandError& error) {
        CHECK(error.GetCode() == tool::ExitCode::NoDevice);
        CHECK(std::string(error.what()).find("self-test") != std::string::npos);
    }
}

TEST_CASE("renderer: a maths mode that a device computes wrongly is said once, and int8 stands in for it") {
    OPENNTC_REQUIRE_DEVICE(context);
    RenderOptions options = MakeSmallOptions(Mode::OnSample);
    const Scene original = MakeSampleScene();
    const Picture honest = Render(*context, original, options).picture;
    const ShaderCopy copy;
    const std::string evaluate =
        "NtcEvaluateHalfNetwork(networkVersion, weights, weightsOffset, layers, realInputs, outputs);";
    copy.Replace("shaders/openntc/InferenceTexel.h", evaluate,
                 "{ " + evaluate + " outputs[0] = 1.0 - outputs[0]; }");
    ShaderCache lies(copy.GetPath());
    Scene scene = original;
    options.math = NTC_MATH_FP16;
    Renderer renderer(*context, lies, scene, options);
    const std::vector<std::string> said = ListNewWarnings(scene, original);
    REQUIRE(said.size() == 1);
    CHECK(said[0].find("fp16: self-test: ") != std::string::npos);
    CHECK(said[0].ends_with(": int8 in its place"));
    CHECK(renderer.GetTextures().GetMath().math == NTC_MATH_INT8);
    CHECK(renderer.GetTextures().GetFeatures().integerDotProduct ==
          context->GetDevice().features.Has(harness::Feature::IntegerDotProduct));
    renderer.Render(scene.cameras.front(), 0, false);
    CHECK(renderer.ReadPicture() == honest);
}
