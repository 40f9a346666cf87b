// SPDX-License-Identifier: MIT
// Loads texture sets stage by stage and says what each stage takes.
#pragma once

#include "LatentWork.h"

#include "Decoder.h"
#include "textures/BlockCoding.h"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace openntc::load_time {

struct LoadOptions {
    std::vector<std::string> sets;
    tool::BackendOptions backend;
    tool::BlockChoice blocks; ///< of all textures; auto: as the files say
    tool::BlockEffort effort = tool::BlockEffort::Fast;
    bool noHints = false;  ///< search, even where a side file of hints lies beside a set
    bool setModes = false; ///< the modes that sets of generation 3 keep, in the place of side files
    Decompressor decompressor = Decompressor::Cpu;
    int repeat = 3;
    int warmUp = 1000; ///< milliseconds that a GPU works before times count
    int batch = 8;     ///< on a GPU: sets in one command buffer
};

/// Milliseconds; what a way does not do is 0.
struct StageTimes {
    double read = 0.0;       ///< from the files, which the system has in memory
    double parse = 0.0;      ///< metadata checked, constants and weights made, latents read
    double upload = 0.0;     ///< to a GPU: copies of latents, weights, constants and hints
    double decompress = 0.0; ///< latents of sets that keep them compressed, before or after the upload
    double decode = 0.0;     ///< latents to texels, all mips
    double transcode = 0.0;  ///< texels to blocks

    double GetTotal() const { return read + parse + upload + decompress + decode + transcode; }
};

/// One way to ship and load the same textures.
struct LoadWay {
    const char* name = "";
    std::uint64_t diskBytes = 0;
    std::uint64_t memoryBytes = 0; ///< that textures keep on the device
    StageTimes times;              ///< medians, stage by stage
};

struct LoadTimes {
    std::vector<std::string> sets;
    std::string device; ///< processor or GPU
    const char* decompressor =
        "none";               ///< or that of GetName(Decompressor), where sets keep latents compressed
    std::uint64_t texels = 0; ///< of all mips, once a set
    std::uint64_t textures = 0;
    std::array<LoadWay, 4> ways;   ///< raw texels, blocks, texture sets on load, texture sets on sample
    std::uint32_t blocksCrc32 = 0; ///< of all blocks: CPU and GPU make the same
    std::uint64_t hintBytes = 0;   ///< of side files of BC7 hints, which count as disk bytes of NTC on load
    std::vector<std::string> uncompressed; ///< textures that stay plain: no block format named for them
};

/// Throws tool::CommandError: BadInput for files, Failed for formats without an encoder, NoDevice.
LoadTimes MeasureLoading(const LoadOptions& options);

} // namespace openntc::load_time
