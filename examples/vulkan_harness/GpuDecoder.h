// SPDX-License-Identifier: MIT
// Decodes texels with the compute pass shaders/openntc/passes/DecodeTexels.comp.
#pragma once

#include "vulkan_harness/Vulkan.h"

#include "openntc/decode/DecodeTypes.h"
#include "openntc/inference/CooperativeMatrices.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace openntc::harness {

/// How the shader multiplies packed bytes; the results are the same.
enum class DotProduct {
    Best,     ///< the instruction where the device has it
    Emulated, ///< bit operations
    Hardware, ///< OpSDot; an error on devices without shaderIntegerDotProduct
};

/// Whether INT8 and INT8_HALF run on cooperative matrices (passes/DecodeBlocks.comp); the results are the same.
enum class MatrixUse { None, Required };

/// Matrices that stand in for the device's, with the SPIR-V that has them: a test's, made of arrays.
struct MatrixSubstitute {
    std::optional<CoopMatLayout> layout; ///< empty: the form of the lanes is not possible
    /// SPIR-V of passes/DecodeBlocks.comp for definitions as in matrices.txt.
    Expected<std::span<const std::uint32_t>> (*findShader)(std::string_view defines) = nullptr;
};

struct GpuDecoderOptions {
    DotProduct dotProduct = DotProduct::Best;
    MatrixUse matrices = MatrixUse::None;
    std::optional<MatrixSubstitute> substitute = std::nullopt; ///< instead of the device's matrices
    /// Texels of one dispatch at most; larger rectangles are split, so that slow devices do not hit a
    /// watchdog and the result buffer (64 bytes per texel) stays small.
    std::uint32_t maxTexelsPerDispatch = 1u << 18;
};

struct GpuDecodeTiming {
    std::optional<double> gpuSeconds; ///< sum over the dispatches; empty without timestamps
    double wallSeconds = 0;           ///< dispatches only, without read-back
    std::uint32_t dispatches = 0;
};

/// Holds the constants, latents and weights of one texture set on a device. The context must outlive it; use
/// from one thread at a time.
class GpuDecoder {
public:
    /// Validates and uploads; the source may go afterwards. Errors: those of ValidateDecodeSource;
    /// Unsupported with "device or feature absent: ..." when the device's limits are too small or it lacks
    /// the dot product or the matrices asked for; ShaderUnavailable where there is no SPIR-V of those.
    static Expected<GpuDecoder> Create(Context& context, const DecodeSource& source,
                                       const GpuDecoderOptions& options = {});

    /// Takes another texture set; pipelines stay. Errors: as Create. After an error nothing can be decoded.
    Expected<void> SetSource(const DecodeSource& source);

    /// Decodes `rect` of `mip`: 16 binary32 per texel, row by row, into outputs (16 * width * height floats
    /// at least). The first call with each maths mode also creates its pipeline. Errors as DecodeReference,
    /// and the device's.
    Expected<GpuDecodeTiming> Decode(int mip, Rect rect, const DecodeOptions& options,
                                     std::span<float> outputs);

    /// True where matrices decode the set in the form of the lanes; false also without matrices.
    bool HasMatrixLanes() const noexcept { return matrixLanes_; }

    /// Wall-clock seconds of vkCreateComputePipelines; empty before the first Decode with that maths mode.
    std::optional<double> GetPipelineSeconds(DecodeMath math) const noexcept;

private:
    GpuDecoder() noexcept = default;
    Expected<const ComputePipeline*> GetPipeline(DecodeMath math);
    DispatchRequest MakeRequest(const ComputePipeline& pipeline, std::span<const BoundBuffer> buffers,
                                const Rect& tile, int mip, bool convertToLinear);

    Context* context_ = nullptr;
    NtcTextureSetConstants constants_ = {};
    int networkVersion_ = 0;
    DecodeWeights weightFormat_ = DecodeWeights::Int8;
    bool hardwareDot_ = false;
    bool onMatrices_ = false;
    bool matrixLanes_ = false; ///< of the set at hand: the form that its weights and the device allow
    std::optional<CoopMatLayout> layout_;
    Expected<std::span<const std::uint32_t>> (*findMatrixShader_)(std::string_view defines) = nullptr;
    std::array<std::byte, 32> pushConstants_{};
    std::uint32_t maxTexels_ = 0;
    std::uint64_t resultTexels_ = 0;
    Buffer constantsBuffer_;
    Buffer latents_;
    Buffer weights_;
    Buffer results_;
    std::optional<ComputePipeline> pipelines_[2][NTC_NETWORK_GENERATION_3]
                                             [5]; // per form of matrices, network version and DecodeMath
};

} // namespace openntc::harness
