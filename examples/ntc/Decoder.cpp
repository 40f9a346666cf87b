// SPDX-License-Identifier: MIT
#include "Decoder.h"

#include "Failure.h"
#include "VulkanDecoder.h"

#include "openntc/decode/FastDecoder.h"
#include "openntc/decode/ReferenceDecoder.h"
#include "openntc/inference/PartialInference.h"
#include "openntc/inference/ReadLatents.h"

#include <algorithm>
#include <utility>

namespace openntc::tool {

namespace {

class ReferenceBackend final : public Decoder {
public:
    explicit ReferenceBackend(const DecodeData& data) : data_(data) {}
    Expected<void> Decode(int mip, Rect rect, const DecodeOptions& options,
                          std::span<float> outputs) override {
        return DecodeReference(data_.GetSource(), mip, rect, options, outputs);
    }
    int GetTileSize() const override { return 1; }

private:
    const DecodeData& data_;
};

class FastBackend final : public Decoder {
public:
    explicit FastBackend(FastDecoder&& decoder) : decoder_(std::move(decoder)) {}
    Expected<void> Decode(int mip, Rect rect, const DecodeOptions& options,
                          std::span<float> outputs) override {
        return decoder_.Decode(mip, rect, options, outputs);
    }

private:
    FastDecoder decoder_;
};

} // namespace

namespace {

InferenceWeightType GetWeightType(DecodeMath math) {
    return GetDecodeWeights(math) == DecodeWeights::FP8 ? InferenceWeightType::GenericFP8
                                                        : InferenceWeightType::GenericInt8;
}

/// All but constants and latents.
DecodeData MakeDecodeData(const TextureSetMetadata& metadata, const std::string& name, DecodeMath math) {
    const std::span<const std::byte> weights =
        Require(metadata.GetInferenceWeights(GetWeightType(math)), ExitCode::BadInput, name);
    DecodeData data;
    data.weights.assign(weights.begin(), weights.end());
    data.networkVersion = metadata.GetNetworkVersion();
    data.math = math;
    return data;
}

} // namespace

DecodeData PrepareDecodeData(const TextureSetMetadata& metadata, const std::string& name, DecodeMath math) {
    DecodeData data = MakeDecodeData(metadata, name, math);
    data.constants = Require(MakeInferenceData(metadata, 0, metadata.GetDesc().mips, GetWeightType(math)),
                             ExitCode::BadInput, name);
    return data;
}

DecodeData LoadDecodeData(const TextureSetMetadata& metadata, Stream& stream, const std::string& name,
                          DecodeMath math) {
    const int mips = metadata.GetDesc().mips;
    DecodeData data = PrepareDecodeData(metadata, name, math);
    data.latents.resize(Require(GetLatentBufferBytes(metadata, 0, mips), ExitCode::BadInput, name));
    Require(ReadLatents(metadata, stream, 0, mips, data.latents), ExitCode::BadInput, name);
    return data;
}

DecodeData LoadDecodeData(TextureSet& set, DecodeMath math) {
    return LoadDecodeData(set.metadata, set.input.GetStream(), set.input.GetName(), math);
}

DecodeData LoadSliceData(TextureSet& set, DecodeMath math, const SliceDesc& slice) {
    const std::string& name = set.input.GetName();
    DecodeData data = MakeDecodeData(set.metadata, name, math);
    data.latents.resize(static_cast<std::size_t>(
        Require(GetPartialLatentBufferSize(set.metadata, slice), ExitCode::BadInput, name)));
    data.constants = Require(MakePartialInferenceData(set.metadata, set.input.GetStream(), slice,
                                                      GetWeightType(math), data.latents),
                             ExitCode::BadInput, name)
                         .constants;
    return data;
}

DecodeMath ChooseMath(const TextureSet& set, std::optional<DecodeMath> asked,
                      const std::function<void(const std::string&)>& warn) {
    const TextureSetMetadata& metadata = set.metadata;
    if (asked || metadata.IsInferenceWeightTypeSupported(InferenceWeightType::GenericInt8) ||
        !metadata.IsInferenceWeightTypeSupported(InferenceWeightType::GenericFP8))
        return asked.value_or(DecodeMath::Int8);
    warn(set.input.GetName() + ": weights: no Int8 network: decoded with the FP8 network");
    return DecodeMath::FP8;
}

Expected<std::unique_ptr<Decoder>> MakeDecoder(const DecodeData& data, const BackendOptions& options) {
    switch (options.backend) {
    case Backend::Cpu: {
        if (data.math != DecodeMath::Int8 && data.math != DecodeMath::Int8Half) {
            if (options.simd != SimdTarget::Best)
                return Fail(Status::Unsupported, "math: %s: has no form for instruction sets",
                            GetName(data.math));
            OPENNTC_CHECK(ValidateDecodeSource(data.GetSource()));
            return std::make_unique<ReferenceBackend>(data);
        }
        Expected<FastDecoder> decoder =
            FastDecoder::Create(data.GetSource(), {.target = options.simd, .threads = options.threads});
        if (!decoder)
            return PassError(decoder);
        return std::make_unique<FastBackend>(std::move(*decoder));
    }
    case Backend::Reference:
        OPENNTC_CHECK(ValidateDecodeSource(data.GetSource()));
        return std::make_unique<ReferenceBackend>(data);
    case Backend::Vulkan:
        break;
    }
    return MakeVulkanDecoder(data, options.device, options.matrices);
}

std::unique_ptr<Decoder> RequireDecoder(const std::string& subject, const DecodeData& data,
                                        const BackendOptions& options) {
    if (options.matrices && options.backend != Backend::Vulkan)
        throw CommandError(ExitCode::Usage, "--math",
                           std::string(GetName(data.math, options)) + ": needs --backend vulkan");
    Expected<std::unique_ptr<Decoder>> decoder = MakeDecoder(data, options);
    const bool absent = !decoder && (decoder.error().GetStatus() == Status::Unsupported ||
                                     decoder.error().GetStatus() == Status::ShaderUnavailable);
    return Require(std::move(decoder), absent ? ExitCode::NoDevice : ExitCode::BadInput, subject);
}

std::span<const std::pair<SimdTarget, const char*>> ListSimdTargets() {
    static constexpr std::pair<SimdTarget, const char*> kTargets[] = {
        {SimdTarget::Portable, SimdTargetToString(SimdTarget::Portable)},
        {SimdTarget::Avx2, SimdTargetToString(SimdTarget::Avx2)},
        {SimdTarget::AvxVnni, SimdTargetToString(SimdTarget::AvxVnni)},
        {SimdTarget::Avx512Vnni, SimdTargetToString(SimdTarget::Avx512Vnni)},
        {SimdTarget::Amx, SimdTargetToString(SimdTarget::Amx)}};
    return kTargets;
}

const char* GetName(Backend backend) {
    switch (backend) {
    case Backend::Cpu:
        return "cpu";
    case Backend::Reference:
        return "reference";
    case Backend::Vulkan:
        return "vulkan";
    }
    return "unknown";
}

const char* GetName(DecodeMath math, const BackendOptions& options) {
    if (options.matrices)
        return math == DecodeMath::Int8Half ? "coopmat_int8_half" : "coopmat_int8";
    return GetName(math);
}

const char* GetName(DecodeMath math) {
    switch (math) {
    case DecodeMath::Int8:
        return "int8";
    case DecodeMath::Int8Half:
        return "int8_half";
    case DecodeMath::FP8:
        return "fp8";
    case DecodeMath::FP16:
        return "fp16";
    case DecodeMath::FP32:
        return "fp32";
    }
    return "unknown";
}

} // namespace openntc::tool
