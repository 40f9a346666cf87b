// SPDX-License-Identifier: MIT
// Stability: experimental
// Decompression on load: what the compute pass openntc/passes/DecompressToTextures needs to decode a
// rectangle of one mip into textures.
//
//   DecompressionRequest request;             // the whole mip 0 into one image per texture of the set
//   SceneNeeds needs;
//   needs.device.integerDotProduct = true;    // what the device has
//   auto pass = MakeDecompressionPass(metadata, 0, mips, request, needs); // for ReadLatents of these mips
//   auto spirv = blob->FindCovering("DecompressToTextures.comp", pass->permutation.key);
//   ... upload pass->constants and the weights of pass->permutation.weightType, bind, dispatch pass->groups
//
// Cooperative matrices: with MathPreference::Fastest, or NTC_MATH_COOPMAT_INT8 by name, and what the device
// has in needs.device. weightType is then CoopMatInt8, the weights are those of MakeCoopMatWeights, with the
// layout if pass->permutation.key.matrixLanes, and constants those of GenericInt8.
//
// The library calls no graphics API.
#pragma once

#include "openntc/core/Allocator.h"
#include "openntc/core/Expected.h"
#include "openntc/core/Rect.h"
#include "openntc/inference/InferenceData.h"
#include "openntc/inference/PartialInference.h"
#include "openntc/passes/DecompressConstants.h"
#include "openntc/permutation/PermutationKey.h"
#include "openntc/texture_set/TextureSetMetadata.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// A texture that is written. Components that it lacks are written as 0, the fourth as 1.
struct DecompressionOutput {
    int image = 0; ///< element of an engine's array of images (NTC_DECOMPRESS_IMAGES); else not looked at
    int firstChannel = 0; ///< output of the network, 0 … 15
    int numChannels = 1;  ///< 1 … 4, within the 16 outputs
    /// Of the texture's first three components, and of its fourth. What is stored otherwise is converted,
    /// every channel from its own colour space.
    ColorSpace rgbColorSpace = ColorSpace::Linear;
    ColorSpace alphaColorSpace = ColorSpace::Linear;
    /// Width of the dither: the distance of two codes of the texture's format (1/255 for UNORM8); 0: none.
    float ditherScale = 0.0f;
    /// Bits of a component where the texture is normalised (8 for UNORM8), 1 … 16: the pass then rounds to
    /// the nearest code itself, after dithering, and every device stores the same texels. 0: the device's
    /// conversion rounds, which may err by a tenth of a code and more; and textures of floats.
    int unormBits = 0;
};

/// A place in a destination texture, texels.
struct TexelOffset {
    int left = 0;
    int top = 0;
};

struct DecompressionRequest {
    int mip = 0;
    std::optional<Rect> rect;               ///< texels of the mip, inside it; without one the whole mip
    std::optional<TexelOffset> destination; ///< of the rectangle's first texel; without one its own place
    /// Without any, one per texture of the set that has channels: see MakeDecompressionOutput.
    std::span<const DecompressionOutput> outputs;
    int firstImage = 0; ///< added to `image` of every output
    /// A dispatch writes 16 outputs, output n of them to image n of its array. Batch b is outputs 16 b …
    /// 16 b + 15; 0 … batchCount - 1.
    int batch = 0;
};

/// One dispatch.
struct DecompressionPass {
    NtcDecompressConstants constants{}; ///< the uniform buffer
    std::uint32_t groups[3] = {1, 1, 1};
    Permutation permutation; ///< which shader, and which weights to bind
    int batchCount = 1;      ///< dispatches that write all outputs
    /// Whether a component of an output is of another colour space than the channel that it shows.
    bool convertsColors = false;

    /// The pass's own definitions, for FindCovering and FindCoveringShader, where shaders were compiled with
    /// NTC_DECOMPRESS_CONVERT={,0}: without conversion there is less code, with the same texels. Those
    /// without the definition serve every pass: then leave this out.
    const char* GetOwnDefines() const noexcept { return convertsColors ? "" : "NTC_DECOMPRESS_CONVERT=0"; }
};

