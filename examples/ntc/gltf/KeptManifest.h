// SPDX-License-Identifier: MIT
// `--keep-manifests`: what `ntc encode` needs to make the same file.
#pragma once

#include "encode/Manifest.h"

#include <string>

namespace openntc::tool {

/// Writes FOLDER/NAME.manifest.json, with paths relative to FOLDER, and images that are part of the model as
/// FOLDER/images/NAME.TEXTURE.png (or .jpg). Throws CommandError(Failed).
void KeepManifest(const Manifest& manifest, const std::string& folder, const std::string& name);

} // namespace openntc::tool
