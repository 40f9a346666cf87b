// SPDX-License-Identifier: MIT
// What the parts of bench_gpu share: its options, the shaders' index, and the synthesised sets.
#pragma once

#include "openntc/core/Expected.h"
#include "openntc/core/Stream.h"
#include "openntc/decode/DecodeTypes.h"
#include "openntc/texture_set/TextureSetMetadata.h"

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
    bool pipelines = false; ///< a table of pipeline creation in the place of the measurements
    bool forms = false;     ///< a table of the ways to fetch weights in their place
};

/// BENCH_STAGE of variants that are there for the tables of pipelines and of forms only.
inline constexpr int kPipelineStage = 4;

/// One line of index.txt: a variant of the shader for one network.
struct Variant {
    std::string name;
    int network = 0;
    int math = 0; ///< NTC_MATH_*
    bool uniformWeights = false;
    int texels = 1; ///< per invocation
    int stage = 0;  ///< BENCH_STAGE
    std::string file16;
    std::string file32; ///< "-": not compared
};

struct Set {
    MemoryStream file;
    std::optional<TextureSetMetadata> metadata;
    std::span<const std::byte> latents;
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

std::unique_ptr<Set> MakeSet(int network, int size);
bool UsesFP8(int math);
/// A steady clock.
double GetSeconds();
std::vector<std::uint32_t> ReadWords(const std::string& path);
/// The variants whose names contain Options::only.
std::vector<Variant> ReadIndex(const Options& options);

} // namespace openntc::bench
