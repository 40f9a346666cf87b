// SPDX-License-Identifier: MIT
// Collaboration and sharing on a device: in compute shaders of both languages and in fragment shaders.
#define NTC_STF_MAX_ROUNDS 8
#include "filtering/WaveEmulator.h"

#include "support/filtering/WaveCases.h"

#include "shader/TestDevice.h"

#include "wave_hlsl_shaders.h"
#include "wave_shaders.h"

#include "vulkan_harness/Vulkan.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <bit>
#include <cmath>

using namespace openntc;
using namespace openntc::harness;
using namespace openntc_tests;

namespace {

constexpr std::uint32_t kWaveWidth = 32, kWaveHeight = 32;

WaveScene MakeDeviceScene(std::uint32_t kernel, double magnification, bool isTurned) {
    WaveScene scene = MakeWaveScene(kernel, magnification, isTurned);
    scene.width = kWaveWidth;
    scene.u = 0.123f;
    scene.v = 0.456f;
    return scene;
}

using WordList = std::vector<std::uint32_t>;

enum class WaveStage { Glsl, Hlsl, Screen, Triangles };

/// A stage's pipeline, made once: compiling takes a CPU driver longer than running.
class WaveRunner {
public:
    WaveRunner(Context& context, WaveStage stage) : context_(context), stage_(stage), pipeline_(Make()) {
        REQUIRE_MESSAGE(pipeline_.has_value(), std::string(pipeline_.error().GetText()));
    }

    /// The picture's words; pixels that took no part are 0.
    WordList Run(const WaveScene& scene) const {
        const auto uniform = context_.CreateBuffer(std::as_bytes(std::span(&scene, 1)), BufferKind::Uniform,
                                                   BufferMemory::HostVisible);
        WordList words(std::size_t{kWaveWidth} * kWaveHeight * WAVE_WORDS);
        const auto output = context_.CreateBuffer(std::as_bytes(std::span(words)), BufferKind::Storage,
                                                  BufferMemory::HostVisible);
        REQUIRE((uniform && output));
        const BoundBuffer bound[] = {{0, &*uniform}, {1, &*output}};
        if (IsDrawn()) {
            const std::uint32_t first = stage_ == WaveStage::Screen ? 0 : 3;
            const auto drawn = context_.Draw({&*pipeline_, bound, std::as_bytes(std::span(&first, 1)),
                                              kWaveWidth, kWaveHeight, first == 0 ? 3u : 12u});
            REQUIRE_MESSAGE(drawn.has_value(), std::string(drawn.error().GetText()));
        } else {
            DispatchRequest request;
            request.pipeline = &*pipeline_;
            request.buffers = bound;
            request.groups[0] = kWaveWidth * kWaveHeight / 64;
            const auto timing = context_.Dispatch(request);
            REQUIRE_MESSAGE(timing.has_value(), std::string(timing.error().GetText()));
        }
        REQUIRE(context_.Read(*output, 0, std::as_writable_bytes(std::span(words))));
        return words;
    }

private:
    bool IsDrawn() const { return stage_ == WaveStage::Screen || stage_ == WaveStage::Triangles; }

    Expected<ComputePipeline> Make() const {
        const BufferSlot slots[] = {{0, BufferKind::Uniform}, {1, BufferKind::Storage}};
        if (IsDrawn()) {
            OPENNTC_ASSIGN(const auto vertex, wave_shaders::FindShader("Waves.vert", ""));
            OPENNTC_ASSIGN(const auto fragment, wave_shaders::FindShader("Waves.frag", ""));
            return context_.CreateDrawPipeline(vertex, fragment, slots, 4);
        }
        OPENNTC_ASSIGN(const auto spirv, stage_ == WaveStage::Glsl
                                             ? wave_shaders::FindShader("Waves.comp", "")
                                             : wave_hlsl_shaders::FindShader("Waves.hlsl", ""));
        return context_.CreateComputePipeline(spirv, slots, 0);
    }

