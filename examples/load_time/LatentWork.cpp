// SPDX-License-Identifier: MIT
#include "LatentWork.h"

#include "Arguments.h"
#include "Failure.h"

#include <atomic>
#include <utility>

namespace openntc::load_time {

using tool::ExitCode;
using tool::Require;

namespace {

constexpr std::pair<Decompressor, const char*> kDecompressors[] = {
    {Decompressor::Cpu, "cpu"}, {Decompressor::Gpu, "gpu"}, {Decompressor::Shader, "shader"}};

} // namespace

const char* GetName(Decompressor decompressor) {
    return kDecompressors[static_cast<std::size_t>(decompressor)].second;
}

Decompressor FindDecompressor(const std::string& name) {
    for (const auto& [decompressor, known] : kDecompressors) {
        if (name == known)
            return decompressor;
    }
    tool::FailUsage("--decompress", name + ": cpu, gpu or shader");
}

std::optional<LatentWork> ReadLatentWork(const TextureSetMetadata& metadata, Stream& stream,
                                         const std::string& name) {
    LatentWork work;
    work.plan = Require(PlanLatentDecompression(metadata, stream, 0, metadata.GetDesc().mips),
                        ExitCode::BadInput, name);
    if (work.plan.tiles.empty())
        return std::nullopt;
    work.upload.resize(static_cast<std::size_t>(work.plan.uploadBytes));
    Require(ReadLatentUploads(work.plan, stream, work.upload), ExitCode::BadInput, name);
    return work;
}

std::vector<std::byte> DecompressOnCpu(LatentWork& work, ThreadTeam& team, const std::string& name) {
    const LatentDecompression& plan = work.plan;
    work.upload.resize(static_cast<std::size_t>(plan.workBytes));
    std::vector<std::byte> latents(static_cast<std::size_t>(plan.latentBytes));
    constexpr std::size_t kNone = ~std::size_t{0};
    std::atomic<std::size_t> corrupt = kNone;
    team.Run(static_cast<int>(plan.tiles.size()), [&](int job, int) {
        const auto tile = static_cast<std::size_t>(job);
        if (!DecompressLatentTile(plan.tiles[tile], work.upload, latents, static_cast<std::uint32_t>(job)))
            corrupt = tile;
    });
    if (corrupt != kNone)
        throw tool::CommandError(ExitCode::BadInput, name, "latents: a tile is corrupt");
    CopyLatents(plan, work.upload, latents);
    return latents;
}

} // namespace openntc::load_time
