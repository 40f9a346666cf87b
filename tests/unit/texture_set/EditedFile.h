// SPDX-License-Identifier: MIT
// V1 of the specification with changed JSON or binary data, to show what loading accepts and refuses.
#pragma once

#include "openntc/container/Header.h"
#include "openntc/texture_set/TextureSetMetadata.h"
#include "support/SpecificationVectors.h"

#include <doctest/doctest.h>

#include <cstring>
#include <string>
#include <string_view>
#include <vector>

namespace openntc_tests {

/// A file taken apart: its JSON text and its binary chunk.
class EditedFile {
public:
    explicit EditedFile(const std::vector<std::byte>& file) {
        std::uint64_t fields[4]; // JSON offset and size, binary offset and size
        std::memcpy(fields, file.data() + 8, sizeof fields);
        json.assign(reinterpret_cast<const char*>(file.data()) + fields[0], fields[1] - 1);
        binary.assign(file.begin() + static_cast<std::ptrdiff_t>(fields[2]), file.end());
    }

    /// Replaces the first occurrence; the test fails if there is none.
    EditedFile& Replace(std::string_view from, std::string_view to) {
        const std::size_t position = json.find(from);
        REQUIRE_MESSAGE(position != std::string::npos, from);
        json.replace(position, from.size(), to);
        return *this;
    }
    EditedFile& ReplaceAll(std::string_view from, std::string_view to) {
        for (std::size_t at = json.find(from); at != std::string::npos; at = json.find(from, at + to.size()))
            json.replace(at, from.size(), to);
        return *this;
    }
    template <typename T>
    EditedFile& Store(std::size_t offset, T value) {
        std::memcpy(binary.data() + offset, &value, sizeof value);
        return *this;
    }

    std::vector<std::byte> Build() const {
        const std::uint64_t jsonSize = json.size() + 1;
        const std::uint64_t binaryOffset = (40 + jsonSize + 3) / 4 * 4;
        std::vector<std::byte> file(binaryOffset + binary.size());
        const std::uint32_t start[2] = {0x5845544E, 0x100};
        const std::uint64_t fields[4] = {40, jsonSize, binaryOffset, binary.size()};
        std::memcpy(file.data(), start, sizeof start);
        std::memcpy(file.data() + 8, fields, sizeof fields);
        std::memcpy(file.data() + 40, json.data(), json.size());
        std::memcpy(file.data() + binaryOffset, binary.data(), binary.size());
        return file;
    }

    openntc::Expected<openntc::TextureSetMetadata> Load() const {
        const std::vector<std::byte> file = Build();
        openntc::ReadOnlyMemoryStream stream(file);
        return openntc::TextureSetMetadata::Load(stream);
    }

    /// The error must have this status and name this field.
    void CheckRefused(openntc::Status status, std::string_view text) const {
        const auto set = Load();
        REQUIRE_FALSE(set);
        const std::string_view message = set.error().GetText();
        CHECK_MESSAGE(set.error().GetStatus() == status, message);
        CHECK_MESSAGE(message.find(text) != std::string_view::npos, message);
    }

    std::string json;
    std::vector<std::byte> binary;
};

inline EditedFile EditV1() {
    return EditedFile(SynthesizeV1());
}

} // namespace openntc_tests
