// SPDX-License-Identifier: MIT
#include "vulkan_harness/MatrixProbe.h"

#include "matrix_shaders.h"

#include <vector>

namespace openntc::harness {

Expected<std::optional<CoopMatLayout>> ProbeCoopMat(Context& context) {
    const DeviceInfo& device = context.GetDevice();
    if (!device.hasByteMatrices)
        return Fail(Status::Unsupported,
                    "device or feature absent: cooperative matrices of signed bytes, 16 x 16 x 32: %s",
                    device.name.c_str());
    OPENNTC_ASSIGN(const std::span<const std::uint32_t> words,
                   matrix_shaders::FindShader("ProbeCoopMat.comp", "NTC_MATH=8"));
    const BufferSlot slot = {0, BufferKind::Storage};
    OPENNTC_ASSIGN(const ComputePipeline pipeline,
                   context.CreateComputePipeline(words, std::span(&slot, 1), 0));
    std::vector<std::int32_t> results(kCoopMatLanes * kCoopMatProbeNumbers);
    OPENNTC_ASSIGN(const Buffer buffer,
                   context.CreateBuffer(results.size() * 4, BufferKind::Storage, BufferMemory::HostVisible));
    const BoundBuffer bound = {0, &buffer};
    DispatchRequest request;
    request.pipeline = &pipeline;
    request.buffers = std::span(&bound, 1);
    OPENNTC_CHECK(context.Dispatch(request));
    OPENNTC_CHECK(context.Read(buffer, 0, std::as_writable_bytes(std::span(results))));
    const Expected<CoopMatLayout> layout = ReadCoopMatLayout(results);
    constexpr std::uint32_t kSharedBytes = 48 << 10;
    constexpr std::uint32_t kInvocations = // of the widest network's workgroups
        kCoopMatLanes * std::uint32_t{GetCoopMatSubgroups(NTC_NETWORK_GENERATION_3, true)};
    if (!layout || device.maxSharedBytes < kSharedBytes || device.maxWorkgroupInvocations < kInvocations)
        return std::optional<CoopMatLayout>();
    return std::optional<CoopMatLayout>(*layout);
}

bool DescribeMatrices(const Expected<std::optional<CoopMatLayout>>& layout, DeviceFeatures& features) {
    features.cooperativeMatrixInt8 = layout.has_value();
    features.cooperativeMatrixLanes = layout && layout->has_value();
    return features.cooperativeMatrixInt8;
}

} // namespace openntc::harness
