// SPDX-License-Identifier: MIT
// Numbers of a glTF model's geometry: accessors over buffer views, with strides, normalised integers and
// sparse replacements (glTF 2.0, section 3.6.2).
#pragma once

#include "gltf/GltfFile.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace openntc::tool {

/// Elements of an accessor as numbers, one after another.
struct GltfNumbers {
    std::size_t count = 0; ///< elements
    int components = 0;    ///< per element, 1 ... 4
    std::vector<float> values;
};

/// Reads accessors of a file. Errors are CommandError(BadInput), `accessors[3].field: value: limit`.
class GltfAccessorReader {
public:
    /// No accessor may have more than `maximumCount` elements.
    GltfAccessorReader(GltfFile& file, std::size_t maximumCount) : file_(file), maximumCount_(maximumCount) {}

    /// Number of elements of accessor `parent`.`name`, without reading them.
    std::size_t GetCount(const GltfFile::Value& parent, const char* name, const std::string& where);

    /// Elements of `low` to `high` components. Normalised integers become -1 ... 1 or 0 ... 1, others whole
    /// numbers; every number is finite.
    GltfNumbers ReadNumbers(const GltfFile::Value& parent, const char* name, const std::string& where,
                            int low, int high);

    /// Scalars of unsigned integers, below `limit` each.
    std::vector<std::uint32_t> ReadIndices(const GltfFile::Value& parent, const char* name,
                                           const std::string& where, std::size_t limit);

private:
    struct Layout {
        std::size_t count = 0;
        int components = 0;
        int type = 0; ///< 5120 ... 5126, numbers of OpenGL
        bool isNormalized = false;
        std::size_t GetElementSize() const;
    };
    Layout GetLayout(const GltfFile::Value& accessor, const std::string& at);
    std::size_t GetNumber(const GltfFile::Value& parent, const char* name, const std::string& at,
                          std::size_t limit, bool isRequired);
    /// Elements, packed, in the order of the file's bytes.
    std::vector<std::byte> ReadElements(const GltfFile::Value& accessor, const Layout& layout,
                                        const std::string& at);
    void ReadView(const GltfFile::Value& parent, const std::string& at, std::size_t count, std::size_t size,
                  std::vector<std::byte>& elements);
    void ApplySparse(const GltfFile::Value& sparse, const Layout& layout, const std::string& at,
                     std::vector<std::byte>& elements);

    GltfFile& file_;
    std::size_t maximumCount_;
};

} // namespace openntc::tool
