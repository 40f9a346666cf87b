// SPDX-License-Identifier: MIT
// Scenes out of formulas: surfaces, materials and textures.
#pragma once

#include "renderer/scene/Scene.h"

#include <cstdint>
#include <functional>
#include <string>

namespace openntc::renderer {

class SceneBuilder {
public:
    explicit SceneBuilder(std::string name) { scene_.name = std::move(name); }

    Scene& GetScene() { return scene_; }

    /// Returns the index of an image whose texels are `texel(x, y)`, red in the lowest byte.
    int AddImage(const std::string& label, int width, int height,
                 const std::function<std::uint32_t(int x, int y)>& texel);

    /// Returns the index of the material.
    int AddMaterial(Material material);

    struct Point {
        glm::vec3 position;
        glm::vec3 normal; ///< 0: none
        glm::vec2 uv;
    };
    /// A surface over the unit square, columns x rows quads. Its front is where the normals point. Tangents
    /// are computed for materials with a normal map. Returns the index of the primitive.
    int AddSurface(int material, int columns, int rows, const std::function<Point(float u, float v)>& point);

    /// A unit square in the xy plane, facing +z, with its texture upright; its corners' coordinates are
    /// `transform`ed.
    int AddQuad(int material, const UvTransform& transform = {}, int cells = 1);
    /// Radius 1, texture round the equator `repeat` times and half as often from pole to pole.
    int AddSphere(int material, float repeat = 2.0f, int columns = 48, int rows = 24);
    /// Round the z axis, of radii `major` and `minor`.
    int AddTorus(int material, float major, float minor, glm::vec2 repeat);
    /// Round the y axis, radius 1, height 1 from 0 up, open.
    int AddCylinder(int material, glm::vec2 repeat);

    /// Draws a primitive; later ones over earlier ones where both blend.
    void Add(int primitive, const glm::mat4& toWorld);
    void AddAt(int primitive, glm::vec3 position, glm::vec3 scale = glm::vec3(1.0f));

    /// A camera at `eye` that looks at `target`.
    void AddCamera(const std::string& name, glm::vec3 eye, glm::vec3 target, float yfov = 0.7f);

    /// The scene, with bounds. The builder is empty afterwards.
    Scene Take();

private:
    Scene scene_;
};

/// Moves, then scales.
glm::mat4 MakePlace(glm::vec3 position, glm::vec3 scale = glm::vec3(1.0f));

/// A turn round an axis (0 x, 1 y, 2 z) by an angle in radians, by the right hand.
glm::mat4 MakeTurn(int axis, float angle);

/// Sets Scene::bounds to those of all vertices that are drawn.
void UpdateBounds(Scene& scene);

} // namespace openntc::renderer
