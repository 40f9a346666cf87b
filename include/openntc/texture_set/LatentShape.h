// SPDX-License-Identifier: MIT
// Stability: stable
// Latent shapes: how many latents of how many bits a texture set stores, the table of proven shapes, and
// picking one.
#pragma once

#include "openntc/InferenceConstants.h"
#include "openntc/core/Expected.h"
#include "openntc/format/LatentQuantization.h"
#include "openntc/format/Limits.h"
#include "openntc/format/NetworkDescription.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// Geometry of the latents. Source of limits: format specification, "validation of a shape". Of generations 2
/// and 3, whose latent mips all have as many features of 4 bits, latent mip 0 is the high-res grid and latent
/// mip 1 the low-res grid: MakeLayeredShape.
struct LatentShape {
    int gridSizeScale = 0; ///< texels of mip 0 per high-res latent pixel and axis, 2 … 8; 1 … 6 if layered
    int highResFeatures = 0;  ///< latents per high-res latent pixel: 4, 8, 12, 16
    int lowResFeatures = 0;   ///< the same for the low-res grid
    int highResQuantBits = 0; ///< bits per latent: 1, 2, 4, 8
    int lowResQuantBits = 0;

    friend constexpr bool operator==(const LatentShape&, const LatentShape&) noexcept = default;

    /// All zero: no latents.
    constexpr bool IsEmpty() const noexcept { return *this == LatentShape{}; }
};

/// A row of the table of known shapes.
struct KnownLatentShape {
    float bitsPerPixel;
    LatentShape shape;
};

/// Bits of latents per texel of mip 0, computed in binary32: (high features · bits + low features · bits / 4)
/// / scale². 0 for a gridSizeScale of 0.
constexpr float GetLatentShapeBitsPerPixel(const LatentShape& shape) noexcept {
    if (shape.gridSizeScale == 0)
        return 0.0f;
    const float highBits = static_cast<float>(shape.highResFeatures * shape.highResQuantBits);
    const float lowBits = static_cast<float>(shape.lowResFeatures * shape.lowResQuantBits);
    return (highBits + 0.25f * lowBits) / static_cast<float>(shape.gridSizeScale * shape.gridSizeScale);
}

/// The shape of generations 2 and 3 with `features` (4, 8, 12, 16) in every latent mip.
constexpr LatentShape MakeLayeredShape(int gridSizeScale, int features) noexcept {
    return {gridSizeScale, features, features, kLayeredLatentBits, kLayeredLatentBits};
}

/// Layers of its latent mips.
constexpr int GetLatentLayers(const LatentShape& shape) noexcept {
    return (shape.highResFeatures + kFeatureStep - 1) / kFeatureStep;
}

/// The smallest network of generation 1 (NTC_NETWORK_*) that holds that many high-res features;
/// NTC_NETWORK_UNKNOWN if none does.
constexpr int GetNetworkVersionForFeatures(int highResFeatures) noexcept {
    for (int version = NTC_NETWORK_SMALL; version <= NTC_NETWORK_XLARGE; ++version) {
        if (highResFeatures > 0 && highResFeatures <= GetHighResSlots(version))
            return version;
    }
    return NTC_NETWORK_UNKNOWN;
}

