// SPDX-License-Identifier: MIT
// Timing of full decodes.
#pragma once

#include "Decoder.h"

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace openntc::tool {

struct BenchmarkTarget {
    std::string name;
    BackendOptions options;
    bool required = false; ///< named on the command line: its absence is an error
};

/// Million texels a second over several runs.
struct Rates {
    double median = 0;
    double minimum = 0;
    double maximum = 0;
    std::size_t runs = 0;
};

struct BenchmarkResult {
    std::string name;
    Backend backend = Backend::Cpu;
    int threads = 0;                  ///< 0: the device's
    std::string skipped;              ///< why nothing was measured, or empty
    Rates rates;                      ///< wall-clock, with read-back
    std::optional<Rates> deviceRates; ///< from the device's timestamps
    /// What dot products alone would allow, in Mtexel/s: on one thread of an instruction set that has them.
    std::optional<double> dotProducts;
    std::string device;
    std::uint32_t crc32 = 0; ///< of all outputs, mip by mip: equal for decoders that agree bit for bit
};

/// All decoders, or those of the named back ends: reference on one thread; fast per instruction set, on one
/// thread and on all; vulkan, on cooperative matrices if wanted, and then an error where a device has none.
std::vector<BenchmarkTarget> ListTargets(const std::vector<std::string>& backends, const std::string& device,
                                         bool onMatrices);

/// One untimed run, then `repeat` timed ones. Throws CommandError if decoding fails or the user interrupts.
BenchmarkResult RunBenchmark(const BenchmarkTarget& target, const TextureSetMetadata& metadata,
                             const DecodeData& data, const DecodeOptions& options, int repeat);

/// Microseconds of `repeat` loads of a file in memory, weights included, after one that is not counted; in increasing order.
/// Throws CommandError(BadInput) naming `path` if it cannot be loaded, and if the user interrupts.
std::vector<double> TimeLoads(std::span<const std::byte> file, int repeat, const std::string& path);

/// Texels of all mips.
std::uint64_t CountTexels(const TextureSetMetadata& metadata);

/// The processor's marketing name, or "unknown".
std::string GetCpuName();
int GetCoreCount();

} // namespace openntc::tool