    Context& context_;
    WaveStage stage_;
    Expected<ComputePipeline> pipeline_;
};

struct WaveCounts {
    int pixels = 0, different = 0, foreign = 0;
    std::uint64_t decodes = 0;
};

/// How many pixels took part, differ from the exact filter on the device, or from that in C++; and decodes.
WaveCounts CountWaves(const WaveScene& scene, const WordList& words) {
    WaveCounts counts;
    for (std::uint32_t i = 0; i < kWaveWidth * kWaveHeight; ++i) {
        const std::uint32_t* const pixel = words.data() + std::size_t{i} * WAVE_WORDS;
        if (pixel[10] == 0)
            continue;
        ++counts.pixels;
        counts.decodes += pixel[8];
        counts.different += std::equal(pixel, pixel + 4, pixel + 4) ? 0 : 1;
        const shader::WaveLookup lookup = shader::MakeWaveLookup(
            scene, {static_cast<int>(i % kWaveWidth), static_cast<int>(i / kWaveWidth)});
        const shader::float4 exact =
            shader::WaveExact(lookup.context, lookup.settings, lookup.extent, lookup.uv, lookup.footprint);
        for (int k = 0; k < 4; ++k)
            counts.foreign += std::bit_cast<std::uint32_t>(exact[k]) == pixel[4 + k] ? 0 : 1;
    }
    return counts;
}

/// Decodes of the picture on emulated waves of `lanes`.
std::uint64_t CountEmulated(const WaveScene& scene, std::uint32_t lanes) {
    openntc_filtering::WaveEmulator wave;
    std::uint64_t decodes = 0;
    const int width = lanes >= 32 ? 8 : 4, height = static_cast<int>(lanes) / width;
    for (int y = 0; y < static_cast<int>(kWaveHeight); y += height) {
        for (int x = 0; x < static_cast<int>(kWaveWidth); x += width) {
            const auto at = [&](std::uint32_t lane) {
                return shader::int2(x, y) + shader::GetWavePixel(lane);
            };
            std::uint32_t words[128][WAVE_WORDS] = {};
            wave.Execute(
                lanes, [&](std::uint32_t lane) { return !shader::IsWaveDiscarded(scene, at(lane)); },
                [&](std::uint32_t lane) {
                    shader::waveDecodes = 0;
                    shader::RunWavePixel(scene, at(lane), lane, true, words[lane]);
                });
            for (std::uint32_t lane = 0; lane < lanes; ++lane)
                decodes += words[lane][8];
        }
    }
    CHECK(wave.GetFindings() == "");
    return decodes;
}

bool CanRunWaves(const Context& context) {
    const DeviceInfo& device = context.GetDevice();
    if (device.hasSubgroupShuffle && device.subgroupSize >= 4 && device.subgroupSize <= 64)
        return true;
    MESSAGE("SKIP: shader_filtering: waves: subgroups of " << device.subgroupSize
                                                           << " lanes, or no shuffles");
    return false;
}

} // namespace

TEST_CASE("waves on a device: collaboration has the exact filter's bits") {
    OPENNTC_REQUIRE_DEVICE(context);
    if (!CanRunWaves(*context))
        return;
    const std::uint32_t lanes = context->GetDevice().subgroupSize;
    for (const WaveStage stage : {WaveStage::Glsl, WaveStage::Hlsl}) {
        const WaveRunner runner(*context, stage);
        for (std::uint32_t kernel = NTC_KERNEL_BILINEAR; kernel <= NTC_KERNEL_CUBIC; ++kernel) {
            for (const double magnification : {1.0, 1.5, 2.0, 4.0, 8.0, 16.0}) {
                for (const bool isTurned : {false, true}) {
                    CAPTURE(static_cast<int>(stage));
                    CAPTURE(kernel);
                    CAPTURE(magnification);
                    CAPTURE(isTurned);
                    const WaveScene scene = MakeDeviceScene(kernel, magnification, isTurned);
                    const WaveCounts counts = CountWaves(scene, runner.Run(scene));
                    CHECK(counts.pixels == kWaveWidth * kWaveHeight);
                    CHECK(counts.different == 0);
                    CHECK(counts.foreign == 0);
                    // The texels that waves need are counted, not guessed.
                    if (magnification == 2.0 && isTurned && kernel == NTC_KERNEL_BILINEAR)
                        CHECK(counts.decodes == CountEmulated(scene, lanes));
                }
            }
        }
        // Keys, islands, mips, a pattern of pixels that take no part.
        for (const std::uint32_t flags : {WAVE_DISCARD, WAVE_KEYS, WAVE_ISLANDS, WAVE_MIPS,
                                          WAVE_DISCARD | WAVE_KEYS | WAVE_MIPS | WAVE_ISLANDS}) {
            CAPTURE(flags);
            WaveScene scene = MakeDeviceScene(NTC_KERNEL_BILINEAR, 1.3, true);
            scene.flags = flags;
            scene.wrap = NTC_WRAP_BORDER;
            scene.u = -0.05f;
            scene.mips = NTC_MIPS_LINEAR;
            scene.lod = 30000;
            const WaveCounts counts = CountWaves(scene, runner.Run(scene));
            CHECK(counts.pixels > 500);
            CHECK(counts.different == 0);
            CHECK(counts.foreign == 0);
        }
    }
}

