// SPDX-License-Identifier: MIT
// The words of the adapter protocol, version 1 (docs/conformance.md), for both of its ends.
#pragma once

#include "Subject.h"

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace openntc::conformance {

inline constexpr int kProtocolVersion = 1;
/// Texels of one request.
inline constexpr std::size_t kMaxRequestTexels = 1024;

/// `int8`, `int8_half`, … to a maths mode.
std::optional<DecodeMath> FindMath(std::string_view name);

/// Takes the first word off a line.
std::string_view TakeWord(std::string_view& line);

/// A whole word as a decimal number.
std::optional<int> ParseNumber(std::string_view word);

/// 16 words of 8 hexadecimal digits: the bits of binary32 numbers.
std::string FormatOutputs(const Outputs& outputs);
std::optional<Outputs> ParseOutputs(std::string_view line);

/// Bytes as two hexadecimal digits each.
std::string FormatBytes(std::span<const std::byte> bytes);
/// A word of `count` bytes, appended.
bool ParseBytes(std::string_view word, std::size_t count, std::vector<std::byte>& bytes);

/// The request `filter` with its lookups.
std::string FormatFilterRequest(const FilterRequest& request, std::span<const FilterLookup> lookups);
/// The words behind `filter` in its line, and the number of lookups; nothing where one is missing or out of range.
std::optional<FilterRequest> ParseFilterRequest(std::string_view line, int& count);
std::optional<FilterLookup> ParseLookup(std::string_view line);
/// A line of taps: `X Y MIP FACTOR BORDER` each, the factor as the bits of a binary32 number.
std::string FormatTaps(std::span<const FilterTap> taps);
bool ParseTaps(std::string_view line, std::vector<FilterTap>& taps);

/// `int8,fp16,linear,mip`.
std::string FormatCapabilities(const Capabilities& capabilities);
/// Words that this version does not know are ignored.
Capabilities ParseCapabilities(std::string_view text);

} // namespace openntc::conformance
