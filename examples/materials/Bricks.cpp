// SPDX-License-Identifier: MIT
// A wall of worn bricks with mortar, moss in the joints and iron anchors.
#include "Materials.h"
#include "Noise.h"

#include <utility>

namespace materials {

namespace {

constexpr const char* kBricksManifest = R"({
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

constexpr int kColumns = 4, kRows = 8;

struct BrickPoint {
    int column, row;
    float inside; ///< distance to the brick's edge, in brick heights; negative in the joint
    float x, y;   ///< -1 ... 1 within the brick
};

BrickPoint Locate(float u, float v) {
    const float wobble = (Fractal(u, v, 16, 3, 11) - 0.5f) * 0.05f;
    const float y = v * kRows + wobble;
    const int row = static_cast<int>(std::floor(y));
    const float x = u * kColumns + (row % 2 == 0 ? 0.0f : 0.5f) + wobble * 0.5f;
    const int column = static_cast<int>(std::floor(x));
    BrickPoint point{};
    point.row = Wrap(row, kRows);
    point.column = Wrap(column, kColumns);
    point.x = (x - static_cast<float>(column)) * 2.0f - 1.0f;
    point.y = (y - static_cast<float>(row)) * 2.0f - 1.0f;
    const float dx = (1.0f - std::fabs(point.x)) * 1.0f, dy = (1.0f - std::fabs(point.y)) * 0.5f;
    const float chips = (Fractal(u, v, 32, 4, 21) - 0.45f) * 0.16f;
    point.inside = std::min(dx, dy) - 0.07f - std::max(chips, 0.0f);
    return point;
}

} // namespace

MaterialImages MakeBricks(int size) {
    Image color(size, 3), height(size, 1), roughness(size, 1), metalness(size, 1);
    for (int py = 0; py < size; ++py) {
        for (int px = 0; px < size; ++px) {
            const float u = (static_cast<float>(px) + 0.5f) / static_cast<float>(size);
            const float v = (static_cast<float>(py) + 0.5f) / static_cast<float>(size);
            const BrickPoint brick = Locate(u, v);
            const float solid = Smooth(-0.015f, 0.05f, brick.inside);
            const float tone = Random(brick.column, brick.row, 1), age = Random(brick.column, brick.row, 2);
            const float grain = Fractal(u, v, 64, 3, 31), stain = Fractal(u, v, 6, 4, 41);
            const float pits = Smooth(0.66f, 0.74f, Fractal(u, v, 48, 2, 51));
            const float moss =
                Smooth(0.52f, 0.68f, Fractal(u, v, 5, 5, 61)) * Smooth(0.14f, -0.02f, brick.inside);

            const float brickRed = Mix(0.22f, 0.42f, tone) * Mix(0.7f, 1.15f, grain) * Mix(1.0f, 0.6f, stain);
            const float mortar = Mix(0.32f, 0.5f, grain) * Mix(1.0f, 0.8f, stain);
            float r = Mix(mortar, brickRed, solid);
            float g = Mix(mortar * 0.95f, brickRed * Mix(0.34f, 0.5f, age), solid);
            float b = Mix(mortar * 0.87f, brickRed * Mix(0.22f, 0.36f, age), solid);
            float h = Mix(0.22f + 0.1f * grain,
                          0.72f + 0.12f * tone + 0.1f * grain - 0.2f * pits + 0.04f * brick.x, solid);
            float rough =
                Mix(0.92f - 0.08f * grain, Mix(0.62f, 0.85f, age) + 0.12f * pits - 0.1f * stain, solid);
            r = Mix(r, 0.05f + 0.05f * grain, moss);
            g = Mix(g, 0.12f + 0.10f * grain, moss);
            b = Mix(b, 0.02f + 0.02f * grain, moss);
            h += 0.12f * moss * grain;
            rough = Mix(rough, 0.97f, moss);

            // Round iron anchors on some bricks, rusting from the rim.
            float metal = 0.0f;
            if (Random(brick.column, brick.row, 3) > 0.8f) {
                const float radius = std::hypot(brick.x * 2.0f, brick.y);
                const float disc = Smooth(0.52f, 0.46f, radius);
                const float rust = Smooth(0.35f, 0.65f, Fractal(u, v, 24, 4, 71) + radius * 0.5f - 0.2f);
                metal = disc * (1.0f - rust);
                const float iron = 0.4f + 0.15f * grain;
                r = Mix(r, Mix(iron, 0.3f * grain + 0.12f, rust), disc);
                g = Mix(g, Mix(iron, 0.12f * grain + 0.04f, rust), disc);
                b = Mix(b, Mix(iron * 1.03f, 0.03f, rust), disc);
                h = Mix(h, 0.93f - 0.25f * radius * radius + 0.03f * grain, disc);
                rough = Mix(rough, Mix(0.28f + 0.2f * grain, 0.9f, rust), disc);
            }
            color.At(px, py, 0) = r;
            color.At(px, py, 1) = g;
            color.At(px, py, 2) = b;
            height.At(px, py) = h;
            roughness.At(px, py) = rough;
            metalness.At(px, py) = metal;
        }
    }
    const float depth = static_cast<float>(size) / 24.0f;
    Image normal = MakeNormals(height, depth), occlusion = MakeOcclusion(height, depth);
    return {std::move(color),  std::move(height),    std::move(roughness), std::move(metalness),
            std::move(normal), std::move(occlusion), Image(0, 0)};
}

bool WriteBricks(const std::filesystem::path& folder, int size) {
    const MaterialImages images = MakeBricks(size);
    return WritePng(folder / "bricks_basecolor.png", images.color, true) &&
           WritePng(folder / "bricks_normal.png", images.normal, false) &&
           WritePng(folder / "bricks_roughness.png", images.roughness, false) &&
           WritePng(folder / "bricks_metalness.png", images.metalness, false) &&
           WritePng(folder / "bricks_occlusion.png", images.occlusion, false) &&
           WritePng(folder / "bricks_height.png", images.height, false) &&
           WriteText(folder / "bricks.json", kBricksManifest);
}

} // namespace materials