namespace detail {

constexpr bool IsFeatureCount(int features) noexcept {
    return features >= kFeatureStep && features <= kMaxFeatures && features % kFeatureStep == 0;
}

inline Expected<void> ValidateLayeredEncoding(const LatentShape& shape) noexcept {
    if (!IsFeatureCount(shape.highResFeatures))
        return Fail(Status::OutOfRange, "latentShape.numFeatures: %d: must be 4, 8, 12 or 16",
                    shape.highResFeatures);
    if (shape != MakeLayeredShape(shape.gridSizeScale, shape.highResFeatures))
        return Fail(Status::OutOfRange,
                    "latentShape: %d x %d and %d x %d bits: generations 2 and 3 have the same features of %d "
                    "bits in all latent mips",
                    shape.highResFeatures, shape.highResQuantBits, shape.lowResFeatures,
                    shape.lowResQuantBits, kLayeredLatentBits);
    return {};
}

/// Everything but gridSizeScale: what a decoder depends on.
inline Expected<void> ValidateLatentEncoding(const LatentShape& shape, int networkVersion) noexcept {
    if (GetGeneration(networkVersion) > 1)
        return ValidateLayeredEncoding(shape);
    if (!IsFeatureCount(shape.highResFeatures))
        return Fail(Status::OutOfRange, "latentShape.highResFeatures: %d: must be 4, 8, 12 or 16",
                    shape.highResFeatures);
    if (!IsFeatureCount(shape.lowResFeatures))
        return Fail(Status::OutOfRange, "latentShape.lowResFeatures: %d: must be 4, 8, 12 or 16",
                    shape.lowResFeatures);
    if (!IsQuantBits(shape.highResQuantBits))
        return Fail(Status::OutOfRange, "latentShape.highResQuantBits: %d: must be 1, 2, 4 or 8",
                    shape.highResQuantBits);
    if (!IsQuantBits(shape.lowResQuantBits))
        return Fail(Status::OutOfRange, "latentShape.lowResQuantBits: %d: must be 1, 2, 4 or 8",
                    shape.lowResQuantBits);
    if (networkVersion != NTC_NETWORK_UNKNOWN && shape.highResFeatures > GetHighResSlots(networkVersion))
        return Fail(Status::OutOfRange, "latentShape.highResFeatures: %d: the network holds at most %d",
                    shape.highResFeatures, GetHighResSlots(networkVersion));
    return {};
}

/// Rows of the format specification's table of known shapes, one column per network.
using LatentShapeRow = std::array<std::uint8_t, 5>; // scale, high features, low features, high bits, low bits

struct KnownLatentShapeRow {
    float bitsPerPixel;
    std::array<LatentShapeRow, 4> networks;
};

inline constexpr int kKnownLatentShapes = 26;
inline constexpr int kKnownLatentShapesOfSmall = 24;

// clang-format off
inline constexpr std::array<KnownLatentShapeRow, kKnownLatentShapes> kKnownLatentShapeTable = {{
    {0.5f,   {{{4, 4,  4, 1, 4}, {4, 4,  4, 1, 4}, {4,  4,  4, 1, 4}, {4,  4,  4, 1, 4}}}},
    {0.625f, {{{4, 4, 12, 1, 2}, {4, 4, 12, 1, 2}, {4,  4, 12, 1, 2}, {4,  4, 12, 1, 2}}}},
    {0.75f,  {{{4, 4,  8, 1, 4}, {4, 4,  8, 1, 4}, {4,  4,  8, 1, 4}, {4,  4,  8, 1, 4}}}},
    {0.875f, {{{4, 4, 12, 2, 2}, {4, 4, 12, 2, 2}, {4,  4, 12, 2, 2}, {4,  4, 12, 2, 2}}}},
    {1.0f,   {{{4, 4,  8, 2, 4}, {4, 4,  8, 2, 4}, {4,  4,  8, 2, 4}, {4,  4,  8, 2, 4}}}},
    {1.25f,  {{{4, 4, 12, 2, 4}, {4, 4, 12, 2, 4}, {4,  4, 12, 2, 4}, {4,  4, 12, 2, 4}}}},
    {1.5f,   {{{4, 4, 16, 2, 4}, {4, 4, 16, 2, 4}, {4,  4, 16, 2, 4}, {4,  4, 16, 2, 4}}}},
    {1.75f,  {{{4, 4, 12, 4, 4}, {4, 8, 12, 2, 4}, {4,  8, 12, 2, 4}, {4,  8, 12, 2, 4}}}},
    {2.0f,   {{{4, 4, 16, 4, 4}, {4, 8, 16, 2, 4}, {4,  8, 16, 2, 4}, {4,  8, 16, 2, 4}}}},
    {2.25f,  {{{4, 4, 16, 1, 8}, {4, 8,  4, 4, 4}, {4, 12, 12, 2, 4}, {4, 12, 12, 2, 4}}}},
    {2.5f,   {{{4, 4, 12, 4, 8}, {4, 8,  8, 4, 4}, {4, 12, 16, 2, 4}, {4, 12, 16, 2, 4}}}},
    {3.0f,   {{{2, 4,  8, 1, 4}, {4, 8, 16, 4, 4}, {4,  8, 16, 4, 4}, {4, 16, 16, 2, 4}}}},
    {3.5f,   {{{2, 4, 12, 2, 2}, {4, 8, 12, 4, 8}, {4, 12,  8, 4, 4}, {4, 12,  8, 4, 4}}}},
    {4.0f,   {{{2, 4,  8, 2, 4}, {2, 4,  8, 2, 4}, {4, 12, 16, 4, 4}, {4, 12, 16, 4, 4}}}},
    {4.5f,   {{{2, 4,  4, 4, 2}, {2, 4,  4, 4, 2}, {4, 12, 12, 4, 8}, {4, 16,  8, 4, 4}}}},
    {5.0f,   {{{2, 4, 12, 2, 4}, {2, 4, 12, 2, 4}, {2,  4, 12, 2, 4}, {4, 16, 16, 4, 4}}}},
    {6.0f,   {{{2, 4, 16, 2, 4}, {2, 8,  8, 2, 4}, {2,  8,  8, 2, 4}, {2,  8,  8, 2, 4}}}},
    {7.0f,   {{{2, 4, 12, 4, 4}, {2, 4, 12, 4, 4}, {2,  4, 12, 4, 4}, {2,  4, 12, 4, 4}}}},
    {8.0f,   {{{2, 4, 16, 4, 4}, {2, 8, 16, 2, 4}, {2,  8, 16, 2, 4}, {2,  8, 16, 2, 4}}}},
    {9.0f,   {{{2, 4, 16, 1, 8}, {2, 8,  4, 4, 4}, {2, 12, 12, 2, 4}, {2, 12, 12, 2, 4}}}},
    {10.0f,  {{{2, 4, 12, 4, 8}, {2, 8,  8, 4, 4}, {2, 12, 16, 2, 4}, {2, 12, 16, 2, 4}}}},
    {12.0f,  {{{2, 4, 16, 4, 8}, {2, 8, 16, 4, 4}, {2,  8, 16, 4, 4}, {2,  8, 16, 4, 4}}}},
    {14.0f,  {{{2, 4, 12, 8, 8}, {2, 8, 12, 4, 8}, {2, 12,  4, 4, 8}, {2, 12,  4, 4, 8}}}},
    {16.0f,  {{{2, 4, 16, 8, 8}, {2, 8, 16, 4, 8}, {2, 12, 16, 4, 4}, {2, 12, 16, 4, 4}}}},
    {18.0f,  {{{0, 0,  0, 0, 0}, {2, 8,  8, 8, 4}, {2, 12, 12, 4, 8}, {2, 16,  4, 4, 8}}}},
    {20.0f,  {{{0, 0,  0, 0, 0}, {2, 8, 16, 8, 4}, {2, 12, 16, 4, 8}, {2, 16,  8, 4, 8}}}},
}};
// clang-format on

/// Scale and features of the shapes known to generations 2 and 3.
inline constexpr std::array<std::array<std::uint8_t, 2>, 9> kKnownLayeredShapes = {
    {{6, 8}, {6, 12}, {4, 8}, {4, 12}, {4, 16}, {3, 12}, {2, 8}, {2, 12}, {2, 16}}};

/// Row `index` of the table for a network, which has it.
constexpr KnownLatentShape GetKnownLatentShape(int index, int networkVersion) noexcept {
    const auto at = static_cast<std::size_t>(index);
    if (GetGeneration(networkVersion) > 1) {
        const LatentShape shape = MakeLayeredShape(kKnownLayeredShapes[at][0], kKnownLayeredShapes[at][1]);
        return {GetLatentShapeBitsPerPixel(shape), shape};
    }
    const KnownLatentShapeRow& row = kKnownLatentShapeTable[at];
    const int column = networkVersion == NTC_NETWORK_UNKNOWN ? NTC_NETWORK_XLARGE - 1 : networkVersion - 1;
    const LatentShapeRow& s = row.networks[static_cast<std::size_t>(column)];
    return {row.bitsPerPixel, LatentShape{s[0], s[1], s[2], s[3], s[4]}};
}

} // namespace detail

