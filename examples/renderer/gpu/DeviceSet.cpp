// SPDX-License-Identifier: MIT
#include "renderer/gpu/DeviceSet.h"

#include "renderer/gpu/MathChoice.h"
#include "renderer/gpu/RequireDevice.h"

#include "openntc/MathModes.h"
#include "openntc/inference/CooperativeVectors.h"

namespace openntc::renderer {

using namespace openntc::harness;

DeviceSet UploadDecodeData(Context& context, const tool::DecodeData& data, int math) {
    NtcTextureSetConstants constants = data.constants;
    std::vector<std::byte> converted;
    std::span<const std::byte> weights = data.weights;
    if (UsesVectors(math)) {
        CoopVecWeights vectors = RequireDevice(MakeCoopVecWeights(
            math == NTC_MATH_COOPVEC_FP8 ? InferenceWeightType::CoopVecFP8 : InferenceWeightType::CoopVecInt8,
            data.networkVersion, data.weights));
        converted = RequireDevice(context.ConvertWeights(vectors));
        SetCoopVecOffsets(vectors, constants);
        weights = converted;
    }
    const auto upload = [&context](std::span<const std::byte> bytes, BufferKind kind) {
        return RequireDevice(context.CreateBuffer(bytes, kind, BufferMemory::DeviceLocal));
    };
    return {upload(std::as_bytes(std::span(&constants, 1)), BufferKind::Uniform),
            upload(data.latents, BufferKind::Storage), upload(weights, BufferKind::Storage)};
}

} // namespace openntc::renderer
