// SPDX-License-Identifier: MIT
#include "Landscape.h"

#include "Failure.h"
#include "LandscapeTerrain.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace openntc::landscape {

namespace {

/// A few earths and greens, so that fields can be told apart.
constexpr float kTints[][3] = {{1.0f, 1.0f, 1.0f},    {0.80f, 0.95f, 0.62f}, {1.0f, 0.86f, 0.66f},
                               {0.66f, 0.84f, 0.60f}, {0.95f, 0.78f, 0.70f}, {0.78f, 0.86f, 1.0f},
                               {1.0f, 0.95f, 0.72f}};

/// Scatters fields over choices.
std::uint32_t Mix(std::uint32_t x) noexcept {
    x = (x ^ (x >> 16)) * 0x7feb352du;
    x = (x ^ (x >> 15)) * 0x846ca68bu;
    return x ^ (x >> 16);
}

using Vector = std::array<double, 3>;

Vector Add(const Vector& a, const Vector& b, double scale) {
    return {a[0] + scale * b[0], a[1] + scale * b[1], a[2] + scale * b[2]};
}

Vector Cross(const Vector& a, const Vector& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Vector Normalize(const Vector& a) {
    const double length = std::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
    return {a[0] / length, a[1] / length, a[2] / length};
}

void Store(const Vector& from, double scale, float (&to)[4]) {
    for (std::size_t i = 0; i < 3; ++i)
        to[i] = static_cast<float>(from[i] * scale);
}

/// A long turn through the landscape, down to the ground twice.
Vector GetEye(const Landscape& landscape, double time) {
    const double width = static_cast<double>(landscape.GetFieldSize()) * landscape.GetOptions().columns;
    const double depth = static_cast<double>(landscape.GetFieldSize()) * landscape.GetOptions().rows;
    const double turn = 2.0 * 3.14159265358979 * time;
    const double x = width * (0.08 + 0.84 * time);
    const double z = depth * (0.5 + 0.28 * std::sin(1.5 * turn));
    const double above = 2.2 * std::min(1.0, width / 64.0) +
                         13.0 * (1.0 + std::cos(2.0 * turn)) * std::min(1.0, width / 512.0);
    const double ground =
        static_cast<double>(shader::GetTerrainHeight(static_cast<float>(x), static_cast<float>(z)));
    return {x, ground + above, z};
}

} // namespace

Landscape::Landscape(const LandscapeOptions& options) : options_(options) {
    for (const std::string& file : options.files) {
        sets_.push_back(std::make_unique<RepeatedSet>(file, options.setSize, options.tileSize));
        if (sets_.back()->GetMetadata().GetNetworkVersion() != GetNetworkVersion())
            throw tool::CommandError(
                tool::ExitCode::BadInput, file,
                "network: of another version than the first file's: one shader decodes all");
    }
    const std::uint32_t count = static_cast<std::uint32_t>(options.columns * options.rows);
    for (std::uint32_t i = 0; i < count; ++i) {
        Field field;
        field.set = Mix(i) % sets_.size();
        const std::uint32_t phases = static_cast<std::uint32_t>(sets_[field.set]->GetPhases());
        field.phase = {static_cast<int>(Mix(i + 1000) % phases), static_cast<int>(Mix(i + 2000) % phases)};
        fields_.push_back(field);
    }
}

std::uint64_t Landscape::GetTexels() const noexcept {
    return fields_.size() * static_cast<std::uint64_t>(options_.setSize) *
           static_cast<std::uint64_t>(options_.setSize);
}

std::uint64_t Landscape::GetLatentBytes() const noexcept {
    std::uint64_t bytes = 0;
    for (const Field& field : fields_)
        bytes += sets_[field.set]->GetLatentBytes();
    return bytes;
}

std::uint64_t Landscape::GetBlockBytes() const noexcept {
    std::uint64_t bytes = 0;
    for (const Field& field : fields_)
        bytes += sets_[field.set]->GetBlockBytes();
    return bytes;
}

std::uint32_t Landscape::GetLargestTileBytes() const noexcept {
    std::uint32_t bytes = 0;
    for (const auto& set : sets_)
        bytes = std::max(bytes, set->GetLargestTileBytes());
    return bytes;
}

std::uint32_t Landscape::GetTileCount() const noexcept {
    std::uint32_t tiles = 0;
    for (const Field& field : fields_)
        tiles += static_cast<std::uint32_t>(sets_[field.set]->GetLayout().GetTileCount());
    return tiles;
}

std::vector<std::byte> Landscape::MakeWeights() const {
    std::vector<std::byte> weights;
    for (const auto& set : sets_)
        weights.insert(weights.end(), set->GetWeights().begin(), set->GetWeights().end());
    return weights;
}

std::uint32_t Landscape::GetWeightsOffset(std::size_t set) const noexcept {
    std::size_t offset = 0;
    for (std::size_t i = 0; i < set; ++i)
        offset += sets_[i]->GetWeights().size();
    return static_cast<std::uint32_t>(offset);
}

LandscapeField Landscape::MakeField(std::size_t field) const noexcept {
    const RepeatedSet& set = GetSetOf(field);
    LandscapeField result{};
    result.set = static_cast<std::uint32_t>(fields_[field].set);
    result.weightsOffset = GetWeightsOffset(fields_[field].set);
    result.color = static_cast<std::uint32_t>(set.GetColorChannel());
    result.normal = set.GetNormalChannel() < 0 ? 16u : static_cast<std::uint32_t>(set.GetNormalChannel());
    const auto& tint = kTints[Mix(static_cast<std::uint32_t>(field) + 3000) % std::size(kTints)];
    std::copy_n(tint, 3, result.tint);
    return result;
}

LandscapeScene MakeScene(const Landscape& landscape, double time, int width, int height,
                         std::uint32_t frame) {
    LandscapeScene scene{};
    const Vector eye = GetEye(landscape, time);
    // Looks where it goes, and down the more the higher it is.
    const Vector ahead = GetEye(landscape, time + 0.01);
    const double high = eye[1] - static_cast<double>(shader::GetTerrainHeight(static_cast<float>(eye[0]),
                                                                              static_cast<float>(eye[2])));
    Vector forward = Normalize({ahead[0] - eye[0], 0.0, ahead[2] - eye[2]});
    forward = Normalize({forward[0], -0.18 - 0.015 * high, forward[2]});
    const Vector right = Normalize(Cross(forward, {0.0, 1.0, 0.0}));
    const Vector down = Cross(forward, right);
    const double pixel = 2.0 * std::tan(0.5 * 1.15) / width; // 66 degrees across
    Vector first = Add(forward, right, -0.5 * pixel * (width - 1));
    first = Add(first, down, -0.5 * pixel * (height - 1));
    Store(eye, 1.0, scene.eye);
    Store(right, pixel, scene.right);
    Store(down, pixel, scene.down);
    Store(first, 1.0, scene.first);
    Store(Normalize({0.5, 0.62, -0.35}), 1.0, scene.sun);
    scene.width = static_cast<std::uint32_t>(width);
    scene.height = static_cast<std::uint32_t>(height);
    scene.columns = static_cast<std::uint32_t>(landscape.GetOptions().columns);
    scene.rows = static_cast<std::uint32_t>(landscape.GetOptions().rows);
    scene.fieldSize = landscape.GetFieldSize();
    scene.setSize = static_cast<std::uint32_t>(landscape.GetOptions().setSize);
    scene.mips = static_cast<std::uint32_t>(landscape.GetMips());
    scene.frame = frame;
    return scene;
}

} // namespace openntc::landscape
