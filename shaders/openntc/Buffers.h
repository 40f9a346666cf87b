// SPDX-License-Identifier: MIT
// Where latents and weights are read from.
//
//   NtcBuffer                           a read-only byte-addressed buffer
//   NtcBufferLoad(buffer, byteOffset)   one 32-bit word of it
//
// GLSL: NtcBuffer is a number, NTC_LATENTS or NTC_WEIGHTS, and the two storage buffers are declared here, at
// NTC_DESCRIPTOR_SET, NTC_LATENTS_BINDING and NTC_WEIGHTS_BINDING (0, 1, 2 unless defined). HLSL: NtcBuffer
// is ByteAddressBuffer, and nothing is declared. C++: pointer and size; words outside read 0. An engine
// replaces this by defining both macros before the first include: `#define NtcBuffer uint` and
// `#define NtcBufferLoad(buffer, byteOffset) MyLoad(...)`. Latents may be a texture instead: LatentFetch.h.
#ifndef OPENNTC_BUFFERS_H
#define OPENNTC_BUFFERS_H

#include "Portability.h"
#include "Switches.h"

#if defined(__cplusplus)
namespace openntc::shader {

#if !defined(NtcBufferLoad)
/// Read-only memory. Words that are not wholly inside read as 0, like robust buffer access on a GPU.
struct NtcBuffer {
    const void* data = nullptr;
    std::size_t size = 0; // bytes
};
inline uint NtcBufferLoad(const NtcBuffer& buffer, uint byteOffset) {
    uint word = 0;
    if (std::size_t(byteOffset) + 4 <= buffer.size)
        std::memcpy(&word, static_cast<const unsigned char*>(buffer.data) + byteOffset, 4);
    if constexpr (std::endian::native == std::endian::big)
        word = (word >> 24) | ((word >> 8) & 0xFF00u) | ((word << 8) & 0xFF0000u) | (word << 24);
    return word;
}
#endif

} // namespace openntc::shader
#elif defined(NTC_HLSL)
#if !defined(NtcBufferLoad)
#define NtcBuffer ByteAddressBuffer
#define NtcBufferLoad(buffer, byteOffset) (buffer).Load(byteOffset)
#define NtcLoadFourWeightWords(buffer, byteOffset) (buffer).Load4(byteOffset)
#endif
#else
#if defined(NtcBufferLoad)
#define NTC_OWN_BUFFER_LOAD
#else
#ifndef NTC_DESCRIPTOR_SET
#define NTC_DESCRIPTOR_SET 0
#endif
#ifndef NTC_LATENTS_BINDING
#define NTC_LATENTS_BINDING 1
#endif
#ifndef NTC_WEIGHTS_BINDING
#define NTC_WEIGHTS_BINDING 2
#endif
#if NTC_LATENT_FETCH == NTC_LATENTS_TEXTURE
layout(set = NTC_DESCRIPTOR_SET, binding = NTC_LATENTS_BINDING) uniform sampler2DArray ntcLatentTexture;
#define NtcSampleLatents(latents, latentsOffset, uv, layer, level)                                           \
    textureLod(ntcLatentTexture, vec3(uv, float(layer)), float(level))
#define NtcLoadLatentWord(byteOffset) 0u
#else
layout(set = NTC_DESCRIPTOR_SET, binding = NTC_LATENTS_BINDING, std430) readonly buffer NtcLatentsBlock {
    uint words[];
}
ntcLatents;
#define NtcLoadLatentWord(byteOffset) ntcLatents.words[(byteOffset) >> 2]
#endif
#define NtcBuffer uint
#define NTC_LATENTS 0u
#define NTC_WEIGHTS 1u
#if NTC_WEIGHT_FETCH == NTC_FETCH_UNIFORM
layout(set = NTC_DESCRIPTOR_SET, binding = NTC_WEIGHTS_BINDING, std140) uniform NtcWeightsBlock {
#if NETWORK_VERSION == NTC_NETWORK_GENERATION_3
    uvec4 words[592]; // 9472 bytes
#elif NETWORK_VERSION == NTC_NETWORK_GENERATION_2
    uvec4 words[872]; // 13952 bytes
#else
    uvec4 words[808 + 64 * NETWORK_VERSION]; // 13952 ... 17024 bytes
#endif
}
ntcWeights;
uint NtcBufferLoad(NtcBuffer buffer_, uint byteOffset) {
    return buffer_ == NTC_LATENTS ? NtcLoadLatentWord(byteOffset)
                                  : ntcWeights.words[byteOffset >> 4][(byteOffset >> 2) & 3u];
}
uvec4 NtcLoadFourWeightWords(NtcBuffer buffer_, uint byteOffset) {
    return ntcWeights.words[byteOffset >> 4];
}
#else
layout(set = NTC_DESCRIPTOR_SET, binding = NTC_WEIGHTS_BINDING, std430) readonly buffer NtcWeightsBlock {
    uint words[];
}
ntcWeights;
uint NtcBufferLoad(NtcBuffer buffer_, uint byteOffset) { // folds: the buffer is a literal at every call
    return buffer_ == NTC_LATENTS ? NtcLoadLatentWord(byteOffset) : ntcWeights.words[byteOffset >> 2];
}
#if NTC_WIDE_WEIGHT_LOADS
layout(set = NTC_DESCRIPTOR_SET, binding = NTC_WEIGHTS_BINDING, std430) readonly buffer NtcWideWeightsBlock {
    uvec4 words[];
}
ntcWideWeights;
uvec4 NtcLoadFourWeightWords(NtcBuffer buffer_, uint byteOffset) {
    return ntcWideWeights.words[byteOffset >> 4];
}
#endif
#endif
#endif
#undef NtcLoadLatentWord
// Word by word where the buffer is not declared above, or weightsOffset need not be a multiple of 16.
#if (NTC_WIDE_WEIGHT_LOADS && defined(NTC_OWN_BUFFER_LOAD)) ||                                               \
    (!NTC_WIDE_WEIGHT_LOADS && NTC_WEIGHT_FETCH == NTC_FETCH_SUBGROUP)
uvec4 NtcLoadFourWeightWords(NtcBuffer buffer_, uint byteOffset) {
    return uvec4(NtcBufferLoad(buffer_, byteOffset), NtcBufferLoad(buffer_, byteOffset + 4u),
                 NtcBufferLoad(buffer_, byteOffset + 8u), NtcBufferLoad(buffer_, byteOffset + 12u));
}
#endif
#endif

#if NTC_LATENT_FETCH == NTC_LATENTS_TEXTURE && !defined(NtcSampleLatents)
#error NTC_LATENT_FETCH: NTC_LATENTS_TEXTURE with own bindings, and in HLSL, needs NtcSampleLatents: see LatentFetch.h
#endif

#endif
