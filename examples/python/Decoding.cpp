// SPDX-License-Identifier: MIT
#include "Python.h"

#include "openntc/decode/FastDecoder.h"
#include "openntc/decode/ReferenceDecoder.h"

namespace openntc::python {

Expected<void> DecodeTexels(const DecodeSource& source, int mip, Rect rect, const DecodeOptions& options,
                            int threads, std::span<float> outputs) {
    if (options.math != DecodeMath::Int8 && options.math != DecodeMath::Int8Half)
        return DecodeReference(source, mip, rect, options, outputs);
    FastDecoderOptions decoderOptions;
    decoderOptions.threads = threads;
    OPENNTC_ASSIGN(const FastDecoder decoder, FastDecoder::Create(source, decoderOptions));
    return decoder.Decode(mip, rect, options, outputs);
}

} // namespace openntc::python
