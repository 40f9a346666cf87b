// SPDX-License-Identifier: MIT
// make_materials FOLDER [SIZE]: writes the sample materials' images and manifests.
#include "Materials.h"

#include <cstdio>
#include <cstdlib>

int main(int argc, char** argv) {
    const int size = argc > 2 ? std::atoi(argv[2]) : 512;
    if (argc < 2 || argc > 3 || size < 1 || size > 8192) {
        std::fprintf(stderr, "usage: make_materials FOLDER [SIZE]\n");
        return 2;
    }
    const std::filesystem::path folder = argv[1];
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error || !materials::WriteBricks(folder, size) || !materials::WriteGrille(folder, size)) {
        std::fprintf(stderr, "make_materials: %s: cannot write\n", argv[1]);
        return 1;
    }
    return 0;
}
