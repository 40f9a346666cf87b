// SPDX-License-Identifier: MIT
#include "Host.h"

#include "openntc/core/FileStream.h"
#include "openntc/decode/FastDecoder.h"
#include "openntc/inference/InferenceData.h"
#include "openntc/inference/ReadLatents.h"
#include "openntc/texture_set/TextureSetMetadata.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string_view>
#include <type_traits>
#include <utility>

namespace opengl_example {

namespace {

template <typename Value>
Value Require(openntc::Expected<Value> value, const std::string& subject) {
    if (!value)
        throw std::runtime_error(subject + ": " + value.error().GetText());
    if constexpr (!std::is_void_v<Value>)
        return std::move(*value);
}

bool Contains(std::string_view name, std::string_view word) {
    return std::search(name.begin(), name.end(), word.begin(), word.end(),
                       [](char a, char b) { return (a | 0x20) == b; }) != name.end();
}

GLuint Compile(GLenum stage, const std::string& source) {
    const GLuint shader = glCreateShader(stage);
    const char* text = source.c_str();
    glShaderSource(shader, 1, &text, nullptr);
    glCompileShader(shader);
    GLint ok = 0;
    glGetShaderiv(shader, GL_COMPILE_STATUS, &ok);
    if (ok == 0) {
        std::array<char, 2048> log{};
        glGetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), nullptr, log.data());
        throw std::runtime_error(std::string("shader: ") + log.data());
    }
    return shader;
}

} // namespace

Material LoadMaterial(const std::string& path) {
    openntc::FileReader file = Require(openntc::FileReader::Open(path), path);
    const openntc::TextureSetMetadata set = Require(openntc::TextureSetMetadata::Load(file), path);
    const auto type = openntc::InferenceWeightType::GenericInt8;
    Material material;
    material.network = set.GetNetworkVersion();
    material.width = set.GetDesc().width;
    material.height = set.GetDesc().height;
    material.mips = set.GetDesc().mips;
    material.constants = Require(openntc::MakeInferenceData(set, 0, material.mips, type), path);
    material.latents.resize(Require(openntc::GetLatentBufferBytes(set, 0, material.mips), path));
    Require(openntc::ReadLatents(set, file, 0, material.mips, material.latents), path);
    const auto weights = Require(set.GetInferenceWeights(type), path);
    material.weights.assign(weights.begin(), weights.end());
    for (const openntc::Texture& texture : set.GetTextures()) {
        if (Contains(texture.name, "color") || Contains(texture.name, "albedo"))
            material.baseColor = texture.firstChannel;
        else if (Contains(texture.name, "normal"))
            material.normal = texture.firstChannel;
        else if (Contains(texture.name, "rough"))
            material.roughness = texture.firstChannel;
    }
    const openntc::FastDecoder decoder =
        Require(openntc::FastDecoder::Create(
                    {&material.constants, material.latents, material.weights, material.network}),
                path);
    for (int mip = 0; mip < material.mips; ++mip) {
        const int width = std::max(material.width >> mip, 1), height = std::max(material.height >> mip, 1);
        std::vector<float> texels(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 16);
        Require(decoder.Decode(mip, {0, 0, width, height}, {}, texels), path);
        material.texels.push_back(std::move(texels));
    }
    return material;
}

Context::Context(int major, int minor) {
    display_ = eglGetPlatformDisplay(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
    if (display_ == EGL_NO_DISPLAY || eglInitialize(display_, nullptr, nullptr) == EGL_FALSE)
        throw NoContext("EGL: no display without a surface");
    eglBindAPI(EGL_OPENGL_API);
    const std::array<EGLint, 7> attributes = {EGL_CONTEXT_MAJOR_VERSION,
                                              major,
                                              EGL_CONTEXT_MINOR_VERSION,
                                              minor,
                                              EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                              EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                              EGL_NONE};
    context_ = eglCreateContext(display_, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes.data());
    if (context_ == EGL_NO_CONTEXT ||
        eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) == EGL_FALSE)
        throw NoContext("EGL: no context of OpenGL " + std::to_string(major) + "." + std::to_string(minor));
    std::printf("%s, OpenGL %s\n", reinterpret_cast<const char*>(glGetString(GL_RENDERER)),
                reinterpret_cast<const char*>(glGetString(GL_VERSION)));
}

Context::~Context() {
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(display_, context_);
    eglTerminate(display_);
}

