// SPDX-License-Identifier: MIT
#include "renderer/gpu/SelfTest.h"

#include "Output.h"
#include "renderer/gpu/RequireDevice.h"

#include "openntc/decode/ReferenceDecoder.h"
#include "openntc/passes/PassConstants.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace openntc::renderer {

using namespace openntc::harness;

namespace {

constexpr int kWidth = 16, kHeight = 12; // of the rectangle in the middle of a mip

bool AreSame(float a, float b) {
    const auto isNone = [](float value) { return std::fabs(value) < std::numeric_limits<float>::min(); };
    return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b) || (isNone(a) && isNone(b));
}

Rect FindMiddle(int width, int height) {
    const int w = std::min(width, kWidth), h = std::min(height, kHeight);
    return {(width - w) / 2, (height - h) / 2, w, h};
}

} // namespace

bool DecodesAsCpu(Context& context, ShaderCache& shaders, const tool::DecodeData& data, DecodeMath math,
                  bool integerDotProduct) {
    static constexpr BufferSlot kSlots[] = {{0, BufferKind::Uniform},
                                            {1, BufferKind::Storage},
                                            {2, BufferKind::Storage},
                                            {3, BufferKind::Storage}};
    std::vector<std::string> defines = {tool::Format("NETWORK_VERSION=%d", data.networkVersion),
                                        tool::Format("NTC_MATH=%d", static_cast<int>(math))};
    if (integerDotProduct)
        defines.emplace_back("NTC_DOT4_SPIRV=1");
    const ComputePipeline pipeline = RequireDevice(context.CreateComputePipeline(
        shaders.Get("DecodeTexels.comp", defines), kSlots, sizeof(NtcDecodeTexelsConstants)));
    const auto upload = [&](std::span<const std::byte> bytes, BufferKind kind) {
        return RequireDevice(context.CreateBuffer(bytes, kind, BufferMemory::DeviceLocal));
    };
    const Buffer constants = upload(std::as_bytes(std::span(&data.constants, 1)), BufferKind::Uniform);
    const Buffer latents = upload(data.latents, BufferKind::Storage);
    const Buffer weights = upload(data.weights, BufferKind::Storage);
    std::vector<float> expected(16 * kWidth * kHeight), decoded(expected.size());
    const Buffer results = RequireDevice(
        context.CreateBuffer(4 * decoded.size(), BufferKind::Storage, BufferMemory::HostVisible));
    const BoundBuffer buffers[] = {{0, &constants}, {1, &latents}, {2, &weights}, {3, &results}};
    for (const int mip : {0, std::max(data.constants.imageMips / 2, 0)}) {
        const Rect rect = FindMiddle(std::max(data.constants.imageWidth >> mip, 1),
                                     std::max(data.constants.imageHeight >> mip, 1));
        const NtcDecodeTexelsConstants push{rect.left, rect.top, rect.width, rect.height, mip, 0};
        DispatchRequest request;
        request.pipeline = &pipeline;
        request.buffers = buffers;
        request.pushConstants = std::as_bytes(std::span(&push, 1));
        const auto texels = static_cast<std::uint32_t>(rect.width * rect.height);
        request.groups[0] = (texels + NTC_DECODE_TEXELS_GROUP - 1) / NTC_DECODE_TEXELS_GROUP;
        RequireDevice(context.Dispatch(request));
        RequireDevice(context.Read(results, 0, std::as_writable_bytes(std::span(decoded))));
        DecodeOptions options;
        options.math = math;
        RequireDevice(DecodeReference(data.GetSource(), mip, rect, options, expected));
        if (!std::equal(expected.begin(), expected.begin() + 16 * texels, decoded.begin(), AreSame))
            return false;
    }
    return true;
}

} // namespace openntc::renderer
