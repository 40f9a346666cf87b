// SPDX-License-Identifier: MIT
// A forged grille over embers: an alpha mask with exact 0 and 1, and emission far above 1.
#include "Materials.h"
#include "Noise.h"

#include <utility>

namespace materials {

namespace {

constexpr const char* kGrilleManifest = R"({
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

} // namespace

MaterialImages MakeGrille(int size) {
    constexpr int kCells = 6;
    Image color(size, 4), height(size, 1), roughness(size, 1), metalness(size, 1), emission(size, 3);
    for (int py = 0; py < size; ++py) {
        for (int px = 0; px < size; ++px) {
            const float u = (static_cast<float>(px) + 0.5f) / static_cast<float>(size);
            const float v = (static_cast<float>(py) + 0.5f) / static_cast<float>(size);
            const float dent = (Fractal(u, v, 12, 3, 5) - 0.5f) * 0.12f;
            const float x = u * kCells, y = v * kCells;
            const int cx = static_cast<int>(x), cy = static_cast<int>(y);
            const float lx = x - static_cast<float>(cx) - 0.5f, ly = y - static_cast<float>(cy) - 0.5f;
            // Octagonal holes; the bars between them carry rivets at the crossings.
            const float edge =
                std::max({std::fabs(lx), std::fabs(ly), (std::fabs(lx) + std::fabs(ly)) * 0.72f}) + dent;
            const float texel = static_cast<float>(kCells) / static_cast<float>(size);
            const float alpha = std::clamp((edge - 0.36f) / texel + 0.5f, 0.0f, 1.0f);
            const float grain = Fractal(u, v, 64, 3, 7), rust = Smooth(0.45f, 0.65f, Fractal(u, v, 8, 5, 9));
            const float rivet = Smooth(0.1f, 0.07f, std::hypot(0.5f - std::fabs(lx), 0.5f - std::fabs(ly)));
            const float bar = Smooth(0.36f, 0.46f, edge);
            const float iron = 0.3f + 0.15f * grain + 0.15f * rivet;
            color.At(px, py, 0) = Mix(iron, 0.3f * grain + 0.1f, rust);
            color.At(px, py, 1) = Mix(iron * 0.98f, 0.12f * grain + 0.04f, rust);
            color.At(px, py, 2) = Mix(iron * 0.95f, 0.03f, rust);
            color.At(px, py, 3) = alpha;
            height.At(px, py) = 0.3f + 0.4f * bar + 0.25f * rivet + 0.05f * grain - 0.05f * rust;
            roughness.At(px, py) = Mix(0.3f + 0.2f * grain, 0.92f, rust);
            metalness.At(px, py) = 1.0f - rust;
            // The bars glow where embers heat them, up to about 20 nominal.
            const float heat = Smooth(0.5f, 0.8f, Fractal(u, v, 4, 4, 13)) * (1.0f - 0.8f * bar) * alpha;
            emission.At(px, py, 0) = 20.0f * heat * heat * heat;
            emission.At(px, py, 1) = 9.0f * heat * heat * heat * heat;
            emission.At(px, py, 2) = 2.0f * heat * heat * heat * heat * heat;
        }
    }
    const float depth = static_cast<float>(size) / 24.0f;
    Image normal = MakeNormals(height, depth), occlusion = MakeOcclusion(height, depth);
    return {std::move(color),  std::move(height),    std::move(roughness), std::move(metalness),
            std::move(normal), std::move(occlusion), std::move(emission)};
}

bool WriteGrille(const std::filesystem::path& folder, int size) {
    const MaterialImages images = MakeGrille(size);
    return WritePng(folder / "grille_basecolor.png", images.color, true) &&
           WritePng(folder / "grille_normal.png", images.normal, false) &&
           WritePng(folder / "grille_roughness.png", images.roughness, false) &&
           WritePng(folder / "grille_metalness.png", images.metalness, false) &&
           WritePng(folder / "grille_occlusion.png", images.occlusion, false) &&
           WriteHdr(folder / "grille_emission.hdr", images.emission) &&
           WriteText(folder / "grille.json", kGrilleManifest);
}

} // namespace materials
