// SPDX-License-Identifier: MIT
// The scene that is drawn when no model is given: the project's own materials.
#pragma once

#include "renderer/scene/SceneBuilder.h"

#include <string>

namespace openntc::renderer {

/// A courtyard of bricks with a brazier of glowing iron, camera "courtyard". The images are generated; the
/// texture sets are bricks.ntc and grille.ntc of `materialDir` (empty: those of the source tree).
Scene MakeSampleScene(const std::string& materialDir = {});

/// A plate whose material calls for every effect of metallic-roughness, transmission too, with the texture set grille.ntc of
/// the source tree; camera "front".
void AddEverything(SceneBuilder& builder);

} // namespace openntc::renderer
