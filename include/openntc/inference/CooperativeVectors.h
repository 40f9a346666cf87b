// SPDX-License-Identifier: MIT
// Stability: experimental
// Weights for cooperative vectors (VK_NV_cooperative_vector): matrices in the layout that the driver chooses.
//
//   1. MakeCoopVecWeights: the four matrices in the form that the driver converts from.
//   2. For each matrix FillCoopVecConversion with null destination, vkConvertCooperativeVectorMatrixNV: the
//      driver writes its size to *pDstSize; store it in destinationSize.
//   3. LayOutCoopVecWeights: offsets of everything in the device buffer, and its size.
//   4. Write `tail` at tailOffset. For each matrix FillCoopVecConversion with addresses, then
//      vkConvertCooperativeVectorMatrixNV (host addresses) or vkCmdConvertCooperativeVectorMatrixNV (device
//      addresses).
//   5. MakeInferenceData with the CoopVecWeights: constants with the offsets of that buffer.
//
// The library calls no graphics API: the engine owns buffers and submission. No Vulkan header is needed here.
#pragma once

#include "openntc/InferenceConstants.h"
#include "openntc/core/Allocator.h"
#include "openntc/core/E4M3.h"
#include "openntc/core/Expected.h"
#include "openntc/core/Half.h"
#include "openntc/format/NetworkDescription.h"
#include "openntc/inference/InferenceData.h"
#include "openntc/texture_set/InferenceWeights.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "openntc/core/HideMacros.h"