/// How a texture of a set is to be stored, by its metadata: its colour spaces, a dither of 1/255 if its
/// channels are UNORM8, and rounding to codes if they are UNORM8 or UNORM16. `image` is given. The texture
/// must have channels.
inline DecompressionOutput MakeDecompressionOutput(const Texture& texture, int image) noexcept {
    DecompressionOutput output;
    output.image = image;
    output.firstChannel = texture.firstChannel;
    output.numChannels = texture.numChannels;
    output.rgbColorSpace = texture.rgbColorSpace;
    output.alphaColorSpace = texture.alphaColorSpace;
    output.ditherScale = texture.channelFormat == ChannelFormat::UNORM8 ? 1.0f / 255.0f : 0.0f;
    if (texture.channelFormat == ChannelFormat::UNORM8)
        output.unormBits = 8;
    else if (texture.channelFormat == ChannelFormat::UNORM16)
        output.unormBits = 16;
    return output;
}

namespace detail {

inline bool IsStoredColorSpace(ColorSpace space) noexcept {
    return space == ColorSpace::Linear || space == ColorSpace::sRGB || space == ColorSpace::HLG;
}

inline Expected<void> CheckDecompressionOutput(const DecompressionOutput& output, std::size_t index,
                                               int firstImage) noexcept {
    if (output.firstChannel < 0 || output.firstChannel >= NTC_MAX_CHANNELS)
        return Fail(Status::InvalidArgument, "outputs[%zu].firstChannel: %d: must be 0 … %d", index,
                    output.firstChannel, NTC_MAX_CHANNELS - 1);
    const int most = std::min(4, NTC_MAX_CHANNELS - output.firstChannel);
    if (output.numChannels < 1 || output.numChannels > most)
        return Fail(Status::InvalidArgument, "outputs[%zu].numChannels: %d: must be 1 … %d", index,
                    output.numChannels, most);
    if (output.image < 0 || firstImage < 0 || output.image > std::numeric_limits<int>::max() - firstImage)
        return Fail(Status::InvalidArgument, "outputs[%zu].image: %d after firstImage %d: must be 0 … %d",
                    index, output.image, firstImage, std::numeric_limits<int>::max());
    if (!IsStoredColorSpace(output.rgbColorSpace) || !IsStoredColorSpace(output.alphaColorSpace))
        return Fail(Status::InvalidArgument,
                    "outputs[%zu] colour spaces: %d, %d: must be Linear, sRGB or HLG", index,
                    static_cast<int>(output.rgbColorSpace), static_cast<int>(output.alphaColorSpace));
    if (!IsMagnitudeAtMost(output.ditherScale, 1.0f))
        return Fail(Status::InvalidArgument, "outputs[%zu].ditherScale: %g: must be -1 … 1", index,
                    static_cast<double>(output.ditherScale));
    if (output.unormBits < 0 || output.unormBits > 16)
        return Fail(Status::InvalidArgument, "outputs[%zu].unormBits: %d: must be 0 … 16", index,
                    output.unormBits);
    return {};
}

inline Expected<void> CheckDecompressionRect(const Rect& rect, int width, int height) noexcept {
    if (rect.width < 1 || rect.height < 1)
        return Fail(Status::OutOfRange, "rect: %d x %d: must not be empty", rect.width, rect.height);
    if (rect.left < 0 || rect.top < 0 || rect.width > width - rect.left || rect.height > height - rect.top)
        return Fail(Status::OutOfRange, "rect: %d,%d,%d,%d: must be inside the mip, %d x %d", rect.left,
                    rect.top, rect.width, rect.height, width, height);
    return {};
}

inline Expected<void> CheckDestination(const TexelOffset& destination, const Rect& rect) noexcept {
    const auto isInside = [](int start, int size) {
        return start >= 0 && start <= std::numeric_limits<int>::max() - size;
    };
    if (!isInside(destination.left, rect.width) || !isInside(destination.top, rect.height))
        return Fail(Status::OutOfRange, "destination: %d,%d: must be 0 or more, and its end below 2^31",
                    destination.left, destination.top);
    return {};
}

/// The constants of one mip, as if it were the only one; the rectangle's latents are checked to be there.
inline Expected<NtcSingleMipConstants> MakeMipConstants(const TextureSetMetadata& metadata,
                                                        const NtcTextureSetConstants& constants, int mip,
                                                        const Rect& rect) noexcept {
    const ColorMip& size = metadata.GetColorMips()[static_cast<std::size_t>(mip)];
    const NtcColorMipConstants& colorMip = constants.colorMips[mip];
    const int image = colorMip.neuralMip;
    if (image < 0 || image >= NTC_MAX_NEURAL_MIPS)
        return Fail(Status::OutOfRange, "constants: mip %d: latent image %d: must be 0 … %d", mip, image,
                    NTC_MAX_NEURAL_MIPS - 1);
    const auto holds = metadata.GetGeneration() > 1 ? HoldsLatentTexels : HoldsLatents;
    if (!holds(constants.highResNeuralMips[image], size.width, size.height, rect) ||
        !holds(constants.lowResNeuralMips[image], size.width, size.height, rect))
        return Fail(Status::OutOfRange,
                    "rect: %d,%d,%d,%d of mip %d: needs latents of image %d that are not present", rect.left,
                    rect.top, rect.width, rect.height, mip, image);
    NtcTextureSetConstants one = constants;
    one.highResNeuralMips[0] = constants.highResNeuralMips[image];
    one.lowResNeuralMips[0] = constants.lowResNeuralMips[image];
    one.colorMips[0] = colorMip;
    one.colorMips[0].neuralMip = 0;
    one.imageWidth = size.width;
    one.imageHeight = size.height;
    one.imageMips = 1;
    return MakeSingleMipConstants(one);
}

inline std::uint32_t PackOutputChannels(const DecompressionOutput& output) noexcept {
    return static_cast<std::uint32_t>(output.firstChannel) |
           static_cast<std::uint32_t>(output.numChannels) << 4 |
           static_cast<std::uint32_t>(output.rgbColorSpace) << 8 |
           static_cast<std::uint32_t>(output.alphaColorSpace) << 10 |
           static_cast<std::uint32_t>(output.unormBits) << 12;
}

/// As NtcIsConverted (passes/DecompressTexel.h) of an output's packed channels.
inline bool IsConverted(std::uint32_t packed, std::uint32_t channelColorSpaces) noexcept {
    for (std::uint32_t k = 0; k < (packed >> 4 & 7u); ++k) {
        const std::uint32_t channel = (packed & 15u) + k; // 15 at most
        if ((channelColorSpaces >> (2 * channel) & 3u) != (packed >> (k == 3 ? 10 : 8) & 3u))
            return true;
    }
    return false;
}

/// Outputs 16 batch … of the request, or of the set's textures. Returns how many outputs there are in all.
inline Expected<int> FillDecompressionOutputs(const TextureSetMetadata& metadata,
                                              const DecompressionRequest& request,
                                              NtcDecompressConstants& constants) noexcept {
    const std::span<const Texture> textures = metadata.GetTextures();
    const bool isDefault = request.outputs.empty();
    const std::size_t candidates = isDefault ? textures.size() : request.outputs.size();
    constexpr std::size_t kMost = 1u << 20;
    if (candidates > kMost)
        return Fail(Status::OutOfRange, "outputs: %zu: at most %zu", candidates, kMost);
    int count = 0;
    for (std::size_t i = 0; i < candidates; ++i) {
        if (isDefault && textures[i].numChannels == 0)
            continue;
        const DecompressionOutput output =
            isDefault ? MakeDecompressionOutput(textures[i], static_cast<int>(i)) : request.outputs[i];
        OPENNTC_CHECK(CheckDecompressionOutput(output, i, request.firstImage));
        const int slot = count++ - NTC_DECOMPRESS_OUTPUTS * request.batch;
        if (slot < 0 || slot >= NTC_DECOMPRESS_OUTPUTS)
            continue;
        NtcDecompressOutput& packed = constants.outputs[slot];
        packed.channels = PackOutputChannels(output);
        packed.ditherScale = output.ditherScale;
        packed.noise = static_cast<std::uint32_t>(count);
        packed.image = static_cast<std::uint32_t>(output.image + request.firstImage);
        constants.outputCount = slot + 1;
    }
    if (count == 0)
        return Fail(Status::InvalidArgument, "outputs: none, and no texture of the set has channels");
    return count;
}

/// The permutation that decodes these channels, whether or not textures cover them.
inline Expected<Permutation> MakeDecompressionPermutation(const TextureSetMetadata& metadata,
                                                          const NtcDecompressConstants& constants,
                                                          SceneNeeds needs) noexcept {
    std::uint32_t channels = 0;
    for (int i = 0; i < constants.outputCount; ++i) {
        const std::uint32_t packed = constants.outputs[i].channels;
        channels |= ((1u << (packed >> 4 & 7u)) - 1u) << (packed & 15u);
    }
    const NtcNeuralMipConstants& high = constants.desc.highResNeuralMips[0];
    const NtcNeuralMipConstants& low = constants.desc.lowResNeuralMips[0];
    needs.textures = {};
    needs.channels = 0; // all: the mask is set below, as outputs may be untrained channels
    needs.linear = false;
    needs.firstMipOnly = true;
    needs.wholeLatents =
        high.sliceWidthHeight == high.imageWidthHeight && low.sliceWidthHeight == low.imageWidthHeight;
    needs.texelsInside = true;
    needs.foldConstants = false;
    needs.oneSetPerSubgroup = true;
    needs.decodesBlocks = true;
    needs.decodesOnMatrices = true;
    needs.tiles = {};
    OPENNTC_ASSIGN(Permutation permutation, MakePermutation(metadata, needs));
    const bool isOnMatrices = IsMatrixMath(permutation.key.math);
    if (isOnMatrices)
        channels = 0xFFFFu;
    permutation.key.effects[NTC_EFFECT_OUTPUT_MASK] = channels;
    permutation.effects[NTC_EFFECT_OUTPUT_MASK] = {
        channels, channels != 0xFFFFu,
        isOnMatrices ? "Matrices evaluate all outputs." : "The outputs of the textures are evaluated."};
    permutation.key.effects[NTC_EFFECT_SINGLE_MIP] = 1;
    permutation.effects[NTC_EFFECT_SINGLE_MIP] = {1, true, "The pass decodes one mip."};
    return permutation;
}

} // namespace detail

