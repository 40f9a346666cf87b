// SPDX-License-Identifier: MIT
// Readers of the conformance vector formats: NAME.texels (binary) and NAME.expect.json. Both are treated as
// hostile: lengths are checked against the bytes at hand before anything is allocated.
#pragma once

#include "openntc/core/Expected.h"
#include "openntc/core/Half.h"
#include "openntc/texture_set/TextureSetMetadata.h"

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace openntc::conformance {

inline constexpr std::size_t kTexelHeaderBytes = 16;
inline constexpr std::size_t kTexelRecordBytes = 304;

/// Bits of TexelRecord::flags: which blocks hold values. 2 and 4 are those of LibNTC's CUDA decoder, a neighbour and not a
/// contract, which are not read.
enum TexelFlags : std::uint32_t {
    kHasExact = 1,  ///< exact, exactHalf and linear
    kHasSource = 8, ///< the texel given to the encoder
};

/// One texel with everything that is known about it. Values are in storage colour space unless said
/// otherwise.
struct TexelRecord {
    std::int32_t mip = 0;
    std::int32_t x = 0;
    std::int32_t y = 0;
    std::uint32_t flags = 0;
    std::array<float, 16> exact{};     ///< Int8, float epilogue: match bit for bit
    std::array<float, 16> exactHalf{}; ///< Int8, half epilogue: match bit for bit
    std::array<float, 16> linear{}; ///< `exact` converted to linear with binary32 libm: match within a bound
    std::array<float, 16> source{}; ///< widened from binary16; 0 for channels that the set does not declare
};

namespace detail {

inline std::uint32_t LoadUint32(const std::byte* bytes) noexcept {
    std::uint32_t value = 0;
    for (int i = 0; i < 4; ++i)
        value |= static_cast<std::uint32_t>(bytes[i]) << (8 * i);
    return value;
}

inline std::array<float, 16> LoadFloats(const std::byte* bytes) noexcept {
    std::array<float, 16> values{};
    for (std::size_t i = 0; i < 16; ++i)
        values[i] = std::bit_cast<float>(LoadUint32(bytes + 4 * i));
    return values;
}

inline std::array<float, 16> LoadHalves(const std::byte* bytes) noexcept {
    std::array<float, 16> values{};
    for (std::size_t i = 0; i < 16; ++i) {
        const std::uint32_t low = static_cast<std::uint32_t>(bytes[2 * i]);
        const std::uint32_t high = static_cast<std::uint32_t>(bytes[2 * i + 1]);
        values[i] = HalfToFloat(static_cast<std::uint16_t>(low | (high << 8)));
    }
    return values;
}

} // namespace detail

/// Reads a whole .texels file. The record count must account for every byte of the file. Records are not
/// checked against an image: their coordinates can be anything.
inline Expected<std::vector<TexelRecord>> ReadTexels(std::span<const std::byte> file) {
    if (file.size() < kTexelHeaderBytes)
        return Fail(Status::FileUnrecognized, "header: %zu bytes: at least %zu", file.size(),
                    kTexelHeaderBytes);
    if (std::memcmp(file.data(), "NTXL", 4) != 0)
        return Fail(Status::FileUnrecognized, "signature: 0x%08x: NTXL", detail::LoadUint32(file.data()));
    if (const std::uint32_t version = detail::LoadUint32(file.data() + 4); version != 1)
        return Fail(Status::FileUnrecognized, "version: %u: 1", version);
    if (const std::uint32_t channels = detail::LoadUint32(file.data() + 8); channels != 16)
        return Fail(Status::FileUnrecognized, "channels: %u: 16", channels);
    const std::uint64_t count = detail::LoadUint32(file.data() + 12);
    if (kTexelHeaderBytes + count * kTexelRecordBytes != file.size())
        return Fail(Status::FileUnrecognized, "records: %llu of %zu bytes: do not make a file of %zu bytes",
                    static_cast<unsigned long long>(count), kTexelRecordBytes, file.size());

    std::vector<TexelRecord> records(static_cast<std::size_t>(count));
    const std::byte* bytes = file.data() + kTexelHeaderBytes;
    for (TexelRecord& record : records) {
        record.mip = static_cast<std::int32_t>(detail::LoadUint32(bytes));
        record.x = static_cast<std::int32_t>(detail::LoadUint32(bytes + 4));
        record.y = static_cast<std::int32_t>(detail::LoadUint32(bytes + 8));
        record.flags = detail::LoadUint32(bytes + 12);
        record.exact = detail::LoadFloats(bytes + 16);
        record.exactHalf = detail::LoadFloats(bytes + 80);
        record.linear = detail::LoadFloats(bytes + 144);
        record.source = detail::LoadHalves(bytes + 272);
        bytes += kTexelRecordBytes;
    }
    return records;
}

/// What NAME.expect.json says about one kind of weights.
struct WeightExpectation {
    std::uint64_t weightBytes = 0;
    std::uint32_t weightCrc32 = 0;
    std::vector<std::byte> constants; ///< NtcTextureSetConstants for all mips
};

struct RangeExpectation {
    int firstMip = 0;
    int numMips = 0;
    std::uint64_t offset = 0; ///< absolute in the file
    std::uint64_t size = 0;
};

/// NAME.expect.json without its slices. Every part is optional, so that smaller vectors can be written by
/// hand; parts that are present must be well-formed.
struct Expectations {
    struct Shape {
        int highResFeatures = 0;
        int lowResFeatures = 0;
        int highResQuantBits = 0;
        int lowResQuantBits = 0;
        std::optional<int> gridSizeScale;
    };

    std::optional<int> width, height, channels, mips, networkVersion, latentImages;
    std::optional<Shape> latentShape;
    std::optional<std::uint32_t> validChannelMask;
    std::vector<int> channelColorSpaces;       ///< NTC_COLOR_SPACE_*, one a channel
    std::vector<std::array<int, 2>> fusedMips; ///< for each colour mip, { first, last } of its latent image
    std::vector<RangeExpectation> streamRanges;
    std::optional<WeightExpectation> int8, fp8;
    bool int8Absent = false; ///< the file says that LibNTC has no such weights for this set
    bool fp8Absent = false;
};

/// Parses NAME.expect.json. Fails with Status::FileUnrecognized, naming the key.
Expected<Expectations> ReadExpectations(std::span<const std::byte> json);

/// NAME.expect.json of a set as this project's loader has it.
Expected<std::string> WriteExpectations(const TextureSetMetadata& metadata);

} // namespace openntc::conformance
