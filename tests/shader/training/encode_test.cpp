// SPDX-License-Identifier: MIT
// Whole trainings on a device: as good as the processor's, the same bytes again, and after interruptions.
#include "encode/DeviceTraining.h"
#include "encode/Training.h"
#include "shader/TestDevice.h"
#include "shader/training/TrainingCase.h"
#include "vulkan_harness/TrainingQueue.h"

#include "openntc/encode/Kernels.h"

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

EncodeOptions MakeOptions(std::uint64_t steps, int networkVersion = NTC_NETWORK_SMALL) {
    EncodeOptions options;
    options.steps = steps;
    options.batchTexels = 1024;
    options.latentShape =
        GetGeneration(networkVersion) == 3 ? MakeLayeredShape(4, 8) : LatentShape{4, 4, 4, 2, 4};
    options.networkVersion = networkVersion;
    options.reportSeconds = 0.0;
    return options;
}

/// Channels first ... first + count - 1 of texels of `all`.
std::vector<float> PickChannels(const std::vector<float>& texels, std::size_t all, std::size_t first,
                                std::size_t count) {
    std::vector<float> picked;
    for (std::size_t at = first; at < texels.size(); at += all)
        picked.insert(picked.end(), texels.begin() + static_cast<std::ptrdiff_t>(at),
                      texels.begin() + static_cast<std::ptrdiff_t>(at + count));
    return picked;
}

Expected<EncodeResult> EncodeOnDevice(const Material& material, const EncodeOptions& options,
                                      const ProgressCallback& progress = {}) {
    OPENNTC_ASSIGN(const std::unique_ptr<TrainingDevice> device,
                   harness::MakeTrainingQueue(*openntc_tests::GetTestContext()));
    return tool::Train(material, options, *device, progress);
}

Expected<EncodeResult> EncodeOnProcessor(const Material& material, EncodeOptions options) {
    options.kernel = IsKernelAvailable(KernelChoice::Avx2) ? KernelChoice::Avx2 : KernelChoice::Portable;
    return tool::Train(material, options);
}

} // namespace

TEST_CASE("trainings on a device are as good as the processor's of as many samples") {
    OPENNTC_REQUIRE_DEVICE(context);
    const Material material = MakeWaves(32, 32);
    EncodeOptions options = MakeOptions(Steps(3, 1));
    // Equal seeds have the same batches, noise and first weights, so that their difference is that of the arithmetic.
    constexpr int kSeeds = 4;
    double sum = 0.0, squares = 0.0;
    for (int seed = 1; seed <= kSeeds; ++seed) {
        options.seed = static_cast<std::uint32_t>(seed);
        const auto trained = EncodeOnDevice(material, options);
        const auto expected = EncodeOnProcessor(material, options);
        REQUIRE(trained);
        REQUIRE(expected);
        const double difference = trained->psnr - expected->psnr;
        MESSAGE("measure: seed " << seed << ": device " << trained->psnr << " dB, processor "
                                 << expected->psnr);
        sum += difference;
        squares += difference * difference;
    }
    const double mean = sum / kSeeds;
    const double error =
        std::sqrt(std::max(squares / kSeeds - mean * mean, 0.0) / (kSeeds - 1)); // of the mean
    constexpr double kStudent = 4.541; // 99 % of means of four lie within so many errors on one side
    MESSAGE("measure: difference " << mean << " dB, standard error " << error);
    CHECK(mean > -0.1 - kStudent * error);
}

TEST_CASE("trainings on a device give the same bytes again, and after an interruption") {
    OPENNTC_REQUIRE_DEVICE(context);
    const Material material = MakeWaves(32, 20);
    constexpr std::uint64_t kSteps = 3; // of four batches each
    EncodeOptions options = MakeOptions(kSteps);
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
        EncodeOnDevice(material, MakeOptions(kSteps), [](const Progress& p) { return p.step < 1; });
    REQUIRE(cancelled);
    REQUIRE(cancelled->cancelled);
    CHECK(cancelled->file.empty());
    options.resumeState = cancelled->state;
    const auto continued = EncodeOnDevice(material, options);
    REQUIRE(continued);
    CHECK(continued->file == first->file);
    CHECK(continued->steps == kSteps);

    const auto refused = EncodeOnProcessor(material, options);
    REQUIRE(!refused);
    CHECK(refused.error().GetStatus() == Status::FileIncompatible);
}