/// Constants, dispatch and shader of one decompression. `constants`: those of the latents and weights that
/// will be bound, for a slice (MakePartialInferenceData), for shuffled weights and for cooperative vectors.
/// `needs`: device, language, preference and latentTextures; the rest is not looked at. Errors: OutOfRange
/// for a mip that the set does not have, a batch that has no outputs, a rectangle that is empty, not inside
/// the mip or not wholly among the latents, or a destination below 0; InvalidArgument for an output that is
/// not possible, or if there is none (a texture of the set with more than four channels is one); those of
/// MakePermutation.
inline Expected<DecompressionPass> MakeDecompressionPass(const TextureSetMetadata& metadata,
                                                         const NtcTextureSetConstants& constants,
                                                         const DecompressionRequest& request,
                                                         const SceneNeeds& needs) noexcept {
    const int mips = metadata.GetDesc().mips;
    if (request.mip < 0 || request.mip >= mips)
        return Fail(Status::OutOfRange, "mip: %d: must be 0 … %d", request.mip, mips - 1);
    if (request.batch < 0 || request.batch > 1 << 16)
        return Fail(Status::OutOfRange, "batch: %d: must be 0 or more, below batchCount", request.batch);
    DecompressionPass pass;
    OPENNTC_ASSIGN(const int outputs, detail::FillDecompressionOutputs(metadata, request, pass.constants));
    pass.batchCount = (outputs + NTC_DECOMPRESS_OUTPUTS - 1) / NTC_DECOMPRESS_OUTPUTS;
    if (request.batch >= pass.batchCount)
        return Fail(Status::OutOfRange, "batch: %d: %d outputs have %d", request.batch, outputs,
                    pass.batchCount);
    for (int i = 0; i < pass.constants.outputCount; ++i)
        pass.convertsColors |=
            detail::IsConverted(pass.constants.outputs[i].channels, constants.channelColorSpaces);
    const ColorMip& size = metadata.GetColorMips()[static_cast<std::size_t>(request.mip)];
    const Rect rect = request.rect.value_or(Rect{0, 0, size.width, size.height});
    OPENNTC_CHECK(detail::CheckDecompressionRect(rect, size.width, size.height));
    const TexelOffset destination = request.destination.value_or(TexelOffset{rect.left, rect.top});
    OPENNTC_CHECK(detail::CheckDestination(destination, rect));
    OPENNTC_ASSIGN(pass.constants.desc, detail::MakeMipConstants(metadata, constants, request.mip, rect));
    if (needs.latentTextures) // the level
        pass.constants.desc.colorMips[0].neuralMip = constants.colorMips[request.mip].neuralMip;
    OPENNTC_ASSIGN(pass.permutation, detail::MakeDecompressionPermutation(metadata, pass.constants, needs));
    pass.constants.left = rect.left;
    pass.constants.top = rect.top;
    pass.constants.width = rect.width;
    pass.constants.height = rect.height;
    pass.constants.destinationLeft = destination.left;
    pass.constants.destinationTop = destination.top;
    const PermutationKey& key = pass.permutation.key;
    if (detail::IsMatrixMath(key.math)) {
        pass.groups[0] = GetCoopMatGroups(rect.width, rect.height,
                                          GetCoopMatSubgroups(key.networkVersion, key.matrixLanes));
        return pass;
    }
    const int width = NTC_DECOMPRESS_GROUP_WIDTH * key.texelsPerInvocation;
    pass.groups[0] = static_cast<std::uint32_t>((rect.width + width - 1) / width);
    pass.groups[1] = static_cast<std::uint32_t>((rect.height + NTC_DECOMPRESS_GROUP_HEIGHT - 1) /
                                                NTC_DECOMPRESS_GROUP_HEIGHT);
    return pass;
}

