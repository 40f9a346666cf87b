// SPDX-License-Identifier: MIT
#include "LatentDecompression.h"

#include "gdeflate_shaders.h"

#include "openntc/passes/GDeflatePass.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

namespace openntc::harness {

Expected<LatentDecompressor> LatentDecompressor::Create(Context& context, TileDecoder decoder) {
    LatentDecompressor made(context, decoder);
    if (decoder == TileDecoder::Device) {
        const DeviceInfo& device = context.GetDevice();
        if (!device.features.Has(Feature::MemoryDecompression))
            return Fail(Status::Unsupported, "device or feature absent: %s: %s",
                        device.features.GetAbsence(Feature::MemoryDecompression).c_str(),
                        device.name.c_str());
        return made;
    }
    static constexpr BufferSlot kSlots[] = {{0, BufferKind::Storage},
                                            {1, BufferKind::Storage},
                                            {2, BufferKind::Storage},
                                            {3, BufferKind::Storage}};
    OPENNTC_ASSIGN(const auto shader, gdeflate_shaders::FindShader("DecompressGDeflate.comp", ""));
    OPENNTC_ASSIGN(made.pipeline_,
                   context.CreateComputePipeline(shader, kSlots, sizeof(NtcGDeflateConstants)));
    OPENNTC_ASSIGN(made.corrupt_, context.CreateBuffer(4, BufferKind::Storage, BufferMemory::HostVisible));
    return made;
}

void LatentDecompressor::Clear() {
    tiles_.clear();
    copies_.clear();
    works_.clear();
    tileBuffers_.clear();
}

Expected<void> LatentDecompressor::Add(const LatentDecompression& plan, const Buffer& work,
                                       const Buffer& latents) {
    for (const LatentCopy& copy : plan.copies)
        copies_.push_back({&work, copy.source, &latents, copy.destination, copy.bytes});
    if (decoder_ == TileDecoder::Shader)
        return AddShaderWork(plan, work, latents);
    for (const LatentTile& tile : plan.tiles)
        tiles_.push_back({&work, tile.source, tile.sourceBytes, tile.isInWork ? &work : &latents,
                          tile.destination, tile.bytes});
    return {};
}

Expected<void> LatentDecompressor::AddShaderWork(const LatentDecompression& plan, const Buffer& work,
                                                 const Buffer& latents) {
    if (plan.tiles.empty())
        return {};
    OPENNTC_ASSIGN(const GDeflatePass pass, MakeGDeflatePass(plan));
    OPENNTC_ASSIGN(Buffer tiles, context_->CreateBuffer(std::as_bytes(pass.tiles.AsSpan()),
                                                        BufferKind::Storage, BufferMemory::DeviceLocal));
    const Buffer& kept = tileBuffers_.emplace_back(std::move(tiles));
    for (const auto& [dispatch, output] : {std::pair(&pass.intoLatents, &latents), {&pass.intoWork, &work}}) {
        if (dispatch->constants.tiles == 0)
            continue;
        Work& added = works_.emplace_back();
        added.tiles = &kept;
        added.work = &work;
        added.output = output;
        const auto constants = std::as_bytes(std::span(&dispatch->constants, 1));
        added.constants.assign(constants.begin(), constants.end());
        std::copy(std::begin(dispatch->groups), std::end(dispatch->groups), std::begin(added.groups));
    }
    return {};
}

Expected<double> LatentDecompressor::RunShader() {
    const std::array<std::byte, 4> zero{};
    OPENNTC_CHECK(context_->Write(corrupt_, 0, zero));
    std::vector<std::array<BoundBuffer, 4>> bound;
    for (const Work& work : works_)
        bound.push_back({{{0, work.tiles}, {1, work.work}, {2, work.output}, {3, &corrupt_}}});
    std::vector<DispatchRequest> requests;
    for (std::size_t i = 0; i < works_.size(); ++i) {
        DispatchRequest& request = requests.emplace_back();
        request.pipeline = &pipeline_;
        request.buffers = bound[i];
        request.pushConstants = works_[i].constants;
        request.overlapsPrevious = i > 0;
        std::copy(std::begin(works_[i].groups), std::end(works_[i].groups), std::begin(request.groups));
    }
    OPENNTC_ASSIGN(const BatchTiming timing, context_->DispatchBatch(requests));
    std::array<std::byte, 4> word{};
    OPENNTC_CHECK(context_->Read(corrupt_, 0, word));
    if (word != zero)
        return Fail(Status::FileUnrecognized, "GDeflate: %u tiles: corrupt",
                    container::detail::LoadLittleEndian<std::uint32_t>(word, 0));
    return timing.gpuSeconds.empty()
               ? timing.wallSeconds
               : std::accumulate(timing.gpuSeconds.begin(), timing.gpuSeconds.end(), 0.0);
}

Expected<double> LatentDecompressor::Run() {
    double seconds = 0.0;
    if (!works_.empty()) {
        OPENNTC_ASSIGN(seconds, RunShader());
    }
    if (tiles_.empty() && copies_.empty())
        return seconds;
    OPENNTC_ASSIGN(const DispatchTiming timing, context_->Decompress(tiles_, copies_));
    return seconds + timing.gpuSeconds.value_or(timing.wallSeconds);
}

} // namespace openntc::harness
