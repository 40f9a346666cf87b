// SPDX-License-Identifier: MIT
#include "StreamedLandscape.h"

#include "Failure.h"
#include "Interrupt.h"
#include "RepeatedTileSource.h"

#include <algorithm>
#include <chrono>

namespace openntc::landscape {

using tool::CommandError;
using tool::ExitCode;
using tool::Require;

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::uint32_t kQueueCapacity = 8192; ///< requests of a pass; more are made again by the next one

double GetMilliseconds(Clock::time_point since) {
    return std::chrono::duration<double, std::milli>(Clock::now() - since).count();
}

std::uint64_t GetBudgetBytes(const Landscape& landscape, double mebibytes) {
    if (mebibytes > 0)
        return static_cast<std::uint64_t>(mebibytes * 1048576.0);
    return std::min<std::uint64_t>(std::uint64_t{64} << 20, landscape.GetLatentBytes() / 8);
}

} // namespace

StreamedLandscape::StreamedLandscape(harness::Context& context, const Landscape& landscape,
                                     const SessionOptions& options)
    : landscape_(landscape), options_(options) {
    slotBytes_ = (landscape.GetLargestTileBytes() + 15) / 16 * 16;
    slots_ = static_cast<std::uint32_t>(GetBudgetBytes(landscape, options.budget) / slotBytes_);
    // Beside the tails, which stay, a tile of each finer level of at least one field.
    const std::size_t least = landscape.GetFields().size() + 4;
    if (slots_ < least)
        throw CommandError(ExitCode::Usage, "--budget",
                           std::to_string(slots_) + " tiles of " + std::to_string(slotBytes_) +
                               " bytes: the tails of all sets, and a few tiles, take " +
                               std::to_string(least));
    CreateLoader();
    const std::uint64_t pixels = static_cast<std::uint64_t>(options.width * options.height) *
                                 static_cast<std::uint64_t>(options.samples * options.samples);
    renderer_.emplace(context, landscape, pixels, &loader_->GetPageTable(),
                      std::uint64_t{slots_} * slotBytes_);
    AddTextures();
}

void StreamedLandscape::CreateLoader() {
    DemandLoaderOptions options;
    options.table.maxTextures = static_cast<std::uint32_t>(landscape_.GetFields().size());
    options.table.maxTiles = landscape_.GetTileCount();
    options.table.maxSlots = slots_;
    options.table.maxSlices = slots_;
    options.table.maxTailRows = options.table.maxTextures * static_cast<std::uint32_t>(landscape_.GetMips());
    options.table.queueCapacity = kQueueCapacity;
    options.slots = slots_;
    options.slotBytes = slotBytes_;
    options.maxOutstanding = 4096;
    options.framesInFlight = 1; // every pass is waited for
    options.threads = options_.threads;
    loader_.emplace(Require(DemandLoader::Create(options), ExitCode::Failed, "loader"));
}

void StreamedLandscape::AddTextures() {
    for (std::size_t i = 0; i < landscape_.GetFields().size(); ++i) {
        const Shared<RepeatedTileSource> source =
            Require(MakeShared<RepeatedTileSource>(GetDefaultAllocator(), landscape_.GetSetOf(i),
                                                   landscape_.GetFields()[i].phase),
                    ExitCode::Failed, "loader");
        TiledTextureDesc desc;
        desc.format = TileFormat::TextureSet;
        desc.textureSet = static_cast<std::uint32_t>(landscape_.GetFields()[i].set);
        desc.hasFeedback = false; // requests say what is wanted
        const DemandId id = Require(loader_->CreateTexture(source, desc), ExitCode::Failed, "loader");
        textureIds_.push_back(id.index);
    }
    renderer_->SetTextures(textureIds_);
    loader_->WaitIdle(); // tails: the first pass then sees something everywhere
}

void StreamedLandscape::ReportErrors() {
    DemandError error;
    if (loader_->TakeError(error))
        throw CommandError(ExitCode::Failed, "tile " + std::to_string(error.tile), error.error.GetText());
}

void StreamedLandscape::WaitFor(const DemandTicket& ticket) const {
    while (!ticket.WaitFor(100))
        tool::ThrowIfInterrupted();
}

void StreamedLandscape::DrawPass(LandscapeScene& scene, FrameRecord& record) {
    tool::ThrowIfInterrupted();
    const Clock::time_point start = Clock::now();
    DemandLimits limits;
    if (options_.tilesPerPass > 0)
        limits.maxTiles = static_cast<std::uint32_t>(options_.tilesPerPass);
    const LaunchPlan plan = Require(loader_->LaunchPrepare(*renderer_, limits), ExitCode::Failed, "loader");
    renderer_->Apply(plan, loader_->GetPageTable());
    record.loaderMilliseconds += GetMilliseconds(start);

    scene.launch = loader_->GetPageTable().MakeConstants(plan.context.round);
    record.passMilliseconds += 1000.0 * renderer_->Draw(scene);

    const Clock::time_point drawn = Clock::now();
    const DemandReadback readback = renderer_->ReadState();
    const auto ticket = Require(loader_->ProcessRequests(plan.context, readback), ExitCode::Failed, "loader");
    record.loaderMilliseconds += GetMilliseconds(drawn);
    const Clock::time_point waiting = Clock::now();
    if (options_.passes == 0)
        WaitFor(ticket);
    record.waitMilliseconds += GetMilliseconds(waiting);
    ReportErrors();

    ++record.passes;
    record.missing = static_cast<std::uint32_t>(readback.requests.GetCount()) + readback.requests.overflow;
    record.wanted = record.missing + static_cast<std::uint32_t>(std::count(
                                         readback.stamps.begin(), readback.stamps.end(), plan.context.round));
}

FrameRecord StreamedLandscape::DrawFrame(LandscapeScene scene) {
    const DemandStatistics before = loader_->GetStatistics();
    const Clock::time_point start = Clock::now();
    FrameRecord record;
    DemandState state = DemandState::Working;
    while (state == DemandState::Working && (options_.passes == 0 || record.passes < options_.passes)) {
        DrawPass(scene, record);
        state = loader_->GetProgress().state;
    }
    record.milliseconds = GetMilliseconds(start);
    record.isComplete = record.missing == 0;
    const DemandStatistics after = loader_->GetStatistics();
    record.resident = after.residentTiles;
    record.residentBytes = after.bytesInUse;
    record.loaded = after.uploaded - before.uploaded;
    record.evicted = after.freed - before.freed;
    record.requested = after.requested - before.requested;
    return record;
}

void StreamedLandscape::Describe(Report& report) const {
    report.slots = slots_;
    report.slotBytes = slotBytes_;
    report.budgetBytes = std::uint64_t{slots_} * slotBytes_;
    report.tableBytes =
        loader_->GetPageTable().GetBytes().size() + loader_->GetPageTable().GetLaunchState().GetBytes();
}

} // namespace openntc::landscape
