// SPDX-License-Identifier: MIT
// The last number that a reader takes and the first that it refuses, for every size that memory depends on.
#include "EditedFile.h"
#include "RewrittenFile.h"

#include <cstdio>
#include <string>

using namespace openntc;
using namespace openntc_tests;

namespace {

/// Appends a view that has the next number, behind the binary chunk. Returns that number.
std::string AppendView(EditedFile& file, const std::vector<std::byte>& data) {
    std::size_t views = 0;
    const std::size_t array = file.json.find("\"views\":");
    for (std::size_t at = file.json.find("\"offset\"", array); at != std::string::npos;
         at = file.json.find("\"offset\"", at + 1))
        ++views;
    file.binary.resize((file.binary.size() + 3) / 4 * 4);
    const std::string view = ",{\"offset\":" + std::to_string(file.binary.size()) +
                             ",\"storedSize\":" + std::to_string(data.size()) + "}";
    file.json.insert(file.json.size() - 2, view); // before ]}
    file.binary.insert(file.binary.end(), data.begin(), data.end());
    return std::to_string(views);
}

/// Changes `"storedSize":N` of view `number`.
void SetStoredSize(EditedFile& file, std::size_t number, std::size_t bytes) {
    constexpr std::string_view kKey = "\"storedSize\":";
    std::size_t at = file.json.find("\"views\":");
    for (std::size_t i = 0; i <= number; ++i)
        at = file.json.find(kKey, at + 1);
    const std::size_t digits = at + kKey.size();
    file.json.replace(digits, file.json.find('}', digits) - digits, std::to_string(bytes));
}

std::string NumberedTextures(int count) {
    std::string text = "\"textures\":[";
    for (int i = 0; i < count; ++i)
        text += std::string(i > 0 ? "," : "") + "{\"name\":\"t" + std::to_string(i) +
                "\",\"firstChannel\":0,\"numChannels\":1}";
    return text + "]";
}

EditedFile WithTextures(int count) {
    EditedFile file = EditV1();
    const std::size_t begin = file.json.find("\"textures\":[");
    const std::size_t end = file.json.find(']', begin) + 1;
    file.json.replace(begin, end - begin, NumberedTextures(count));
    return file;
}

/// The latent images of the mips, in order.
void SetLatentMips(EditedFile& file, std::initializer_list<int> images) {
    constexpr std::string_view kKey = "\"latentMip\":";
    std::size_t at = 0;
    for (const int image : images) {
        at = file.json.find(kKey, at);
        REQUIRE(at != std::string::npos);
        at += kKey.size();
        file.json[at] = static_cast<char>('0' + image);
    }
}

} // namespace

TEST_CASE("limits: heights of 0 and beyond the largest are refused, as widths are") {
    EditV1().Replace("\"height\":20", "\"height\":0").CheckRefused(Status::OutOfRange, "height: 0");
    EditV1().Replace("\"height\":20", "\"height\":1048577").CheckRefused(Status::OutOfRange, "1048576");
}

TEST_CASE("limits: 64 textures load, 65 do not") {
    const auto most = WithTextures(64).Load();
    REQUIRE_MESSAGE(most, std::string(most.error().GetText()));
    CHECK(most->GetTextures().size() == 64);
    CHECK(most->GetTextures()[63].name == "t63");
    WithTextures(65).CheckRefused(Status::FileUnrecognized, "textures: too many elements: at most 64");
}