TEST_CASE("waves in fragment shaders: partial waves, triangles of a pixel, and after discard") {
    OPENNTC_REQUIRE_DEVICE(context);
    if (!CanRunWaves(*context))
        return;
    if (!context->GetDevice().features.Has(Feature::FragmentStores)) {
        MESSAGE(
            "SKIP: fragment shaders: " << context->GetDevice().features.GetAbsence(Feature::FragmentStores));
        return;
    }
    for (const WaveStage stage : {WaveStage::Screen, WaveStage::Triangles}) {
        const WaveRunner runner(*context, stage);
        for (const std::uint32_t flags : {0u, WAVE_DISCARD, WAVE_DISCARD | WAVE_KEYS}) {
            for (const double magnification : {1.0, 4.0}) {
                CAPTURE(static_cast<int>(stage));
                CAPTURE(flags);
                WaveScene scene = MakeDeviceScene(NTC_KERNEL_BILINEAR, magnification, true);
                scene.flags = flags;
                const WaveCounts counts = CountWaves(scene, runner.Run(scene));
                CHECK(counts.pixels > (stage == WaveStage::Screen ? 500 : 100));
                CHECK((counts.pixels < 1024) == (flags != 0 || stage == WaveStage::Triangles));
                CHECK(counts.different == 0);
                CHECK(counts.foreign == 0);
                CHECK(counts.decodes < 4u * static_cast<std::uint64_t>(counts.pixels));
            }
        }
    }
}

TEST_CASE("waves on a device: the error and the bias of shared texels are what the specification measured") {
    OPENNTC_REQUIRE_DEVICE(context);
    if (!CanRunWaves(*context))
        return;
    // Few frames at a time: an invocation of lavapipe leaves its loops after 65535 rounds of all of them.
    const std::uint32_t frames = 200, places = 6;
    const WaveRunner runner(*context, WaveStage::Glsl);
    struct Row {
        double magnification, noise, bias; // of 2 x 2, renormalised
    };
    for (const Row& row : {Row{1, 0.169, 0.064}, Row{2, 0.115, 0.074}, Row{4, 0.096, 0.050},
                           Row{8, 0.089, 0.043}, Row{16, 0.088, 0.025}}) {
        CAPTURE(row.magnification);
        WaveScene scene = MakeDeviceScene(NTC_KERNEL_BILINEAR, row.magnification, false);
        scene.flags = WAVE_SHARE;
        scene.frames = frames;
        double noise = 0, bias = 0;
        for (std::uint32_t place = 0; place < places;
             ++place) { // of the texture: magnified, each shows little
            scene.u = static_cast<float>(place) * 0.1618f;
            scene.frame = place * frames;
            const WordList words = runner.Run(scene);
            for (std::size_t i = 0; i < words.size() / WAVE_WORDS * 4; ++i) {
                const std::uint32_t* const pixel = words.data() + i / 4 * WAVE_WORDS + i % 4;
                const double mean = double{std::bit_cast<float>(pixel[0])} / frames;
                noise += double{std::bit_cast<float>(pixel[11])} / frames;
                bias += std::pow(mean - double{std::bit_cast<float>(pixel[4])}, 2);
            }
        }
        const double count = 4.0 * kWaveWidth * kWaveHeight * places;
        CHECK(std::sqrt(noise / count) < 1.5 * row.noise);
        CHECK(std::sqrt(noise / count) > 0.5 * row.noise);
        CHECK(std::sqrt(bias / count) < 1.5 * row.bias);
        CHECK(std::sqrt(bias / count) > 0.004); // it is there
        MESSAGE("magnified " << row.magnification << ": error of a frame " << std::sqrt(noise / count)
                             << ", bias " << std::sqrt(bias / count));
    }
}
