// SPDX-License-Identifier: MIT
// How an engine uses OpenNTC: `engine_dropin FILE.ntc` decodes mip 0 with material.comp, prints some texels
// and checks the whole mip against the reference decoder. The lines between the two marks are all that an
// engine needs; `gpu` is whatever uploads buffers there.
#include "engine_dropin_shaders.h"

#include <openntc/core/FileStream.h>
#include <openntc/decode/ReferenceDecoder.h>
#include <openntc/openntc.h>
#include <vulkan_harness/Vulkan.h>

#include <cstdio>
#include <cstring>
#include <vector>

using namespace openntc;
using harness::BufferKind;
using harness::BufferMemory;

namespace {

constexpr int kNoDevice = 4; // exit status when Vulkan or a device is absent

Expected<int> Run(harness::Context& gpu, const char* path) {
    // ---- OpenNTC in an engine, from here
    const InferenceWeightType type = InferenceWeightType::GenericInt8;
    OPENNTC_ASSIGN(FileReader file, FileReader::Open(path));
    OPENNTC_ASSIGN(const TextureSetMetadata set, TextureSetMetadata::Load(file));
    const int mips = set.GetDesc().mips;
    OPENNTC_ASSIGN(const std::size_t latentBytes, GetLatentBufferBytes(set, 0, mips));
    std::vector<std::byte> latents(latentBytes);
    OPENNTC_CHECK(ReadLatents(set, file, 0, mips, latents));
    OPENNTC_ASSIGN(const std::span<const std::byte> weights, set.GetInferenceWeights(type));
    OPENNTC_ASSIGN(const NtcTextureSetConstants constants, MakeInferenceData(set, 0, mips, type));
    // What the scene reads, and what the device can do, pick one of the shaders that CMakeLists.txt had compiled.
    SceneNeeds needs;
    needs.device.integerDotProduct = gpu.GetDevice().features.Has(harness::Feature::IntegerDotProduct);
    OPENNTC_ASSIGN(const Permutation permutation, MakePermutation(set, needs));
    OPENNTC_ASSIGN(const CoveringShader shader,
                   engine_dropin_shaders::FindCoveringShader("material.comp", permutation.key));
    const auto constantBytes = std::as_bytes(std::span(&constants, 1));
    OPENNTC_ASSIGN(const auto constantBuffer,
                   gpu.CreateBuffer(constantBytes, BufferKind::Uniform, BufferMemory::DeviceLocal));
    OPENNTC_ASSIGN(const auto latentBuffer,
                   gpu.CreateBuffer(latents, BufferKind::Storage, BufferMemory::DeviceLocal));
    OPENNTC_ASSIGN(const auto weightBuffer,
                   gpu.CreateBuffer(weights, BufferKind::Storage, BufferMemory::DeviceLocal));
    // ---- to here; now make a pipeline of shader.words, bind them and call NtcSampleTextureSet in a shader.

    const auto width = static_cast<std::uint32_t>(set.GetDesc().width);
    const auto height = static_cast<std::uint32_t>(set.GetDesc().height);
    std::vector<float> texels(std::size_t{width} * height * NTC_MAX_CHANNELS);
    const auto texelBytes = std::as_writable_bytes(std::span(texels));
    OPENNTC_ASSIGN(const auto result,
                   gpu.CreateBuffer(texelBytes.size(), BufferKind::Storage, BufferMemory::HostVisible));
    const harness::BufferSlot slots[] = {{0, BufferKind::Uniform},
                                         {1, BufferKind::Storage},
                                         {2, BufferKind::Storage},
                                         {3, BufferKind::Storage}};
    OPENNTC_ASSIGN(const auto pipeline, gpu.CreateComputePipeline(shader.words, slots, 0));
    const harness::BoundBuffer buffers[] = {
        {0, &constantBuffer}, {1, &latentBuffer}, {2, &weightBuffer}, {3, &result}};
    OPENNTC_CHECK(gpu.Dispatch({&pipeline, buffers, {}, {(width + 7) / 8, (height + 7) / 8, 1}}));
    OPENNTC_CHECK(gpu.Read(result, 0, texelBytes));

    for (std::uint32_t x = 0; x < 4 && x < width; ++x) {
        std::printf("texel (%u, 0):", x);
        for (int c = 0; c < set.GetDesc().channels; ++c)
            std::printf(
                " %.6g",
                static_cast<double>(texels[std::size_t{x} * NTC_MAX_CHANNELS + static_cast<std::size_t>(c)]));
        std::printf("\n");
    }
    std::vector<float> reference(texels.size());
    const DecodeSource source{&constants, latents, weights, set.GetNetworkVersion()};
    const Rect all{0, 0, set.GetDesc().width, set.GetDesc().height};
    OPENNTC_CHECK(DecodeReference(source, 0, all, {}, reference));
    const bool equal = std::memcmp(texels.data(), reference.data(), texelBytes.size()) == 0;
    std::printf("%u x %u texels on %s: %s\n", width, height, gpu.GetDevice().name.c_str(),
                equal ? "all bits equal the reference decoder's" : "different from the reference decoder's");
    return equal ? 0 : 1;
}

} // namespace

int main(int argc, char** argv) {
    if (argc < 2) {
        std::fprintf(stderr, "usage: engine_dropin FILE.ntc [DEVICE]\n");
        return 2;
    }
    harness::ContextOptions options;
    options.device = argc > 2 ? argv[2] : "";
    const auto gpu = harness::Context::Create(options);
    if (!gpu) {
        std::fprintf(stderr, "SKIP: %s\n", gpu.error().GetText());
        return kNoDevice;
    }
    const Expected<int> status = Run(**gpu, argv[1]);
    if (!status)
        std::fprintf(stderr, "engine_dropin: %s: %s\n", argv[1], status.error().GetText());
    return status ? *status : 1;
}
