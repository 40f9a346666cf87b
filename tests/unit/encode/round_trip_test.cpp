// SPDX-License-Identifier: MIT
// What the encoder writes, read and decoded by the rest of the project.
#include "DecodedSet.h"
#include "Train.h"

#include "openntc/encode/Kernels.h"

#include <iterator>
#include <string>

using namespace openntc;
using namespace openntc::encode;

namespace {

/// Smooth colours, a stripe pattern, a constant and a mask, in `channels` of one set.
Material MakeMaterial(int width, int height) {
    Material material = *Material::Create(width, height);
    const auto count = static_cast<std::size_t>(width * height);
    std::vector<float> color(count * 3), constant(count, 0.3f), mask(count), rest(count * 2);
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const auto i = static_cast<std::size_t>(y * width + x);
            const float u = static_cast<float>(x) / static_cast<float>(width);
            const float v = static_cast<float>(y) / static_cast<float>(height);
            color[i * 3] = 0.5f + 0.4f * std::sin(6.3f * u);
            color[i * 3 + 1] = 0.5f + 0.4f * std::sin(6.3f * v);
            color[i * 3 + 2] = 0.5f + 0.3f * std::sin(6.3f * (u + v));
            const float distance = std::hypot(u - 0.5f, v - 0.5f);
            mask[i] = std::clamp((0.4f - distance) * 20.0f, 0.0f, 1.0f);
            rest[i * 2] = (x / 8 + y / 8) % 2 == 0 ? 0.2f : 0.8f;
            rest[i * 2 + 1] = u * v;
        }
    }
    REQUIRE(material.AddTexture(
        {.name = "Color", .firstChannel = 0, .channels = 3, .rgbColorSpace = ColorSpace::sRGB}, color));
    REQUIRE(material.AddTexture({.name = "Mask", .firstChannel = 3, .channels = 1}, mask));
    REQUIRE(material.AddTexture({.name = "Constant", .firstChannel = 5, .channels = 1}, constant));
    REQUIRE(material.AddTexture({.name = "Rest", .firstChannel = 9, .channels = 2}, rest));
    material.GenerateMips();
    return material;
}

EncodeOptions Short() {
    EncodeOptions options;
    options.steps = 120;
    options.threads = 2;
    return options;
}

} // namespace

TEST_CASE("the decoded file has the PSNR that training reports, for every network and odd sizes") {
    struct Case {
        int width, height, network;
        float bitsPerPixel;
        LatentShape shape = {}; ///< instead of bits per pixel
    };
    for (const Case& c :
         {Case{64, 64, NTC_NETWORK_MEDIUM, 4.0f}, Case{100, 37, NTC_NETWORK_LARGE, 5.0f},
          Case{64, 48, NTC_NETWORK_SMALL, 2.0f}, Case{33, 20, NTC_NETWORK_XLARGE, 16.0f},
          Case{5, 1, NTC_NETWORK_MEDIUM, 1.0f}, Case{48, 32, NTC_NETWORK_LARGE, 0.0f, {2, 12, 8, 1, 1}}}) {
        CAPTURE(c.width);
        CAPTURE(c.network);
        const Material material = MakeMaterial(c.width, c.height);
        EncodeOptions options = Short();
        options.networkVersion = c.network;
        options.bitsPerPixel = c.bitsPerPixel;
        options.latentShape = c.shape;
        const auto result = test::Train(material, options);
        REQUIRE_MESSAGE(result.has_value(), std::string(result ? "" : result.error().GetText()));
        const auto decoded = test::DecodeFile(result->file);
        const double psnr = test::MeasurePsnr(material, decoded);
        CHECK(psnr > 10.0);
        // 0.05 dB is the project's promise; what remains is the 16-bit storage of references while training.
        CHECK(std::fabs(psnr - result->psnr) < 0.05);
        for (const auto& mip : decoded) {
            for (std::size_t i = 0; i < mip.size(); i += 16) {
                REQUIRE(mip[i + 5] == 0.3f);  // the constant channel, bit for bit
                REQUIRE(mip[i + 12] == 0.0f); // a channel that no texture declares
            }
        }
    }
}

TEST_CASE("equal seeds and steps give equal bytes, whatever the number of threads") {
    const Material material = MakeMaterial(64, 64);
    EncodeOptions options = Short();
    options.steps = test::Steps(40, 8);
    std::vector<std::byte> file;
    for (const KernelChoice kernel : kKernels) {
        // The portable kernel, which takes ten times as long, has its turn where it is the best: under a cap.
        if (!IsKernelAvailable(kernel) || (kernel == KernelChoice::Portable && !file.empty()))
            continue;
        CAPTURE(std::string(KernelToString(kernel)));
        options.kernel = kernel;
        options.threads = 1;
        const auto one = test::Train(material, options);
        REQUIRE(one.has_value());
        CHECK(one->kernel == std::string(KernelToString(kernel)));
        for (const int threads : {2, 3, 8}) {
            options.threads = threads;
            const auto many = test::Train(material, options);
            REQUIRE(many.has_value());
            CHECK(one->file == many->file);
        }
        if (file.empty()) // of the best kernel
            file = one->file;
    }
    options.kernel = KernelChoice::Best;
    options.seed = 2;
    const auto other = test::Train(material, options);
    REQUIRE(other.has_value());
    CHECK(file != other->file);
}

