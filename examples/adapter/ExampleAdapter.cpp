// SPDX-License-Identifier: MIT
// An example of the adapter interface: OpenNTC's reference decoder behind openntc_adapter.h. Replace the insides of
// Open and Decode by your engine's upload and dispatch.
#include "adapter/openntc_adapter.h"

#include "openntc/bc/BlockEncoder.h"
#include "openntc/core/Stream.h"
#include "openntc/decode/ReferenceDecoder.h"
#include "openntc/decode/ShaderMath.h"
#include "openntc/inference/PartialInference.h"
#include "openntc/inference/ReadLatents.h"
#include "openntc/passes/DecompressionPass.h"
#include "openntc/texture_set/TextureSetMetadata.h"

#include "openntc/StochasticFiltering.h"
#include "openntc/passes/DecompressTexel.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

using namespace openntc;

struct OpenntcAdapterSet {
    std::span<const std::byte> file;
    TextureSetMetadata metadata;
};

static Expected<OpenntcAdapterSet*> Open(std::span<const std::byte> file) {
    ReadOnlyMemoryStream stream(file);
    OPENNTC_ASSIGN(TextureSetMetadata metadata, TextureSetMetadata::Load(stream));
    return new OpenntcAdapterSet{file, std::move(metadata)};
}

static Expected<void> Decode(const OpenntcAdapterSet& set, DecodeOptions options,
                             std::span<const OpenntcAdapterTexel> texels, float* outputs) {
    const InferenceWeightType type = InferenceWeightType::GenericInt8; // what both modes below read
    const int mips = set.metadata.GetDesc().mips;
    OPENNTC_ASSIGN(const NtcTextureSetConstants constants, MakeInferenceData(set.metadata, 0, mips, type));
    OPENNTC_ASSIGN(const std::size_t bytes, GetLatentBufferBytes(set.metadata, 0, mips));
    std::vector<std::byte> latents(bytes);
    ReadOnlyMemoryStream stream(set.file);
    OPENNTC_CHECK(ReadLatents(set.metadata, stream, 0, mips, latents));
    OPENNTC_ASSIGN(const std::span<const std::byte> weights, set.metadata.GetInferenceWeights(type));
    const DecodeSource source{&constants, latents, weights, set.metadata.GetNetworkVersion()};
    for (const OpenntcAdapterTexel& texel : texels) {
        OPENNTC_CHECK(DecodeReference(source, texel.mip, {texel.x, texel.y, 1, 1}, options, {outputs, 16}));
        outputs += 16;
    }
    return {};
}

// The texels of mip firstMip + k that a slice holds; none where the mip ends before.
static Rect GetHeldTexels(const OpenntcAdapterSet& set, const SliceDesc& slice, int k) {
    const ColorMip& mip = set.metadata.GetColorMips()[static_cast<std::size_t>(slice.firstMip + k)];
    const auto halve = [k](int end) { return (end + (1 << k) - 1) >> k; };
    const int left = std::min(slice.rect.left >> k, mip.width);
    const int top = std::min(slice.rect.top >> k, mip.height);
    return {left, top, std::min(halve(slice.rect.left + slice.rect.width), mip.width) - left,
            std::min(halve(slice.rect.top + slice.rect.height), mip.height) - top};
}

// What an engine that streams tiles does: the latents of the rectangle, and nothing else.
static Expected<void> DecodeSlice(const OpenntcAdapterSet& set, const SliceDesc& slice, DecodeOptions options,
                                  float* outputs) {
    const InferenceWeightType type = InferenceWeightType::GenericInt8;
    OPENNTC_ASSIGN(const std::uint64_t bytes, GetPartialLatentBufferSize(set.metadata, slice));
    std::vector<std::byte> latents(bytes);
    ReadOnlyMemoryStream stream(set.file);
    OPENNTC_ASSIGN(const PartialInferenceData data,
                   MakePartialInferenceData(set.metadata, stream, slice, type, latents));
    OPENNTC_ASSIGN(const std::span<const std::byte> weights, set.metadata.GetInferenceWeights(type));
    const DecodeSource source{&data.constants, latents, weights, set.metadata.GetNetworkVersion()};
    for (int k = 0; k < slice.numMips; ++k) {
        const Rect part = GetHeldTexels(set, slice, k);
        const std::size_t texels =
            static_cast<std::size_t>(part.width) * static_cast<std::size_t>(part.height);
        if (texels != 0)
            OPENNTC_CHECK(DecodeReference(source, slice.firstMip + k, part, options, {outputs, 16 * texels}));
        outputs += 16 * texels;
    }
    return {};
}