std::string LoadFunctions(const std::string& stem, int network) {
    const std::string path = std::string(OPENGL_FUNCTIONS_DIR "/") + stem +
                             ".glsl+NETWORK_VERSION=" + std::to_string(network) + "+NTC_MATH=1.glsl";
    std::ifstream file(path);
    if (!file)
        throw std::runtime_error(path + ": cannot be read");
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

GLuint MakeProgram(const std::string& vertex, const std::string& fragment) {
    const GLuint program = glCreateProgram();
    glAttachShader(program, Compile(GL_VERTEX_SHADER, vertex));
    glAttachShader(program, Compile(GL_FRAGMENT_SHADER, fragment));
    glLinkProgram(program);
    GLint ok = 0;
    glGetProgramiv(program, GL_LINK_STATUS, &ok);
    if (ok == 0) {
        std::array<char, 2048> log{};
        glGetProgramInfoLog(program, static_cast<GLsizei>(log.size()), nullptr, log.data());
        throw std::runtime_error(std::string("program: ") + log.data());
    }
    return program;
}

const char* const kCoverVertex = "#version 330\n"
                                 "void main() {\n"
                                 "    vec2 corner = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);\n"
                                 "    gl_Position = vec4(corner * 2.0 - 1.0, 0.0, 1.0);\n"
                                 "}\n";

Targets::Targets(int width, int height) : width_(width), height_(height) {
    glGenFramebuffers(1, &framebuffer_);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
    glGenTextures(static_cast<GLsizei>(textures_.size()), textures_.data());
    std::array<GLenum, 4> buffers{};
    for (std::size_t i = 0; i < textures_.size(); ++i) {
        glActiveTexture(GL_TEXTURE15); // not one that a material is bound to
        glBindTexture(GL_TEXTURE_2D, textures_[i]);
        glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, width, height, 0, GL_RGBA, GL_FLOAT, nullptr);
        buffers[i] = GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(i);
        glFramebufferTexture2D(GL_FRAMEBUFFER, buffers[i], GL_TEXTURE_2D, textures_[i], 0);
    }
    glDrawBuffers(static_cast<GLsizei>(buffers.size()), buffers.data());
    glViewport(0, 0, width, height);
}

Targets::~Targets() {
    glDeleteFramebuffers(1, &framebuffer_);
    glDeleteTextures(static_cast<GLsizei>(textures_.size()), textures_.data());
}

std::vector<float> Targets::Read() const {
    const std::size_t texels = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
    std::vector<float> four(texels * 4), all(texels * 16);
    for (std::size_t i = 0; i < textures_.size(); ++i) {
        glReadBuffer(GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(i));
        glReadPixels(0, 0, width_, height_, GL_RGBA, GL_FLOAT, four.data());
        for (std::size_t texel = 0; texel < texels; ++texel)
            std::copy_n(four.data() + texel * 4, 4, all.data() + texel * 16 + i * 4);
    }
    return all;
}

std::size_t CompareMips(const Material& material, GLuint program) {
    glUseProgram(program);
    const GLint mipLocation = glGetUniformLocation(program, "mip");
    std::size_t wrong = 0, numbers = 0;
    double seconds = 0.0, texels = 0.0;
    for (int mip = 0; mip < material.mips; ++mip) {
        const int width = std::max(material.width >> mip, 1), height = std::max(material.height >> mip, 1);
        const Targets targets(width, height);
        glUniform1i(mipLocation, mip);
        if (mip == 0) { // drivers compile when they first draw
            glDrawArrays(GL_TRIANGLES, 0, 3);
            glFinish();
        }
        const auto start = std::chrono::steady_clock::now();
        glDrawArrays(GL_TRIANGLES, 0, 3);
        glFinish();
        if (mip == 0) {
            seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
            texels = static_cast<double>(width) * height;
        }
        const std::vector<float> drawn = targets.Read();
        const std::vector<float>& expected = material.texels[static_cast<std::size_t>(mip)];
        for (std::size_t i = 0; i < drawn.size(); ++i)
            wrong +=
                std::bit_cast<std::uint32_t>(drawn[i]) != std::bit_cast<std::uint32_t>(expected[i]) ? 1u : 0u;
        numbers += drawn.size();
    }
    if (const GLenum error = glGetError(); error != GL_NO_ERROR)
        throw std::runtime_error("OpenGL: error " + std::to_string(error));
    std::printf("%zu of %zu numbers differ from the CPU's; mip 0: %.0f texels/s\n", wrong, numbers,
                texels / seconds);
    return wrong;
}

void DrawPicture(GLuint program, int size, const std::string& path) {
    const Targets targets(size, size);
    glUseProgram(program);
    glUniform1f(glGetUniformLocation(program, "size"), static_cast<float>(size));
    glDrawArrays(GL_TRIANGLES, 0, 3);
    const std::vector<float> texels = targets.Read();
    std::ofstream file(path, std::ios::binary);
    file << "P6\n" << size << " " << size << "\n255\n";
    for (int y = size - 1; y >= 0; --y) { // OpenGL's rows begin at the bottom
        for (int x = 0; x < size; ++x) {
            for (std::size_t c = 0; c < 3; ++c) {
                const std::size_t texel = static_cast<std::size_t>(y) * static_cast<std::size_t>(size) +
                                          static_cast<std::size_t>(x);
                const float value = std::clamp(texels[texel * 16 + c], 0.0f, 1.0f);
                file.put(static_cast<char>(static_cast<unsigned char>(std::lround(value * 255.0f))));
            }
        }
    }
    if (!file.flush())
        throw std::runtime_error(path + ": cannot be written");
}

int RunExample(const char* name, int argc, char** argv, int (*run)(const char* file, const char* picture)) {
    if (argc < 2 || argc > 3) {
        std::fprintf(stderr, "usage: %s FILE.ntc [PICTURE.ppm]\n", name);
        return 2;
    }
    try {
        return run(argv[1], argc == 3 ? argv[2] : nullptr);
    } catch (const NoContext& error) {
        std::printf("SKIP: %s: %s\n", name, error.what());
        return 4;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s: %s\n", name, error.what());
        return 3;
    }
}

} // namespace opengl_example
