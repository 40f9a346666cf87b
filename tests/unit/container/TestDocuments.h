// SPDX-License-Identifier: MIT
// Documents and helpers that the container tests share.
#pragma once

#include "openntc/container/Reader.h"
#include "openntc/container/Writer.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

namespace openntc::container::test {

inline std::filesystem::path SharedFolder() {
    const char* fromEnvironment = std::getenv("OPENNTC_SHARED_DIR");
    return std::filesystem::path(fromEnvironment != nullptr ? fromEnvironment : OPENNTC_DEFAULT_SHARED_DIR);
}

inline std::vector<std::filesystem::path> ConformanceFiles() {
    std::vector<std::filesystem::path> files;
    std::error_code none;
    for (const auto& entry : std::filesystem::directory_iterator(SharedFolder() / "conformance", none)) {
        if (entry.path().extension() == ".ntc")
            files.push_back(entry.path());
    }
    std::sort(files.begin(), files.end());
    return files;
}

inline std::string ReadWholeFile(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

inline Expected<Container> ReadBytes(std::string_view bytes, Allocator& allocator = GetDefaultAllocator()) {
    ReadOnlyMemoryStream stream(std::as_bytes(std::span(bytes.data(), bytes.size())));
    return ReadContainer(stream, allocator);
}

inline std::string Join(std::initializer_list<std::string_view> parts) {
    std::string text;
    for (const std::string_view part : parts)
        text.append(part);
    return text;
}

/// A file around a JSON text: header, text, NUL, and `binaryBytes` zeros.
inline std::string WrapJson(std::string_view json, std::size_t binaryBytes = 64) {
    Header header;
    header.jsonSize = json.size() + 1;
    header.binaryOffset = (kHeaderBytes + header.jsonSize + 3) & ~std::uint64_t{3};
    header.binarySize = binaryBytes;
    const HeaderBytes bytes = EncodeHeader(header);
    std::string file(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    file += json;
    file.resize(static_cast<std::size_t>(header.binaryOffset) + binaryBytes);
    return file;
}

inline Expected<Container> ReadJson(std::string_view json, std::size_t binaryBytes = 64) {
    return ReadBytes(WrapJson(json, binaryBytes));
}

/// The message of the error that reading this JSON gives, or "" if it is accepted.
inline std::string JsonError(std::string_view json, std::size_t binaryBytes = 64) {
    const Expected<Container> container = ReadJson(json, binaryBytes);
    return container ? std::string() : std::string(container.error().GetText());
}

inline std::string FormatToString(const Document& document) {
    const Expected<Array<char>> text = FormatDocument(document);
    if (!text)
        return Join({"ERROR ", text.error().GetText()});
    return std::string(text->data(), text->size());
}

template <typename T>
void Fill(Array<T>& array, std::initializer_list<T> values) {
    for (const T& value : values)
        (void)array.PushBack(value);
}

inline MlpLayer MakeLayer(std::uint32_t inputs, std::uint32_t outputs, std::uint32_t firstView) {
    MlpLayer layer;
    layer.inputChannels = inputs;
    layer.outputChannels = outputs;
    layer.weightView = firstView;
    layer.scaleView = firstView + 1;
    layer.biasView = firstView + 2;
    layer.weightType = MlpDataType::Int8;
    layer.scaleType = MlpDataType::Float32;
    layer.biasType = MlpDataType::Int32;
    return layer;
}

inline std::string Replace(std::string text, std::string_view from, std::string_view to) {
    const std::size_t at = text.find(from);
    return at == std::string::npos ? std::string("pattern not found") : text.replace(at, from.size(), to);
}

/// The smallest accepted document.
inline constexpr std::string_view kMinimalJson =
    R"({"schemaVersion":1,"width":1,"height":2,"numChannels":3})";

} // namespace openntc::container::test
