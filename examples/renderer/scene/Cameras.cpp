// SPDX-License-Identifier: MIT
#include "renderer/scene/Cameras.h"

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace openntc::renderer {

glm::mat4 MakeView(const Camera& camera) {
    const glm::mat3 turn = glm::transpose(glm::mat3(camera.toWorld));
    glm::mat4 view(turn);
    view[3] = glm::vec4(-(turn * glm::vec3(camera.toWorld[3])), 1.0f);
    return view;
}

glm::mat4 MakeProjection(const Camera& camera, float viewportAspect) {
    const float n = camera.znear, f = camera.zfar;
    const bool isFinite = f > 0.0f;
    glm::mat4 projection(0.0f); // columns
    if (camera.perspective) {
        const float aspect = camera.aspect > 0.0f ? camera.aspect : viewportAspect;
        float tangent = std::tan(0.5f * camera.yfov);
        if (viewportAspect < aspect)
            tangent *= aspect / viewportAspect;
        projection[0].x = 1.0f / (viewportAspect * tangent);
        projection[1].y = -1.0f / tangent;
        projection[2].z = isFinite ? n / (f - n) : 0.0f;
        projection[3].z = isFinite ? n * f / (f - n) : n;
        projection[2].w = -1.0f;
        return projection;
    }
    // Depth falls linearly from 1 at znear to 0 at zfar; an orthographic camera always has the latter.
    const float aspect = camera.xmag / camera.ymag;
    const float x = viewportAspect > aspect ? camera.ymag * viewportAspect : camera.xmag;
    const float y = viewportAspect < aspect ? camera.xmag / viewportAspect : camera.ymag;
    projection[0].x = 1.0f / x;
    projection[1].y = -1.0f / y;
    projection[2].z = 1.0f / (f - n);
    projection[3].z = f / (f - n);
    projection[3].w = 1.0f;
    return projection;
}

glm::mat4 MakeViewProjection(const Camera& camera, float viewportAspect) {
    return MakeProjection(camera, viewportAspect) * MakeView(camera);
}

glm::mat4 MakeJitteredViewProjection(const Camera& camera, glm::vec2 size, glm::vec2 jitter) {
    // A pixel that samples to the right of its centre sees a picture that has moved to the left.
    glm::mat4 shift(1.0f);
    shift[3].x = -2.0f * jitter.x / size.x;
    shift[3].y = -2.0f * jitter.y / size.y;
    return shift * MakeViewProjection(camera, size.x / size.y);
}

glm::vec2 GetJitter(unsigned frame) {
    // 2^32 over powers of the plastic number; half a pixel first, so that frame 0 is the centre.
    const auto place = [frame](std::uint32_t step) {
        const std::uint32_t word = 0x80000000u + frame * step;
        return static_cast<float>(static_cast<double>(word) / 4294967296.0 - 0.5);
    };
    return {place(0xC13FA9A9u), place(0x91E10DA6u)};
}

Camera MakeOrbitCamera(const Bounds& bounds, float azimuth, float elevation, float distance) {
    Camera camera;
    camera.name = "orbit";
    const glm::vec3 middle = 0.5f * (bounds.low + bounds.high);
    const float radius = std::max(0.5f * glm::length(bounds.high - bounds.low), 1e-6f);
    const float length = distance * 1.2f * radius / std::sin(0.5f * camera.yfov);
    const glm::vec3 back(std::sin(azimuth) * std::cos(elevation), std::sin(elevation),
                         std::cos(azimuth) * std::cos(elevation));
    const glm::vec3 right(std::cos(azimuth), 0.0f, -std::sin(azimuth));
    camera.toWorld = glm::mat4(glm::vec4(right, 0.0f), glm::vec4(glm::cross(back, right), 0.0f),
                               glm::vec4(back, 0.0f), glm::vec4(middle + length * back, 1.0f));
    camera.znear = std::max(0.01f * length, 1e-6f);
    return camera;
}

} // namespace openntc::renderer