// What an engine does with passes/CompressBlocks.
static Expected<void> EncodePicture(bc::BlockFormat format, bc::BlockQuality level, int alphaThreshold,
                                    const std::byte* texels, std::uint32_t width, std::uint32_t height,
                                    std::byte* blocks) {
    const bool isHalf = format == bc::BlockFormat::Bc6Unsigned || format == bc::BlockFormat::Bc6Signed;
    const bool isSigned = format == bc::BlockFormat::Bc4Signed || format == bc::BlockFormat::Bc5Signed;
    bc::BlockImage image;
    image.width = width;
    image.height = height;
    image.bytes = {texels, std::size_t{isHalf ? 8u : 4u} * width * height};
    image.type = isHalf ? bc::TexelType::Half : isSigned ? bc::TexelType::Signed8 : bc::TexelType::Unsigned8;
    bc::BlockOptions options;
    options.quality = level;
    options.alphaThreshold = alphaThreshold;
    const bc::BlockRect all{0, 0, bc::CountBlocks(width), bc::CountBlocks(height)};
    return bc::EncodeBlocks(format, image, all, options,
                            {blocks, bc::GetBytesPerBlock(format) * all.width * all.height});
}

// What an engine does with passes/DecompressToTextures.
static Expected<void> DecodeTextures(const OpenntcAdapterSet& set, DecodeMath math,
                                     const OpenntcAdapterRect& rect,
                                     std::span<const OpenntcAdapterOutput> outputs, void* const* texels) {
    std::vector<DecompressionOutput> written;
    for (const OpenntcAdapterOutput& output : outputs)
        written.push_back({static_cast<int>(written.size()), output.firstChannel, output.channels,
                           static_cast<ColorSpace>(output.rgbColorSpace),
                           static_cast<ColorSpace>(output.alphaColorSpace), 0.0f, output.bits});
    DecompressionRequest request;
    request.mip = rect.mip;
    request.rect = Rect{rect.left, rect.top, rect.width, rect.height};
    request.destination = TexelOffset{rect.destinationLeft, rect.destinationTop};
    request.outputs = written;
    OPENNTC_ASSIGN(
        const DecompressionPass pass,
        MakeDecompressionPass(set.metadata, 0, set.metadata.GetDesc().mips, request, SceneNeeds{}));
    const NtcDecompressConstants& constants = pass.constants;
    for (int i = 0; i < rect.width * rect.height; ++i) { // an invocation each
        const OpenntcAdapterTexel texel{rect.mip, rect.left + i % rect.width, rect.top + i / rect.width};
        float channels[16];
        OPENNTC_CHECK(Decode(set, {math, false}, {&texel, 1}, channels));
        const int place = (constants.destinationTop + i / rect.width) * rect.textureWidth +
                          constants.destinationLeft + i % rect.width;
        for (std::size_t n = 0; n < outputs.size(); ++n) {
            const shader::float4 value =
                shader::NtcMakeOutputTexel(constants.outputs[n], constants.desc.channelColorSpaces, channels,
                                           {texel.x, texel.y}, constants.desc.imageWidth);
            for (int k = 0; k < 4; ++k) { // what an image store does
                const int at = 4 * place + k, bits = outputs[n].bits;
                if (bits == 0)
                    static_cast<float*>(texels[n])[at] = value[k];
                else if (bits == 8)
                    static_cast<std::uint8_t*>(texels[n])[at] =
                        static_cast<std::uint8_t>(std::lround(255.0f * value[k]));
                else
                    static_cast<std::uint16_t*>(texels[n])[at] =
                        static_cast<std::uint16_t>(std::lround(65535.0f * value[k]));
            }
        }
    }
    return {};
}

// What a shader does round a texture of its own: docs/filtering.md.
static std::vector<shader::NtcStfTap> ListTaps(const OpenntcAdapterSampler& sampler, int way,
                                               const OpenntcAdapterLookup& lookup) {
    shader::NtcStfSampler settings = shader::NtcStfMakeSampler(static_cast<std::uint32_t>(sampler.kernel),
                                                               static_cast<std::uint32_t>(sampler.wrapX));
    settings.mips = static_cast<std::uint32_t>(sampler.mips);
    settings.wrapY = static_cast<std::uint32_t>(sampler.wrapY);
    settings.sigma = sampler.sigma;
    settings.radius = sampler.radius;
    settings.maxAnisotropy = static_cast<std::uint32_t>(sampler.maxAnisotropy);
    settings.lodBias = sampler.lodBias;
    const shader::NtcStfExtent extent =
        shader::NtcStfMakeExtent(sampler.width, sampler.height, sampler.levels);
    const shader::float2 uv(lookup.uv[0], lookup.uv[1]);
    const shader::NtcStfFootprint footprint = shader::NtcStfGetFootprint(
        settings, extent, {lookup.ddx[0], lookup.ddx[1]}, {lookup.ddy[0], lookup.ddy[1]});
    const shader::uint4 random(lookup.random[0], lookup.random[1], lookup.random[2], lookup.random[3]);
    if (way == OPENNTC_ADAPTER_FILTER_ONE)
        return {shader::NtcStfSample(settings, extent, uv, footprint, random)};
    if (way == OPENNTC_ADAPTER_FILTER_PAIR) {
        const shader::NtcStfPair pair = shader::NtcStfSamplePair(settings, extent, uv, footprint, random);
        return {pair.first, pair.second.scale != 0.0f ? pair.second : shader::NtcStfTap{}};
    }
    std::vector<shader::NtcStfTap> taps;
    for (std::uint32_t i = 0; i < shader::NtcStfGetTapCount(settings, extent, footprint); ++i)
        taps.push_back(shader::NtcStfGetTap(settings, extent, uv, footprint, i));
    return taps;
}

