// SPDX-License-Identifier: MIT
// Stability: stable
// Limits of texture sets. Those of the constants that shaders read are the NTC_MAX_* of InferenceConstants.h;
// here are their names in C++ and what this SDK accepts besides.
#pragma once

#include "openntc/InferenceConstants.h"

#include "openntc/core/HideMacros.h"

namespace openntc {

inline constexpr int kMaxChannels = NTC_MAX_CHANNELS;
inline constexpr int kMaxMips = NTC_MAX_MIPS;
inline constexpr int kMaxNeuralMips = NTC_MAX_NEURAL_MIPS;

inline constexpr int kMaxTextures = 64; ///< per set that this SDK reads and writes
/// Texels per side that this SDK accepts: (2 x + 1) / (2 W) is rounded exactly for texels -2^22 … 2^22 - 1.
inline constexpr int kMaxImageDimension = 1 << 20;
inline constexpr int kMaxLatentDimension = 65535; ///< latent pixels per side: 16 bits in the constants

inline constexpr int kMaxFeatures = 16; ///< latents per latent pixel of a grid; a multiple of kFeatureStep
inline constexpr int kFeatureStep = 4;
/// Layers of a latent mip of generations 2 and 3, of kFeatureStep latents each.
inline constexpr int kMaxLatentLayers = kMaxFeatures / kFeatureStep;
inline constexpr int kMinGridSizeScale =
    2; ///< texels of mip 0 per high-res latent pixel and axis, for encoding
inline constexpr int kMaxGridSizeScale = 8;
inline constexpr int kMaxLayeredGridSizeScale = 6; ///< the same of generations 2 and 3, from 1 on
inline constexpr int kLayeredLatentBits = 4;       ///< of every latent of generations 2 and 3

/// Modes of BC7 blocks and their partitions, as counted in BlockCompressionMode.
inline constexpr int kBlockModes = 8;
inline constexpr int kBlockPartitions = 64;

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