/// Checks a shape that somebody wants to encode with: features, bits, gridSizeScale, and, unless
/// networkVersion is NTC_NETWORK_UNKNOWN (generation 1), that this network holds the high-res features. The
/// empty shape is valid. Errors: OutOfRange.
inline Expected<void> ValidateLatentShape(const LatentShape& shape,
                                          int networkVersion = NTC_NETWORK_UNKNOWN) noexcept {
    if (networkVersion != NTC_NETWORK_UNKNOWN && !IsKnownNetwork(networkVersion))
        return Fail(Status::OutOfRange, "networkVersion: %d: must be 0 … %d", networkVersion,
                    NTC_NETWORK_GENERATION_3);
    if (shape.IsEmpty())
        return {};
    const bool layered = GetGeneration(networkVersion) > 1;
    const int smallest = layered ? 1 : kMinGridSizeScale;
    const int largest = layered ? kMaxLayeredGridSizeScale : kMaxGridSizeScale;
    if (shape.gridSizeScale < smallest || shape.gridSizeScale > largest)
        return Fail(Status::OutOfRange, "latentShape.gridSizeScale: %d: must be %d … %d", shape.gridSizeScale,
                    smallest, largest);
    return detail::ValidateLatentEncoding(shape, networkVersion);
}

/// Rows of the table for a network: 24 for small, 26 for the others of generation 1 and NTC_NETWORK_UNKNOWN,
/// which counts as xlarge, 9 for generations 2 and 3; 0 for numbers that are no network version.
constexpr int GetKnownLatentShapeCount(int networkVersion) noexcept {
    if (networkVersion != NTC_NETWORK_UNKNOWN && !IsKnownNetwork(networkVersion))
        return 0;
    if (GetGeneration(networkVersion) > 1)
        return static_cast<int>(detail::kKnownLayeredShapes.size());
    return networkVersion == NTC_NETWORK_SMALL ? detail::kKnownLatentShapesOfSmall
                                               : detail::kKnownLatentShapes;
}

