// SPDX-License-Identifier: MIT
// Generated scenes, each made so that its picture shows one thing, by numbers: what must look alike lies side
// by side.
#pragma once

#include "renderer/scene/Scene.h"

#include <span>
#include <string_view>

namespace openntc::renderer {

struct TestSceneInfo {
    std::string_view name;
    std::string_view shows;
};

/// The names that MakeTestScene takes.
std::span<const TestSceneInfo> GetTestScenes();

/// A scene with camera "front", without texture sets but for "everything". An unknown name gives a scene without instances.
Scene MakeTestScene(std::string_view name);

} // namespace openntc::renderer
