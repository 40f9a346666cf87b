// SPDX-License-Identifier: MIT
// Files as LibNTC 0.5 wrote them: types on the network, binary32 biases. Expected values by hand.
#include "EditedFile.h"

#include <limits>
#include <string>

using namespace openntc;
using namespace openntc_tests;

namespace {

EditedFile MakeLegacy() {
    EditedFile file = EditV1();
    file.ReplaceAll(",\"weightType\":\"Int8\",\"scaleType\":\"Float32\",\"biasType\":\"Int32\"", "");
    file.Replace("\"weightLayout\":\"RowMajor\"",
                 "\"weightLayout\":\"RowMajor\",\"weightType\":\"Int8\",\"scaleBiasType\":\"Float32\"");
    const std::size_t biases[] = {3328, 7936, 12544}; // layers 0 – 2
    for (const std::size_t offset : biases) {
        for (std::size_t row = 0; row < 64; ++row)
            file.Store(offset + 4 * row, 0.0f);
    }
    for (std::size_t row = 0; row < 16; ++row)
        file.Store(13888 + 4 * row, 0.0f);
    return file;
}

template <typename T>
T Read(std::span<const std::byte> bytes, std::size_t offset) {
    T value;
    std::memcpy(&value, bytes.data() + offset, sizeof value);
    return value;
}

} // namespace

TEST_CASE("binary32 biases become integers") {
    EditedFile file = MakeLegacy();
    const float scales[] = {0.5f, 0.5f, 0.0f, -0.0f, 1e-20f, -1e-20f, 0.25f};
    const float biases[] = {1.25f, -1.25f, 1.5f, -0.00001f, 1.0f, 1.0f, 1e9f};
    //                2.5 → 3    −2.5 → −3   constant   constant   saturates, both ways; 4e9 saturates
    const std::int32_t expected[] = {
        3, -3, 98304, -1, 2147483647, std::numeric_limits<std::int32_t>::min(), 2147483647};
    for (std::size_t row = 0; row < 7; ++row)
        file.Store(13824 + 4 * row, scales[row]).Store(13888 + 4 * row, biases[row]);
    const auto set = file.Load();
    REQUIRE_MESSAGE(set, std::string(set.error().GetText()));
    const auto weights = *set->GetInferenceWeights(InferenceWeightType::GenericInt8);
    for (std::size_t row = 0; row < 7; ++row) {
        CAPTURE(row);
        const bool isConstant = row == 2 || row == 3;
        CHECK(Read<std::int32_t>(weights, 13888 + 4 * row) == expected[row]);
        CHECK(Read<float>(weights, 13056 + 4 * row) == (isConstant ? 0x1p-16f : scales[row]));
        int sum = 0;
        for (std::size_t i = 0; i < 64; ++i)
            sum += Read<std::int8_t>(weights, 11264 + 64 * row + i) != 0 ? 1 : 0;
        CHECK((sum == 0) == isConstant);
    }
    file.Store(13888, std::numeric_limits<float>::quiet_NaN())
        .CheckRefused(Status::FileUnrecognized, "biasView");
}

TEST_CASE("an explicit scale type without a view means scales of one") {
    const auto set = EditV1().Replace("\"scaleView\":1,", "").Load();
    REQUIRE_MESSAGE(set, std::string(set.error().GetText()));
    const auto weights = *set->GetInferenceWeights(InferenceWeightType::GenericInt8);
    CHECK(Read<float>(weights, 12288) == 1.0f);
    CHECK(Read<float>(weights, 12288 + 252) == 1.0f);
    CHECK(Read<float>(weights, 12544) != 1.0f);
}
