// SPDX-License-Identifier: MIT
// opengl33 FILE.ntc [PICTURE.ppm]: a texture set in OpenGL 3.3, which has neither storage buffers nor `precise`. Constants are a
// uniform block of 624 bytes (std140), latents and weights R32UI textures of 1024 words a row; a uniform that is zero keeps
// roundings apart. The decoder is functions33.glsl as one text without directives.
#include "Host.h"
#include "Programs.h"

#include <algorithm>
#include <cstring>

using namespace opengl_example;

namespace {

constexpr const char* kHead = "#version 330\n";
constexpr const char* kBindings =
    "layout(std140) uniform Material { NtcTextureSetConstants desc; };\n"
    "uniform usampler2D latents;\n"
    "uniform usampler2D weights;\n"
    "#define SAMPLE(texel, mip, channels) SampleMaterial(desc, latents, weights, texel, mip, channels)\n";

void BindWords(GLuint unit, const std::vector<std::byte>& bytes) {
    constexpr std::size_t kWordsPerRow = 1024; // as functions33.glsl has it
    const std::size_t rows = std::max<std::size_t>((bytes.size() / 4 + kWordsPerRow - 1) / kWordsPerRow, 1);
    std::vector<std::uint32_t> words(rows * kWordsPerRow);
    std::memcpy(words.data(), bytes.data(), bytes.size() / 4 * 4);
    GLuint texture = 0;
    glGenTextures(1, &texture);
    glActiveTexture(GL_TEXTURE0 + unit);
    glBindTexture(GL_TEXTURE_2D, texture);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST); // integers have no other
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_R32UI, kWordsPerRow, static_cast<GLsizei>(rows), 0, GL_RED_INTEGER,
                 GL_UNSIGNED_INT, words.data());
}

GLuint MakeBoundProgram(const std::string& fragment) {
    const GLuint program = MakeProgram(kCoverVertex, fragment);
    glUseProgram(program);
    glUniformBlockBinding(program, glGetUniformBlockIndex(program, "Material"), 0);
    glUniform1i(glGetUniformLocation(program, "latents"), 0);
    glUniform1i(glGetUniformLocation(program, "weights"), 1);
    glUniform1ui(glGetUniformLocation(program, "ntcZero"), 0);
    return program;
}

int Run(const char* file, const char* picture) {
    const Material material = LoadMaterial(file);
    const Context context(3, 3);
    GLuint vertexArray = 0, constants = 0;
    glGenVertexArrays(1, &vertexArray);
    glBindVertexArray(vertexArray);
    glGenBuffers(1, &constants);
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, constants);
    glBufferData(GL_UNIFORM_BUFFER, sizeof(material.constants), &material.constants, GL_STATIC_DRAW);
    BindWords(0, material.latents);
    BindWords(1, material.weights);

    const std::string decoder = kHead + LoadFunctions("functions33", material.network) + kBindings;
    const std::size_t wrong = CompareMips(material, MakeBoundProgram(decoder + kTexelsMain));
    if (picture != nullptr)
        DrawPicture(MakeBoundProgram(decoder + MakeSphereMain(material)), 512, picture);
    return wrong == 0 ? 0 : 1;
}

} // namespace

int main(int argc, char** argv) {
    return RunExample("opengl33", argc, argv, Run);
}
