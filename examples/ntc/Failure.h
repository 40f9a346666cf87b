// SPDX-License-Identifier: MIT
// How a command ends when it cannot do its work: an exit code and one line.
#pragma once

#include "openntc/core/Expected.h"

#include <exception>
#include <string>
#include <type_traits>
#include <utility>

namespace openntc::tool {

/// Documented exit codes of `ntc`.
enum class ExitCode : int {
    Ok = 0,
    Failed = 1, ///< the work failed: vectors failed, cancelled, disk full
    Usage = 2,  ///< options, or a texel or mip outside the image
    BadInput =
        3, ///< the input is missing, unreadable, malformed, of another generation or lacks what was asked for
    NoDevice = 4, ///< a device or feature is absent
};

/// Thrown by commands and caught in main. `subject` is the file or option, `text` is `field: value: limit`.
class CommandError final : public std::exception {
public:
    CommandError(ExitCode code, std::string subject, std::string text)
        : code_(code), subject_(std::move(subject)), text_(std::move(text)) {}

    const char* what() const noexcept override { return text_.c_str(); }
    ExitCode GetCode() const noexcept { return code_; }
    const std::string& GetSubject() const noexcept { return subject_; }

    /// `ntc: SUBJECT: TEXT` without control characters, so that a hostile name cannot forge lines or escapes.
    std::string GetLine() const {
        std::string line = "ntc: " + subject_ + ": " + text_;
        for (char& c : line) {
            if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f)
                c = '?';
        }
        return line;
    }

private:
    ExitCode code_;
    std::string subject_;
    std::string text_;
};

/// The value of an Expected, or a CommandError with `code`. Running out of memory is always ExitCode::Failed.
template <typename T>
T Require(Expected<T>&& expected, ExitCode code, const std::string& subject) {
    if (!expected) {
        const Error& error = expected.error();
        throw CommandError(error.GetStatus() == Status::OutOfMemory ? ExitCode::Failed : code, subject,
                           error.GetText());
    }
    if constexpr (!std::is_void_v<T>)
        return std::move(*expected);
}

} // namespace openntc::tool
