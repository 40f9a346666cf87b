// SPDX-License-Identifier: MIT
#include "renderer/gpu/SelfTest.h"

#include "Output.h"
#include "conformance/HardwareIntervals.h"
#include "renderer/gpu/DeviceSet.h"
#include "renderer/gpu/MathChoice.h"
#include "renderer/gpu/RequireDevice.h"

#include "openntc/MathModes.h"
#include "openntc/decode/ReferenceDecoder.h"
#include "openntc/decode/ShaderMath.h"
#include "openntc/passes/PassConstants.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace openntc::renderer {

using namespace openntc::harness;

namespace {

constexpr int kWidth = 16, kHeight = 12; // of the rectangle in the middle of a mip
constexpr int kIntervalStride = 7;       // of texels whose intervals are computed: that takes long

bool AreSame(float a, float b) {
    const auto isNone = [](float value) { return std::fabs(value) < std::numeric_limits<float>::min(); };
    return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b) || (isNone(a) && isNone(b));
}

Rect FindMiddle(int width, int height) {
    const int w = std::min(width, kWidth), h = std::min(height, kHeight);
    return {(width - w) / 2, (height - h) / 2, w, h};
}

/// Every few texels of a rectangle: within the intervals of FP8 hardware.
bool AreWithinIntervals(const DecodeSource& source, int mip, Rect rect, std::span<const float> expected,
                        std::span<const float> texels) {
    std::vector<conformance::ValueRecord> records;
    std::vector<std::size_t> places;
    for (int i = 0; i < rect.width * rect.height; i += kIntervalStride) {
        conformance::ValueRecord& record = records.emplace_back();
        record.texel = {mip, rect.left + i % rect.width, rect.top + i / rect.width};
        places.push_back(16 * static_cast<std::size_t>(i));
        std::copy_n(expected.begin() + static_cast<std::ptrdiff_t>(places.back()), 16,
                    record.outputs.begin());
    }
    conformance::FillHardwareIntervals(source, records);
    for (std::size_t i = 0; i < records.size(); ++i) {
        for (std::size_t c = 0; c < 16; ++c) {
            const float value = texels[places[i] + c];
            if (!(value >= records[i].low[c] && value <= records[i].high[c]))
                return false;
        }
    }
    return true;
}

} // namespace

bool AreAsPromised(const tool::DecodeData& data, int math, int mip, Rect rect,
                   std::span<const float> texels) {
    std::vector<float> expected(texels.size());
    DecodeOptions options;
    options.math = GetDecodeMath(math);
    RequireDevice(DecodeReference(data.GetSource(), mip, rect, options, expected));
    return math == NTC_MATH_COOPVEC_FP8
               ? AreWithinIntervals(data.GetSource(), mip, rect, expected, texels)
               : std::equal(expected.begin(), expected.end(), texels.begin(), AreSame);
}

bool DecodesAsPromised(Context& context, ShaderCache& shaders, const tool::DecodeData& data, int math,
                       bool integerDotProduct) {
    static constexpr BufferSlot kSlots[] = {{0, BufferKind::Uniform},
                                            {1, BufferKind::Storage},
                                            {2, BufferKind::Storage},
                                            {3, BufferKind::Storage}};
    std::vector<std::string> defines = {tool::Format("NETWORK_VERSION=%d", data.networkVersion),
                                        tool::Format("NTC_MATH=%d", math)};
    if (integerDotProduct && !UsesVectors(math))
        defines.emplace_back("NTC_DOT4_SPIRV=1");
    const ComputePipeline pipeline = RequireDevice(context.CreateComputePipeline(
        shaders.Get("DecodeTexels.comp", defines), kSlots, sizeof(NtcDecodeTexelsConstants)));
    const DeviceSet set = UploadDecodeData(context, data, math);
    std::vector<float> decoded(16 * kWidth * kHeight);
    const Buffer results = RequireDevice(
        context.CreateBuffer(4 * decoded.size(), BufferKind::Storage, BufferMemory::HostVisible));
    const BoundBuffer buffers[] = {{0, &set.constants}, {1, &set.latents}, {2, &set.weights}, {3, &results}};
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
        if (!AreAsPromised(data, math, mip, rect, std::span(decoded).first(std::size_t{16} * texels)))
            return false;
    }
    return true;
}

} // namespace openntc::renderer
