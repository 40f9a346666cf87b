// SPDX-License-Identifier: MIT
#include "Renderer.h"

#include "Failure.h"
#include "landscape_shaders.h"

#include <algorithm>
#include <cstring>

namespace openntc::landscape {

using harness::BufferKind;
using harness::BufferMemory;
using tool::CommandError;
using tool::ExitCode;
using tool::Require;

namespace {

template <typename T>
std::span<const std::byte> GetBytes(const std::vector<T>& values) {
    return std::as_bytes(std::span(values));
}

} // namespace

Renderer::Renderer(harness::Context& context, const Landscape& landscape, std::uint64_t pixels,
                   const PageTable* table, std::uint64_t poolBytes)
    : context_(context), landscape_(landscape) {
    const bool isTiled = table != nullptr;
    const std::uint64_t latentBytes = isTiled ? poolBytes : landscape.GetLatentBytes();
    const std::uint64_t limit = context.GetDevice().maxStorageBufferBytes;
    if (latentBytes > limit || pixels * sizeof(LandscapePixel) > limit)
        throw CommandError(ExitCode::NoDevice, isTiled ? "--budget" : "--compare",
                           "latents: " + std::to_string(latentBytes) +
                               " bytes, pixels: " + std::to_string(pixels * sizeof(LandscapePixel)) +
                               ": the device binds " + std::to_string(limit));
    scene_ =
        Require(context.CreateBuffer(sizeof(LandscapeScene), BufferKind::Uniform, BufferMemory::HostVisible),
                ExitCode::NoDevice, "device");
    latents_ = Require(context.CreateBuffer(latentBytes, BufferKind::Storage, BufferMemory::DeviceLocal),
                       ExitCode::NoDevice, "device");
    weights_ = Make(GetBytes(landscape.MakeWeights()), BufferKind::Storage);
    std::vector<NtcTextureSetConstants> constants;
    for (const auto& set : landscape.GetSets())
        constants.push_back(set->GetConstants());
    sets_ = Make(GetBytes(constants), BufferKind::Storage);
    for (std::size_t i = 0; i < landscape.GetFields().size(); ++i)
        fieldRows_.push_back(landscape.MakeField(i));
    if (!isTiled)
        UploadAllLatents();
    fields_ = Make(GetBytes(fieldRows_), BufferKind::Storage);
    pixels_ = Make(pixels * sizeof(LandscapePixel));
    colors_ = Make(pixels * 4);
    bound_ = {{0, &scene_},  {1, &latents_}, {2, &weights_}, {3, &sets_},
              {4, &fields_}, {5, &pixels_},  {6, &colors_}};
    if (isTiled) {
        state_ = table->GetLaunchState();
        stateBytes_.resize(state_.GetBytes());
        Require(ClearLaunchState(state_, stateBytes_), ExitCode::Failed, "launch state");
        table_ = Make(table->GetBytes(), BufferKind::Storage);
        launchState_ = Make(stateBytes_, BufferKind::Storage);
        bound_.push_back({0, &table_, 1});
        bound_.push_back({1, &launchState_, 1});
    }
    MakePipeline(isTiled);
}

harness::Buffer Renderer::Make(std::span<const std::byte> bytes, BufferKind kind) {
    return Require(context_.CreateBuffer(bytes, kind, BufferMemory::HostVisible), ExitCode::NoDevice,
                   "device");
}

harness::Buffer Renderer::Make(std::uint64_t bytes) {
    return Require(context_.CreateBuffer(bytes, BufferKind::Storage, BufferMemory::HostVisible),
                   ExitCode::NoDevice, "device");
}

void Renderer::MakePipeline(bool isTiled) {
    const std::string defines = "NETWORK_VERSION=" + std::to_string(landscape_.GetNetworkVersion()) +
                                " NTC_MATH=1 LANDSCAPE_TILED=" + (isTiled ? "1" : "0");
    const auto spirv =
        Require(landscape_shaders::FindShader("Landscape.comp", defines), ExitCode::Failed, "shader");
    std::vector<harness::BufferSlot> slots;
    for (const harness::BoundBuffer& bound : bound_)
        slots.push_back(
            {bound.binding, bound.buffer == &scene_ ? BufferKind::Uniform : BufferKind::Storage, bound.set});
    pipeline_ = Require(context_.CreateComputePipeline(spirv, slots, 0), ExitCode::NoDevice, "pipeline");
}

std::uint64_t Renderer::UploadAllLatents() {
    std::uint64_t offset = 0;
    for (std::size_t i = 0; i < fieldRows_.size(); ++i) {
        const std::vector<std::byte> latents =
            landscape_.GetSetOf(i).MakeLatents(landscape_.GetFields()[i].phase);
        Require(context_.Write(latents_, offset, latents), ExitCode::NoDevice, "device");
        fieldRows_[i].latentsOffset = static_cast<std::uint32_t>(offset);
        offset += latents.size();
    }
    return offset;
}

void Renderer::SetTextures(std::span<const std::uint32_t> textureIds) {
    for (std::size_t i = 0; i < fieldRows_.size(); ++i)
        fieldRows_[i].textureId = textureIds[i];
    Require(context_.Write(fields_, 0, GetBytes(fieldRows_)), ExitCode::NoDevice, "device");
}

Expected<void> Renderer::Upload(const TileUpload& upload) {
    return context_.Write(latents_, upload.offset, upload.bytes);
}

void Renderer::Apply(const LaunchPlan& plan, const PageTable& table) {
    for (const PageTable::ByteRange& range : plan.tableChanges)
        Require(context_.Write(table_, range.offset, table.GetBytes().subspan(range.offset, range.size)),
                ExitCode::NoDevice, "device");
    for (const StateFill& fill : plan.stateFills) {
        const std::vector<std::uint32_t> zeros(fill.words);
        Require(context_.Write(launchState_, std::uint64_t{fill.firstWord} * 4, GetBytes(zeros)),
                ExitCode::NoDevice, "device");
    }
    const NtcRequestQueue queue = {0, 0, state_.queueCapacity, 0};
    Require(context_.Write(launchState_, std::uint64_t{state_.queueWord} * 4,
                           std::as_bytes(std::span(&queue, 1))),
            ExitCode::NoDevice, "device");
}

double Renderer::Draw(const LandscapeScene& scene) {
    Require(context_.Write(scene_, 0, std::as_bytes(std::span(&scene, 1))), ExitCode::NoDevice, "device");
    harness::DispatchRequest request;
    request.pipeline = &pipeline_;
    request.buffers = bound_;
    request.groups[0] = (scene.width + 7) / 8;
    request.groups[1] = (scene.height + 7) / 8;
    const harness::DispatchTiming timing = Require(context_.Dispatch(request), ExitCode::NoDevice, "device");
    return timing.gpuSeconds.value_or(timing.wallSeconds);
}

DemandReadback Renderer::ReadState() {
    Require(context_.Read(launchState_, 0, stateBytes_), ExitCode::NoDevice, "device");
    DemandReadback readback;
    readback.requests = Require(
        ReadRequests(state_,
                     std::span<const std::byte>(stateBytes_).subspan(std::size_t{state_.queueWord} * 4)),
        ExitCode::NoDevice, "device");
    // Words of a vector of bytes: its memory is aligned for any type.
    readback.stamps = {reinterpret_cast<const std::uint32_t*>(stateBytes_.data()) + state_.stampsWord,
                       state_.words - state_.stampsWord};
    return readback;
}

Picture Renderer::ReadPicture(std::uint64_t pixels) {
    Picture picture;
    picture.pixels.resize(pixels);
    picture.colors.resize(pixels);
    Require(context_.Read(pixels_, 0, std::as_writable_bytes(std::span(picture.pixels))), ExitCode::NoDevice,
            "device");
    Require(context_.Read(colors_, 0, std::as_writable_bytes(std::span(picture.colors))), ExitCode::NoDevice,
            "device");
    return picture;
}

} // namespace openntc::landscape