/// Row `index` of the table, sorted by bits per pixel. NTC_NETWORK_UNKNOWN counts as xlarge.
/// Errors: OutOfRange for an index outside the table or a number that is no network version.
inline Expected<KnownLatentShape> EnumerateKnownLatentShapes(int index, int networkVersion) noexcept {
    const int count = GetKnownLatentShapeCount(networkVersion);
    if (count == 0)
        return Fail(Status::OutOfRange, "networkVersion: %d: must be 0 … %d", networkVersion,
                    NTC_NETWORK_GENERATION_3);
    if (index < 0 || index >= count)
        return Fail(Status::OutOfRange, "latent shape index: %d: must be 0 … %d", index, count - 1);
    return detail::GetKnownLatentShape(index, networkVersion);
}

/// The known shape nearest to a wish in bits per pixel, less than 25 % of the wish away (binary32). Source:
/// format specification, "picking rule". Errors: OutOfRange if no row is that near, for a wish that is not
/// positive or not a number, and for numbers that are no network version.
inline Expected<KnownLatentShape> PickLatentShape(float bitsPerPixel, int networkVersion) noexcept {
    const int count = GetKnownLatentShapeCount(networkVersion);
    if (count == 0)
        return Fail(Status::OutOfRange, "networkVersion: %d: must be 0 … %d", networkVersion,
                    NTC_NETWORK_GENERATION_3);
    if (!(bitsPerPixel > 0.0f))
        return Fail(Status::OutOfRange, "bitsPerPixel: %g: must be positive",
                    static_cast<double>(bitsPerPixel));
    int best = -1;
    float bestDistance = 0.0f;
    for (int i = 0; i < count; ++i) {
        const float rowBits = detail::GetKnownLatentShape(i, networkVersion).bitsPerPixel;
        const float distance = std::fabs(rowBits - bitsPerPixel);
        if (distance < 0.25f * bitsPerPixel) {
            if (best < 0 || distance < bestDistance) {
                best = i;
                bestDistance = distance;
            }
        } else if (best >= 0) {
            break; // rows are sorted: nothing nearer follows
        }
    }
    if (best < 0)
        return Fail(Status::OutOfRange, "bitsPerPixel: %g: no known latent shape within 25 %% (%.3g to %.4g)",
                    static_cast<double>(bitsPerPixel),
                    static_cast<double>(detail::GetKnownLatentShape(0, networkVersion).bitsPerPixel) / 1.25,
                    static_cast<double>(detail::GetKnownLatentShape(count - 1, networkVersion).bitsPerPixel) /
                        0.75);
    return EnumerateKnownLatentShapes(best, networkVersion);
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
