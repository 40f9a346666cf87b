// SPDX-License-Identifier: MIT
// The files of filtering's cases, and how taps are compared.
#include "FilterSuite.h"

#include "../Output.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <tuple>

namespace openntc::conformance {

namespace {

using tool::Format;

constexpr std::size_t kFilterHeaderBytes = 12;
constexpr std::size_t kLookupBytes = 44; // with the number of taps
constexpr std::size_t kTapBytes = 16;
/// Fractions of a Gaussian are within 4e-6 along an axis: exp in binary32, eight roundings to 2^-24.
constexpr float kGaussianTolerance = 1e-5f;

void AppendWord(std::vector<std::byte>& bytes, std::uint32_t value) {
    for (int i = 0; i < 4; ++i)
        bytes.push_back(static_cast<std::byte>(value >> (8 * i) & 255u));
}

/// Words one after the other; those behind the end are 0.
class Words {
public:
    explicit Words(std::span<const std::byte> bytes) : bytes_(bytes) {}
    std::uint32_t Take() {
        std::uint32_t value = 0;
        for (std::size_t i = 0; i < 4 && at_ < bytes_.size(); ++i)
            value |= std::to_integer<std::uint32_t>(bytes_[at_++]) << (8 * i);
        return value;
    }
    float TakeFloat() { return std::bit_cast<float>(Take()); }
    std::size_t GetRest() const { return bytes_.size() - at_; }

private:
    std::span<const std::byte> bytes_;
    std::size_t at_ = 0;
};

/// In an order that does not hang on the order of the answer.
std::vector<FilterTap> Sort(std::vector<FilterTap> taps) {
    std::sort(taps.begin(), taps.end(), [](const FilterTap& a, const FilterTap& b) {
        return std::tuple(a.mip, a.y, a.x, a.scale) < std::tuple(b.mip, b.y, b.x, b.scale);
    });
    return taps;
}

bool IsEqual(const FilterTap& a, const FilterTap& b, float tolerance) {
    const bool isClose = std::fabs(a.scale - b.scale) <= tolerance;
    return a.x == b.x && a.y == b.y && a.mip == b.mip && a.isBorder == b.isBorder && isClose;
}

std::string DescribeTap(const FilterTap& tap) {
    const std::string place = tap.isBorder ? "the border" : Format("texel (%d, %d)", tap.x, tap.y);
    return Format("%s of mip %d times %s", place.c_str(), tap.mip, tool::FormatFloat(tap.scale).c_str());
}

/// The first tap that differs, or nothing.
std::string FindDifference(const std::vector<FilterTap>& taps, const std::vector<FilterTap>& expected,
                           float tolerance) {
    if (taps.size() != expected.size())
        return Format("%zu taps: expected %zu", taps.size(), expected.size());
    const std::vector<FilterTap> got = Sort(taps), wanted = Sort(expected);
    for (std::size_t i = 0; i < got.size(); ++i) {
        if (!IsEqual(got[i], wanted[i], tolerance))
            return DescribeTap(got[i]) + ": expected " + DescribeTap(wanted[i]);
    }
    return {};
}

} // namespace

std::vector<std::byte> WriteFilterFile(const FilterFile& file) {
    std::vector<std::byte> bytes;
    for (const char c : {'N', 'T', 'C', 'F'})
        bytes.push_back(static_cast<std::byte>(c));
    AppendWord(bytes, 1);
    AppendWord(bytes, static_cast<std::uint32_t>(file.lookups.size()));
    for (std::size_t i = 0; i < file.lookups.size(); ++i) {
        const FilterLookup& lookup = file.lookups[i];
        for (const std::array<float, 2>* pair : {&lookup.uv, &lookup.ddx, &lookup.ddy}) {
            for (const float number : *pair)
                AppendWord(bytes, std::bit_cast<std::uint32_t>(number));
        }
        for (const std::uint32_t number : lookup.random)
            AppendWord(bytes, number);
        AppendWord(bytes, static_cast<std::uint32_t>(file.taps[i].size()));
        for (const FilterTap& tap : file.taps[i]) {
            AppendWord(bytes, static_cast<std::uint32_t>(tap.x));
            AppendWord(bytes, static_cast<std::uint32_t>(tap.y));
            AppendWord(bytes, static_cast<std::uint32_t>(tap.isBorder ? -1 - tap.mip : tap.mip));
            AppendWord(bytes, std::bit_cast<std::uint32_t>(tap.scale));
        }
    }
    return bytes;
}

Expected<FilterFile> ReadFilterFile(std::span<const std::byte> bytes) {
    if (bytes.size() < kFilterHeaderBytes || std::memcmp(bytes.data(), "NTCF", 4) != 0)
        return Fail(Status::FileUnrecognized, "signature: not NTCF");
    Words words(bytes.subspan(4));
    if (const std::uint32_t version = words.Take(); version != 1)
        return Fail(Status::FileUnrecognized, "version: %u: 1", version);
    const std::uint32_t count = words.Take();
    if (count == 0 || count > kMaxFilterLookups)
        return Fail(Status::FileUnrecognized, "lookups: %u: must be 1 … %d", count, kMaxFilterLookups);
    FilterFile file;
    for (std::uint32_t i = 0; i < count; ++i) {
        if (words.GetRest() < kLookupBytes)
            return Fail(Status::FileUnrecognized, "lookup %u: the file ends before", i);
        FilterLookup lookup;
        for (std::array<float, 2>* pair : {&lookup.uv, &lookup.ddx, &lookup.ddy}) {
            for (float& number : *pair)
                number = words.TakeFloat();
        }
        for (std::uint32_t& number : lookup.random)
            number = words.Take() & 0xFFFFu;
        const std::uint32_t taps = words.Take();
        if (taps > kMaxFilterTaps || words.GetRest() < taps * kTapBytes)
            return Fail(Status::FileUnrecognized, "lookup %u: %u taps: the file ends before", i, taps);
        file.lookups.push_back(lookup);
        std::vector<FilterTap>& list = file.taps.emplace_back();
        for (std::uint32_t k = 0; k < taps; ++k) {
            FilterTap tap;
            tap.x = static_cast<std::int32_t>(words.Take());
            tap.y = static_cast<std::int32_t>(words.Take());
            tap.mip = static_cast<std::int32_t>(words.Take());
            tap.scale = words.TakeFloat();
            tap.isBorder = tap.mip < 0;
            tap.mip = tap.isBorder ? -1 - tap.mip : tap.mip;
            list.push_back(tap);
        }
    }
    if (words.GetRest() != 0)
        return Fail(Status::FileUnrecognized, "%zu bytes behind the last lookup", words.GetRest());
    return file;
}

FilterDifference CompareFilterTaps(const FilterRequest& request, const FilterTaps& taps,
                                   const FilterTaps& expected) {
    FilterDifference difference;
    for (std::size_t i = 0; i < expected.size(); ++i) {
        const bool isClose = request.IsGaussian() && request.way == FilterWay::All;
        const std::string text = FindDifference(taps.at(i), expected[i], isClose ? kGaussianTolerance : 0.0f);
        if (!text.empty() && difference.different++ == 0)
            difference.first = Format("lookup %zu: ", i) + text;
    }
    return difference;
}

} // namespace openntc::conformance
