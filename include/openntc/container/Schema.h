// SPDX-License-Identifier: MIT
// Stability: experimental
// The table of fields of each JSON object. The reader and the writer are both driven by these tables; keys
// are written in their order. Source: the format specification, schema versions 1 to 3.
#pragma once

#include "openntc/container/SchemaFields.h"
#include "openntc/format/NetworkDescription.h"

#include "openntc/core/HideMacros.h"

namespace openntc::container::detail {

inline constexpr Field kLatentShapeFields[] = {
    In(kIn2 | kIn3, Required<&LatentShapeRecord::numFeatures>("numFeatures")),
    In(kIn1, Required<&LatentShapeRecord::highResFeatures>("highResFeatures")),
    In(kIn1, Required<&LatentShapeRecord::highResQuantBits>("highResQuantBits")),
    In(kIn1, Required<&LatentShapeRecord::lowResFeatures>("lowResFeatures")),
    In(kIn1, Required<&LatentShapeRecord::lowResQuantBits>("lowResQuantBits")),
};
template <>
inline constexpr ObjectType kObjectType<LatentShapeRecord>{kLatentShapeFields, false};

inline constexpr Field kMlpLayerFields[] = {
    Required<&MlpLayer::inputChannels>("inputChannels"),
    Required<&MlpLayer::outputChannels>("outputChannels"),
    View<&MlpLayer::weightView>("weightView", true),
    View<&MlpLayer::scaleView>("scaleView", false),
    View<&MlpLayer::biasView>("biasView", true),
    In(kIn1, MakeField<&MlpLayer::weightType>("weightType")),
    In(kIn2 | kIn3, Required<&MlpLayer::weightType>("weightType")),
    In(kIn1, MakeField<&MlpLayer::scaleBiasType>("scaleBiasType")),
    MakeField<&MlpLayer::scaleType>("scaleType"),
    In(kIn1, MakeField<&MlpLayer::biasType>("biasType")),
    In(kIn2 | kIn3, Required<&MlpLayer::biasType>("biasType")),
};
template <>
inline constexpr ObjectType kObjectType<MlpLayer>{kMlpLayerFields, true};

inline constexpr Field kMlpFields[] = {
    MakeField<&Mlp::layers>("layers", kNetworkLayers),
    MakeField<&Mlp::activation>("activation"),
    MakeField<&Mlp::weightLayout>("weightLayout"),
    In(kIn1, MakeField<&Mlp::weightType>("weightType")),
    In(kIn1, MakeField<&Mlp::scaleBiasType>("scaleBiasType")),
};
template <>
inline constexpr ObjectType kObjectType<Mlp>{kMlpFields, true};

inline constexpr Field kBcModeBufferFields[] = {
    Required<&BcModeBufferRecord::mipLevel>("mipLevel"),
    View<&BcModeBufferRecord::view>("view", true),
};
template <>
inline constexpr ObjectType kObjectType<BcModeBufferRecord>{kBcModeBufferFields, true};

inline constexpr Field kTextureFields[] = {
    Required<&TextureRecord::name>("name"),
    Required<&TextureRecord::firstChannel>("firstChannel"),
    Required<&TextureRecord::numChannels>("numChannels"),
    MakeField<&TextureRecord::channelFormat>("channelFormat"),
    Defaulted<&TextureRecord::rgbColorSpace, ColorSpace::Linear>("rgbColorSpace"),
    Defaulted<&TextureRecord::alphaColorSpace, ColorSpace::Linear>("alphaColorSpace"),
    Defaulted<&TextureRecord::bcFormat, BlockCompressedFormat::None>("bcFormat"),
    In(kIn1 | kIn2, Defaulted<&TextureRecord::bcQuality, 255u>("bcQuality")),
    In(kIn1 | kIn2, View<&TextureRecord::bcAccelerationDataView>("bcAccelerationDataView", false)),
    In(kIn3, MakeField<&TextureRecord::bcModeBuffers>("bcModeBuffers", kMaxMips)),
};
template <>
inline constexpr ObjectType kObjectType<TextureRecord>{kTextureFields, true};

inline constexpr Field kChannelFields[] = {
    In(kIn1, MakeField<&ChannelRecord::scale>("scale")),
    In(kIn1, MakeField<&ChannelRecord::bias>("bias")),
    Defaulted<&ChannelRecord::colorSpace, ColorSpace::Linear>("colorSpace"),
};
template <>
inline constexpr ObjectType kObjectType<ChannelRecord>{kChannelFields, false};

inline constexpr Field kLatentImageFields[] = {
    In(kIn2 | kIn3, Required<&LatentImageRecord::width>("width")),
    In(kIn2 | kIn3, Required<&LatentImageRecord::height>("height")),
    In(kIn2, Required<&LatentImageRecord::arraySize>("arraySize")),
    In(kIn2, View<&LatentImageRecord::view>("view", true)),
    In(kIn3, View<&LatentImageRecord::layerViews>("layerViews", false)),
    In(kIn1, Required<&LatentImageRecord::highResWidth>("highResWidth")),
    In(kIn1, Required<&LatentImageRecord::highResHeight>("highResHeight")),
    In(kIn1, Required<&LatentImageRecord::lowResWidth>("lowResWidth")),
    In(kIn1, Required<&LatentImageRecord::lowResHeight>("lowResHeight")),
    In(kIn1, Required<&LatentImageRecord::highResBitsPerPixel>("highResBitsPerPixel")),
    In(kIn1, Required<&LatentImageRecord::lowResBitsPerPixel>("lowResBitsPerPixel")),
    In(kIn1, View<&LatentImageRecord::highResView>("highResView", true)),
    In(kIn1, View<&LatentImageRecord::lowResView>("lowResView", true)),
};
template <>
inline constexpr ObjectType kObjectType<LatentImageRecord>{kLatentImageFields, true};

inline constexpr Field kColorMipFields[] = {
    MakeField<&ColorMipRecord::width>("width"),
    MakeField<&ColorMipRecord::height>("height"),
    In(kIn1, MakeField<&ColorMipRecord::latentMip>("latentMip")),
    In(kIn2 | kIn3, Required<&ColorMipRecord::latentMip>("latentMip")),
    In(kIn1, MakeField<&ColorMipRecord::positionLod>("positionLod")),
    In(kIn2 | kIn3, Required<&ColorMipRecord::positionLod>("positionLod")),
    In(kIn1, MakeField<&ColorMipRecord::positionScale>("positionScale")),
    In(kIn2 | kIn3, Required<&ColorMipRecord::positionScale>("positionScale")),
};
template <>
inline constexpr ObjectType kObjectType<ColorMipRecord>{kColorMipFields, false};

inline constexpr Field kBufferViewFields[] = {
    Required<&BufferView::offset>("offset"),
    Required<&BufferView::storedSize>("storedSize"),
    In(kIn1 | kIn2, Named<&BufferView::compression>("compression", std::span(kCompressionNames).first<1>())),
    In(kIn3, MakeField<&BufferView::compression>("compression")),
    MakeField<&BufferView::uncompressedSize>("uncompressedSize"),
    In(kIn3, MakeField<&BufferView::crc32>("crc32")),
};
template <>
inline constexpr ObjectType kObjectType<BufferView>{kBufferViewFields, false};

inline constexpr Field kDocumentFields[] = {
    Required<&Document::schemaVersion>("schemaVersion"),
    Required<&Document::width>("width"),
    Required<&Document::height>("height"),
    Required<&Document::numChannels>("numChannels"),
    MakeField<&Document::numColorMips>("numColorMips"),
    MakeField<&Document::latentShape>("latentShape"),
    In(kIn1, MakeField<&Document::mlp>("mlp")),
    MakeField<&Document::mlpVersions>("mlpVersions", kMaxMlpVersions),
    MakeField<&Document::textures>("textures", kMaxTextures),
    MakeField<&Document::channels>("channels", kMaxChannels),
    MakeField<&Document::latents>("latents", kMaxNeuralMips),
    MakeField<&Document::colorMips>("colorMips", kMaxMips),
    MakeField<&Document::views>("views", kMaxViews),
};
template <>
inline constexpr ObjectType kObjectType<Document>{kDocumentFields, true};

/// Longest chain of objects in objects: document, network, layer.
inline constexpr std::size_t kMaxObjectNesting = 3;

} // namespace openntc::container::detail

#include "openntc/core/RestoreMacros.h"
