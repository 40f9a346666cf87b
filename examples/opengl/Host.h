// SPDX-License-Identifier: MIT
// A host without a window: an EGL context, programs, targets, and the texture set as the two examples need it.
#pragma once

#include "openntc/InferenceConstants.h"

#define GL_GLEXT_PROTOTYPES 1
#include <GL/glcorearb.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

namespace opengl_example {

/// What shaders read, and what their texels must be.
struct Material {
    int network = 0; ///< NTC_NETWORK_…
    int width = 0, height = 0, mips = 0;
    int baseColor = -1, normal = -1, roughness = -1; ///< first channels of textures of such names; -1: none
    openntc::NtcTextureSetConstants constants{};
    std::vector<std::byte> latents, weights;
    std::vector<std::vector<float>> texels; ///< of each mip by the CPU: 16 values a texel, row by row
};

/// Errors, here and below: std::runtime_error.
Material LoadMaterial(const std::string& path);

struct NoContext : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// A context of OpenGL `major`.`minor` core without a surface. Throws NoContext where the driver has none.
class Context {
public:
    Context(int major, int minor);
    ~Context();
    Context(const Context&) = delete;
    Context& operator=(const Context&) = delete;

private:
    void* display_ = nullptr;
    void* context_ = nullptr;
};

/// The flattened functions for a network, from the folder that openntc_add_shaders(OUTPUT FLAT) wrote.
std::string LoadFunctions(const std::string& stem, int network);

GLuint MakeProgram(const std::string& vertex, const std::string& fragment);

/// A vertex shader: three vertices without attributes cover the target, and gl_FragCoord says which texel it is.
extern const char* const kCoverVertex;

/// Four RGBA32F attachments hold the 16 channels of a texel.
class Targets {
public:
    Targets(int width, int height);
    ~Targets();
    Targets(const Targets&) = delete;
    Targets& operator=(const Targets&) = delete;
    /// 16 values a texel, row by row.
    std::vector<float> Read() const;

private:
    int width_, height_;
    GLuint framebuffer_ = 0;
    std::array<GLuint, 4> textures_{};
};

/// Draws every mip with `program`, whose uniform `mip` it sets, compares the words with the CPU's, and says how many differ and
/// how many texels a second were drawn. Returns the number that differ.
std::size_t CompareMips(const Material& material, GLuint program);

/// Draws a lit sphere with `program` and writes it as a portable pixmap.
void DrawPicture(GLuint program, int size, const std::string& path);

/// The main function: `NAME FILE.ntc [PICTURE.ppm]`, for which `run` is given the two paths (the second one may be null). Exit status: of
/// `run`, 2 usage, 3 an error, 4 no such context.
int RunExample(const char* name, int argc, char** argv, int (*run)(const char* file, const char* picture));

} // namespace opengl_example
