// SPDX-License-Identifier: MIT
// README's function on a sound file, on none, and on a file cut short anywhere: a shader and its buffers, or one line.
#include "app.h"

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <vector>

namespace {

/// An engine that remembers how many bytes it was given for each binding.
struct Engine {
    void UploadUniform(int binding, std::span<const std::byte> bytes) { sizes[binding] = bytes.size(); }
    void UploadStorage(int binding, std::span<const std::byte> bytes) { sizes[binding] = bytes.size(); }
    std::map<int, std::size_t> sizes;
};

int failures = 0;

void Check(bool good, const char* what) {
    if (!good) {
        std::printf("FAIL  %s\n", what);
        ++failures;
    }
}

} // namespace

int main(int argc, char** argv) {
    if (argc < 3)
        return 2;
    Engine engine;
    const auto shader = LoadMaterial(argv[1], engine);
    Check(shader.has_value(), shader ? "" : shader.error().GetText());
    Check(shader && !shader->words.empty(), "SPIR-V");
    Check(engine.sizes[0] == 624 && engine.sizes[1] == 56 && engine.sizes[2] == 13952, "buffers of V1");

    Engine other;
    const auto layered = LoadMaterial(argv[2], other);
    Check(layered.has_value(), layered ? "" : layered.error().GetText());
    Check(layered && !layered->words.empty(), "SPIR-V of generation 3");
    Check(other.sizes[0] == 624 && other.sizes[1] == 1524 && other.sizes[2] == 9472,
          "buffers of generation 3");

    const auto absent = LoadMaterial("no/such/file.ntc", engine);
    Check(!absent && std::string(absent.error().GetText()).size() > 10, "no file: one line");

    std::ifstream file(argv[1], std::ios::binary);
    const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
    for (std::size_t size = 0; size < bytes.size(); size += 97) {
        std::ofstream("cut.ntc", std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(size));
        const auto cut = LoadMaterial("cut.ntc", engine);
        Check(!cut && std::string(cut.error().GetText()).size() > 10, "a file cut short: one line");
    }
    std::filesystem::remove("cut.ntc");
    std::printf("%s\n", failures == 0 ? "README: as written" : "README: not as written");
    return failures == 0 ? 0 : 1;
}
