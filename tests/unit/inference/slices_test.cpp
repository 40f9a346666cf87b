// SPDX-License-Identifier: MIT
// Slices: the arithmetic of their geometry, what they hold, their sizes, and every error.
#include "support/RandomSlices.h"
#include "support/SpecificationVectors.h"

#include "openntc/inference/PartialInference.h"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <tuple>
#include <vector>

using namespace openntc;
using namespace openntc_tests;

namespace {

/// Binary32 as the specification writes it: volatile, so that every operation is rounded, whatever the
/// options.
int GetCellInFloat(int numerator, int denominator, int latents) {
    const volatile float top = static_cast<float>(numerator);
    const volatile float bottom = static_cast<float>(denominator);
    const volatile float grid = static_cast<float>(latents);
    const volatile float ratio = top / bottom;
    const volatile float scaled = ratio * grid;
    const volatile float position = scaled - 0.5f;
    return std::max(static_cast<int>(position), 0);
}

int GetCeilingInFloat(int numerator, int denominator, int latents) {
    const volatile float top = static_cast<float>(numerator);
    const volatile float bottom = static_cast<float>(denominator);
    const volatile float ratio = top / bottom;
    const volatile float scaled = ratio * static_cast<float>(latents);
    return static_cast<int>(std::ceil(scaled));
}

struct SliceFile {
    std::vector<std::byte> bytes;
    TextureSetMetadata metadata;
};

SliceFile LoadSliceFile(const SynthesisDesc& synthesis) {
    std::vector<std::byte> bytes = MakeFile(synthesis);
    ReadOnlyMemoryStream stream(bytes);
    auto metadata = TextureSetMetadata::Load(stream);
    REQUIRE(metadata);
    return {std::move(bytes), std::move(*metadata)};
}

SliceFile LoadSquare() {
    SynthesisDesc synthesis;
    synthesis.desc = {64, 32, 4, 5};
    synthesis.shape = {4, 4, 8, 2, 4};
    return LoadSliceFile(synthesis);
}

struct StatusCase {
    SliceDesc desc;
    const char* field;
};

constexpr int kBig = std::numeric_limits<int>::max();

/// A stream that fails at the read of this number, and remembers how it was used.
/// Without GetMemory: to be read.
class CountingStream final : public Stream {
public:
    CountingStream(std::span<const std::byte> bytes, int failAt) : bytes_(bytes), failAt_(failAt) {}
    bool Read(void* destination, std::size_t bytes) noexcept override {
        return reads_++ != failAt_ && bytes_.Read(destination, bytes);
    }
    bool Write(const void*, std::size_t) noexcept override { return false; }
    bool Seek(std::uint64_t offset) noexcept override { return bytes_.Seek(offset); }
    std::uint64_t Tell() noexcept override { return bytes_.Tell(); }
    std::uint64_t Size() noexcept override { return bytes_.Size(); }

    int GetReads() const { return reads_; }

private:
    ReadOnlyMemoryStream bytes_;
    int failAt_;
    int reads_ = 0;
};

/// All sizes of an axis of a set with that many latents, and a slice of it.
struct AxisCase {
    std::array<ColorMip, NTC_MAX_MIPS> mips;
    int first, coarsest, begin, count, latents;

