// SPDX-License-Identifier: MIT
// The images of a scene: found while materials are read, decoded afterwards.
#pragma once

#include "renderer/scene/Scene.h"

#include "encode/Manifest.h"

#include <string>
#include <vector>

namespace openntc::renderer {

/// Where an image of Scene::images is: a file, or bytes of another one.
struct ImageSource {
    std::string path;
    tool::ImageBytes bytes;
};

using ImageSources = std::vector<ImageSource>; ///< as many as Scene::images

/// Decodes all images, several at once. One that cannot be read becomes a grey texel and an error.
void DecodeImages(const ImageSources& sources, Scene& scene);

} // namespace openntc::renderer
