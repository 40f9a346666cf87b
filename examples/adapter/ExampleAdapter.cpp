// SPDX-License-Identifier: MIT
// An example of the adapter interface: OpenNTC's reference decoder behind openntc_adapter.h. Replace the inside of
// create and decode_texels by your engine's upload and dispatch.
#include "adapter/openntc_adapter.h"

#include "openntc/core/Stream.h"
#include "openntc/decode/ReferenceDecoder.h"
#include "openntc/inference/InferenceData.h"
#include "openntc/texture_set/TextureSetMetadata.h"

#include <string>

using namespace openntc;

struct OpenntcAdapterSet {
    std::span<const std::byte> file;
    TextureSetMetadata metadata;
};

static std::string lastError;

static int Finish(const Expected<void>& result) {
    lastError = result ? "" : result.error().GetText();
    return result ? OPENNTC_ADAPTER_OK : OPENNTC_ADAPTER_FAILED;
}

static Expected<void> Decode(const OpenntcAdapterSet& set, DecodeOptions options,
                             const OpenntcAdapterTexel& texel, float* outputs) {
    const bool isFP8 = options.math == DecodeMath::FP8;
    const auto type = isFP8 ? InferenceWeightType::GenericFP8 : InferenceWeightType::GenericInt8;
    OPENNTC_ASSIGN(const StreamRange range,
                   set.metadata.GetStreamRangeForLatents(0, set.metadata.GetDesc().mips));
    OPENNTC_ASSIGN(const NtcTextureSetConstants constants, MakeInferenceData(set.metadata, range, type));
    OPENNTC_ASSIGN(const std::span<const std::byte> weights, set.metadata.GetInferenceWeights(type));
    const DecodeSource source{&constants, set.file.subspan(range.offset, range.size), weights,
                              set.metadata.GetNetworkVersion(), GetDecodeWeights(options.math)};
    return DecodeReference(source, texel.mip, {texel.x, texel.y, 1, 1}, options, {outputs, 16});
}

uint32_t openntc_adapter_version(void) {
    return OPENNTC_ADAPTER_VERSION;
}
const char* openntc_adapter_name(void) {
    return "OpenNTC reference decoder as an example adapter";
}
uint32_t openntc_adapter_capabilities(void) {
    return 1u << OPENNTC_ADAPTER_INT8 | 1u << OPENNTC_ADAPTER_INT8_HALF | OPENNTC_ADAPTER_CAN_LINEAR;
}
const char* openntc_adapter_error(void) {
    return lastError.c_str();
}

int openntc_adapter_create(const void* file, uint64_t bytes, OpenntcAdapterSet** set) {
    const std::span content(static_cast<const std::byte*>(file), bytes);
    ReadOnlyMemoryStream stream(content);
    Expected<TextureSetMetadata> metadata = TextureSetMetadata::Load(stream);
    if (!metadata)
        return Finish(PassError(metadata));
    *set = new OpenntcAdapterSet{content, std::move(*metadata)};
    return OPENNTC_ADAPTER_OK;
}

void openntc_adapter_destroy(OpenntcAdapterSet* set) {
    delete set;
}

int openntc_adapter_decode_texels(OpenntcAdapterSet* set, int math, int linear,
                                  const OpenntcAdapterTexel* texels, uint32_t count, float* outputs) {
    for (uint32_t i = 0; i < count; ++i) {
        const auto decoded =
            Decode(*set, {static_cast<DecodeMath>(math - 1), linear != 0}, texels[i], outputs + 16 * i);
        if (!decoded)
            return Finish(decoded);
    }
    return Finish({});
}