TEST_CASE("limits: 512 BC7 records load, 513 do not, and what is not whole records is ignored") {
    std::vector<std::byte> records(std::size_t{4} * 513);
    for (std::size_t i = 0; i < 513; ++i) {
        records[4 * i] = static_cast<std::byte>(i / 64 % 8);
        records[4 * i + 1] = static_cast<std::byte>(i % 64);
        records[4 * i + 2] = static_cast<std::byte>(i % 251);
    }
    const auto with = [&records](std::size_t bytes) {
        EditedFile file = EditV1();
        const std::string view =
            AppendView(file, {records.begin(), records.begin() + static_cast<std::ptrdiff_t>(bytes)});
        return file.Replace("\"firstChannel\":0,",
                            "\"firstChannel\":0,\"bcAccelerationDataView\":" + view + ",");
    };
    const auto most = with(2048).Load();
    REQUIRE_MESSAGE(most, std::string(most.error().GetText()));
    REQUIRE(most->GetTextures()[0].bcModes.size() == 512);
    CHECK(most->GetTextures()[0].bcModes[511].mode == 7);
    CHECK(most->GetTextures()[0].bcModes[511].partition == 63);
    CHECK(most->GetTextures()[0].bcModes[511].frequency == 511 % 251);
    with(2052).CheckRefused(Status::FileUnrecognized, "bcAccelerationDataView: 2052");
    const auto broken = with(2051).Load();
    REQUIRE(broken);
    CHECK(broken->GetTextures()[0].bcModes.empty());
}

TEST_CASE("limits: every view that is one byte shorter than what is read from it is refused by name") {
    // Bytes that are read of the views of V1 and of the FP8 network behind it, in the order of the views.
    struct View {
        std::size_t bytes;
        const char* field;
    };
    const View views[] = {
        {3072, "weightView"}, {256, "scaleView"},   {256, "biasView"},    {4096, "weightView"},
        {256, "scaleView"},   {256, "biasView"},    {4096, "weightView"}, {256, "scaleView"},
        {256, "biasView"},    {1024, "weightView"}, {64, "scaleView"},    {64, "biasView"},
        {3072, "weightView"}, {128, "biasView"},    {4096, "weightView"}, {128, "biasView"},
        {4096, "weightView"}, {128, "biasView"},    {1024, "weightView"}, {64, "scaleView"},
        {64, "biasView"},     {30, "highRes"},      {24, "lowRes"}};
    SynthesisDesc both = GetV1().synthesis;
    both.withFP8 = true;
    const EditedFile file(MakeFile(both));
    for (std::size_t i = 0; i < std::size(views); ++i) {
        CAPTURE(i);
        EditedFile enough = file;
        SetStoredSize(enough, i, views[i].bytes);
        const auto set = enough.Load();
        CHECK_MESSAGE(set, std::string(set ? "" : set.error().GetText()));
        EditedFile cut = file;
        SetStoredSize(cut, i, views[i].bytes - 1);
        const std::string field = std::string(views[i].field) + ": ";
        cut.CheckRefused(Status::FileUnrecognized, field);
        cut.CheckRefused(Status::FileUnrecognized, ".storedSize: " + std::to_string(views[i].bytes - 1) +
                                                       ": needs at least " + std::to_string(views[i].bytes));
    }
}

TEST_CASE("limits: a view that nobody reads starts at a multiple of 4 too") {
    for (const int offset : {1, 2, 3}) {
        CAPTURE(offset);
        EditedFile file = EditV1();
        file.json.insert(file.json.size() - 2,
                         ",{\"offset\":" + std::to_string(offset) + ",\"storedSize\":4}");
        file.CheckRefused(Status::FileUnrecognized, "offset: " + std::to_string(offset));
    }
    EditedFile file = EditV1();
    file.json.insert(file.json.size() - 2, ",{\"offset\":4,\"storedSize\":4}");
    CHECK(file.Load());
}