    detail::SliceAxisSizes GetSizes() const { return {mips, false}; }
    detail::ServedMips GetServed() const { return detail::ServedMips(mips, first, coarsest - first + 1, 0); }
    int GetWidth(int mip) const { return mips[static_cast<std::size_t>(mip)].width; }
};

AxisCase PickAxis(SliceRandom& random) {
    AxisCase axis{};
    const int width = random.Pick(1, 1 << random.Pick(1, 20));
    for (int mip = 0; mip < NTC_MAX_MIPS; ++mip)
        axis.mips[static_cast<std::size_t>(mip)].width = GetMipDimension(width, mip);
    axis.first = random.Pick(0, 5);
    axis.coarsest = axis.first + random.Pick(0, 3);
    const int size = axis.GetWidth(axis.first);
    axis.begin = random.Pick(0, size - 1);
    axis.count = random.Pick(0, 2) == 0 ? random.Pick(1, std::min(size - axis.begin, 40))
                                        : random.Pick(1, size - axis.begin);
    const int cell = random.Pick(2, 16);
    axis.latents = random.Pick(0, 3) == 0
                       ? random.Pick(1, 65535)
                       : std::min(GetLatentGridDimension(width, cell, random.Pick(0, 2)), 65535);
    return axis;
}

/// What decoders read (network.md 2.1), in binary32: the two latent pixels of a texel.
std::array<int, 2> GetTapsInFloat(int texel, int size, int latents) {
    const volatile float center = static_cast<float>(2 * texel + 1) / static_cast<float>(2 * size);
    const volatile float scaled = center * static_cast<float>(latents);
    const volatile float position = scaled - 0.5f;
    const int cell = static_cast<int>(std::floor(position));
    return {std::clamp(cell, 0, latents - 1), std::clamp(cell + 1, 0, latents - 1)};
}

} // namespace

TEST_CASE("slices: three cases that another rounding gets wrong") {
    // (C, L, c0, c1 -> l0, size), format specification, streaming 3.2
    const int cases[][6] = {
        {88, 22, 22, 25, 5, 2}, {2862, 1431, 1441, 1920, 720, 241}, {6512, 3256, 3588, 3700, 1793, 58}};
    for (const auto& [size, latents, begin, last, first, count] : cases) {
        const detail::LatentInterval interval = detail::GetEdgeInterval(size, latents, begin, last + 1);
        CHECK(interval.first == first);
        CHECK(interval.last - interval.first + 1 == count);
        // Exact arithmetic has one more.
        const std::int64_t upper = (2 * std::int64_t{last + 1} * latents - size) / (2 * size) + 1;
        const std::int64_t lower = (2 * std::int64_t{begin} * latents - size) / (2 * size);
        CHECK(upper - lower + 1 == count + 1);
    }
}

TEST_CASE("slices: integers in the place of binary32 give its bits") {
    const std::uint64_t seed = openntc::test::GetTestSeed();
    MESSAGE("OPENNTC_TEST_SEED=" << seed);
    SliceRandom random(seed);
    int different = 0;
    for (int i = 0; i < 300000; ++i) {
        const int denominator = random.Pick(1, 1 << random.Pick(0, 21));
        const int numerator = random.Pick(0, std::min(denominator + 1, 1 << 21));
        const int latents = random.Pick(1, random.Pick(0, 1) == 0 ? 65535 : 64);
        different += detail::GetCell(detail::GetLatentPosition(numerator, denominator, latents)) !=
                             GetCellInFloat(numerator, denominator, latents)
                         ? 1
                         : 0;
        const int texels = random.Pick(1, denominator);
        const int exact = static_cast<int>((std::int64_t{texels} * latents + denominator - 1) / denominator);
        different += detail::GetScaledCeiling(texels, denominator, latents) !=
                             std::max(exact, GetCeilingInFloat(texels, denominator, latents))
                         ? 1
                         : 0;
    }
    INFO("OPENNTC_TEST_SEED=" << seed);
    CHECK(different == 0);
}

