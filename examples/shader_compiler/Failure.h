// SPDX-License-Identifier: MIT
// How compiling permutations fails.
#pragma once

#include <cerrno>
#include <exception>
#include <filesystem>
#include <fstream>
#include <string>
#include <system_error>
#include <utility>

namespace openntc::shader_compiler {

enum class FailureKind {
    Usage,  ///< a define, stage or entry point that makes no sense
    Input,  ///< a source or list that is missing or malformed, a shader that does not compile
    Output, ///< a file that cannot be written
};

/// `subject` is the file or option, `text` is `field: value: limit` or a compiler's message.
class Failure final : public std::exception {
public:
    Failure(FailureKind kind, std::string subject, std::string text)
        : kind_(kind), subject_(std::move(subject)), text_(std::move(text)) {}

    const char* what() const noexcept override { return text_.c_str(); }
    FailureKind GetKind() const noexcept { return kind_; }
    const std::string& GetSubject() const noexcept { return subject_; }

private:
    FailureKind kind_;
    std::string subject_;
    std::string text_;
};

/// Why a stream that was just opened on `path` gives no text; empty if it does.
inline std::string WhyUnreadable(const std::filesystem::path& path, const std::ifstream& stream) {
    const int reason = errno;
    std::error_code ignored;
    if (std::filesystem::is_directory(path, ignored))
        return std::generic_category().message(EISDIR);
    return stream ? std::string() : std::generic_category().message(reason);
}

} // namespace openntc::shader_compiler
