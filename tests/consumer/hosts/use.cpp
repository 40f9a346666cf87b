// SPDX-License-Identifier: MIT
// A program whose own headers define macros with our names. HOST_HEADER: that header; HOST_FIRST: included before ours
// (standard headers come first, because libstdc++ drops min and max), else behind. check.cmake writes all_headers.h.
#if HOST_FIRST
#include <bits/stdc++.h>
#if defined(__x86_64__)
#include <immintrin.h>
#endif
#include HOST_HEADER
#include "all_headers.h"
#else
#include "all_headers.h"
#include HOST_HEADER
#endif

// The host has its macros as before.
#if defined(HOST_DEFINES_X11) && !(defined(Status) && defined(None) && defined(Bool) && defined(True) &&     \
                                   defined(False) && defined(Success) && defined(Always))
#error a macro of X11 is lost
#endif
#if defined(HOST_DEFINES_FUNCTIONS)
#if !(defined(min) && defined(max) && defined(abs) && defined(round))
#error a function macro is lost
#endif
static_assert(min(2, 1) == 1 && max(2, 1) == 2 && abs(-3) == 3 && round(2.6) == 3);
#endif

// Every public name that such a macro can hide has another spelling, and templates are instantiated below the macros.
static_assert(openntc::StatusCode::OutOfRange != openntc::StatusCode::Ok);
static_assert(openntc::BlockCompressedFormat::Uncompressed != openntc::BlockCompressedFormat::BC7);
static_assert(openntc::SimdCap::Baseline != openntc::SimdCap::Amx);
static_assert(openntc::container::EnumToString(openntc::container::Compression::Uncompressed) == "None");

openntc::Expected<void> Refuse(int number) {
    if (number > 3)
        return openntc::Fail(openntc::StatusCode::OutOfRange, "number: %d: at most 3", number);
    return {};
}

openntc::StatusCode Load(openntc::Stream& stream, openntc::Stream& copy) {
    const openntc::Expected<void> refused = Refuse(4);
    if (!refused && refused.error().GetStatus() != openntc::StatusCode::OutOfRange)
        return openntc::StatusCode::InternalError;
    openntc::Expected<openntc::TextureSetMetadata> set = openntc::TextureSetMetadata::Load(stream);
    if (!set)
        return set.error().GetStatus();
    openntc::Expected<openntc::WritableTextureSet> writable = openntc::MakeWritableCopy(*set, stream);
    if (!writable || !writable->Write(copy))
        return openntc::StatusCode::IOError;
    for (const openntc::Texture& texture : set->GetTextures()) {
        if (texture.bcFormat != openntc::BlockCompressedFormat::Uncompressed)
            return openntc::StatusCode::Unsupported;
    }
    const openntc::Expected<openntc::NtcTextureSetConstants> constants =
        openntc::MakeInferenceData(*set, openntc::kEntireStream, openntc::InferenceWeightType::GenericInt8);
    return constants ? openntc::StatusCode::Ok : constants.error().GetStatus();
}

openntc::StatusCode Decode(const openntc::DecodeSource& source, std::span<float> outputs) {
    if (!openntc::DecodeReference(source, 0, {0, 0, 1, 1}, {}, outputs))
        return openntc::StatusCode::InvalidArgument;
    const openntc::Expected<openntc::FastDecoder> decoder = openntc::FastDecoder::Create(source);
    if (!decoder || !decoder->Decode(0, {0, 0, 1, 1}, {}, outputs))
        return openntc::StatusCode::Unsupported;
    return openntc::StatusCode::Ok;
}

openntc::StatusCode Encode(openntc::encode::Material material) {
    openntc::encode::MaterialTexture texture;
    texture.bcFormat = openntc::BlockCompressedFormat::Uncompressed;
    const std::vector<float> texels(16, 0.5f);
    if (!material.AddTexture(texture, texels))
        return openntc::StatusCode::OutOfRange;
    const openntc::Expected<openntc::encode::EncodeResult> result =
        openntc::encode::Encoder::Encode(material, openntc::encode::EncodeOptions());
    return result ? openntc::StatusCode::Ok : result.error().GetStatus();
}

int main() {
    return openntc::StatusToString(openntc::StatusCode::Ok)[0] == 'O' ? 0 : 1;
}
