// SPDX-License-Identifier: MIT
// Slices against what LibNTC cuts out of the same files: constants, sizes, checksums of the bytes,
// conservative sizes. The recorded slices that LibNTC refuses by mistake have their own record of what is
// right.
#include "conformance/ConformanceFolder.h"
#include "conformance/Expectations.h"
#include "support/Vectors.h"

#include "openntc/core/Crc32.h"
#include "openntc/inference/PartialInference.h"

#include <doctest/doctest.h>

#include <cstdio>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

using namespace openntc;
using namespace openntc_tests;

namespace {

std::string ToHexDigits(std::span<const std::byte> bytes) {
    std::string hex;
    for (const std::byte b : bytes) {
        char digits[3];
        std::snprintf(digits, sizeof digits, "%02x", static_cast<unsigned>(b));
        hex += digits;
    }
    return hex;
}

struct CutSlice {
    std::vector<std::byte> latents;
    NtcTextureSetConstants constants;
};

CutSlice Cut(const TextureSetMetadata& set, std::span<const std::byte> file, const SliceDesc& desc) {
    const Expected<std::uint64_t> bytes = GetPartialLatentBufferSize(set, desc);
    REQUIRE(bytes);
    CutSlice slice;
    slice.latents.assign(static_cast<std::size_t>(*bytes), std::byte{0xA5});
    ReadOnlyMemoryStream stream(file);
    const Expected<PartialInferenceData> data =
        MakePartialInferenceData(set, stream, desc, InferenceWeightType::GenericInt8, slice.latents);
    if (!data)
        FAIL(std::string(data.error().GetText()));
    CHECK(data->latentBytes == *bytes);
    slice.constants = data->constants;
    return slice;
}

SliceDesc ReadDesc(const rapidjson::Value& entry) {
    const auto& rect = entry["rect"];
    return {entry["firstMip"].GetInt(),
            entry["numMips"].GetInt(),
            {rect[0].GetInt(), rect[1].GetInt(), rect[2].GetInt(), rect[3].GetInt()},
            SliceCoverage::Published};
}

struct Counts {
    int equal = 0;
    int refused = 0;
    int extended = 0;
};

void CheckConservativeSizes(const TextureSetMetadata& set, const SliceDesc& desc,
                            const rapidjson::Value& entry) {
    for (const auto& [alignment, key] :
         {std::pair{1, "conservativeAlign1"}, std::pair{4, "conservativeAlign4"}}) {
        const Expected<std::uint64_t> bytes = GetConservativeLatentBufferSize(
            set, desc.firstMip, desc.numMips, desc.rect.width, desc.rect.height, alignment);
        REQUIRE(bytes);
        CHECK(*bytes == entry[key].GetUint64());
    }
}

void CheckSlice(const TextureSetMetadata& set, std::span<const std::byte> file, const rapidjson::Value& entry,
                const rapidjson::Value* right, Counts& counts) {
    SliceDesc desc = ReadDesc(entry);
    CHECK(entry["conservativeStatus"].GetInt() == 0);
    CheckConservativeSizes(set, desc, entry);
    const bool isRecorded = entry["status"].GetInt() == 0;
    if (!isRecorded && right == nullptr) {
        REQUIRE(entry["status"].GetInt() == static_cast<int>(Status::OutOfRange));
        const Expected<SliceLayout> layout = GetSliceLayout(set, desc);
        REQUIRE_FALSE(layout);
        CHECK(layout.error().GetStatus() == Status::OutOfRange);
        return;
    }
    const rapidjson::Value& expected = isRecorded ? entry : *right;
    const CutSlice slice = Cut(set, file, desc);
    CHECK(slice.latents.size() == expected["size"].GetUint64());
    CHECK(Crc32(slice.latents) == expected["latentCrc32"].GetUint());
    if (isRecorded) {
        CHECK(ToHexDigits(std::as_bytes(std::span(&slice.constants, 1))) ==
              std::string(entry["constants"].GetString()));
        ++counts.equal;
    } else {
        ++counts.refused;
    }
    // What a slice holds unless LibNTC's cut is asked for is the same.
    desc.coverage = SliceCoverage::Whole;
    const CutSlice whole = Cut(set, file, desc);
    if (whole.latents == slice.latents)
        CHECK(std::memcmp(&whole.constants, &slice.constants, sizeof slice.constants) == 0);
    else
        ++counts.extended;
}

} // namespace

TEST_CASE("slices equal LibNTC's in constants, sizes, checksums and conservative sizes") {
    const std::vector<std::string> names = ListGeneration1Sets();
    if (names.empty()) {
        MESSAGE("SKIP: no conformance vectors: set OPENNTC_SHARED_DIR");
        ReportVectors("slices", 0, 1);
        return;
    }
    const std::vector<std::byte> text = ReadBytes(GetConformanceFolder() / "slices" / "refused-right.json");
    rapidjson::Document refused;
    refused.Parse(reinterpret_cast<const char*>(text.data()), text.size());
    REQUIRE(refused.IsArray());
    Counts counts;
    for (const std::string& name : names) {
        const rapidjson::Document expected = ReadExpectations(name);
        const std::vector<std::byte> file = ReadBytes(GetConformanceFolder() / (name + ".ntc"));
        ReadOnlyMemoryStream stream(file);
        const Expected<TextureSetMetadata> set = TextureSetMetadata::Load(stream);
        REQUIRE(set);
        const auto& slices = expected["slices"];
        for (rapidjson::SizeType i = 0; i < slices.Size(); ++i) {
            const rapidjson::Value* right = nullptr;
            for (const auto& entry : refused.GetArray()) {
                if (entry["set"].GetString() == name && entry["slice"].GetUint() == i)
                    right = &entry;
            }
            INFO(name << " slice " << i);
            CheckSlice(*set, file, slices[i], right, counts);
        }
    }
    CHECK(counts.equal == 272);
    CHECK(counts.refused == static_cast<int>(refused.Size()));
    CHECK(counts.refused == 16);
    // npot-100x37-large, slice 8: 11 texels from x = 35 on of a mip with 50, whose coarsest mip has 1:
    // LibNTC's cut starts at latent pixel 24 of 25, and the texels lie between 17 and 23.
    CHECK(counts.extended == 1);
    ReportVectors("slices", counts.equal + counts.refused, 0);
}
