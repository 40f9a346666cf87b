// SPDX-License-Identifier: MIT
// Fields of texture sets beside each other, and what all of them together would take.
#pragma once

#include "LandscapeConstants.h"
#include "RepeatedSet.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace openntc::landscape {

struct LandscapeOptions {
    std::vector<std::string> files; ///< small sets that are repeated, all of one network
    int columns = 16;
    int rows = 8;
    int setSize = 8192; ///< texels of a field
    int tileSize = 64;  ///< texels of a level's last mip
};

struct Field {
    std::size_t set = 0; ///< of Landscape::GetSets
    Phase phase;
};

class Landscape {
public:
    /// Throws CommandError as RepeatedSet, and BadInput for sets of different networks.
    explicit Landscape(const LandscapeOptions& options);

    const LandscapeOptions& GetOptions() const noexcept { return options_; }
    const std::vector<std::unique_ptr<RepeatedSet>>& GetSets() const noexcept { return sets_; }
    const std::vector<Field>& GetFields() const noexcept { return fields_; } ///< row by row
    const RepeatedSet& GetSetOf(std::size_t field) const { return *sets_[fields_[field].set]; }
    int GetNetworkVersion() const noexcept { return sets_[0]->GetMetadata().GetNetworkVersion(); }
    /// Metres: 256 texels are one.
    float GetFieldSize() const noexcept { return static_cast<float>(options_.setSize) / 256.0f; }
    int GetMips() const noexcept { return sets_[0]->GetMetadata().GetDesc().mips; }

    std::uint64_t GetTexels() const noexcept; ///< of mip 0, all fields
    std::uint64_t GetLatentBytes() const noexcept;
    std::uint64_t GetBlockBytes() const noexcept;
    std::uint32_t GetLargestTileBytes() const noexcept;
    std::uint32_t GetTileCount() const noexcept; ///< all fields

    /// Weights of all sets, one behind the other, and where those of a set begin.
    std::vector<std::byte> MakeWeights() const;
    std::uint32_t GetWeightsOffset(std::size_t set) const noexcept;
    /// A field for the shader, with no texture yet and latents from byte 0 on.
    LandscapeField MakeField(std::size_t field) const noexcept;

private:
    LandscapeOptions options_;
    std::vector<std::unique_ptr<RepeatedSet>> sets_;
    std::vector<Field> fields_;
};

/// A frame's camera. `time` 0 … 1 along the path.
LandscapeScene MakeScene(const Landscape& landscape, double time, int width, int height, std::uint32_t frame);

} // namespace openntc::landscape
