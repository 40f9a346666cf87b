// SPDX-License-Identifier: MIT
// Stability: stable
// Expected<T>: a value, or a Status with a message that names the field, the value and the limit.
#pragma once

#include "openntc/core/Status.h"

#include <cstdarg>
#include <cstddef>
#include <cstdio>
#include <utility>

#if defined(__clang__)
#pragma clang diagnostic push
#pragma clang diagnostic ignored "-Weverything"
#endif
#include <tl/expected.hpp>
#if defined(__clang__)
#pragma clang diagnostic pop
#endif

#include "openntc/core/HideMacros.h"

namespace openntc {

/// A failure. The message is stored in place, so that reporting an error never allocates (running out of
/// memory is one of the errors to report). Longer messages are cut.
class Error {
public:
    static constexpr std::size_t kMaxMessageBytes = 256; ///< including the terminating NUL

    explicit Error(Status status) noexcept : status_(status) {}

    Status GetStatus() const noexcept { return status_; }

    /// Convention: `field: value: limit`, each part as specific as is known. Never null, one line,
    /// NUL-terminated.
    const char* GetText() const noexcept { return message_; }

    friend Error MakeErrorV(Status status, const char* format, std::va_list arguments) noexcept;

private:
    Status status_;
    char message_[kMaxMessageBytes] = {};
};

inline Error MakeErrorV(Status status, const char* format, std::va_list arguments) noexcept {
    Error error(status);
    std::vsnprintf(error.message_, Error::kMaxMessageBytes, format, arguments);
    // Text taken from hostile files must not forge further lines or terminal escapes in a log.
    // Bytes 0x80 to 0x9F after 0xC2 are control characters too (C1).
    unsigned char previous = 0;
    for (char* c = error.message_; *c != '\0'; ++c) {
        const auto byte = static_cast<unsigned char>(*c);
        if (byte < 0x20 || byte == 0x7F || (previous == 0xC2 && byte < 0xA0))
            *c = '?';
        previous = byte;
    }
    return error;
}

template <typename T>
using Expected = tl::expected<T, Error>;

using Unexpected = tl::unexpected<Error>;

#if defined(__MINGW32__) && !defined(__clang__)
// MinGW's vsnprintf in C++ is the ISO C one; its plain "printf" attribute would check for the old Microsoft
// formats.
#define OPENNTC_PRINTF_FORMAT(formatIndex, firstArgument)                                                    \
    __attribute__((format(gnu_printf, formatIndex, firstArgument)))
#elif defined(__GNUC__) || defined(__clang__)
#define OPENNTC_PRINTF_FORMAT(formatIndex, firstArgument)                                                    \
    __attribute__((format(printf, formatIndex, firstArgument)))
#else
#define OPENNTC_PRINTF_FORMAT(formatIndex, firstArgument)
#endif

/// Builds an Error with a printf-style message.
OPENNTC_PRINTF_FORMAT(2, 3)
inline Error MakeError(Status status, const char* format, ...) noexcept {
    std::va_list arguments;
    va_start(arguments, format);
    Error error = MakeErrorV(status, format, arguments);
    va_end(arguments);
    return error;
}

/// Builds the failed state of any Expected<T> with a printf-style message: `return Fail(Status::OutOfRange,
/// ...)`.
OPENNTC_PRINTF_FORMAT(2, 3)
inline Unexpected Fail(Status status, const char* format, ...) noexcept {
    std::va_list arguments;
    va_start(arguments, format);
    Error error = MakeErrorV(status, format, arguments);
    va_end(arguments);
    return Unexpected(error);
}

/// Passes the error of one Expected on as the failed state of another.
template <typename T>
Unexpected PassError(const Expected<T>& failed) noexcept {
    return Unexpected(failed.error());
}

} // namespace openntc

/// Evaluates an expression of type Expected<void>; returns its error from the calling function if it failed.
#define OPENNTC_CHECK(expression)                                                                            \
    do {                                                                                                     \
        if (auto openntcResult = (expression); !openntcResult)                                               \
            return ::openntc::Unexpected(openntcResult.error());                                             \
    } while (false)

#define OPENNTC_CONCATENATE_(a, b) a##b
#define OPENNTC_CONCATENATE(a, b) OPENNTC_CONCATENATE_(a, b)

/// `OPENNTC_ASSIGN(auto x, F())`: declares x from the value of an Expected, or returns its error.
#define OPENNTC_ASSIGN(declaration, expression)                                                              \
    OPENNTC_ASSIGN_(declaration, expression, OPENNTC_CONCATENATE(openntcExpected, __LINE__))
#define OPENNTC_ASSIGN_(declaration, expression, name)                                                       \
    auto name = (expression);                                                                                \
    if (!name)                                                                                               \
        return ::openntc::Unexpected(name.error());                                                          \
    declaration = std::move(*name)

#include "openntc/core/RestoreMacros.h"
