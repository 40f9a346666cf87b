// SPDX-License-Identifier: MIT
#include "EditableSet.h"

#include "openntc/core/Stream.h"
#include "openntc/texture_set/WritableTextureSet.h"

#include <cstring>
#include <stdexcept>
#include <utility>

namespace openntc::conformance {

namespace {

template <typename T>
T Demand(Expected<T>&& expected) {
    if (!expected)
        throw std::runtime_error(expected.error().GetText());
    if constexpr (!std::is_void_v<T>)
        return std::move(*expected);
}

std::vector<std::byte> Copy(std::span<const std::byte> bytes, const LatentGrid& grid) {
    const auto begin = bytes.begin() + static_cast<std::ptrdiff_t>(grid.offset);
    return {begin, begin + static_cast<std::ptrdiff_t>(grid.size)};
}

std::vector<std::byte> Take(MemoryStream& stream) {
    return {stream.GetBytes().begin(), stream.GetBytes().end()};
}

} // namespace

std::span<std::byte> EditableSet::GetInt8Weights(std::size_t layer) {
    const NetworkDescription network = GetNetworkDescription(weights.networkVersion);
    return weights.int8.AsSpan().subspan(static_cast<std::size_t>(network.weightOffsets[layer]),
                                         static_cast<std::size_t>(network.inputs[layer]) *
                                             static_cast<std::size_t>(network.outputs[layer]));
}

void EditableSet::SetInt8Scale(std::size_t layer, std::size_t row, float scale) {
    const int start = GetNetworkDescription(weights.networkVersion).int8ScaleOffsets[layer];
    std::memcpy(weights.int8.data() + start + 4 * row, &scale, 4);
}

float EditableSet::GetInt8Scale(std::size_t layer, std::size_t row) {
    const int start = GetNetworkDescription(weights.networkVersion).int8ScaleOffsets[layer];
    float scale = 0;
    std::memcpy(&scale, weights.int8.data() + start + 4 * row, 4);
    return scale;
}

void EditableSet::SetInt8Bias(std::size_t layer, std::size_t row, std::int32_t bias) {
    const int start = GetNetworkDescription(weights.networkVersion).int8BiasOffsets[layer];
    std::memcpy(weights.int8.data() + start + 4 * row, &bias, 4);
}

std::vector<std::byte> SynthesizeBytes(const SynthesisDesc& synthesis) {
    MemoryStream stream;
    Demand(SynthesizeTextureSet(stream, synthesis));
    return Take(stream);
}

EditableSet SynthesizeEditableSet(const SynthesisDesc& synthesis) {
    const std::vector<std::byte> file = SynthesizeBytes(synthesis);
    ReadOnlyMemoryStream stream(file);
    const TextureSetMetadata metadata = Demand(TextureSetMetadata::Load(stream));
    EditableSet set;
    set.desc = metadata.GetDesc();
    set.shape = metadata.GetLatentShape();
    set.channelColorSpaces = synthesis.channelColorSpaces;
    set.weights = Demand(metadata.GetWeights().Clone(GetDefaultAllocator()));
    for (const LatentImage& image : metadata.GetLatentImages())
        set.latents.push_back({image, Copy(file, image.highRes), Copy(file, image.lowRes)});
    set.mips.assign(metadata.GetColorMips().begin(), metadata.GetColorMips().end());
    return set;
}

std::vector<std::byte> WriteSet(const EditableSet& set) {
    WritableTextureSet writable;
    Demand(writable.SetDescription(set.desc, set.shape, set.channelColorSpaces));
    Demand(writable.AddNetwork(set.weights, InferenceWeightType::GenericInt8));
    Demand(writable.AddNetwork(set.weights, InferenceWeightType::GenericFP8));
    Texture texture;
    texture.name = "t";
    texture.numChannels = set.desc.channels;
    Demand(writable.AddTexture(texture));
    for (const EditableSet::Latents& latents : set.latents)
        Demand(writable.AddLatentImage(latents.image, latents.highRes, latents.lowRes));
    for (const ColorMip& mip : set.mips)
        Demand(writable.AddColorMip(mip));
    MemoryStream stream;
    Demand(writable.Write(stream));
    return Take(stream);
}

} // namespace openntc::conformance
