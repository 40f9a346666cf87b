// SPDX-License-Identifier: MIT
// What cases run on.
#pragma once

#include "report/Blocks.h"
#include "report/Cases.h"
#include "report/Encodings.h"
#include "report/Report.h"

#include <memory>
#include <string>
#include <vector>

namespace openntc::report {

/// A case that is ready to run. Refers to its device and encoding, which must outlive it.
class PreparedCase {
public:
    virtual ~PreparedCase() = default;
    /// The first rows of mip 0, a multiple of 8: 16 values a texel.
    virtual std::vector<float> Decode(int rows) = 0;
    /// Nanoseconds per texel of `repeats` dispatches, after what is needed to warm up.
    virtual std::vector<double> Time(int repeats) = 0;
    /// Known after Time.
    virtual std::uint64_t GetTexelsPerDispatch() const = 0;
};

/// Repeats are spread over rounds through all cases, so that a change of load or clocks meets all of them.
struct Repeats {
    int rounds = 0, perRound = 0;
};

class MeasuredDevice {
public:
    virtual ~MeasuredDevice() = default;
    virtual const DeviceRecord& GetRecord() const = 0;
    /// True if the whole of mip 0 takes seconds.
    virtual bool IsSlow() const = 0;
    virtual Repeats GetRepeats() const = 0;
    /// Makes everything ready. Null if this device cannot run the case, and why in `skipped`. Throws CommandError.
    virtual std::unique_ptr<PreparedCase> Prepare(const Case& c, const Encoding& encoding,
                                                  std::string& skipped) = 0;
    /// The ways to compress a texture to blocks here. Empty if there is none, and why in `skipped`. Throws CommandError.
    virtual std::vector<std::unique_ptr<PreparedBlocks>>
    PrepareBlocks(const BlockCase& c, const BlockTexture& texture, std::string& skipped) = 0;
};

/// Wall clock of the C++ decoders, all cores.
std::unique_ptr<MeasuredDevice> MakeCpuDevice(bool quick);

struct VulkanSettings {
    std::string device;  ///< part of its name; empty: a GPU if there is one
    std::string sources; ///< folder of OpenNTC's source: shaders/ and examples/ntc/report/ReportDecode.comp
    std::string glslang; ///< program for cooperative vectors, or for everything where none is built in
    bool quick = false;
};

/// Times between timestamps. Throws CommandError(NoDevice).
std::unique_ptr<MeasuredDevice> MakeVulkanDevice(const VulkanSettings& settings);

/// The processor's marketing name and what its decoder uses.
DeviceRecord DescribeCpu();

} // namespace openntc::report