TEST_CASE("slices hold the latents of all their texels, and never more than the conservative size") {
    const std::uint64_t seed = openntc::test::GetTestSeed();
    MESSAGE("OPENNTC_TEST_SEED=" << seed);
    SliceRandom random(seed);
    int extended = 0;
    for (int i = 0; i < 200000; ++i) {
        const AxisCase axis = PickAxis(random);
        const auto interval =
            detail::GetSliceInterval(axis.GetSizes(), axis.GetServed(), axis.first, axis.begin,
                                     axis.begin + axis.count, axis.latents, SliceCoverage::Whole);
        const auto published =
            detail::GetSliceInterval(axis.GetSizes(), axis.GetServed(), axis.first, axis.begin,
                                     axis.begin + axis.count, axis.latents, SliceCoverage::Published);
        bool isNeeded = false;
        bool isHeld = true;
        for (int mip = axis.first; mip <= axis.coarsest; ++mip) {
            const int k = mip - axis.first;
            const int from = axis.begin >> k;
            const int to = std::min(((axis.begin + axis.count - 1) >> k) + 1, axis.GetWidth(mip)) - 1;
            for (const int texel : {from, to}) {
                if (texel < from || texel > to)
                    continue;
                const auto [first, second] = GetTapsInFloat(texel, axis.GetWidth(mip), axis.latents);
                isHeld = isHeld && first >= interval.first && second <= interval.last;
                isNeeded = isNeeded || first < published.first || second > published.last;
            }
        }
        int alignment = 1;
        while (alignment < 64 && axis.begin % (2 * alignment) == 0)
            alignment *= 2;
        const int bound = detail::GetConservativeLatents(axis.GetSizes(), axis.GetServed(), axis.first,
                                                         axis.count, alignment, axis.latents, false);
        const int anywhere = detail::GetConservativeLatents(axis.GetSizes(), axis.GetServed(), axis.first,
                                                            axis.count, 1, axis.latents, false);
        const detail::LatentInterval paired = detail::PairHalfBytes(interval, axis.latents);
        const int pairedBound = detail::GetConservativeLatents(axis.GetSizes(), axis.GetServed(), axis.first,
                                                               axis.count, alignment, axis.latents, true);
        const int latents = interval.last - interval.first + 1;
        const bool isRight = isHeld && isNeeded == (interval.first < published.first) &&
                             interval.last == published.last && latents <= bound && latents <= anywhere &&
                             paired.last - paired.first + 1 <= pairedBound && interval.first >= 0 &&
                             interval.last < axis.latents && latents >= 1;
        if (!isRight)
            FAIL_CHECK("OPENNTC_TEST_SEED="
                       << seed << ": mip " << axis.first << " of " << axis.GetWidth(axis.first) << " to mip "
                       << axis.coarsest << ", texels " << axis.begin << " + " << axis.count << ", latents "
                       << axis.latents << ": " << interval.first << " ... " << interval.last << " held "
                       << isHeld << " needed " << isNeeded << " bounds " << bound << ", " << anywhere << ", "
                       << pairedBound << " alignment " << alignment);
        extended += interval.first < published.first ? 1 : 0;
    }
    CHECK(extended > 1000);
}

