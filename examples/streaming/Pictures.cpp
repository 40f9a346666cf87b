// SPDX-License-Identifier: MIT
#include "Pictures.h"

#include "Png.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace openntc::landscape {

namespace {

struct Color {
    std::uint16_t red = 0;
    std::uint16_t green = 0;
    std::uint16_t blue = 0;
};

constexpr Color kTail = {34, 30, 56};
constexpr Color kFinest = {250, 220, 60};
constexpr Color kLevels[] = {kFinest, {74, 170, 110}, {52, 92, 150}};
constexpr Color kCamera = {255, 60, 60};

/// Of the finest level that has the tile over (x, y), counted in tiles of level 0.
Color GetColor(const TileLayout& layout, const PageTable& table, std::uint32_t texture, int x, int y) {
    const std::span<const TileLevel> levels = layout.GetLevels();
    for (int level = 0; level < layout.GetLevelCount(); ++level) {
        const TileLevel& at = levels[static_cast<std::size_t>(level)];
        const int column = x * at.tilesX / levels[0].tilesX, row = y * at.tilesY / levels[0].tilesY;
        const auto slot =
            table.GetSlot(texture, at.firstTile + static_cast<std::uint32_t>(row * at.tilesX + column));
        if (slot && *slot != NTC_TILE_MISSING)
            return kLevels[std::min<std::size_t>(static_cast<std::size_t>(level), std::size(kLevels) - 1)];
    }
    return kTail;
}

class Rows {
public:
    Rows(const std::filesystem::path& path, int width, int height)
        : writer_(path, path.filename().string(), {width, height, 3, 8}),
          row_(3 * static_cast<std::size_t>(width)) {}

    void Set(int x, const Color& color) {
        std::uint16_t* const at = row_.data() + 3 * static_cast<std::size_t>(x);
        at[0] = color.red;
        at[1] = color.green;
        at[2] = color.blue;
    }
    void Write() { writer_.WriteRow(row_); }
    void Finish() { writer_.Finish(); }

private:
    tool::PngWriter writer_;
    std::vector<std::uint16_t> row_;
};

} // namespace

void WriteFramePng(const std::filesystem::path& path, const Picture& picture, int width, int height,
                   int samples) {
    Rows rows(path, width, height);
    const unsigned count = static_cast<unsigned>(samples * samples);
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            unsigned sums[3] = {count / 2, count / 2, count / 2};
            for (int i = 0; i < samples * samples; ++i) {
                const std::size_t at = static_cast<std::size_t>(y * samples + i / samples) *
                                           static_cast<std::size_t>(width * samples) +
                                       static_cast<std::size_t>(x * samples + i % samples);
                for (unsigned c = 0; c < 3; ++c)
                    sums[c] += (picture.colors[at] >> (8 * c)) & 255u;
            }
            rows.Set(x, {static_cast<std::uint16_t>(sums[0] / count),
                         static_cast<std::uint16_t>(sums[1] / count),
                         static_cast<std::uint16_t>(sums[2] / count)});
        }
        rows.Write();
    }
    rows.Finish();
}

void WriteResidencyPng(const std::filesystem::path& path, const Landscape& landscape, const PageTable& table,
                       std::span<const std::uint32_t> textureIds, double x, double z) {
    const int tiles = landscape.GetSets()[0]->GetLayout().GetResidencyWidth();
    const int cell = tiles + 1; // a line between fields
    const int columns = landscape.GetOptions().columns, rows = landscape.GetOptions().rows;
    const int cameraX = static_cast<int>(x * cell), cameraZ = static_cast<int>(z * cell);
    Rows png(path, columns * cell + 1, rows * cell + 1);
    for (int py = 0; py <= rows * cell; ++py) {
        for (int px = 0; px <= columns * cell; ++px) {
            Color color;
            if (px % cell != 0 && py % cell != 0) {
                const std::size_t field = static_cast<std::size_t>(py / cell * columns + px / cell);
                color = GetColor(landscape.GetSetOf(field).GetLayout(), table, textureIds[field],
                                 px % cell - 1, py % cell - 1);
            }
            if (std::abs(px - cameraX) + std::abs(py - cameraZ) <= std::max(tiles / 8, 1))
                color = kCamera;
            png.Set(px, color);
        }
        png.Write();
    }
    png.Finish();
}

} // namespace openntc::landscape
