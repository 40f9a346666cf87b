// SPDX-License-Identifier: MIT
// What the parts of bench_gpu share: its options, the shaders' index, and the synthesised sets.
#pragma once

#include "vulkan_harness/Vulkan.h"

#include "openntc/core/Expected.h"
#include "openntc/core/Stream.h"
#include "openntc/decode/DecodeTypes.h"
#include "openntc/texture_set/TextureSetMetadata.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace openntc::bench {

struct Options {
    std::string folder;
    std::string device;
    std::string only; ///< part of the variant's name
    std::string json;
    int size = 4096;
    int rows = 32; ///< compared
    int repetitions = 60;
    bool pipelines = false;   ///< a table of pipeline creation in the place of the measurements
    bool matrices = false;    ///< cooperative matrices in their place
    bool textures = false;    ///< DecompressToTextures beside decoding to a buffer, in their place
    bool forms = false;       ///< a table of the ways to fetch weights in their place
    bool generations = false; ///< generations of files in turns, in their place
};

/// BENCH_STAGE of variants that are there for the tables of pipelines and of forms only.
inline constexpr int kPipelineStage = 4;

/// One line of index.txt: a variant of the shader for one network.
struct Variant {
    std::string name;
    int network = 0;
    int math = 0; ///< NTC_MATH_*
    bool uniformWeights = false;
    int texels = 1;             ///< per invocation
    int stage = 0;              ///< BENCH_STAGE
    bool latentTexture = false; ///< latents are bound as a texture
    std::string file16;
    std::string file32; ///< "-": not compared
};

struct Set {
    MemoryStream file;
    std::optional<TextureSetMetadata> metadata;
    std::vector<std::byte> latents;
    NtcTextureSetConstants constants[2]; ///< for Int8 and FP8 weights
    std::span<const std::byte> weights[2];
    std::map<DecodeMath, std::vector<float>> references;
};

template <typename T>
T Require(Expected<T> value) {
    if (!value) {
        std::fprintf(stderr, "bench_gpu: %s\n", value.error().GetText());
        std::exit(1);
    }
    if constexpr (!std::is_void_v<T>)
        return std::move(*value);
}

/// What BenchDecode.comp reads and writes, on the device: constants, latents, weights, results. `latents` outlive it.
class BenchBuffers {
public:
    BenchBuffers(harness::Context& device, const NtcTextureSetConstants& constants,
                 std::span<const std::byte> latents, std::span<const std::byte> weights,
                 std::uint64_t resultBytes);

    const harness::Buffer& GetResults() const { return results_; }
    /// For variants with latentTexture; of generations 2 and 3.
    void MakeLatentTexture(const TextureSetMetadata& metadata);
    /// Null until it is made.
    const harness::Image* GetLatentTexture() const { return texture_ ? &*texture_ : nullptr; }
    /// The variant's buffers; its weights are a uniform buffer or a storage buffer.
    std::array<harness::BoundBuffer, 4> Bind(bool uniformWeights);

private:
    harness::Context& device_;
    std::span<const std::byte> latentBytes_;
    std::vector<std::byte> weightBytes_;
    harness::Buffer constants_, latents_, weights_, results_;
    std::optional<harness::Image> texture_;
    std::optional<harness::Buffer> uniformWeights_; ///< made when it is asked for: not every size can be one
};

/// The shader's pipeline, made anew. Errors: the driver's.
Expected<harness::ComputePipeline> MakeKernel(harness::Context& device, std::span<const std::uint32_t> spirv,
                                              bool uniformWeights, bool latentTexture = false);

/// Milliseconds of each of `repetitions` dispatches, between the timestamps round it.
std::vector<double> TimeKernel(harness::Context& device, const harness::ComputePipeline& kernel,
                               const std::array<harness::BoundBuffer, 4>& buffers, std::uint32_t width,
                               std::uint32_t groupsX, std::uint32_t groupsY, int repetitions,
                               const harness::Image* latentTexture = nullptr);

std::unique_ptr<Set> MakeSet(int network, int size);
bool UsesFP8(int math);
bool UsesVectors(int math);
/// What the device lacks for the variant, or null.
const char* FindObstacle(harness::Context& device, const Variant& v);

/// Weights as a variant's maths mode reads them, and constants with their offsets.
struct DeviceWeights {
    NtcTextureSetConstants constants;
    std::vector<std::byte> weights;
};
DeviceWeights MakeDeviceWeights(harness::Context& device, const Variant& v, const Set& set);

/// A steady clock.
double GetSeconds();
std::vector<std::uint32_t> ReadWords(const std::string& path);
/// The variants whose names contain Options::only.
std::vector<Variant> ReadIndex(const Options& options);

/// `values`: one or more.
double GetMedian(std::vector<double> values);

} // namespace openntc::bench
