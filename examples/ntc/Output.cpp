// SPDX-License-Identifier: MIT
#include "Output.h"

#include "Failure.h"
#include "openntc/core/FileCalls.h"

#include <cerrno>
#include <cmath>
#include <cstdarg>
#include <cstdio>

namespace openntc::tool {

void WriteOutput(std::string_view text) {
    if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size())
        throw CommandError(ExitCode::Failed, "-",
                           Format("standard output: cannot be written: %s", SystemReason(errno).GetText()));
}

void FinishOutput() {
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
        throw CommandError(ExitCode::Failed, "-",
                           Format("standard output: cannot be written: %s", SystemReason(errno).GetText()));
}

std::string Format(const char* format, ...) {
    std::va_list arguments;
    va_start(arguments, format);
    std::va_list copy;
    va_copy(copy, arguments);
    const int length = std::vsnprintf(nullptr, 0, format, copy);
    va_end(copy);
    std::string text(length > 0 ? static_cast<std::size_t>(length) : 0, '\0');
    if (length > 0)
        std::vsnprintf(text.data(), text.size() + 1, format, arguments);
    va_end(arguments);
    return text;
}

std::string FormatFloat(float value) {
    if (std::isnan(value))
        return "nan";
    if (std::isinf(value))
        return value < 0 ? "-inf" : "inf";
    return Format("%.9g", static_cast<double>(value));
}

std::string Printable(std::string_view text) {
    std::string result(text);
    for (char& c : result) {
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f)
            c = '?';
    }
    return result;
}

std::string EscapeMarkup(std::string_view text) {
    std::string result;
    for (const char c : text) {
        switch (c) {
        case '&':
            result += "&amp;";
            break;
        case '<':
            result += "&lt;";
            break;
        case '>':
            result += "&gt;";
            break;
        case '"':
            result += "&quot;";
            break;
        default:
            result += c;
        }
    }
    return result;
}

} // namespace openntc::tool
