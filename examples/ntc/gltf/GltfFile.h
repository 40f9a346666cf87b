// SPDX-License-Identifier: MIT
// A glTF 2.0 file, text (.gltf) or binary (.glb): its JSON, and the bytes of its images wherever they are.
#pragma once

#include "encode/Manifest.h"

#include <rapidjson/document.h>

#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace openntc::tool {

/// Where the texels of a texture are.
struct GltfImage {
    std::string label; ///< for messages: the decoded URI, or `images[3]`
    std::string path;  ///< of a separate file; for an embedded image MODEL: images[3]
    ImageBytes bytes;  ///< of an embedded image; empty: the file is to be read
};

/// Errors are CommandError(BadInput) about the file, `field: value: limit`.
class GltfFile {
public:
    using Value = rapidjson::Value;

    /// Checks the container, asset.minVersion, asset.version and extensionsRequired; reads no image.
    explicit GltfFile(const std::string& path);

    const Value& GetRoot() const { return document_; }
    const std::string& GetPath() const { return path_; }

    [[noreturn]] void Fail(const std::string& field, const std::string& text) const;

    /// A member that is an object; an empty object where there is none. `where` names it in errors.
    const Value& GetObject(const Value& parent, const char* name, const std::string& where) const;
    /// A member that is a string; empty where there is none.
    std::string GetString(const Value& parent, const char* name, const std::string& where) const;
    /// A member of the root that is an array, or null.
    const Value* FindArray(const char* name) const;
    /// The object that index `parent`.`name` points to in the root's `array`.
    const Value& Follow(const Value& parent, const char* name, const char* array,
                        const std::string& where) const;

    /// The image that a texture (an element of the root's `textures`) is made of.
    GltfImage GetImage(const Value& texture, const std::string& where);
    /// The bytes of the buffer view that `parent`.bufferView points to.
    ImageBytes GetView(const Value& parent, const std::string& where);

private:
    void ReadDocument(std::vector<std::byte>&& file);
    std::size_t FindJsonChunk(const std::vector<std::byte>& file, std::size_t& size);
    void CheckAsset() const;
    void CheckExtensions() const;

    std::string GetReferencedPath(const std::string& uri, const std::string& where) const;
    ImageBytes GetBuffer(const Value& buffer, unsigned index, const std::string& where);
    /// The bytes of a data URI that is written somewhere else in the file, decoded once.
    std::shared_ptr<const std::vector<std::byte>> Decode(const Value& uri, const std::string& where,
                                                         std::string& mediaType);

    std::string path_;
    rapidjson::Document document_;
    ImageBytes binaryChunk_;
    bool isBinary_ = false;
    // A hostile file may point to the same bytes many times: each is kept once.
    std::map<std::string, std::shared_ptr<const std::vector<std::byte>>> files_;
    std::map<const Value*, std::pair<std::string, std::shared_ptr<const std::vector<std::byte>>>> decoded_;
};

} // namespace openntc::tool
