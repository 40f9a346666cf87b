// SPDX-License-Identifier: MIT
// What cases run on.
#pragma once

#include "report/Cases.h"
#include "report/Encodings.h"
#include "report/Report.h"

#include <memory>
#include <string>
#include <vector>

namespace openntc::report {

struct Timing {
    Spread spread;
    std::uint64_t texelsPerDispatch = 0;
};

class MeasuredDevice {
public:
    virtual ~MeasuredDevice() = default;
    virtual const DeviceRecord& GetRecord() const = 0;
    /// Makes everything ready. Returns why this device cannot run the case, or nothing. Throws CommandError.
    virtual std::string Prepare(const Case& c, const Encoding& encoding) = 0;
    /// The first rows of mip 0, a multiple of 8, as the prepared case decodes them: 16 values a texel.
    virtual std::vector<float> Decode(int rows) = 0;
    /// True if the whole of mip 0 takes seconds.
    virtual bool IsSlow() const = 0;
    /// Times the prepared case, after it has run before.
    virtual Timing Measure() = 0;
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

/// Median, quartiles (linear between ranks) and range.
Spread Summarise(std::vector<double> values);

/// The processor's marketing name and what its decoder uses.
DeviceRecord DescribeCpu();

} // namespace openntc::report