TEST_CASE("all kernels train alike") {
    const Material material = MakeMaterial(48, 48);
    EncodeOptions options = Short();
    options.steps = test::Steps(60, 12);
    double portable = 0.0;
    std::vector<std::byte> binary32; // of kernels that multiply in binary32
    for (auto kernel = std::rbegin(kKernels); kernel != std::rend(kKernels);
         ++kernel) { // the portable one first
        options.kernel = *kernel;
        const auto result = test::Train(material, options);
        if (!IsKernelAvailable(*kernel)) {
            REQUIRE_FALSE(result.has_value());
            CHECK(result.error().GetStatus() == Status::Unsupported);
            MESSAGE("SKIP: " << std::string(result.error().GetText()));
            continue;
        }
        REQUIRE(result.has_value());
        CAPTURE(result->kernel);
        const double psnr = test::MeasurePsnr(material, test::DecodeFile(result->file));
        CHECK(std::fabs(psnr - result->psnr) < 0.05);
        if (*kernel == KernelChoice::Portable)
            portable = psnr;
        // The same gradients up to rounding; after 60 steps rounding has moved the result by a few tenths.
        CHECK(std::fabs(psnr - portable) < 1.5);
        if (*kernel == KernelChoice::Avx2 || *kernel == KernelChoice::Avx512) {
            // One order of sums, each operation rounded once: equal bytes.
            CHECK((binary32.empty() || binary32 == result->file));
            binary32 = result->file;
        }
    }
}

TEST_CASE("a cancelled run resumes to the same bytes") {
    const Material material = MakeMaterial(64, 64);
    EncodeOptions options = Short();
    options.steps = 60;
    const auto whole = test::Train(material, options);
    REQUIRE(whole.has_value());
    options.reportSeconds = 0.0;
    // Within training, within a round of refinement between steps, and within the last round.
    struct Place {
        std::uint64_t step;
        int calls;
    };
    std::vector<std::byte> state;
    for (const Place& place : {Place{25, 1}, Place{54, 3}, Place{60, 3}}) {
        const std::uint64_t step = place.step;
        CAPTURE(step);
        int seen = 0;
        options.resumeState = {};
        const auto part = test::Train(material, options, [&](const Progress& p) {
            seen += p.step == step ? 1 : 0;
            return p.step <= step && seen < place.calls;
        });
        REQUIRE(part.has_value());
        REQUIRE(part->cancelled);
        CHECK(part->file.empty());
        CHECK(part->steps == step);
        state = part->state;
        options.resumeState = state;
        const auto rest = test::Train(material, options);
        REQUIRE(rest.has_value());
        CHECK(rest->file == whole->file);
    }
    const std::vector<std::byte> wrong(state.begin(), state.end() - 1);
    options.resumeState = wrong;
    CHECK_FALSE(test::Train(material, options).has_value());
}

TEST_CASE("a portable run does not go on from another kernel's state, nor the other way round") {
    const KernelChoice best = GetBestKernel();
    if (best == KernelChoice::Portable) {
        MESSAGE("SKIP: this machine has the portable kernel alone");
        return;
    }
    const Material material = MakeMaterial(16, 16);
    EncodeOptions options = Short();
    options.steps = 10;
    options.reportSeconds = 0.0;
    for (const auto& [from, to] :
         {std::pair(best, KernelChoice::Portable), std::pair(KernelChoice::Portable, best)}) {
        options.kernel = from;
        options.resumeState = {};
        const auto part = test::Train(material, options, [](const Progress& p) { return p.step < 5; });
        REQUIRE(part.has_value());
        REQUIRE(part->cancelled);
        options.resumeState = part->state;
        CHECK(test::Train(material, options).has_value());
        options.kernel = to;
        const auto other = test::Train(material, options);
        REQUIRE(!other.has_value());
        CHECK(other.error().GetStatus() == Status::FileIncompatible);
    }
}

TEST_CASE("impossible options are refused") {
    const Material material = MakeMaterial(16, 16);
    EncodeOptions options = Short();
    options.bitsPerPixel = 1000.0f;
    CHECK_FALSE(test::Train(material, options).has_value());
    options = Short();
    options.latentShape = {2, 12, 8, 2, 4};
    options.networkVersion = NTC_NETWORK_SMALL;
    CHECK_FALSE(test::Train(material, options).has_value());
    options = Short();
    options.maskChannel = 7;
    CHECK_FALSE(test::Train(material, options).has_value());
    CHECK_FALSE(test::Train(*Material::Create(4, 4), Short()).has_value());
}
