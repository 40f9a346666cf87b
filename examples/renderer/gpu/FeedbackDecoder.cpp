// SPDX-License-Identifier: MIT
#include "renderer/gpu/FeedbackDecoder.h"

#include "renderer/gpu/RequireDevice.h"

#include <algorithm>
#include <chrono>

namespace openntc::renderer {

using namespace openntc::harness;

namespace {

constexpr std::size_t kScratchAcross = 4; // tiles of a side of a scratch image

/// Requests with what their spans refer to.
struct RequestList {
    std::deque<std::vector<BoundBuffer>> buffers;
    std::deque<std::vector<BoundImage>> images;
    std::deque<ComputePipeline> pipelines;
    std::vector<DispatchRequest> requests;

    DispatchRequest& Add(ComputePipeline pipeline, std::vector<BoundBuffer> boundBuffers,
                         std::vector<BoundImage> boundImages, const std::uint32_t (&groups)[3]) {
        DispatchRequest& request = requests.emplace_back();
        request.pipeline = &pipelines.emplace_back(std::move(pipeline));
        request.buffers = buffers.emplace_back(std::move(boundBuffers));
        request.images = images.emplace_back(std::move(boundImages));
        std::copy(std::begin(groups), std::end(groups), std::begin(request.groups));
        request.overlapsPrevious = requests.size() > 1;
        return request;
    }
};

/// lavapipe 22.3 writes the first timestamp behind the dispatches where there were draws before.
double GetSeconds(const BatchTiming& timing, bool isCpu) {
    return isCpu || timing.gpuSeconds.empty() ? timing.wallSeconds : timing.gpuSeconds.front();
}

std::uint32_t RoundToBlocks(int texels) {
    return static_cast<std::uint32_t>((texels + 3) / 4 * 4);
}

} // namespace

void FeedbackDecoder::Run(std::span<const TileJob> jobs, TileSeconds& seconds) {
    for (std::size_t first = 0; first < jobs.size(); first += kScratchAcross * kScratchAcross)
        RunBatch(jobs.subspan(first, std::min(jobs.size() - first, kScratchAcross * kScratchAcross)),
                 seconds);
}

std::uint64_t FeedbackDecoder::GetBytes() const {
    std::uint64_t bytes = blocks_.GetSize();
    for (const auto& [key, image] : scratch_)
        bytes += image.GetBytes();
    for (const Buffer& buffer : constants_)
        bytes += buffer.GetSize();
    return bytes;
}

void FeedbackDecoder::RunBatch(std::span<const TileJob> jobs, TileSeconds& seconds) {
    const std::vector<Piece> pieces = Decode(jobs, seconds);
    Transcode(pieces, seconds);
    const auto start = std::chrono::steady_clock::now();
    CopyTexels(pieces);
    seconds.transcode += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

std::vector<const Image*> FeedbackDecoder::FindScratch(const StreamedSet& set) {
    std::map<ImageFormat, std::size_t> used;
    std::vector<const Image*> images;
    for (const SlotPlan& slot : set.slots) {
        const ImageFormat format = GetTexelFormat(slot);
        const auto side = static_cast<std::uint32_t>(kScratchAcross) * static_cast<std::uint32_t>(tileSize_);
        const auto [found, isNew] = scratch_.try_emplace({format, used[format]++});
        if (isNew)
            found->second = RequireDevice(context_.CreateImage(format, side, side));
        images.push_back(&found->second);
    }
    return images;
}

const Buffer& FeedbackDecoder::GetConstants(std::size_t number) {
    while (constants_.size() <= number)
        constants_.push_back(RequireDevice(context_.CreateBuffer(
            sizeof(NtcDecompressConstants), BufferKind::Uniform, BufferMemory::DeviceLocal)));
    return constants_[number];
}

std::vector<FeedbackDecoder::Piece> FeedbackDecoder::Decode(std::span<const TileJob> jobs,
                                                            TileSeconds& seconds) {
    static constexpr BufferSlot kSlots[] = {{0, BufferKind::Uniform},
                                            {1, BufferKind::Storage},
                                            {2, BufferKind::Storage},
                                            {0, BufferKind::Image, 1, NTC_DECOMPRESS_OUTPUTS}};
    SceneNeeds needs;
    needs.device = device_;
    std::vector<Piece> pieces;
    std::deque<DecompressionPass> passes;
    std::vector<BufferWrite> writes;
    RequestList list;
    for (std::size_t i = 0; i < jobs.size(); ++i) {
        const TileJob& job = jobs[i];
        const std::vector<const Image*> images = FindScratch(*job.set);
        const int left = static_cast<int>(i % kScratchAcross) * tileSize_;
        const int top = static_cast<int>(i / kScratchAcross) * tileSize_;
        for (const TilePart& part : GetTileParts(job.set->layout, job.tile)) {
            DecompressionRequest request;
            request.mip = part.mip;
            request.rect = part.rect;
            request.destination = TexelOffset{left + part.left, top + part.top};
            request.outputs = job.set->outputs;
            const DecompressionPass& pass = passes.emplace_back(
                RequireDevice(MakeDecompressionPass(*job.set->metadata, job.set->constants, request, needs)));
            const Buffer& constants = GetConstants(writes.size());
            writes.push_back({&constants, 0, std::as_bytes(std::span(&pass.constants, 1))});
            std::vector<BoundImage> bound;
            for (std::uint32_t n = 0; n < NTC_DECOMPRESS_OUTPUTS; ++n) // an array without holes
                bound.push_back({0, images[n < images.size() ? n : 0], 1, n});
            list.Add(RequireDevice(context_.CreateComputePipeline(
                         shaders_.Get("DecompressToTextures.comp", ListDefines(pass)), kSlots, 0)),
                     {{0, &constants}, {1, &job.set->latents}, {2, &job.set->weights}}, std::move(bound),
                     pass.groups);
            for (std::size_t n = 0; n < images.size(); ++n)
                pieces.push_back({images[n],
                                  &(*job.atlases)[n],
                                  &job.set->slots[n],
                                  {left + part.left, top + part.top, part.rect.width, part.rect.height},
                                  {job.left + static_cast<std::uint32_t>(part.left),
                                   job.top + static_cast<std::uint32_t>(part.top), job.layer,
                                   static_cast<std::uint32_t>(part.rect.width),
                                   static_cast<std::uint32_t>(part.rect.height)}});
        }
    }
    RequireDevice(context_.Write(writes));
    seconds.decode += GetSeconds(RequireDevice(context_.DispatchBatch(list.requests)), device_.isCpu);
    return pieces;
}

void FeedbackDecoder::Transcode(const std::vector<Piece>& pieces, TileSeconds& seconds) {
    static constexpr BufferSlot kSlots[] = {{0, BufferKind::Texture}, {1, BufferKind::Storage}};
    std::deque<bc::BlockCompressionPass> passes;
    std::map<const Image*, std::vector<BufferToImage>> copies;
    std::vector<const Piece*> compressed;
    std::uint64_t words = 0;
    for (const Piece& piece : pieces) {
        if (!piece.slot->block)
            continue;
        bc::BlockCompressionDesc desc = MakeBlockDesc(*piece.slot, effort_, device_);
        desc.left = piece.from.left;
        desc.top = piece.from.top;
        desc.width = piece.from.width;
        desc.height = piece.from.height;
        desc.sourceWidth = static_cast<std::int32_t>(piece.texels->GetWidth());
        desc.sourceHeight = static_cast<std::int32_t>(piece.texels->GetHeight());
        desc.destinationRows.firstWord = static_cast<std::uint32_t>(words);
        const bc::BlockCompressionPass& pass =
            passes.emplace_back(RequireDevice(bc::MakeBlockCompressionPass(desc)));
        ImageRegion to = piece.to;
        to.width = RoundToBlocks(piece.from.width);
        to.height = RoundToBlocks(piece.from.height);
        copies[piece.atlas].push_back({4 * words, to});
        words = (pass.destinationWords + 3) / 4 * 4; // blocks begin at multiples of 16 bytes
        compressed.push_back(&piece);
    }
    if (passes.empty())
        return;
    if (blocks_.GetSize() < 4 * words)
        blocks_ =
            RequireDevice(context_.CreateBuffer(4 * words, BufferKind::Storage, BufferMemory::DeviceLocal));
    RequestList list;
    for (std::size_t i = 0; i < passes.size(); ++i) {
        DispatchRequest& request =
            list.Add(RequireDevice(context_.CreateComputePipeline(
                         shaders_.Get("CompressBlocks.comp", SplitDefines(passes[i].defines.View())), kSlots,
                         sizeof passes[i].constants)),
                     {{1, &blocks_}}, {{0, compressed[i]->texels}}, passes[i].groups);
        request.pushConstants = std::as_bytes(std::span(&passes[i].constants, 1));
    }
    seconds.transcode += GetSeconds(RequireDevice(context_.DispatchBatch(list.requests)), device_.isCpu);
    const auto start = std::chrono::steady_clock::now();
    for (const auto& [atlas, regions] : copies)
        RequireDevice(context_.Copy(blocks_, *atlas, regions));
    seconds.transcode += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void FeedbackDecoder::CopyTexels(const std::vector<Piece>& pieces) {
    std::map<std::pair<const Image*, const Image*>, std::vector<ImageToImage>> copies;
    for (const Piece& piece : pieces) {
        if (!piece.slot->block)
            copies[{piece.texels, piece.atlas}].push_back({static_cast<std::uint32_t>(piece.from.left),
                                                           static_cast<std::uint32_t>(piece.from.top), 0,
                                                           piece.to});
    }
    for (const auto& [images, regions] : copies)
        RequireDevice(context_.Copy(*images.first, *images.second, regions));
}

} // namespace openntc::renderer
