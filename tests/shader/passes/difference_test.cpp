// SPDX-License-Identifier: MIT
// The pass ImageDifference on the device, in both languages: the C++ build's numbers and those of a model in whole numbers,
// whatever the rectangle; sums beyond 32 bits; alpha rule, logarithm, numbers that cannot be measured.
#include "shader/TestDevice.h"
#include "shader/passes/PassDevice.h"

#include "difference_hlsl_shaders.h"
#include "difference_shaders.h"

#include "openntc/passes/ImageDifferenceReference.h"

#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <vector>

using namespace openntc;
using namespace openntc::harness;
using namespace openntc_tests;
using namespace passes_test;

namespace {

constexpr unsigned kDifferenceSeed = 4711;

class DifferenceDevice {
public:
    DifferenceDevice(Context& context, bool isHlsl) : context_(context) {
        const auto shader = isHlsl ? difference_hlsl_shaders::FindShader("ImageDifference.hlsl", "")
                                   : difference_shaders::FindShader("ImageDifference.comp", "");
        static constexpr BufferSlot kSlots[] = {
            {0, BufferKind::Texture}, {1, BufferKind::Texture}, {2, BufferKind::Storage}};
        pipeline_ =
            Take(context.CreateComputePipeline(Take(shader), kSlots, sizeof(NtcImageDifferenceConstants)));
        results_ = Take(context.CreateBuffer(256, BufferKind::Storage, BufferMemory::HostVisible));
    }

    ImageDifferenceResult Measure(const Image& first, const Image& second, ImageDifferenceRequest request,
                                  bool isAdded = false) {
        request.outputOffset = 16;
        const ImageDifferencePass pass = Take(MakeImageDifferencePass(request));
        if (!isAdded)
            REQUIRE(context_.Write(results_, 0, std::vector<std::byte>(256)));
        const BoundBuffer buffers[] = {{2, &results_}};
        const BoundImage images[] = {{0, &first}, {1, &second}};
        DispatchRequest dispatch;
        dispatch.pipeline = &pipeline_;
        dispatch.buffers = buffers;
        dispatch.images = images;
        dispatch.pushConstants = std::as_bytes(std::span(&pass.constants, 1));
        std::copy(std::begin(pass.groups), std::end(pass.groups), std::begin(dispatch.groups));
        Take(context_.Dispatch(dispatch));
        std::array<std::uint32_t, 64> words{};
        REQUIRE(context_.Read(results_, 0, std::as_writable_bytes(std::span(words))));
        for (std::size_t i = 0; i < words.size(); ++i) // nothing is written beside the result
            CHECK((words[i] == 0 || (i >= 4 && i < 14)));
        return ReadImageDifference(std::span(words).subspan<4, 10>());
    }

private:
    Context& context_;
    ComputePipeline pipeline_;
    Buffer results_;
};

struct FloatImage {
    std::vector<float> components;
    int width;
    int height;

    DifferenceImage View() const { return {components, width, height}; }
};

FloatImage MakeFloats(std::mt19937& random, int width, int height, float scale) {
    FloatImage image{{}, width, height};
    for (int i = 0; i < 4 * width * height; ++i)
        image.components.push_back(scale * (static_cast<float>(random() % 20001u) / 10000.0f - 1.0f));
    return image;
}

Image Upload(Context& context, const FloatImage& image) {
    Image result = Take(context.CreateImage(ImageFormat::RGBA32F, static_cast<std::uint32_t>(image.width),
                                            static_cast<std::uint32_t>(image.height)));
    REQUIRE(context.Write(result, std::as_bytes(std::span(image.components))));
    return result;
}

} // namespace