static std::string lastError;

template <typename T>
static int Finish(const Expected<T>& result) {
    lastError = result ? "" : result.error().GetText();
    return result ? OPENNTC_ADAPTER_OK : OPENNTC_ADAPTER_FAILED;
}

uint32_t openntc_adapter_version(void) {
    return OPENNTC_ADAPTER_VERSION;
}
const char* openntc_adapter_name(void) {
    return "OpenNTC reference decoder as an example adapter";
}
uint32_t openntc_adapter_capabilities(void) {
    return 1u << OPENNTC_ADAPTER_INT8 | 1u << OPENNTC_ADAPTER_INT8_HALF | OPENNTC_ADAPTER_CAN_LINEAR |
           OPENNTC_ADAPTER_CAN_DECODE_SLICE | OPENNTC_ADAPTER_CAN_DECODE_SLICE_MIPS |
           OPENNTC_ADAPTER_CAN_ENCODE_BLOCKS | OPENNTC_ADAPTER_CAN_DECODE_TEXTURES |
           OPENNTC_ADAPTER_CAN_FILTER;
}
const char* openntc_adapter_error(void) {
    return lastError.c_str();
}
int openntc_adapter_create(const void* file, uint64_t bytes, OpenntcAdapterSet** set) {
    const Expected<OpenntcAdapterSet*> opened = Open({static_cast<const std::byte*>(file), bytes});
    *set = opened.value_or(nullptr);
    return Finish(opened);
}
void openntc_adapter_destroy(OpenntcAdapterSet* set) {
    delete set;
}
int openntc_adapter_decode_texels(OpenntcAdapterSet* set, int math, int linear,
                                  const OpenntcAdapterTexel* texels, uint32_t count, float* outputs) {
    // The adapter's numbers of maths modes are those of the shaders.
    return Finish(Decode(*set, {GetDecodeMath(math), linear != 0}, {texels, count}, outputs));
}
int openntc_adapter_decode_slice(OpenntcAdapterSet* set, int math, int linear, int mip, int32_t left,
                                 int32_t top, int32_t width, int32_t height, float* outputs) {
    return Finish(
        DecodeSlice(*set, {mip, 1, {left, top, width, height}}, {GetDecodeMath(math), linear != 0}, outputs));
}
int openntc_adapter_decode_slice_mips(OpenntcAdapterSet* set, int math, int linear, int firstMip, int mips,
                                      int32_t left, int32_t top, int32_t width, int32_t height, uint32_t,
                                      float* outputs) {
    return Finish(DecodeSlice(*set, {firstMip, mips, {left, top, width, height}},
                              {GetDecodeMath(math), linear != 0}, outputs));
}
int openntc_adapter_encode_blocks(int format, int level, int alphaThreshold, const void* texels,
                                  uint32_t width, uint32_t height, void* blocks) {
    // The adapter's numbers of formats and levels are those of bc/BlockFormat.h and bc/Quality.h.
    return Finish(EncodePicture(static_cast<bc::BlockFormat>(format), static_cast<bc::BlockQuality>(level),
                                alphaThreshold, static_cast<const std::byte*>(texels), width, height,
                                static_cast<std::byte*>(blocks)));
}
int openntc_adapter_decode_textures(OpenntcAdapterSet* set, int math, const OpenntcAdapterRect* rect,
                                    const OpenntcAdapterOutput* outputs, uint32_t count,
                                    void* const* texels) {
    return Finish(DecodeTextures(*set, GetDecodeMath(math), *rect, {outputs, count}, texels));
}
int openntc_adapter_filter(const OpenntcAdapterSampler* sampler, int way, const OpenntcAdapterLookup* lookup,
                           OpenntcAdapterTap* taps, uint32_t* count) {
    *count = 0;
    for (const shader::NtcStfTap& tap : ListTaps(*sampler, way, *lookup))
        taps[(*count)++] = {tap.texel.x, tap.texel.y, tap.mip, tap.scale, tap.isBorder ? 1 : 0};
    return Finish(Expected<void>());
}