TEST_CASE("slices: every status, and the size that is needed") {
    const SliceFile file = LoadSquare(); // 64x32, 32x16, 16x8, 8x4, 4x2
    const StatusCase cases[] = {
        {{-1, 1, {0, 0, 1, 1}}, "firstMip"},  {{5, 1, {0, 0, 1, 1}}, "firstMip"},
        {{0, 0, {0, 0, 1, 1}}, "numMips"},    {{0, -1, {0, 0, 1, 1}}, "numMips"},
        {{0, 6, {0, 0, 1, 1}}, "numMips"},    {{4, 2, {0, 0, 1, 1}}, "numMips"},
        {{0, kBig, {0, 0, 1, 1}}, "numMips"}, {{kBig, 1, {0, 0, 1, 1}}, "firstMip"},
        {{0, 1, {-1, 0, 1, 1}}, "left"},      {{0, 1, {64, 0, 1, 1}}, "left"},
        {{0, 1, {0, -1, 1, 1}}, "top"},       {{0, 1, {0, 32, 1, 1}}, "top"},
        {{0, 1, {0, 0, 0, 1}}, "width"},      {{0, 1, {0, 0, -1, 1}}, "width"},
        {{0, 1, {60, 0, 5, 1}}, "width"},     {{0, 1, {1, 0, kBig, 1}}, "width"},
        {{0, 1, {0, 0, 1, 0}}, "height"},     {{0, 1, {0, 30, 1, 3}}, "height"},
        {{0, 1, {0, 0, 1, 33}}, "height"}, // LibNTC tests against the width and takes it
        {{1, 1, {0, 0, 33, 1}}, "width"},
    };
    std::vector<std::byte> latents(4096);
    ReadOnlyMemoryStream stream(file.bytes);
    for (const StatusCase& entry : cases) {
        INFO(ToText(entry.desc));
        const auto layout = GetSliceLayout(file.metadata, entry.desc);
        const auto size = GetPartialLatentBufferSize(file.metadata, entry.desc);
        const auto data = MakePartialInferenceData(file.metadata, stream, entry.desc,
                                                   InferenceWeightType::GenericInt8, latents);
        REQUIRE_FALSE(layout);
        REQUIRE_FALSE(size);
        REQUIRE_FALSE(data);
        CHECK(layout.error().GetStatus() == Status::OutOfRange);
        CHECK(data.error().GetStatus() == Status::OutOfRange);
        CHECK(std::string(layout.error().GetText()).starts_with(std::string(entry.field) + ": "));
        CHECK(std::string(data.error().GetText()) == layout.error().GetText());
    }
    // A tall rectangle of a tall set: LibNTC refuses it.
    SynthesisDesc tall;
    tall.desc = {8, 40, 4, 1};
    tall.shape = {4, 4, 8, 2, 4};
    CHECK(GetSliceLayout(LoadSliceFile(tall).metadata, {0, 1, {0, 20, 8, 20}}));

    const SliceDesc fine{0, 3, {8, 4, 20, 9}};
    const auto bytes = GetPartialLatentBufferSize(file.metadata, fine);
    REQUIRE(bytes);
    const auto make = [&](InferenceWeightType type, std::span<std::byte> buffer, Stream& source) {
        const auto data = MakePartialInferenceData(file.metadata, source, fine, type, buffer);
        return data ? Status::Ok : data.error().GetStatus();
    };
    const std::span<std::byte> whole(latents);
    const std::size_t exact = static_cast<std::size_t>(*bytes);
    CHECK(make(InferenceWeightType::GenericInt8, whole.first(exact), stream) == Status::Ok);
    CHECK(make(InferenceWeightType::Unknown, whole, stream) == Status::InvalidArgument);
    CHECK(make(static_cast<InferenceWeightType>(99), whole, stream) == Status::InvalidArgument);
    CHECK(make(InferenceWeightType::GenericFP8, whole, stream) == Status::Unsupported);
    CHECK(make(InferenceWeightType::CoopVecInt8, whole, stream) == Status::Unsupported);
    CHECK(make(InferenceWeightType::GenericInt8, whole.first(exact - 1), stream) == Status::OutOfRange);
    CHECK(make(InferenceWeightType::GenericInt8, {}, stream) == Status::OutOfRange);
    const auto small =
        MakePartialInferenceData(file.metadata, stream, fine, InferenceWeightType::GenericInt8, {});
    REQUIRE_FALSE(small);
    CHECK(std::string(small.error().GetText()) ==
          "latents: 0 bytes: the slice needs " + std::to_string(*bytes));
}

TEST_CASE("slices: one read for rows that lie close together; a failure of any is an IOError") {
    const SliceFile file = LoadSquare();
    const SliceDesc slice{0, 5, {8, 4, 20, 9}};
    const auto layout = GetSliceLayout(file.metadata, slice);
    REQUIRE(layout);
    std::vector<std::byte> latents(static_cast<std::size_t>(layout->bytes));
    CountingStream counting(file.bytes, -1);
    REQUIRE(ReadSlice(*layout, counting, latents));
    CHECK(counting.GetReads() == layout->gridCount); // each is smaller than a window
    for (int failAt = 0; failAt < layout->gridCount; ++failAt) {
        CountingStream failing(file.bytes, failAt);
        const auto result = ReadSlice(*layout, failing, latents);
        REQUIRE_FALSE(result);
        CHECK(result.error().GetStatus() == Status::IOError);
    }
    // Rows over the whole width are one run.
    const auto band = GetSliceLayout(file.metadata, {0, 1, {0, 8, 64, 8}});
    REQUIRE(band);
    REQUIRE(band->gridCount == 2);
    CHECK(GetSliceRunCount(band->grids[0]) == 1);

    // From memory: the same bytes, wherever the memory starts, and an error where it ends too early.
    std::vector<std::byte> fromMemory(latents.size(), std::byte{0x77});
    const auto range = file.metadata.GetStreamRangeForLatents(0, 5);
    REQUIRE(range);
    const std::span<const std::byte> all(file.bytes);
    const auto part =
        all.subspan(static_cast<std::size_t>(range->offset), static_cast<std::size_t>(range->size));
    REQUIRE(ReadSlice(*layout, part, range->offset, fromMemory));
    CHECK(fromMemory == latents);
    for (const auto& [source, offset] :
         {std::pair{part.subspan(4), range->offset + 64}, std::pair{part.first(8), range->offset},
          std::pair{std::span<const std::byte>(), std::uint64_t{0}}, std::pair{part, ~std::uint64_t{0}}}) {
        const auto result = ReadSlice(*layout, source, offset, fromMemory);
        REQUIRE_FALSE(result);
        CHECK(result.error().GetStatus() == Status::IOError);
    }
    const auto tooSmall = ReadSlice(*layout, part, range->offset, std::span(fromMemory).first(4));
    REQUIRE_FALSE(tooSmall);
    CHECK(tooSmall.error().GetStatus() == Status::OutOfRange);
}