TEST_CASE("image difference: 8-bit images by whole numbers, any rectangle, in both languages") {
    OPENNTC_REQUIRE_DEVICE(context);
    MESSAGE("seed " << kDifferenceSeed);
    std::mt19937 random(kDifferenceSeed);
    constexpr int kWidth = 150, kHeight = 131, kSecondWidth = 170, kSecondHeight = 140;
    const auto make = [&random](int count) {
        std::vector<std::byte> bytes;
        for (int i = 0; i < 4 * count; ++i)
            bytes.push_back(static_cast<std::byte>(random() & 255u));
        return bytes;
    };
    const std::vector<std::byte> a = make(kWidth * kHeight), b = make(kSecondWidth * kSecondHeight);
    const Image first = Take(context->CreateImage(ImageFormat::RGBA8, kWidth, kHeight));
    const Image second = Take(context->CreateImage(ImageFormat::RGBA8, kSecondWidth, kSecondHeight));
    REQUIRE(context->Write(first, a));
    REQUIRE(context->Write(second, b));
    for (const bool isHlsl : {false, true}) {
        DifferenceDevice device(*context, isHlsl);
        for (int i = 0; i < 12; ++i) {
            const auto pick = [&random](int low, int high) {
                return low + static_cast<int>(random() % static_cast<unsigned>(high - low + 1));
            };
            ImageDifferenceRequest request;
            request.rect = {pick(0, kWidth - 1), pick(0, kHeight - 1), 1, 1};
            if (i == 0)
                request.rect = {0, 0, kWidth, kHeight};
            else if (i > 2)
                request.rect = {request.rect.left, request.rect.top, pick(1, kWidth - request.rect.left),
                                pick(1, kHeight - request.rect.top)};
            request.secondLeft = pick(0, kSecondWidth - request.rect.width);
            request.secondTop = pick(0, kSecondHeight - request.rect.height);
            if (i % 3 == 1)
                request.alphaThreshold = 128.0f / 255.0f;
            ImageDifferenceResult expected;
            for (int y = 0; y < request.rect.height; ++y) {
                for (int x = 0; x < request.rect.width; ++x) {
                    const std::size_t p =
                        static_cast<std::size_t>((request.rect.top + y) * kWidth + request.rect.left + x);
                    const std::size_t q = static_cast<std::size_t>((request.secondTop + y) * kSecondWidth +
                                                                   request.secondLeft + x);
                    const auto code = [](const std::vector<std::byte>& bytes, std::size_t texel,
                                         std::size_t k) {
                        return std::to_integer<int>(bytes[4 * texel + k]);
                    };
                    const bool isHidden =
                        request.alphaThreshold.has_value() && code(a, p, 3) < 128 && code(b, q, 3) < 128;
                    for (std::size_t k = 0; k < 4; ++k) {
                        const int d = code(a, p, k) - code(b, q, k);
                        if (k == 3 || !isHidden)
                            expected.squaredErrors[k] += static_cast<std::uint64_t>(d * d);
                    }
                }
            }
            CAPTURE(i);
            CHECK(device.Measure(first, second, request) == expected);
        }
    }
    CHECK(context->GetValidationLog().errors.empty());
}

