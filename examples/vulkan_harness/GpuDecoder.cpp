// SPDX-License-Identifier: MIT
#include "vulkan_harness/GpuDecoder.h"

#include "decode_shaders.h"
#include "matrix_shaders.h"
#include "vulkan_harness/MatrixProbe.h"

#include "openntc/ColorSpaces.h"
#include "openntc/MathModes.h"
#include "openntc/passes/PassConstants.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <iterator>

namespace openntc::harness {

namespace {

constexpr std::uint32_t kLocalSize = NTC_DECODE_TEXELS_GROUP;
constexpr std::uint64_t kTexelBytes = 16 * sizeof(float);

constexpr BufferSlot kSlots[] = {
    {0, BufferKind::Uniform}, {1, BufferKind::Storage}, {2, BufferKind::Storage}, {3, BufferKind::Storage}};

std::size_t GetIndex(DecodeMath math) {
    return static_cast<std::size_t>(math) - static_cast<std::size_t>(DecodeMath::Int8);
}

Expected<std::span<const std::uint32_t>> FindStoredMatrixShader(std::string_view defines) {
    return matrix_shaders::FindShader("DecodeBlocks.comp", defines);
}

} // namespace

Expected<GpuDecoder> GpuDecoder::Create(Context& context, const DecodeSource& source,
                                        const GpuDecoderOptions& options) {
    OPENNTC_CHECK(ValidateDecodeSource(source));
    const DeviceInfo& device = context.GetDevice();
    if (options.dotProduct == DotProduct::Hardware && !device.features.Has(Feature::IntegerDotProduct)) {
        return Fail(Status::Unsupported, "device or feature absent: shaderIntegerDotProduct: %s",
                    device.name.c_str());
    }
    GpuDecoder decoder;
    decoder.context_ = &context;
    if (options.matrices == MatrixUse::Required) {
        decoder.onMatrices_ = true;
        decoder.findMatrixShader_ =
            options.substitute ? options.substitute->findShader : FindStoredMatrixShader;
        if (options.substitute) {
            decoder.layout_ = options.substitute->layout;
        } else {
            OPENNTC_ASSIGN(decoder.layout_, ProbeCoopMat(context));
        }
    }
    decoder.hardwareDot_ =
        options.dotProduct != DotProduct::Emulated && device.features.Has(Feature::IntegerDotProduct);
    const std::uint64_t deviceTexels = std::min<std::uint64_t>(
        device.maxStorageBufferBytes / kTexelBytes, std::uint64_t{device.maxWorkgroupCount[0]} * kLocalSize);
    decoder.maxTexels_ = static_cast<std::uint32_t>(std::clamp<std::uint64_t>(
        options.maxTexelsPerDispatch, 1, std::min<std::uint64_t>(deviceTexels, 1u << 26)));
    OPENNTC_CHECK(decoder.SetSource(source));
    return decoder;
}

Expected<void> GpuDecoder::SetSource(const DecodeSource& source) {
    OPENNTC_CHECK(ValidateDecodeSource(source));
    constants_ = *source.constants;
    networkVersion_ = source.networkVersion;
    weightFormat_ = source.weightFormat;
    OPENNTC_ASSIGN(constantsBuffer_, context_->CreateBuffer(std::as_bytes(std::span(source.constants, 1)),
                                                            BufferKind::Uniform, BufferMemory::DeviceLocal));
    OPENNTC_ASSIGN(latents_,
                   context_->CreateBuffer(source.latents, BufferKind::Storage, BufferMemory::DeviceLocal));
    if (onMatrices_) {
        if (source.weightFormat != DecodeWeights::Int8)
            return Fail(Status::Unsupported, "weights: cooperative matrices need those of Int8");
        matrixLanes_ = layout_ && FitsCoopMatLanes(networkVersion_, source.weights);
        OPENNTC_ASSIGN(
            const Array<std::byte> weights,
            MakeCoopMatWeights(networkVersion_, source.weights, matrixLanes_ ? &*layout_ : nullptr));
        OPENNTC_ASSIGN(weights_, context_->CreateBuffer(weights.AsSpan(), BufferKind::Storage,
                                                        BufferMemory::DeviceLocal));
        return {};
    }
    OPENNTC_ASSIGN(weights_,
                   context_->CreateBuffer(source.weights, BufferKind::Storage, BufferMemory::DeviceLocal));
    return {};
}

std::optional<double> GpuDecoder::GetPipelineSeconds(DecodeMath math) const noexcept {
    if (GetIndex(math) >= std::size(pipelines_[0][0]))
        return std::nullopt;
    const std::optional<ComputePipeline>& pipeline =
        pipelines_[matrixLanes_ ? 1 : 0][networkVersion_ - 1][GetIndex(math)];
    return pipeline ? std::optional<double>(pipeline->GetCreationSeconds()) : std::nullopt;
}

Expected<const ComputePipeline*> GpuDecoder::GetPipeline(DecodeMath math) {
    std::optional<ComputePipeline>& pipeline =
        pipelines_[matrixLanes_ ? 1 : 0][networkVersion_ - 1][GetIndex(math)];
    char defines[96];
    if (!pipeline && onMatrices_) {
        if (math != DecodeMath::Int8 && math != DecodeMath::Int8Half)
            return Fail(Status::Unsupported, "math: %d: cooperative matrices are for Int8 and Int8Half",
                        static_cast<int>(math));
        std::snprintf(defines, sizeof defines, "NETWORK_VERSION=%d NTC_MATH=%d%s NTC_RESULT_BITS=32",
                      networkVersion_,
                      math == DecodeMath::Int8 ? NTC_MATH_COOPMAT_INT8 : NTC_MATH_COOPMAT_INT8_HALF,
                      matrixLanes_ ? " NTC_COOPMAT_LANES=1" : "");
        OPENNTC_ASSIGN(const std::span<const std::uint32_t> words, findMatrixShader_(defines));
        OPENNTC_ASSIGN(pipeline,
                       context_->CreateComputePipeline(words, kSlots, sizeof(NtcDecodeBlocksConstants)));
    }
    if (!pipeline) {
        std::snprintf(defines, sizeof defines, "NETWORK_VERSION=%d NTC_MATH=%d%s", networkVersion_,
                      static_cast<int>(math), hardwareDot_ ? " NTC_DOT4_SPIRV=1" : "");
        OPENNTC_ASSIGN(const std::span<const std::uint32_t> words,
                       decode_shaders::FindShader("DecodeTexels.comp", defines));
        OPENNTC_ASSIGN(pipeline,
                       context_->CreateComputePipeline(words, kSlots, sizeof(NtcDecodeTexelsConstants)));
    }
    return &*pipeline;
}

DispatchRequest GpuDecoder::MakeRequest(const ComputePipeline& pipeline, std::span<const BoundBuffer> buffers,
                                        const Rect& tile, int mip, bool convertToLinear) {
    DispatchRequest request;
    request.pipeline = &pipeline;
    request.buffers = buffers;
    const auto width = static_cast<std::uint32_t>(tile.width),
               height = static_cast<std::uint32_t>(tile.height);
    const auto set = [&](const auto& constants, std::uint32_t groups) {
        std::memcpy(pushConstants_.data(), &constants, sizeof constants);
        request.pushConstants = std::span(pushConstants_).first(sizeof constants);
        request.groups[0] = groups;
    };
    if (onMatrices_)
        set(NtcDecodeBlocksConstants{tile.left, tile.top, width, height, mip},
            GetCoopMatGroups(tile.width, tile.height, GetCoopMatSubgroups(networkVersion_, matrixLanes_)));
    else
        set(NtcDecodeTexelsConstants{tile.left, tile.top, tile.width, tile.height, mip,
                                     convertToLinear ? 1u : 0u},
            (width * height + kLocalSize - 1) / kLocalSize);
    return request;
}

Expected<GpuDecodeTiming> GpuDecoder::Decode(int mip, Rect rect, const DecodeOptions& options,
                                             std::span<float> outputs) {
    OPENNTC_CHECK(detail::ValidateDecodeMath(options.math, weightFormat_));
    OPENNTC_CHECK(detail::ValidateDecodeRequest(constants_, mip, rect, outputs.size()));
    GpuDecodeTiming timing;
    timing.gpuSeconds = 0.0;
    OPENNTC_ASSIGN(const ComputePipeline* const pipeline, GetPipeline(options.math));

    const int tileWidth = static_cast<int>(std::min<std::int64_t>(rect.width, maxTexels_));
    const int tileHeight = static_cast<int>(
        std::min<std::int64_t>(rect.height, std::max<std::int64_t>(std::int64_t{maxTexels_} / tileWidth, 1)));
    const std::uint64_t tileTexels =
        static_cast<std::uint64_t>(tileWidth) * static_cast<std::uint64_t>(tileHeight);
    if (tileTexels > resultTexels_) {
        OPENNTC_ASSIGN(results_, context_->CreateBuffer(tileTexels * kTexelBytes, BufferKind::Storage,
                                                        BufferMemory::HostVisible));
        resultTexels_ = tileTexels;
    }
    const BoundBuffer bound[] = {{0, &constantsBuffer_}, {1, &latents_}, {2, &weights_}, {3, &results_}};

    for (int y = 0; y < rect.height; y += tileHeight) {
        for (int x = 0; x < rect.width; x += tileWidth) {
            const int width = std::min(tileWidth, rect.width - x);
            const int height = std::min(tileHeight, rect.height - y);
            const Rect tile = {rect.left + x, rect.top + y, width, height};
            const std::size_t texels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
            const DispatchRequest request = MakeRequest(*pipeline, bound, tile, mip, options.convertToLinear);
            OPENNTC_ASSIGN(const DispatchTiming dispatch, context_->Dispatch(request));
            timing.wallSeconds += dispatch.wallSeconds;
            if (timing.gpuSeconds && dispatch.gpuSeconds)
                *timing.gpuSeconds += *dispatch.gpuSeconds;
            else
                timing.gpuSeconds.reset();
            ++timing.dispatches;
            // Tiles are whole rows, or parts of one row: contiguous in the output either way.
            const std::size_t first = static_cast<std::size_t>(y) * static_cast<std::size_t>(rect.width) +
                                      static_cast<std::size_t>(x);
            OPENNTC_CHECK(context_->Read(results_, 0,
                                         std::as_writable_bytes(outputs.subspan(16 * first, 16 * texels))));
        }
    }
    if (onMatrices_ && options.convertToLinear) { // DecodeBlocks gives what is stored
        const std::size_t texels =
            static_cast<std::size_t>(rect.width) * static_cast<std::size_t>(rect.height);
        for (std::size_t i = 0; i < 16 * texels; ++i)
            outputs[i] = shader::NtcConvertChannelToLinearColorSpace(outputs[i], static_cast<int>(i % 16),
                                                                     constants_.channelColorSpaces);
    }
    return timing;
}

} // namespace openntc::harness
