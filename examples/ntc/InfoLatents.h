// SPDX-License-Identifier: MIT
// What `ntc info` says of generations, latents and views.
#pragma once

#include "Json.h"

#include "openntc/texture_set/TextureSetMetadata.h"

namespace openntc::tool {

/// The releases of LibNTC that read files of a generation, 1 to 3: "0.5 - 0.7".
const char* GetReleases(int generation);

/// Two grids, or layers, of how many features.
void PrintLatentShape(const TextureSetMetadata& metadata);

/// Each latent image or latent mip, and each view.
void PrintLatentDetails(const TextureSetMetadata& metadata);
void PrintViews(const TextureSetMetadata& metadata);

/// The members latentImages or latentMips.
void WriteLatents(JsonWriter& json, const TextureSetMetadata& metadata);

/// The member views.
void WriteViews(JsonWriter& json, const TextureSetMetadata& metadata);

} // namespace openntc::tool
