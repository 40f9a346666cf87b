// SPDX-License-Identifier: MIT
// Stability: stable
// Umbrella header of the runtime: reads texture sets and prepares everything that the shaders need. The CPU
// decoders (openntc/decode) and the writer of files (openntc/container/Writer.h) are included separately.
#pragma once

#define OPENNTC_VERSION_MAJOR 0
#define OPENNTC_VERSION_MINOR 1
#define OPENNTC_VERSION_PATCH 0
/// One number to compare versions with: major · 10000 + minor · 100 + patch.
#define OPENNTC_VERSION (OPENNTC_VERSION_MAJOR * 10000 + OPENNTC_VERSION_MINOR * 100 + OPENNTC_VERSION_PATCH)

#include "openntc/inference/BufferPacking.h"
#include "openntc/inference/InferenceData.h"
#include "openntc/inference/PartialInference.h"
#include "openntc/inference/ReadLatents.h"
#include "openntc/permutation/PermutationCover.h"
#include "openntc/permutation/PermutationKey.h"
#include "openntc/permutation/ShaderBlob.h"
#include "openntc/texture_set/TextureSetMetadata.h"
