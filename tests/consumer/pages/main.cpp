// SPDX-License-Identifier: MIT
// The two blocks of C++ of docs/shaders.md, each the body of a function.
#include <openntc/inference/Synthesis.h>
#include <openntc/openntc.h>

#include "shaders.includes"

#include <cstdio>
#include <filesystem>
#include <string_view>

namespace {

bool FindForScene(const openntc::Expected<openntc::TextureSetMetadata>& set,
                  const openntc::Expected<openntc::ShaderBlob>& blob, bool hasShaderIntegerDotProduct) {
#include "shaders.0"
    return shader.has_value() && !shader->words.empty();
}

bool FindInFile() {
#include "shaders.1"
    return spirv.has_value() && !spirv->empty();
}

} // namespace

// The page opens the blob where it lies: in the folder that is the argument.
int main(int argc, char** argv) {
    if (argc < 2)
        return 2;
    std::filesystem::current_path(argv[1]);
    openntc::Texture albedo;
    albedo.name = "Albedo";
    albedo.numChannels = 3;
    openntc::SynthesisDesc desc;
    desc.desc = {24, 20, 4, 4};
    desc.shape = {4, 4, 8, 2, 4};
    desc.textures = {&albedo, 1};
    openntc::MemoryStream stream;
    if (!openntc::SynthesizeTextureSet(stream, desc) || !stream.Seek(0))
        return 2;
    const auto set = openntc::TextureSetMetadata::Load(stream);
    auto file = openntc::FileReader::Open("app_shaders.bin");
    if (!file)
        return 2;
    const auto words = openntc::ReadShaderBlob(*file);
    if (!words)
        return 2;
    const auto blob = openntc::ShaderBlob::Open(words->AsSpan());
    const bool good = FindForScene(set, blob, true) && FindForScene(set, blob, false) && FindInFile();
    std::printf("docs/shaders.md: %s\n", good ? "as written" : "not as written");
    return good ? 0 : 1;
}
