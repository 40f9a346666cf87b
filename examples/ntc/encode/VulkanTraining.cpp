// SPDX-License-Identifier: MIT
#include "encode/DeviceTraining.h"

#include "vulkan_harness/TrainingQueue.h"

#include <utility>

namespace openntc::tool {

namespace {

template <typename AnyMaterial>
Expected<encode::EncodeResult> TrainWithContext(const std::string& device, AnyMaterial&& material,
                                                const encode::EncodeOptions& options,
                                                const encode::ProgressCallback& progress) {
    harness::ContextOptions contextOptions;
    contextOptions.device = device;
    OPENNTC_ASSIGN(const std::unique_ptr<harness::Context> context, harness::Context::Create(contextOptions));
    OPENNTC_ASSIGN(const std::unique_ptr<encode::TrainingDevice> queue, harness::MakeTrainingQueue(*context));
    return Train(std::forward<AnyMaterial>(material), options, *queue, progress);
}

} // namespace

Expected<encode::EncodeResult> TrainOnVulkan(const std::string& device, const encode::Material& material,
                                             const encode::EncodeOptions& options,
                                             const encode::ProgressCallback& progress) {
    return TrainWithContext(device, material, options, progress);
}

Expected<encode::EncodeResult> TrainOnVulkan(const std::string& device, encode::Material&& material,
                                             const encode::EncodeOptions& options,
                                             const encode::ProgressCallback& progress) {
    return TrainWithContext(device, std::move(material), options, progress);
}

} // namespace openntc::tool
