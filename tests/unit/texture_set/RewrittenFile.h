// SPDX-License-Identifier: MIT
// A file read and written again.
#pragma once

#include "openntc/texture_set/Rewrite.h"

#include <doctest/doctest.h>

#include <cstddef>
#include <string>
#include <vector>

namespace openntc_tests {

inline std::vector<std::byte> Rewrite(const std::vector<std::byte>& file) {
    openntc::ReadOnlyMemoryStream stream(file);
    const auto set = openntc::TextureSetMetadata::Load(stream);
    REQUIRE_MESSAGE(set, std::string(set.error().GetText()));
    auto copy = openntc::MakeWritableCopy(*set, stream);
    REQUIRE_MESSAGE(copy, std::string(copy.error().GetText()));
    openntc::MemoryStream result;
    const auto written = copy->Write(result);
    REQUIRE_MESSAGE(written, std::string(written.error().GetText()));
    return {result.GetBytes().begin(), result.GetBytes().end()};
}

} // namespace openntc_tests
