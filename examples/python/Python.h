// SPDX-License-Identifier: MIT
// What the sources of the Python module share: texture sets in memory, and errors as exceptions.
#pragma once

#include "openntc/core/Expected.h"
#include "openntc/decode/DecodeTypes.h"

#include <pybind11/pybind11.h>

#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

namespace openntc::python {

/// Becomes openntc.Error in Python: a ValueError with the message, which names field, value and limit.
class PythonError : public std::runtime_error {
public:
    explicit PythonError(const std::string& text) : std::runtime_error(text) {}
};

/// `subject`: a file, or nothing.
template <typename Result>
Result Unwrap(Expected<Result> result, const std::string& subject = {}) {
    if (!result)
        throw PythonError(subject + (subject.empty() ? "" : ": ") + result.error().GetText());
    if constexpr (!std::is_void_v<Result>)
        return std::move(*result);
}

inline pybind11::bytes MakeBytes(std::span<const std::byte> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// FastDecoder for Int8 and Int8Half, DecodeReference for the rest. `outputs`: 16 values a texel, row by row.
Expected<void> DecodeTexels(const DecodeSource& source, int mip, Rect rect, const DecodeOptions& options,
                            int threads, std::span<float> outputs);

/// `encode` and EncodeResult.
void AddEncoding(pybind11::module_& module);

} // namespace openntc::python