// All layers of a medium network are 64 wide, so that it can borrow views of a small one: nothing but its version is
// wrong with it.
TEST_CASE("limits: networks of two versions in one file are refused for that") {
    const auto layer = [](int outputs, int view) {
        char text[256];
        std::snprintf(
            text, sizeof text,
            "{\"inputChannels\":64,\"outputChannels\":%d,\"weightView\":%d,\"scaleView\":%d,"
            "\"biasView\":%d,\"weightType\":\"Int8\",\"scaleType\":\"Float32\",\"biasType\":\"Int32\"}",
            outputs, view, view + 1, view + 2);
        return std::string(text);
    };
    const std::string medium = "{\"layers\":[" + layer(64, 3) + "," + layer(64, 3) + "," + layer(64, 6) +
                               "," + layer(16, 9) +
                               "],\"activation\":\"HGELUClamp\",\"weightLayout\":\"RowMajor\"}";
    EditedFile two = EditV1();
    const std::size_t textures = two.json.find("\"textures\"");
    two.json.insert(textures, "\"mlpVersions\":[" + medium + "],");
    two.CheckRefused(Status::FileUnrecognized, "mlpVersions[0]: medium network");

    // The medium network alone is sound.
    EditedFile one = EditV1();
    const std::size_t mlp = one.json.find("\"mlp\":");
    one.json.replace(mlp, one.json.find("\"textures\"") - mlp, "\"mlp\":" + medium + ",");
    const auto set = one.Load();
    REQUIRE_MESSAGE(set, std::string(set.error().GetText()));
    CHECK(set->GetNetworkVersion() == NTC_NETWORK_MEDIUM);
}

TEST_CASE("limits: rewriting a latent view that was cut short does not take in the bytes behind it") {
    EditedFile file = EditV1(); // 6 x 5 pixels of 8 bits: 30 bytes in 8 words
    const std::size_t grid = 13952;
    file.Store<std::uint16_t>(grid + 30, 0xABCD);
    SetStoredSize(file, 12, 30);
    CHECK(Rewrite(file.Build()) == Rewrite(SynthesizeV1())); // whose last word is padded with zeros
}

TEST_CASE("limits: runs of mips when their latent images are not in order") {
    EditedFile file(SynthesizeV2());
    SetLatentMips(file, {1, 1, 0, 0, 1, 1});
    const auto set = file.Load();
    REQUIRE_MESSAGE(set, std::string(set.error().GetText()));
    CHECK(set->GetFusedMipLevels(0) == MipRange{0, 1});
    CHECK(set->GetFusedMipLevels(1) == MipRange{0, 1});
    CHECK(set->GetFusedMipLevels(2) == MipRange{2, 3});
    CHECK(set->GetFusedMipLevels(3) == MipRange{2, 3});
    CHECK(set->GetFusedMipLevels(4) == MipRange{4, 5});
    CHECK(set->GetMipLevelsForLatentImage(0) == MipRange{2, 3});
    CHECK(set->GetMipLevelsForLatentImage(1) == MipRange{0, 1});
}

TEST_CASE(
    "limits: the latent range of mips holds the images between theirs, wherever these lie in the file") {
    SynthesisDesc desc = GetV1().synthesis;
    desc.desc = {256, 256, 4, 9};
    desc.shape = {2, 4, 8, 2, 4};
    EditedFile file(MakeFile(desc));
    const auto inOrder = file.Load();
    REQUIRE_MESSAGE(inOrder, std::string(inOrder.error().GetText()));
    REQUIRE(inOrder->GetLatentImages().size() == 3);
    // Image 1's high-res grid moves to the end of the file; mips 0 and 1 are served by images 0 and 2.
    const LatentGrid& moved = inOrder->GetLatentImages()[1].highRes;
    const std::uint64_t chunk = file.Build().size() - file.binary.size();
    const std::span<const std::byte> whole = file.binary;
    const auto grid =
        whole.subspan(static_cast<std::size_t>(moved.offset - chunk), static_cast<std::size_t>(moved.size));
    const std::vector<std::byte> copy(grid.begin(), grid.end());
    const std::string view = AppendView(file, copy);
    file.Replace("\"highResView\":14", "\"highResView\":" + view);
    SetLatentMips(file, {0, 2, 2, 2, 2, 2, 2, 2, 2});
    const auto set = file.Load();
    REQUIRE_MESSAGE(set, std::string(set.error().GetText()));
    const auto range = set->GetStreamRangeForLatents(0, 2);
    REQUIRE(range);
    CHECK(range->offset == set->GetLatentImages()[0].highRes.offset);
    CHECK(range->offset + range->size == file.Build().size());
}
