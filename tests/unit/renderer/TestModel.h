// SPDX-License-Identifier: MIT
// Small glTF models, written by tests: numbers first, then JSON about them.
#pragma once

#include "renderer/scene/GltfScene.h"

#include "Failure.h"
#include "Png.h"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

namespace openntc_tests {

/// A folder of its own, removed with all that is in it.
class ModelFolder {
public:
    ModelFolder()
        : path_(std::filesystem::temp_directory_path() /
                ("openntc-renderer-" + std::to_string(std::random_device()()))) {
        std::filesystem::create_directories(path_);
    }
    ~ModelFolder() {
        std::error_code error;
        std::filesystem::remove_all(path_, error);
    }
    ModelFolder(const ModelFolder&) = delete;
    ModelFolder& operator=(const ModelFolder&) = delete;

    std::string GetPath(const std::string& name) const { return (path_ / name).string(); }

    void Write(const std::string& name, const std::string& text) const {
        std::filesystem::create_directories((path_ / name).parent_path());
        std::ofstream(path_ / name, std::ios::binary) << text;
    }

    /// RGBA of width x height; 16 bits are 257 times the bytes.
    void WriteImage(const std::string& name, int width, int height, const std::vector<std::uint16_t>& samples,
                    int channels = 4, int bits = 8) const {
        openntc::tool::PngWriter writer(path_ / name, name, {width, height, channels, bits});
        const auto row = static_cast<std::size_t>(width * channels);
        for (std::size_t y = 0; y < static_cast<std::size_t>(height); ++y)
            writer.WriteRow(std::span(samples).subspan(y * row, row));
        writer.Finish();
    }

private:
    std::filesystem::path path_;
};

/// Binary data with its views and accessors.
class ModelData {
public:
    /// Returns the index of a view over the numbers, each of `padding` bytes more behind it.
    template <typename T>
    int AddView(const std::vector<T>& numbers, std::size_t group = 1, std::size_t padding = 0) {
        bytes_.append((4 - bytes_.size() % 4) % 4, '\0');
        const std::size_t begin = bytes_.size();
        for (std::size_t i = 0; i < numbers.size(); ++i) {
            char raw[sizeof(T)];
            std::memcpy(raw, &numbers[i], sizeof(T));
            bytes_.append(raw, sizeof(T));
            if ((i + 1) % group == 0 && i + 1 < numbers.size())
                bytes_.append(padding, '\x7f');
        }
        views_ += (views_.empty() ? "" : ",") + std::string("{\"buffer\":0,\"byteOffset\":") +
                  std::to_string(begin) + ",\"byteLength\":" + std::to_string(bytes_.size() - begin) +
                  (padding == 0 ? "" : ",\"byteStride\":" + std::to_string(group * sizeof(T) + padding)) +
                  "}";
        return viewCount_++;
    }

    /// Returns the index. `more`: further members, with a comma before them.
    int AddAccessor(int view, int type, const std::string& shape, std::size_t count,
                    const std::string& more = "") {
        accessors_ += (accessors_.empty() ? "" : ",") + std::string("{") +
                      (view < 0 ? "" : "\"bufferView\":" + std::to_string(view) + ",") +
                      "\"componentType\":" + std::to_string(type) + ",\"type\":\"" + shape +
                      "\",\"count\":" + std::to_string(count) + more + "}";
        return accessorCount_++;
    }
    int AddFloats(const std::vector<float>& numbers, int components) {
        const char* const shapes[] = {"SCALAR", "VEC2", "VEC3", "VEC4"};
        return AddAccessor(AddView(numbers), 5126, shapes[components - 1],
                           numbers.size() / static_cast<std::size_t>(components));
    }

    /// A .glb file; `json` are the members of the root beside asset, buffers, bufferViews and accessors.
    std::string MakeGlb(const std::string& json) const {
        std::string text = R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":)" +
                           std::to_string(bytes_.size()) + "}],\"bufferViews\":[" + views_ +
                           "],\"accessors\":[" + accessors_ + "]" + (json.empty() ? "" : "," + json) + "}";
        text.append((4 - text.size() % 4) % 4, ' ');
        std::string binary = bytes_;
        binary.append((4 - binary.size() % 4) % 4, '\0');
        std::string file = "glTF" + Word(2) + Word(28 + text.size() + binary.size());
        file += Word(text.size()) + "JSON" + text + Word(binary.size()) + std::string("BIN\0", 4) + binary;
        return file;
    }

private:
    static std::string Word(std::size_t value) {
        std::string text;
        for (int i = 0; i < 4; ++i)
            text += static_cast<char>(value >> (8 * i) & 0xffu);
        return text;
    }

    std::string bytes_, views_, accessors_;
    int viewCount_ = 0, accessorCount_ = 0;
};

/// Loads a model from a folder of its own.
inline openntc::renderer::Scene LoadModel(const std::string& glb,
                                          const openntc::renderer::GltfSceneOptions& options = {}) {
    const ModelFolder folder;
    folder.Write("model.glb", glb);
    return openntc::renderer::LoadGltfScene(folder.GetPath("model.glb"), options);
}

/// What loading says is wrong; empty where nothing is.
inline std::string GetModelError(const std::string& glb) {
    try {
        LoadModel(glb);
    } catch (const openntc::tool::CommandError& error) {
        return error.what();
    }
    return {};
}

} // namespace openntc_tests
