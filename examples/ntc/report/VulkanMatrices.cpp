// SPDX-License-Identifier: MIT
#include "Output.h"
#include "report/RepeatedSet.h"
#include "report/SharedDevice.h"

#include "report_coopmat.h"

#include "openntc/decode/ShaderMath.h"
#include "openntc/inference/CooperativeMatrices.h"
#include "openntc/passes/PassConstants.h"
#include "vulkan_harness/GpuDecoder.h"
#include "vulkan_harness/MatrixProbe.h"

#include <algorithm>
#include <array>

namespace openntc::report {

namespace {

constexpr int kMatrixTexels = 1 << 22; // of a dispatch: fewer do not fill a GPU
constexpr harness::BufferSlot kMatrixSlots[] = {{0, harness::BufferKind::Uniform},
                                                {1, harness::BufferKind::Storage},
                                                {2, harness::BufferKind::Storage},
                                                {3, harness::BufferKind::Storage}};

/// passes/DecodeBlocks, which decodes a rectangle of a mip: it is timed on the set repeated downwards.
class MatrixCase final : public PreparedCase {
public:
    MatrixCase(SharedDevice& shared, const Case& c, const Encoding& encoding, harness::GpuDecoder decoder,
               const CoopMatLayout* layout, RepeatedSet set, std::span<const std::uint32_t> spirv)
        : shared_(shared), decoder_(std::move(decoder)),
          width_(encoding.record.width), options_{.math = GetDecodeMath(c.math),
                                                  .convertToLinear = c.linear} {
        push_ = {0, 0, static_cast<std::uint32_t>(set.constants.imageWidth),
                 static_cast<std::uint32_t>(set.constants.imageHeight), 0};
        groups_ = GetCoopMatGroups(set.constants.imageWidth, set.constants.imageHeight,
                                   GetCoopMatSubgroups(c.network, layout != nullptr));
        kernel_ = RequireDevice(
            shared_.context->CreateComputePipeline(spirv, kMatrixSlots, sizeof push_, {.isKept = false}),
            shared_.GetInfo().name + ": " + c.GetId());
        const Array<std::byte> weights =
            tool::Require(MakeCoopMatWeights(c.network, encoding.GetData(c.math).weights, layout),
                          tool::ExitCode::Failed, encoding.record.name);
        const std::span<const std::byte> contents[] = {std::as_bytes(std::span(&set.constants, 1)),
                                                       set.latents, weights.AsSpan()};
        for (std::size_t i = 0; i < buffers_.size(); ++i)
            buffers_[i] = RequireDevice(shared_.context->CreateBuffer(contents[i], kMatrixSlots[i].kind,
                                                                      harness::BufferMemory::DeviceLocal));
    }

    std::vector<float> Decode(int rows) override {
        std::vector<float> outputs(std::size_t{16} * static_cast<std::size_t>(width_) *
                                   static_cast<std::size_t>(rows));
        RequireDevice(decoder_.Decode(0, {0, 0, width_, rows}, options_, outputs));
        return outputs;
    }

    std::vector<double> Time(int repeats) override {
        shared_.MakeResults(GetTexelsPerDispatch() * 32);
        const harness::BoundBuffer bound[] = {
            {0, &buffers_[0]}, {1, &buffers_[1]}, {2, &buffers_[2]}, {3, &shared_.results}};
        harness::DispatchRequest request;
        request.pipeline = &kernel_;
        request.buffers = bound;
        request.pushConstants = std::as_bytes(std::span(&push_, 1));
        request.groups[0] = groups_;
        std::vector<double> times =
            shared_.TimeWarm([&](int count) { return shared_.Time(request, count); }, repeats);
        for (double& time : times)
            time /= static_cast<double>(GetTexelsPerDispatch());
        return times;
    }

    std::uint64_t GetTexelsPerDispatch() const override { return std::uint64_t{push_.width} * push_.height; }

private:
    SharedDevice& shared_;
    harness::GpuDecoder decoder_;
    int width_;
    DecodeOptions options_;
    NtcDecodeBlocksConstants push_ = {};
    std::uint32_t groups_ = 1;
    harness::ComputePipeline kernel_;
    std::array<harness::Buffer, 3> buffers_;
};

} // namespace

std::unique_ptr<PreparedCase> PrepareOnMatrices(SharedDevice& shared, const Case& c, const Encoding& encoding,
                                                std::string& skipped) {
    const tool::DecodeData& data = encoding.GetData(c.math);
    const auto layout = harness::ProbeCoopMat(*shared.context);
    auto decoder = harness::GpuDecoder::Create(*shared.context, data.GetSource(),
                                               {.matrices = harness::MatrixUse::Required});
    if (!layout || !decoder) {
        skipped = (layout ? decoder.error() : layout.error()).GetText();
        return nullptr;
    }
    const bool hasLanes = decoder->HasMatrixLanes();
    const auto spirv = report_coopmat::FindShader(
        "DecodeBlocks.comp", tool::Format("NETWORK_VERSION=%d NTC_MATH=%d%s", c.network, c.math,
                                          hasLanes ? " NTC_COOPMAT_LANES=1" : ""));
    const int texels = encoding.record.width * encoding.record.height;
    RepeatedSet set = RepeatBelow(data, std::max(1, kMatrixTexels / std::max(1, texels)));
    if (!spirv || set.latents.empty()) {
        skipped = spirv ? "the pass's set cannot be repeated" : spirv.error().GetText();
        return nullptr;
    }
    return std::make_unique<MatrixCase>(shared, c, encoding, std::move(*decoder),
                                        hasLanes ? &**layout : nullptr, std::move(set), *spirv);
}

} // namespace openntc::report