TEST_CASE("image difference: floats are the C++ build's, sums pass 32 bits, rectangles add up") {
    OPENNTC_REQUIRE_DEVICE(context);
    std::mt19937 random(kDifferenceSeed);
    FloatImage a = MakeFloats(random, 200, 190, 1.0f), b = MakeFloats(random, 200, 190, 1.3f);
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    const float odd[] = {
        std::numeric_limits<float>::quiet_NaN(), kInfinity, -kInfinity, 1e30f, -0.0f, 1e-42f, 1000.0f};
    for (std::size_t i = 0; i < std::size(odd); ++i)
        a.components[4000 + 5 * i] = odd[i];
    const Image first = Upload(*context, a), second = Upload(*context, b);
    for (const bool isHlsl : {false, true}) {
        DifferenceDevice device(*context, isHlsl);
        for (const float steps : {255.0f, 65535.0f, 3.7f}) {
            ImageDifferenceRequest request;
            request.rect = {0, 0, 200, 190};
            request.steps = steps;
            const ImageDifferenceResult expected = Take(MeasureImageDifference(a.View(), b.View(), request));
            CHECK(device.Measure(first, second, request) == expected);
            // NaN, three large numbers and, in many steps, 1000; in 65535 steps every difference above 1.
            if (steps < 65535.0f)
                CHECK(expected.unmeasured == (steps > 100.0f ? 5 : 4));
            else
                CHECK(expected.unmeasured > 5);
            if (steps == 65535.0f)
                CHECK(expected.squaredErrors[0] > std::uint64_t{1} << 32);
            request.rect = {0, 0, 200, 67};
            device.Measure(first, second, request);
            request.rect = {0, 67, 200, 123};
            request.secondTop = 67;
            CHECK(device.Measure(first, second, request, true) == expected);
            // Against double precision, without the odd numbers.
            request.rect = {0, 67, 200, 123};
            const ImageDifferenceResult rest = Take(MeasureImageDifference(a.View(), b.View(), request));
            if (steps == 65535.0f)
                continue;
            double exact = 0;
            for (std::size_t i = 67 * 200; i < std::size_t{190} * 200; ++i)
                exact += std::pow(
                    static_cast<double>(a.components[4 * i]) - static_cast<double>(b.components[4 * i]), 2);
            exact /= 200 * 123;
            // |d| <= 2.3 is off by 1 / steps at most.
            CHECK(std::fabs(rest.GetMeanSquaredError(0, 200 * 123, steps) - exact) <=
                  4.6 / static_cast<double>(steps) + 1 / std::pow(static_cast<double>(steps), 2));
        }
        ImageDifferenceRequest logarithmic;
        logarithmic.rect = {0, 67, 200, 123};
        logarithmic.secondTop = 67;
        logarithmic.steps = 10000;
        logarithmic.isLogarithmic = true;
        const ImageDifferenceResult expected = Take(MeasureImageDifference(a.View(), b.View(), logarithmic));
        const ImageDifferenceResult result = device.Measure(first, second, logarithmic);
        for (std::size_t k = 0; k < 4; ++k) {
            // Values below ln 2.3 differ by a step at most: sums of d^2 by 2 |d| + 1 a texel.
            const double texels = 200 * 123;
            const double difference =
                static_cast<double>(result.squaredErrors[k]) - static_cast<double>(expected.squaredErrors[k]);
            CHECK(std::fabs(difference) <= texels * (2 * 8330 + 1));
            CHECK(std::fabs(difference) <= 1e-3 * static_cast<double>(expected.squaredErrors[k]));
        }
        double exact = 0;
        for (std::size_t i = 67 * 200; i < std::size_t{190} * 200; ++i)
            exact += std::pow(std::log(std::fabs(static_cast<double>(a.components[4 * i + 1])) + 1) -
                                  std::log(std::fabs(static_cast<double>(b.components[4 * i + 1])) + 1),
                              2);
        CHECK(result.GetMeanSquaredError(1, 1, 10000.0f) == doctest::Approx(exact).epsilon(1e-3));
    }
}

TEST_CASE("image difference: what is not possible is refused") {
    const auto refuse = [](Status status, auto change) {
        ImageDifferenceRequest request;
        request.rect = {0, 0, 8, 8};
        change(request);
        const auto pass = MakeImageDifferencePass(request);
        REQUIRE_FALSE(pass);
        CHECK(pass.error().GetStatus() == status);
    };
    using R = ImageDifferenceRequest;
    refuse(Status::OutOfRange, [](R& r) { r.rect.width = 0; });
    refuse(Status::OutOfRange, [](R& r) { r.rect.left = -1; });
    refuse(Status::OutOfRange, [](R& r) { r.secondTop = -1; });
    refuse(Status::OutOfRange, [](R& r) { r.secondLeft = std::numeric_limits<int>::max() - 7; });
    refuse(Status::OutOfRange, [](R& r) { r.rect.width = r.rect.height = 1 << 17; });
    refuse(Status::OutOfRange, [](R& r) { r.outputOffset = 2; });
    refuse(Status::OutOfRange, [](R& r) { r.outputOffset = std::uint64_t{1} << 34; });
    refuse(Status::InvalidArgument, [](R& r) { r.steps = 0; });
    refuse(Status::InvalidArgument, [](R& r) { r.steps = std::numeric_limits<float>::quiet_NaN(); });
    refuse(Status::InvalidArgument, [](R& r) { r.alphaThreshold = std::numeric_limits<float>::quiet_NaN(); });
    const std::vector<float> few(4 * 63);
    const DifferenceImage image = {few, 8, 8};
    ImageDifferenceRequest request;
    request.rect = {0, 0, 8, 8};
    CHECK_FALSE(MeasureImageDifference(image, image, request));
}