namespace detail {

/// `makeConstants` gives those of a weight type.
template <typename MakeConstants>
Expected<DecompressionPass> MakeDecompressionPassWith(const TextureSetMetadata& metadata,
                                                      const DecompressionRequest& request, SceneNeeds needs,
                                                      MakeConstants&& makeConstants) noexcept {
    needs.decodesOnMatrices = true;
    OPENNTC_ASSIGN(const MathChoice math, ChooseMath(metadata.GetWeights(), needs));
    const Expected<NtcTextureSetConstants> constants = makeConstants(math.weights);
    if (!constants)
        return PassError(constants);
    return MakeDecompressionPass(metadata, *constants, request, needs);
}

} // namespace detail

/// The same for sets of every generation, for a buffer that ReadLatents fills for mips firstMip … firstMip +
/// numMips - 1, and the metadata's own weights. Errors: also those of MakeInferenceData; Unsupported if
/// `needs` lead to cooperative vectors, whose constants only the device's own layout gives: the first
/// overload takes them.
inline Expected<DecompressionPass> MakeDecompressionPass(const TextureSetMetadata& metadata, int firstMip,
                                                         int numMips, const DecompressionRequest& request,
                                                         const SceneNeeds& needs) noexcept {
    return detail::MakeDecompressionPassWith(metadata, request, needs, [&](InferenceWeightType type) {
        return MakeInferenceData(metadata, firstMip, numMips, type);
    });
}

/// The same for a buffer that holds the bytes `latentRange` of the stream. Errors: also Unsupported for sets
/// of later generations, whose decoders read no bytes as they are in a file: pass mips.
inline Expected<DecompressionPass> MakeDecompressionPass(const TextureSetMetadata& metadata,
                                                         StreamRange latentRange,
                                                         const DecompressionRequest& request,
                                                         const SceneNeeds& needs) noexcept {
    return detail::MakeDecompressionPassWith(metadata, request, needs, [&](InferenceWeightType type) {
        return MakeInferenceData(metadata, latentRange, type);
    });
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
