// SPDX-License-Identifier: MIT
// Whole trainings on a device: as good as the processor's, the same bytes again, and after interruptions.
#include "shader/TestDevice.h"
#include "shader/training/TrainingCase.h"
#include "vulkan_harness/TrainingQueue.h"

#include "openntc/encode/DeviceEncoder.h"

using namespace openntc;
using namespace openntc::encode;
using namespace openntc::test;

namespace {

/// Steps of a training: `few` under sanitizers.
constexpr std::uint64_t Steps([[maybe_unused]] std::uint64_t steps, [[maybe_unused]] std::uint64_t few) {
#ifdef OPENNTC_TEST_SANITIZED
    return few;
#else
    return steps;
#endif
}

EncodeOptions MakeOptions(std::uint64_t steps) {
    EncodeOptions options;
    options.steps = steps;
    options.batchTexels = 1024;
    options.latentShape = {4, 4, 4, 2, 4};
    options.networkVersion = NTC_NETWORK_SMALL;
    options.reportSeconds = 0.0;
    return options;
}

Expected<EncodeResult> EncodeOnDevice(const Material& material, const EncodeOptions& options,
                                      const ProgressCallback& progress = {}) {
    OPENNTC_ASSIGN(const std::unique_ptr<TrainingDevice> device,
                   harness::MakeTrainingQueue(*openntc_tests::GetTestContext()));
    return DeviceEncoder::Encode(material, options, *device, progress);
}

Expected<EncodeResult> EncodeOnProcessor(const Material& material, const EncodeOptions& options) {
    const ProgressCallback none;
#if OPENNTC_FAST_X86
    if (IsKernelAvailable(KernelChoice::Avx2))
        return encode::detail::EncodeRun<encode::detail::avx2::Kernel, encode::detail::Fp8Avx2Kernel>(
                   material, options, options.latentShape)
            .Run(none);
#endif
    return encode::detail::EncodeRun<encode::detail::PortableKernel, encode::detail::Fp8Kernel>(
               material, options, options.latentShape)
        .Run(none);
}

} // namespace

TEST_CASE("a training on a device is as good as the processor's of as many samples") {
    OPENNTC_REQUIRE_DEVICE(context);
    const Material material = MakeWaves(32, 32);
    EncodeOptions options = MakeOptions(Steps(30, 10));
    const auto trained = EncodeOnDevice(material, options);
    REQUIRE(trained);
    // A training as short depends on its noise: the processor's with other seeds show by how much.
    double worst = 1000.0;
    for (options.seed = 1; options.seed <= 8; ++options.seed) {
        const auto expected = EncodeOnProcessor(material, options);
        REQUIRE(expected);
        worst = std::min(worst, expected->psnr);
    }
    CHECK(trained->psnr > worst - 0.1);
}

TEST_CASE("trainings on a device give the same bytes again, and after an interruption") {
    OPENNTC_REQUIRE_DEVICE(context);
    const Material material = MakeWaves(32, 20);
    EncodeOptions options = MakeOptions(5);
    std::vector<std::byte> saved;
    options.saveSeconds = 0.0;
    options.save = [&saved](std::span<const std::byte> state, double) {
        if (saved.empty())
            saved.assign(state.begin(), state.end());
    };
    const auto first = EncodeOnDevice(material, options);
    REQUIRE(first);
    options.save = {};
    const auto again = EncodeOnDevice(material, options);
    REQUIRE(again);
    CHECK(again->file == first->file);

    REQUIRE(!saved.empty());
    options.resumeState = saved;
    const auto resumed = EncodeOnDevice(material, options);
    REQUIRE(resumed);
    CHECK(resumed->file == first->file);

    const auto cancelled =
        EncodeOnDevice(material, MakeOptions(5), [](const Progress& p) { return p.step < 2; });
    REQUIRE(cancelled);
    REQUIRE(cancelled->cancelled);
    CHECK(cancelled->file.empty());
    options.resumeState = cancelled->state;
    const auto continued = EncodeOnDevice(material, options);
    REQUIRE(continued);
    CHECK(continued->file == first->file);
    CHECK(continued->steps == 5);

    const auto refused = EncodeOnProcessor(material, options);
    REQUIRE(!refused);
    CHECK(refused.error().GetStatus() == Status::FileIncompatible);
}

TEST_CASE("a device that is lost leaves the last good state") {
    OPENNTC_REQUIRE_DEVICE(shared);
    harness::ContextOptions contextOptions;
    contextOptions.device = openntc_tests::GetTestDeviceName();
    contextOptions.faults.submissions = 40;
    const auto context = harness::Context::Create(contextOptions);
    REQUIRE(context);
    const auto device = harness::MakeTrainingQueue(**context);
    REQUIRE(device);
    const Material material = MakeWaves(32, 20);
    EncodeOptions options = MakeOptions(1000);
    std::vector<std::byte> saved;
    options.save = [&saved](std::span<const std::byte> state, double) {
        saved.assign(state.begin(), state.end());
    };
    const auto lost = DeviceEncoder::Encode(material, options, **device);
    REQUIRE(!lost);
    CHECK(lost.error().GetStatus() == Status::Unsupported);
    REQUIRE(!saved.empty());
    options = MakeOptions(3);
    options.resumeState = saved;
    const auto resumed = EncodeOnDevice(material, options);
    REQUIRE(resumed);
    const auto whole = EncodeOnDevice(material, MakeOptions(3));
    REQUIRE(whole);
    CHECK(resumed->file == whole->file);
}
