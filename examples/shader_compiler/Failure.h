// SPDX-License-Identifier: MIT
// How compiling permutations fails.
#pragma once

#include <exception>
#include <string>
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

} // namespace openntc::shader_compiler
