// SPDX-License-Identifier: MIT
// Stability: internal
// The 40-byte NTEX header that says where the JSON chunk and the binary chunk lie.
#pragma once

#include "openntc/container/Document.h"
#include "openntc/core/CheckedMath.h"
#include "openntc/core/Expected.h"

#include <array>
#include <cstddef>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc::container {

/// Offsets are bytes from the start of the stream. Source: the format specification, section "Binary
/// container".
struct Header {
    std::uint64_t jsonOffset = kHeaderBytes;
    std::uint64_t jsonSize = 0; ///< as written, counts one terminating NUL
    std::uint64_t binaryOffset = 0;
    std::uint64_t binarySize = 0;
};

using HeaderBytes = std::array<std::byte, kHeaderBytes>;

namespace detail {

// Little-endian by explicit assembly, so that host byte order and struct padding play no part.
template <typename T>
constexpr T LoadLittleEndian(std::span<const std::byte> bytes, std::size_t offset) noexcept {
    T value = 0;
    for (std::size_t i = 0; i < sizeof(T); ++i)
        value |= static_cast<T>(bytes[offset + i]) << (8 * i);
    return value;
}

template <typename T>
constexpr void StoreLittleEndian(std::span<std::byte> bytes, std::size_t offset, T value) noexcept {
    for (std::size_t i = 0; i < sizeof(T); ++i)
        bytes[offset + i] = static_cast<std::byte>((value >> (8 * i)) & 0xFFu);
}

} // namespace detail

/// Decodes a header and checks, in this order: the signature, the container version, and that both chunks end
/// inside a stream of `streamSize` bytes; then that the JSON chunk is neither empty nor larger than
/// kMaxJsonBytes. Errors: FileUnrecognized.
inline Expected<Header> DecodeHeader(const HeaderBytes& bytes, std::uint64_t streamSize) noexcept {
    const auto signature = detail::LoadLittleEndian<std::uint32_t>(bytes, 0);
    if (signature != kSignature)
        return Fail(Status::FileUnrecognized, "header.signature: 0x%08x: must be 0x%08x (NTEX)", signature,
                    kSignature);
    const auto version = detail::LoadLittleEndian<std::uint32_t>(bytes, 4);
    if (version != kContainerVersion)
        return Fail(Status::FileUnrecognized, "header.containerVersion: 0x%x: must be 0x%x", version,
                    kContainerVersion);
    Header header;
    header.jsonOffset = detail::LoadLittleEndian<std::uint64_t>(bytes, 8);
    header.jsonSize = detail::LoadLittleEndian<std::uint64_t>(bytes, 16);
    header.binaryOffset = detail::LoadLittleEndian<std::uint64_t>(bytes, 24);
    header.binarySize = detail::LoadLittleEndian<std::uint64_t>(bytes, 32);
    if (!IsRangeInside(header.jsonOffset, header.jsonSize, streamSize))
        return Fail(
            Status::FileUnrecognized, "header.jsonSize: %llu bytes at offset %llu: the stream has %llu bytes",
            static_cast<unsigned long long>(header.jsonSize),
            static_cast<unsigned long long>(header.jsonOffset), static_cast<unsigned long long>(streamSize));
    if (!IsRangeInside(header.binaryOffset, header.binarySize, streamSize))
        return Fail(Status::FileUnrecognized,
                    "header.binSize: %llu bytes at offset %llu: the stream has %llu bytes",
                    static_cast<unsigned long long>(header.binarySize),
                    static_cast<unsigned long long>(header.binaryOffset),
                    static_cast<unsigned long long>(streamSize));
    if (header.jsonSize == 0 || header.jsonSize > kMaxJsonBytes)
        return Fail(Status::FileUnrecognized, "header.jsonSize: %llu: must be 1 to %llu",
                    static_cast<unsigned long long>(header.jsonSize),
                    static_cast<unsigned long long>(kMaxJsonBytes));
    return header;
}

/// The bytes of a header.
inline HeaderBytes EncodeHeader(const Header& header) noexcept {
    HeaderBytes bytes{};
    detail::StoreLittleEndian<std::uint32_t>(bytes, 0, kSignature);
    detail::StoreLittleEndian<std::uint32_t>(bytes, 4, kContainerVersion);
    detail::StoreLittleEndian<std::uint64_t>(bytes, 8, header.jsonOffset);
    detail::StoreLittleEndian<std::uint64_t>(bytes, 16, header.jsonSize);
    detail::StoreLittleEndian<std::uint64_t>(bytes, 24, header.binaryOffset);
    detail::StoreLittleEndian<std::uint64_t>(bytes, 32, header.binarySize);
    return bytes;
}

} // namespace openntc::container

#include "openntc/core/RestoreMacros.h"
