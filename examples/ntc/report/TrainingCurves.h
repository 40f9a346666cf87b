// SPDX-License-Identifier: MIT
// What accuracy costs in time when a material is encoded: PSNR against seconds, for each kernel of the processor and each device.
#pragma once

#include "report/Encodings.h"
#include "report/Report.h"

#include "openntc/encode/EncodeOptions.h"

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace openntc::report {

/// A curve: of a kernel of the processor, or, without one, of a Vulkan device.
struct TrainingCase {
    std::optional<encode::KernelChoice> kernel;

    std::string GetId() const;
};

/// Those of this machine; `quick`: its fastest kernel, and devices.
std::vector<TrainingCase> ListTrainingCases(bool quick);

struct TrainingSettings {
    std::string manifest; ///< the material; empty: the report's
    /// A curve ends with the first encoding that takes longer, of the processor's time for its kernels; 0: by the report.
    double seconds = 0.0;
    int batchTexels = 0; ///< of devices; 0: the encoder's
};

class TrainingCurves {
public:
    /// `material`: the report's, for settings that name none.
    TrainingCurves(const TrainingSettings& settings, bool quick,
                   const std::function<std::shared_ptr<const Source>()>& material);

    /// Encodes with twice the steps each time. `isSlow`: a device that begins with few. A device that cannot train is
    /// skipped with its reason. Throws CommandError(Failed) when interrupted.
    TrainingRecord Measure(const TrainingCase& c, const DeviceRecord& device, bool isSlow) const;

private:
    TrainingSettings settings_;
    std::string name_;
    std::shared_ptr<const Source> source_;
};

/// A line about a curve: its last point, or why there is none.
std::string DescribeTraining(const TrainingRecord& record);

} // namespace openntc::report
