// SPDX-License-Identifier: MIT
#include "encode/DeviceTraining.h"

#include "openntc/encode/DeviceEncoder.h"

namespace openntc::tool {

Expected<encode::EncodeResult> Train(const encode::Material& material, const encode::EncodeOptions& options,
                                     encode::TrainingDevice& device,
                                     const encode::ProgressCallback& progress) {
    return encode::DeviceEncoder::Encode(material, options, device, progress);
}

Expected<encode::EncodeResult> Train(encode::Material&& material, const encode::EncodeOptions& options,
                                     encode::TrainingDevice& device,
                                     const encode::ProgressCallback& progress) {
    return encode::DeviceEncoder::Encode(std::move(material), options, device, progress);
}

} // namespace openntc::tool
