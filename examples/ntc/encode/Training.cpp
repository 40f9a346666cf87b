// SPDX-License-Identifier: MIT
#include "encode/Training.h"

#include "openntc/encode/Encoder.h"

namespace openntc::tool {

Expected<encode::EncodeResult> Train(const encode::Material& material, const encode::EncodeOptions& options,
                                     const encode::ProgressCallback& progress) {
    return encode::Encoder::Encode(material, options, progress);
}

Expected<encode::EncodeResult> Train(encode::Material&& material, const encode::EncodeOptions& options,
                                     const encode::ProgressCallback& progress) {
    return encode::Encoder::Encode(std::move(material), options, progress);
}

} // namespace openntc::tool