/// Reads that a grid takes: windows of 16 KiB that start at a row and hold whole ones, or one a row where more
/// than 4 KiB lie between two.
int CountGridReads(const SliceGrid& grid) {
    const int runs = GetSliceRunCount(grid);
    const SliceRun first = GetSliceRun(grid, 0);
    if (runs == 1)
        return 1;
    const auto rowBytes = static_cast<std::int64_t>(first.GetSourceBytes());
    const auto stride = static_cast<std::int64_t>(GetSliceRun(grid, 1).sourceOffset - first.sourceOffset);
    if (stride - rowBytes > 4096)
        return runs;
    const int rowsOfWindow = static_cast<int>((16384 - rowBytes) / stride) + 1;
    return (runs + rowsOfWindow - 1) / rowsOfWindow;
}

/// The first byte of the stream behind all rows of a slice.
std::size_t GetSliceEnd(const SliceLayout& layout) {
    std::uint64_t end = 0;
    for (const SliceGrid& grid : layout.GetGrids()) {
        const SliceRun last = GetSliceRun(grid, GetSliceRunCount(grid) - 1);
        end = std::max(end, last.sourceOffset + last.GetSourceBytes());
    }
    return static_cast<std::size_t>(end);
}

TEST_CASE("slices: streams give the bytes of memory, with as many reads as documented") {
    SliceRandom random(openntc::test::GetTestSeed());
    int windowed = 0, single = 0;
    for (const auto& [width, height, shape] : {std::tuple{4096, 160, LatentShape{2, 8, 4, 8, 4}},
                                               std::tuple{4096, 160, LatentShape{4, 4, 4, 1, 2}},
                                               std::tuple{1024, 512, LatentShape{2, 12, 4, 1, 4}},
                                               std::tuple{1002, 300, LatentShape{2, 12, 4, 1, 1}},
                                               std::tuple{64, 2048, LatentShape{2, 16, 4, 8, 8}}}) {
        SynthesisDesc synthesis;
        synthesis.desc = {width, height, 4, 3};
        synthesis.shape = shape;
        const SliceFile file = LoadSliceFile(synthesis);
        for (int i = 0; i < 40; ++i) {
            SliceDesc slice{0, random.Pick(1, 3), {}};
            slice.rect = {random.Pick(0, width - 1), random.Pick(0, height - 1), 0, 0};
            slice.rect.width = random.Pick(1, width - slice.rect.left);
            slice.rect.height = random.Pick(1, height - slice.rect.top);
            const auto layout = GetSliceLayout(file.metadata, slice);
            REQUIRE(layout);
            std::vector<std::byte> expected(static_cast<std::size_t>(layout->bytes), std::byte{1});
            std::vector<std::byte> latents(expected.size(), std::byte{2});
            REQUIRE(ReadSlice(*layout, std::span<const std::byte>(file.bytes), 0, expected));
            CountingStream stream(file.bytes, -1);
            REQUIRE(ReadSlice(*layout, stream, latents));
            CHECK_MESSAGE(latents == expected, ToText(synthesis));
            int reads = 0;
            bool isWhole = true; // an odd number of half bytes: rows are not equally long
            for (const SliceGrid& grid : layout->GetGrids()) {
                reads += CountGridReads(grid);
                isWhole = isWhole && grid.bitsPerPixel % 8 == 0;
                ++(CountGridReads(grid) == GetSliceRunCount(grid) ? single : windowed);
            }
            if (isWhole)
                CHECK(stream.GetReads() == reads);
            CountingStream cut(std::span(file.bytes).first(GetSliceEnd(*layout)), -1);
            REQUIRE(ReadSlice(*layout, cut, latents)); // nothing is read behind the last row
            CHECK(latents == expected);
        }
    }
    CHECK(windowed > 20);
    CHECK(single > 20);
}

