// SPDX-License-Identifier: MIT
// opengl43 FILE.ntc [PICTURE.ppm]: a texture set in OpenGL 4.3. Constants are a uniform block of 624 bytes (std140), latents and
// weights shader storage buffers; the decoder is functions43.glsl as one text without directives.
#include "Host.h"
#include "Programs.h"

using namespace opengl_example;

namespace {

constexpr const char* kHead = "#version 430\n";
constexpr const char* kBindings =
    "layout(std140, binding = 0) uniform Material { NtcTextureSetConstants desc; };\n"
    "#define SAMPLE(texel, mip, channels) SampleMaterial(desc, texel, mip, channels)\n";

void Bind(GLenum target, GLuint index, const void* data, std::size_t bytes) {
    GLuint buffer = 0;
    glGenBuffers(1, &buffer);
    glBindBuffer(target, buffer);
    glBufferData(target, static_cast<GLsizeiptr>(bytes), data, GL_STATIC_DRAW);
    glBindBufferBase(target, index, buffer);
}

int Run(const char* file, const char* picture) {
    const Material material = LoadMaterial(file);
    const Context context(4, 3);
    GLuint vertexArray = 0;
    glGenVertexArrays(1, &vertexArray);
    glBindVertexArray(vertexArray);
    Bind(GL_UNIFORM_BUFFER, 0, &material.constants, sizeof(material.constants));
    Bind(GL_SHADER_STORAGE_BUFFER, 0, material.latents.data(), material.latents.size());
    Bind(GL_SHADER_STORAGE_BUFFER, 1, material.weights.data(), material.weights.size());

    const std::string decoder = kHead + LoadFunctions("functions43", material.network) + kBindings;
    const std::size_t wrong = CompareMips(material, MakeProgram(kCoverVertex, decoder + kTexelsMain));
    if (picture != nullptr)
        DrawPicture(MakeProgram(kCoverVertex, decoder + MakeSphereMain(material)), 512, picture);
    return wrong == 0 ? 0 : 1;
}

} // namespace

int main(int argc, char** argv) {
    return RunExample("opengl43", argc, argv, Run);
}
