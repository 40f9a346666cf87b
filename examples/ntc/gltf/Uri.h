// SPDX-License-Identifier: MIT
// URIs of glTF files: percent-encoding and embedded data.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace openntc::tool {

/// `%41` becomes `A`; a percent sign that starts no such triple stays.
std::string UnescapeUri(std::string_view uri);

struct DataUri {
    std::string mediaType; ///< lower case, without parameters; may be empty
    std::vector<std::byte> bytes;
};

bool IsDataUri(std::string_view uri);

/// `data:image/png;base64,…` (RFC 2397, RFC 4648 section 4; padding may be missing). nullopt, and what is wrong in
/// `error`, for data that is not base64.
std::optional<DataUri> ParseDataUri(std::string_view uri, std::string& error);

} // namespace openntc::tool
