// SPDX-License-Identifier: MIT
// A file taken apart into its JSON document and views, to be put together in forms that the library's writer never makes.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include <rapidjson/document.h>

namespace openntc::conformance {

struct RawLayout {
    std::vector<std::size_t> order; ///< views in the order of their bytes; empty: by index
    std::size_t gap = 0;            ///< bytes between views, a multiple of 4
    bool dataFirst = false;         ///< the binary chunk lies before the JSON chunk
    std::size_t chunkGap = 0;       ///< bytes before the second chunk, a multiple of 4
    bool isPretty = false;          ///< spaces and line feeds in the text
    bool hasNul = true;             ///< the text ends with NUL
};

class RawFile {
public:
    /// `file` is a valid one.
    explicit RawFile(std::span<const std::byte> file);

    rapidjson::Document json;
    std::vector<std::vector<std::byte>> views;

    /// Layer `layer` of the Int8 network in `mlp`.
    rapidjson::Value& GetLayer(std::size_t layer) {
        return json["mlp"]["layers"][static_cast<unsigned>(layer)];
    }
    void Set(rapidjson::Value& object, const char* key, rapidjson::Value value);
    void Set(rapidjson::Value& object, const char* key, const char* text);

    /// View i becomes view indices[i], everywhere.
    void RenumberViews(std::span<const std::size_t> indices);
    /// Members of all objects in reverse order, with unknown ones between them, enumerators in other cases.
    void DisguiseText();

    std::vector<std::byte> Write(const RawLayout& layout = {}) const;
};

} // namespace openntc::conformance