namespace openntc {

/// What a device offers; fill it from VkPhysicalDeviceCooperativeVectorFeaturesNV and the list of
/// vkGetPhysicalDeviceCooperativeVectorPropertiesNV.
struct CoopVecDevice {
    bool hasCooperativeVectors = false; ///< cooperativeVector, shaderFloat16, vulkanMemoryModel
    /// Inputs SINT8_PACKED as SINT8_PACKED and FLOAT32 as SINT8, matrix SINT8, bias and result SINT32.
    bool hasInt8 = false;
    bool hasE4M3 = false; ///< inputs FLOAT16 as FLOAT_E4M3, matrix FLOAT_E4M3, bias and result FLOAT16
};

/// Which cooperative vectors come first where there are both. Int8 is exact and, where it was measured,
/// faster (MathPreference in permutation/SceneNeeds.h).
enum class CoopVecOrder : std::uint8_t { Int8First, FP8First };

/// The weights to use on a device: CoopVecInt8 and CoopVecFP8 in the order asked for, then GenericInt8, as
/// far as device and set have them; GenericFP8 for a set that has no Int8 network; Unknown for a set without
/// weights.
constexpr InferenceWeightType PickWeightType(const CoopVecDevice& device, bool setHasInt8, bool setHasFP8,
                                             CoopVecOrder order = CoopVecOrder::Int8First) noexcept {
    const bool canInt8 = setHasInt8 && device.hasCooperativeVectors && device.hasInt8;
    const bool canFP8 = setHasFP8 && device.hasCooperativeVectors && device.hasE4M3 && device.hasInt8;
    if (canFP8 && (order == CoopVecOrder::FP8First || !canInt8))
        return InferenceWeightType::CoopVecFP8;
    if (canInt8)
        return InferenceWeightType::CoopVecInt8;
    if (setHasInt8)
        return InferenceWeightType::GenericInt8;
    return setHasFP8 ? InferenceWeightType::GenericFP8 : InferenceWeightType::Unknown;
}

/// Component types, with the values of VkComponentTypeKHR.
enum class CoopVecComponent : std::int32_t { Float16 = 0, SInt8 = 3, FloatE4M3 = 1000491002 };

inline constexpr std::int32_t kCoopVecRowMajor = 0;           ///< VK_COOPERATIVE_VECTOR_MATRIX_LAYOUT_*
inline constexpr std::int32_t kCoopVecInferencingOptimal = 2; ///< the same
inline constexpr std::size_t kCoopVecAlignment = 64;          ///< of matrices in the device buffer, bytes

/// One matrix; rows are outputs. Offsets and sizes in bytes.
struct CoopVecMatrix {
    std::uint32_t rows = 0;
    std::uint32_t columns = 0;
    CoopVecComponent sourceComponent = CoopVecComponent::SInt8; ///< row-major
    CoopVecComponent destinationComponent = CoopVecComponent::SInt8;
    std::size_t sourceOffset = 0; ///< in CoopVecWeights::matrices
    std::size_t sourceSize = 0;
    std::size_t sourceStride = 0;
    std::size_t destinationOffset = 0; ///< in the device buffer; set by LayOutCoopVecWeights
    std::size_t destinationSize = 0;   ///< as the driver says
};

struct CoopVecWeights {
    InferenceWeightType type = InferenceWeightType::Unknown; ///< CoopVecInt8 or CoopVecFP8
    std::array<CoopVecMatrix, kNetworkLayers> layers;
    Array<std::byte> matrices;  ///< sources of the conversion
    Array<std::byte> tail;      ///< scales and biases, as in the generic buffer
    std::size_t tailOffset = 0; ///< in the device buffer; set by LayOutCoopVecWeights
    std::size_t size = 0;       ///< of the device buffer
};

/// Takes a generic weight buffer apart. E4M3 matrices are widened to binary16, because drivers convert to
/// E4M3 but not from it; nothing is lost. Errors: InvalidArgument for a type that is not CoopVecInt8 or
/// CoopVecFP8, an unknown network version or a buffer of another size than the network's; OutOfMemory.
inline Expected<CoopVecWeights> MakeCoopVecWeights(InferenceWeightType type, int networkVersion,
                                                   std::span<const std::byte> generic,
                                                   Allocator& allocator = GetDefaultAllocator()) noexcept {
    const bool isFP8 = type == InferenceWeightType::CoopVecFP8;
    if (!isFP8 && type != InferenceWeightType::CoopVecInt8)
        return Fail(Status::InvalidArgument, "weight type: %s: must be CoopVecInt8 or CoopVecFP8",
                    InferenceWeightTypeToString(type));
    if (!IsKnownNetwork(networkVersion))
        return Fail(Status::InvalidArgument, "network version: %d: must be 1 to %d", networkVersion,
                    NTC_NETWORK_GENERATION_3);
    const NetworkDescription network = GetNetworkDescription(networkVersion);
    const std::size_t expected = static_cast<std::size_t>(isFP8 ? network.fp8Bytes : network.int8Bytes);
    if (generic.size() != expected)
        return Fail(Status::InvalidArgument, "weights: %zu bytes: the generic buffer has %zu", generic.size(),
                    expected);
    CoopVecWeights weights{type, {}, Array<std::byte>(allocator), Array<std::byte>(allocator), 0, 0};
    std::size_t offset = 0;
    for (std::size_t layer = 0; layer < kNetworkLayers; ++layer) {
        CoopVecMatrix& matrix = weights.layers[layer];
        const bool isE4M3 = isFP8 && layer + 1 < kNetworkLayers;
        matrix.rows = static_cast<std::uint32_t>(network.outputs[layer]);
        matrix.columns = static_cast<std::uint32_t>(network.inputs[layer]);
        matrix.sourceComponent = isE4M3 ? CoopVecComponent::Float16 : CoopVecComponent::SInt8;
        matrix.destinationComponent = isE4M3 ? CoopVecComponent::FloatE4M3 : CoopVecComponent::SInt8;
        matrix.sourceStride = std::size_t{matrix.columns} * (isE4M3 ? 2 : 1);
        matrix.sourceOffset = offset;
        matrix.sourceSize = matrix.sourceStride * matrix.rows;
        offset += matrix.sourceSize; // a multiple of 64
    }
    OPENNTC_CHECK(weights.matrices.Resize(offset));
    for (std::size_t layer = 0; layer < kNetworkLayers; ++layer) {
        const CoopVecMatrix& matrix = weights.layers[layer];
        const std::byte* from = generic.data() + network.weightOffsets[layer];
        std::byte* to = weights.matrices.data() + matrix.sourceOffset;
        if (matrix.sourceComponent == CoopVecComponent::SInt8) {
            std::memcpy(to, from, matrix.sourceSize);
            continue;
        }
        for (std::size_t i = 0; i < matrix.sourceSize / 2; ++i) {
            const std::uint16_t half = FloatToHalf(E4M3ToFloat(std::to_integer<std::uint8_t>(from[i])));
            to[2 * i] = static_cast<std::byte>(half & 0xFFu);
            to[2 * i + 1] = static_cast<std::byte>(half >> 8);
        }
    }
    const std::size_t matrixBytes = static_cast<std::size_t>(network.weightBytes);
    OPENNTC_CHECK(weights.tail.Assign(generic.subspan(matrixBytes)));
    return weights;
}

/// Sets offsets and the size of the device buffer from the matrices' destinationSize. Errors: InvalidArgument
/// if a size is 0 (not asked for yet); OutOfRange beyond 16 MiB a matrix, which no driver needs.
inline Expected<void> LayOutCoopVecWeights(CoopVecWeights& weights) noexcept {
    std::size_t offset = 0;
    for (std::size_t layer = 0; layer < kNetworkLayers; ++layer) {
        CoopVecMatrix& matrix = weights.layers[layer];
        if (matrix.destinationSize == 0)
            return Fail(Status::InvalidArgument, "layer %zu: destinationSize: 0: ask the driver", layer);
        if (matrix.destinationSize > (std::size_t{1} << 24))
            return Fail(Status::OutOfRange, "layer %zu: destinationSize: %zu: at most 16777216", layer,
                        matrix.destinationSize);
        matrix.destinationOffset = offset;
        offset += (matrix.destinationSize + kCoopVecAlignment - 1) / kCoopVecAlignment * kCoopVecAlignment;
    }
    weights.tailOffset = offset;
    weights.size = offset + weights.tail.size();
    return {};
}

/// Fills a VkConvertCooperativeVectorMatrixInfoNV, but not its sType, pNext, srcData and dstData: set srcData
/// to `matrices` + sourceOffset and dstData to the device buffer + destinationOffset, or dstData to null to
/// ask for the size.
template <typename ConvertInfo>
void FillCoopVecConversion(CoopVecMatrix& matrix, ConvertInfo& info) noexcept {
    info.srcSize = matrix.sourceSize;
    info.pDstSize = &matrix.destinationSize;
    info.srcComponentType = static_cast<decltype(info.srcComponentType)>(matrix.sourceComponent);
    info.dstComponentType = static_cast<decltype(info.dstComponentType)>(matrix.destinationComponent);
    info.numRows = matrix.rows;
    info.numColumns = matrix.columns;
    info.srcLayout = static_cast<decltype(info.srcLayout)>(kCoopVecRowMajor);
    info.srcStride = matrix.sourceStride;
    info.dstLayout = static_cast<decltype(info.dstLayout)>(kCoopVecInferencingOptimal);
    info.dstStride = matrix.sourceStride; // not used by optimal layouts
}

/// Points the constants of the generic weights at the device buffer.
inline void SetCoopVecOffsets(const CoopVecWeights& weights, NtcTextureSetConstants& constants) noexcept {
    constants.networkWeightOffset0 = static_cast<std::int32_t>(weights.layers[0].destinationOffset);
    constants.networkWeightOffset1 = static_cast<std::int32_t>(weights.layers[1].destinationOffset);
    constants.networkWeightOffset2 = static_cast<std::int32_t>(weights.layers[2].destinationOffset);
    constants.networkWeightOffset3 = static_cast<std::int32_t>(weights.layers[3].destinationOffset);
    constants.networkScaleBiasOffset = static_cast<std::int32_t>(weights.tailOffset);
}

namespace detail {

/// The generic weights that laid-out weights stand for.
inline Expected<InferenceWeightType> GetCoopVecSource(const CoopVecWeights& weights) noexcept {
    if (weights.type != InferenceWeightType::CoopVecInt8 && weights.type != InferenceWeightType::CoopVecFP8)
        return Fail(Status::InvalidArgument, "weights.type: %s: must be CoopVecInt8 or CoopVecFP8",
                    InferenceWeightTypeToString(weights.type));
    if (weights.size == 0)
        return Fail(Status::InvalidArgument, "weights.size: 0: LayOutCoopVecWeights comes first");
    return weights.type == InferenceWeightType::CoopVecFP8 ? InferenceWeightType::GenericFP8
                                                           : InferenceWeightType::GenericInt8;
}

} // namespace detail

/// MakeInferenceData for a device buffer of cooperative-vector weights that LayOutCoopVecWeights has laid
/// out; inputs are encoded as for the generic weights of the same kind. `generic`: what the weights were made
/// from, the metadata's own or shuffled. Errors: InvalidArgument for weights without a type or not laid out,
/// and those of MakeInferenceData.
inline Expected<NtcTextureSetConstants> MakeInferenceData(const TextureSetMetadata& metadata,
                                                          StreamRange latentRange,
                                                          const CoopVecWeights& weights,
                                                          const InferenceWeights& generic) noexcept {
    OPENNTC_ASSIGN(const InferenceWeightType source, detail::GetCoopVecSource(weights));
    OPENNTC_ASSIGN(NtcTextureSetConstants constants,
                   MakeInferenceData(metadata, latentRange, source, generic));
    SetCoopVecOffsets(weights, constants);
    return constants;
}

inline Expected<NtcTextureSetConstants> MakeInferenceData(const TextureSetMetadata& metadata,
                                                          StreamRange latentRange,
                                                          const CoopVecWeights& weights) noexcept {
    return MakeInferenceData(metadata, latentRange, weights, metadata.GetWeights());
}

/// The same by mips, for sets of every generation.
inline Expected<NtcTextureSetConstants> MakeInferenceData(const TextureSetMetadata& metadata, int firstMip,
                                                          int numMips, const CoopVecWeights& weights,
                                                          const InferenceWeights& generic) noexcept {
    OPENNTC_ASSIGN(const InferenceWeightType source, detail::GetCoopVecSource(weights));
    OPENNTC_ASSIGN(NtcTextureSetConstants constants,
                   MakeInferenceData(metadata, firstMip, numMips, source, generic));
    SetCoopVecOffsets(weights, constants);
    return constants;
}

inline Expected<NtcTextureSetConstants> MakeInferenceData(const TextureSetMetadata& metadata, int firstMip,
                                                          int numMips,
                                                          const CoopVecWeights& weights) noexcept {
    return MakeInferenceData(metadata, firstMip, numMips, weights, metadata.GetWeights());
}

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
