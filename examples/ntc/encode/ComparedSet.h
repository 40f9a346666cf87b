// SPDX-License-Identifier: MIT
// Either side of a comparison: a texture set, or images, as planes of stored values.
#pragma once

#include "TextureSet.h"

#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace openntc::tool {

struct ComparedTexture {
    std::string name;
    std::string fileName; ///< what `ntc decode` calls its image, without extension
    int firstChannel = 0;
    int channels = 0;
};

struct ComparedSet {
    std::string path;
    std::uint32_t declared = 0;
    int maskChannel = -1; ///< alpha mask that a manifest names; a file does not know it
    std::vector<ComparedTexture> textures;
    std::vector<std::string> warnings; ///< of decoding
    struct Mip {
        int width = 0, height = 0;
        std::vector<float> planes[16]; ///< empty for channels without texture
    };
    std::vector<Mip> mips;
};

/// Which channels of two sides belong together.
struct ComparedPairs {
    /// What a side has alone, in its own numbers.
    struct LeftOut {
        std::vector<int> channels;
        std::vector<std::string> textures; ///< all of whose channels are left out
        std::string text;                  ///< for people; empty: nothing
    };
    bool isByName = false;                 ///< false: no name is on both sides, so that channels go by number
    std::uint32_t channels = 0;            ///< that are compared, by the numbers of the first side
    std::vector<ComparedTexture> textures; ///< with such channels
    LeftOut onlyInA, onlyInB;
};

/// Pairs textures by name, or else by file name, and moves the channels of `b` to the
/// numbers that they have in `a`. Where one has more channels the first ones are paired.
ComparedPairs PairChannels(const ComparedSet& a, ComparedSet& b);

/// What a texture set decodes to: by its Int8 network, or FP8 where it has no other. Throws CommandError.
ComparedSet DecodeSet(TextureSet& set);

/// Loads a .ntc file, a manifest, a folder or an image. Throws CommandError.
ComparedSet LoadComparedSet(const std::string& path);

/// Both sides of a comparison. Of the RGB images that decode makes of a set's textures of two channels, these
/// two. Throws CommandError.
std::pair<ComparedSet, ComparedSet> LoadComparedSets(const std::string& a, const std::string& b);

/// Three channels from `firstChannel` on, pixel by pixel; all must be there.
std::vector<float> InterleaveColors(const ComparedSet::Mip& mip, int firstChannel);

/// Clamps a channel to 0 ... 1, as readers of an alpha mask do: encoders write exact 0 and 1 beyond the
/// range.
void ClampChannel(ComparedSet& set, int channel);

/// Squared error and worst texel of one channel of one mip.
struct ChannelDifference {
    double squares = 0.0;
    double texels = 0.0;
    float worst = -1.0f; ///< absolute difference
    int worstX = 0, worstY = 0;

    void Add(const ChannelDifference& other);
    double Psnr() const; ///< dB; infinite for equal values
};
/// `mask`, when not empty: texels of 0 are left out.
ChannelDifference CompareChannel(const ComparedSet::Mip& a, const ComparedSet::Mip& b, int channel,
                                 std::span<const float> mask = {});

/// Structural similarity (Wang, Bovik, Sheikh, Simoncelli 2004) of one channel: mean over 8 x 8 windows every
/// 4 texels, constants 0.01 and 0.03 for a range of 1; smaller images are one window. With a `mask` windows
/// that hold a texel of 0 are left out; 1 when none is left.
double MeasureSsim(const ComparedSet::Mip& a, const ComparedSet::Mip& b, int channel,
                   std::span<const float> mask = {});

} // namespace openntc::tool
