// SPDX-License-Identifier: MIT
// Standard output with errors noticed: a full disk or a closed pipe must not look like success.
#pragma once

#include <string>
#include <string_view>

namespace openntc::tool {

/// Writes text to standard output.
void WriteOutput(std::string_view text);

/// Flushes standard output; throws CommandError(Failed) if anything written so far was lost.
void FinishOutput();

/// printf into a std::string.
#if defined(__GNUC__)
__attribute__((format(printf, 1, 2)))
#endif
std::string
Format(const char* format, ...);

/// `%.9g` with `nan`, `inf` and `-inf` whatever the C library calls them: nine digits identify a binary32.
std::string FormatFloat(float value);

/// Replaces control characters of text that came from a file.
std::string Printable(std::string_view text);

/// For HTML and XML: `&`, `<`, `>` and `"` as entities.
std::string EscapeMarkup(std::string_view text);

} // namespace openntc::tool
