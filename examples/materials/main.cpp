// SPDX-License-Identifier: MIT
// make_materials FOLDER [SIZE]: writes the sample materials' images and manifests.
#include "Materials.h"

#include <cstdio>
#include <cstdlib>
#include <fstream>

namespace {

constexpr const char* kBricks = R"({
  "textures": [
    {"fileName": "bricks_basecolor.png", "name": "BaseColor", "isSRGB": true, "bcFormat": "BC7", "semantics": {"Albedo": "RGB"}},
    {"fileName": "bricks_height.png", "name": "Height", "channelSwizzle": "R", "bcFormat": "BC4", "semantics": {"Displacement": "R"}},
    {"fileName": "bricks_metalness.png", "name": "Metalness", "channelSwizzle": "R", "bcFormat": "BC4", "semantics": {"Metalness": "R"}},
    {"fileName": "bricks_roughness.png", "name": "Roughness", "channelSwizzle": "R", "bcFormat": "BC4", "semantics": {"Roughness": "R"}},
    {"fileName": "bricks_normal.png", "name": "Normal", "bcFormat": "BC5", "firstChannel": 8, "semantics": {"Normal": "RGB"}},
    {"fileName": "bricks_occlusion.png", "name": "Occlusion", "channelSwizzle": "R", "bcFormat": "BC4", "firstChannel": 11, "semantics": {"Occlusion": "R"}}
  ]
}
)";

constexpr const char* kGrille = R"({
  "textures": [
    {"fileName": "grille_basecolor.png", "name": "BaseColor", "isSRGB": true, "bcFormat": "BC7", "semantics": {"Albedo": "RGB", "AlphaMask": "A"}},
    {"fileName": "grille_metalness.png", "name": "Metalness", "channelSwizzle": "R", "bcFormat": "BC4", "semantics": {"Metalness": "R"}},
    {"fileName": "grille_roughness.png", "name": "Roughness", "channelSwizzle": "R", "bcFormat": "BC4", "semantics": {"Roughness": "R"}},
    {"fileName": "grille_normal.png", "name": "Normal", "bcFormat": "BC5", "firstChannel": 8, "semantics": {"Normal": "RGB"}},
    {"fileName": "grille_occlusion.png", "name": "Occlusion", "channelSwizzle": "R", "bcFormat": "BC4", "firstChannel": 11, "semantics": {"Occlusion": "R"}},
    {"fileName": "grille_emission.hdr", "name": "Emissive", "bcFormat": "BC6", "firstChannel": 12, "semantics": {"Emissive": "RGB"}}
  ]
}
)";

bool WriteText(const std::filesystem::path& path, const char* text) {
    std::ofstream file(path, std::ios::binary);
    file << text;
    return file.good();
}

} // namespace

int main(int argc, char** argv) {
    const int size = argc > 2 ? std::atoi(argv[2]) : 512;
    if (argc < 2 || argc > 3 || size < 1 || size > 8192) {
        std::fprintf(stderr, "usage: make_materials FOLDER [SIZE]\n");
        return 2;
    }
    const std::filesystem::path folder = argv[1];
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error || !materials::WriteBricks(folder, size) || !WriteText(folder / "bricks.json", kBricks) ||
        !materials::WriteGrille(folder, size) || !WriteText(folder / "grille.json", kGrille)) {
        std::fprintf(stderr, "make_materials: %s: cannot write\n", argv[1]);
        return 1;
    }
    return 0;
}