TEST_CASE("references that do not fit a device come with the steps, to the same bytes") {
    OPENNTC_REQUIRE_DEVICE(context);
    const Material material = MakeWaves(32, 20);
    const EncodeOptions options = MakeOptions(2);
    const auto whole = EncodeOnDevice(material, options);
    REQUIRE(whole);
    const auto device = harness::MakeTrainingQueue(*context);
    REQUIRE(device);
    constexpr std::uint64_t kAll = ~std::uint64_t{0};
    for (const auto& [largestBuffer, refusals] : {std::pair(std::uint64_t{64}, 0), std::pair(kAll, 1)}) {
        SmallDevice small(**device, largestBuffer, refusals);
        const auto streamed = tool::Train(material, options, small);
        REQUIRE(streamed);
        CHECK(streamed->file == whole->file);
    }
    SmallDevice none(**device, kAll, 2);
    const auto refused = tool::Train(material, options, none);
    REQUIRE(!refused);
    CHECK(refused.error().GetStatus() == Status::OutOfMemory);
}

TEST_CASE("generation 3 trains on a device: the same bytes after an interruption and with references that "
          "come with the steps") {
    OPENNTC_REQUIRE_DEVICE(context);
    Material material = MakeWaves(21, 12, 30000.0f);
    REQUIRE(material.AddTexture({.name = "B", .firstChannel = 3, .channels = 1},
                                std::vector<float>(21 * 12, 0.375f)));
    material.GenerateMips();
    EncodeOptions options = MakeOptions(2, NTC_NETWORK_GENERATION_3);
    options.maskChannel = 2;
    options.discardMasked = true;
    std::vector<std::byte> saved;
    options.saveSeconds = 0.0;
    options.save = [&saved](std::span<const std::byte> state, double) {
        if (saved.empty())
            saved.assign(state.begin(), state.end());
    };
    const auto whole = EncodeOnDevice(material, options);
    REQUIRE(whole);
    CHECK(whole->restarts == 0);
    CHECK(std::isfinite(whole->fp8Psnr)); // there is always one
    CHECK(std::isinf(whole->channelPsnr[3]));
    for (std::size_t channel = 0; channel < 3; ++channel)
        CHECK(std::isfinite(whole->channelPsnr[channel]));
    REQUIRE(!saved.empty());
    options.save = {};
    options.resumeState = saved;
    const auto resumed = EncodeOnDevice(material, options);
    REQUIRE(resumed);
    CHECK(resumed->file == whole->file);
    options.resumeState = {};
    const auto device = harness::MakeTrainingQueue(*context);
    REQUIRE(device);
    SmallDevice small(**device, 64, 0);
    const auto streamed = tool::Train(material, options, small);
    REQUIRE(streamed);
    CHECK(streamed->file == whole->file);
}

TEST_CASE("hard materials train on a device: constants, noise, masks, high dynamic range") {
    OPENNTC_REQUIRE_DEVICE(context);
    constexpr int kSize = 20;
    Material material = *Material::Create(kSize, kSize);
    std::vector<float> texels;
    std::uint32_t random = 1;
    for (int i = 0; i < kSize * kSize; ++i) {
        random = random * 1664525u + 1013904223u;
        const float noise = static_cast<float>(random >> 8) / 16777216.0f;
        const float hill = static_cast<float>(i % kSize) / kSize;
        texels.insert(texels.end(),
                      {0.375f, noise, i / kSize < 8 ? 1.0f : 0.0f, hill * hill * 30000.0f, 1e-4f * hill});
    }
    REQUIRE(
        material.AddTexture({.name = "A", .firstChannel = 0, .channels = 3}, PickChannels(texels, 5, 0, 3)));
    REQUIRE(
        material.AddTexture({.name = "B", .firstChannel = 3, .channels = 2}, PickChannels(texels, 5, 3, 2)));
    material.GenerateMips();
    for (const bool discards : {false, true}) {
        EncodeOptions options = MakeOptions(2);
        options.maskChannel = 2;
        options.discardMasked = discards;
        const auto trained = EncodeOnDevice(material, options);
        REQUIRE(trained);
        CHECK(trained->restarts == 0);
        CHECK(std::isinf(trained->channelPsnr[0])); // exact
        for (std::size_t channel = 1; channel < 5; ++channel)
            CHECK(std::isfinite(trained->channelPsnr[channel]));
    }
    // Rates a thousand times too large are taken back, and the training ends with a file.
    EncodeOptions wild = MakeOptions(21);
    wild.rateScale = 1000.0f;
    const auto tamed = EncodeOnDevice(MakeWaves(16, 8), wild);
    REQUIRE(tamed);
    CHECK(!tamed->file.empty());
    CHECK(tamed->restarts > 0);
    // A material of constants needs no training.
    Material flat = *Material::Create(8, 8);
    REQUIRE(flat.AddTexture({.name = "A", .firstChannel = 0, .channels = 1}, std::vector<float>(64, 0.25f)));
    flat.GenerateMips();
    const auto constant = EncodeOnDevice(flat, MakeOptions(4));
    REQUIRE(constant);
    CHECK(std::isinf(constant->psnr));
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
    const auto lost = tool::Train(material, options, **device);
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
