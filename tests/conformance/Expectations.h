// SPDX-License-Identifier: MIT
// Reads what the shared conformance vectors expect.
#pragma once

#include "conformance/ConformanceFolder.h"

#include "openntc/container/RapidJson.h"

#include <cstddef>
#include <string>
#include <vector>

#include <rapidjson/document.h>

namespace openntc_tests {

inline rapidjson::Document ReadExpectations(const std::string& name) {
    const std::vector<std::byte> bytes = ReadBytes(GetConformanceFolder() / (name + ".expect.json"));
    rapidjson::Document document;
    document.Parse(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    return document;
}

} // namespace openntc_tests