TEST_CASE("slices: conservative sizes refuse what is no size") {
    const SliceFile file = LoadSquare();
    const int cases[][5] = {{-1, 1, 1, 1, 1}, {5, 1, 1, 1, 1},  {0, 0, 1, 1, 1},  {0, 6, 1, 1, 1},
                            {0, 1, 0, 1, 1},  {0, 1, 65, 1, 1}, {0, 1, 1, 0, 1},  {0, 1, 1, 33, 1},
                            {1, 1, 33, 1, 1}, {0, 1, 1, 1, 0},  {0, 1, 1, 1, -4}, {0, kBig, 1, 1, 1}};
    for (const auto& [firstMip, numMips, width, height, alignment] : cases) {
        const auto bytes =
            GetConservativeLatentBufferSize(file.metadata, firstMip, numMips, width, height, alignment);
        REQUIRE_FALSE(bytes);
        CHECK(bytes.error().GetStatus() == Status::OutOfRange);
    }
    // An alignment that is no power of two counts as 1; more alignment never needs more.
    const auto any = GetConservativeLatentBufferSize(file.metadata, 0, 1, 16, 16);
    REQUIRE(any);
    CHECK(*GetConservativeLatentBufferSize(file.metadata, 0, 1, 16, 16, 3) == *any);
    CHECK(*GetConservativeLatentBufferSize(file.metadata, 0, 1, 16, 16, 16) < *any);
    CHECK(GetConservativeLatentBufferSize(file.metadata, 0, 1, 16, 16, kBig));
    CHECK(GetConservativeLatentBufferSize(file.metadata, 0, 1, 16, 16, 1 << 30));
}

TEST_CASE("slices: rows of constants") {
    const SliceFile file = LoadSquare();
    const auto layout = GetSliceLayout(file.metadata, {0, 2, {8, 4, 20, 9}});
    REQUIRE(layout);
    const NtcSliceConstants row = MakeSliceConstants(*layout, 0);
    CHECK(row.highRes.imageWidthHeight == (16u | 8u << 16));
    CHECK(row.highRes.dataOffset == 0);
    CHECK(row.lowRes.dataOffset == layout->grids[0].bytes);
    const NtcSliceConstants absent = MakeSliceConstants(*layout, 1);
    CHECK(absent.highRes.sliceWidthHeight == 0);
    const auto moved = MoveSliceConstants(row, 1024);
    REQUIRE(moved);
    CHECK(moved->highRes.dataOffset == 1024);
    CHECK(moved->lowRes.dataOffset == 1024 + row.lowRes.dataOffset);
    CHECK(MoveSliceConstants(absent, 1024)->highRes.dataOffset == 0);
    CHECK(MoveSliceConstants(row, 6).error().GetStatus() == Status::InvalidArgument);
    CHECK(MoveSliceConstants(row, 0xFFFFFFFCu).error().GetStatus() == Status::OutOfRange);
    NtcTextureSetConstants constants{};
    CHECK(PatchConstants(constants, -1, row).error().GetStatus() == Status::OutOfRange);
    CHECK(PatchConstants(constants, 8, row).error().GetStatus() == Status::OutOfRange);
    REQUIRE(PatchConstants(constants, 7, *moved));
    CHECK(constants.lowResNeuralMips[7].dataOffset == moved->lowRes.dataOffset);
    CHECK(GetSliceConstants(constants, 7).highRes.sliceLeftTop == row.highRes.sliceLeftTop);
    CHECK(GetSliceConstants(constants, 8).highRes.sliceWidthHeight == 0);
    CHECK(GetSliceConstants(constants, -1).highRes.sliceWidthHeight == 0);
}
