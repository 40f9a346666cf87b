// SPDX-License-Identifier: MIT
// Frames.
#include "renderer/gpu/Renderer.h"

#include "renderer/scene/Cameras.h"
#include "renderer/scene/Lights.h"

#include <glm/matrix.hpp>

#include <algorithm>

namespace openntc::renderer {

using namespace openntc::harness;

namespace {

std::size_t At(Pass pass) {
    return static_cast<std::size_t>(pass);
}

std::uint32_t CountGroups(int pixels) {
    return (static_cast<std::uint32_t>(pixels) + 7) / 8;
}

} // namespace

Renderer::Renderer(Context& context, ShaderCache& shaders, Scene& scene, const RenderOptions& options)
    : context_(context), shaders_(shaders), scene_(scene), options_(options), buffers_(context, scene),
      textures_(context, shaders, scene, options_) {
    MakeTargets();
    MakeMaterials();
}

bool Renderer::Apply(const RenderOptions& options) {
    if (!UseSameTextures(options, options_))
        return false;
    const bool hasOtherTargets = options.width != options_.width || options.height != options_.height ||
                                 options.path != options_.path || options.masks != options_.masks;
    const bool isRebuilt = hasOtherTargets || options.filter != options_.filter ||
                           options.stochastic != options_.stochastic || options.counts != options_.counts;
    options_ = options;
    if (hasOtherTargets)
        MakeTargets();
    if (isRebuilt)
        MakeMaterials();
    return true;
}

std::uint64_t Renderer::GetTargetBytes() const {
    std::uint64_t bytes = pixels_.GetSize() + candidates_.GetSize() + lists_.GetSize();
    for (const Image* const image : {&visible_, &depth_, &picture_, &mean_})
        bytes += image->GetBytes();
    return bytes;
}

const Material& Renderer::GetMaterial(std::size_t instance) const {
    const auto primitive = static_cast<std::size_t>(scene_.instances[instance].primitive);
    return scene_.materials[static_cast<std::size_t>(scene_.primitives[primitive].material)];
}

void Renderer::WriteFrame(const Camera& camera, std::uint32_t frame, bool isJittered) {
    const glm::vec2 size(options_.width, options_.height);
    const glm::vec2 jitter = isJittered ? GetJitter(frame) : glm::vec2(0.0f);
    toClip_ = MakeJitteredViewProjection(camera, size, jitter);
    const glm::mat4 projection = MakeProjection(camera, size.x / size.y);
    const glm::mat3 turn(camera.toWorld);
    shader::NtcrFrame constants = {};
    constants.toClip = toClip_;
    constants.eye = glm::vec4(glm::vec3(camera.toWorld[3]), camera.perspective ? 1.0f : 0.0f);
    glm::vec3 center(0.0f, 0.0f, -1.0f), x(0.0f), y(0.0f);
    if (camera.perspective) {
        x.x = 1.0f / projection[0].x;
        y.y = 1.0f / projection[1].y;
        center += 2.0f * (x * (jitter.x / size.x) + y * (jitter.y / size.y));
    }
    constants.rayCenter = glm::vec4(turn * center, 0.0f);
    constants.rayX = glm::vec4(turn * x, 0.0f);
    constants.rayY = glm::vec4(turn * y, 0.0f);
    constants.lights = MakeLights();
    constants.width = options_.width;
    constants.height = options_.height;
    constants.frame = frame;
    constants.seed = options_.seed;
    constants.randomR2 = options_.randomR2 ? 1u : 0u;
    constants.exposure = options_.exposure;
    constants.toneCurve = options_.toneCurve;
    constants.newWeight = 1.0f / static_cast<float>(frame + 1);
    RequireDevice(context_.Write(frame_, 0, std::as_bytes(std::span(&constants, 1))));
}

double Renderer::Draw(const std::vector<std::size_t>& instances, DrawPipelines pipelines, const Image& color,
                      bool clears) {
    std::vector<RasterDraw> draws;
    for (const std::size_t index : instances) {
        const Instance& instance = scene_.instances[index];
        const Primitive& primitive = scene_.primitives[static_cast<std::size_t>(instance.primitive)];
        if (primitive.indexCount == 0)
            continue;
        const MaterialState& state = materials_[static_cast<std::size_t>(primitive.material)];
        RasterDraw& draw = draws.emplace_back();
        draw.pipeline = &(state.*pipelines)[instance.flipped ? 1 : 0];
        draw.buffers = state.buffers;
        draw.images = state.images;
        draw.vertices = primitive.indexCount;
        draw.instance = static_cast<std::uint32_t>(index);
    }
    RasterRequest request;
    request.color = &color;
    request.depth = &depth_;
    request.clearsColor = clears && &color == &visible_; // the picture has the sky already
    request.clearsDepth = clears;
    request.draws = draws;
    return GetSeconds(RequireDevice(context_.Draw(request)));
}

double Renderer::DispatchTiles(ComputePipeline MaterialState::*pipeline, bool overlaps) {
    std::vector<DispatchRequest> requests;
    std::deque<std::array<std::uint32_t, 2>> tiles; // push constants
    for (std::size_t i = 0; i < materials_.size(); ++i) {
        const TileRect rect =
            buffers_.FindTiles(static_cast<int>(i), toClip_, options_.width, options_.height);
        if (rect.columns == 0 || (materials_[i].*pipeline).GetImpl() == nullptr)
            continue;
        DispatchRequest& request = requests.emplace_back();
        request.pipeline = &(materials_[i].*pipeline);
        request.buffers = materials_[i].buffers;
        request.images = materials_[i].images;
        request.pushConstants = std::as_bytes(std::span(tiles.emplace_back(std::array{rect.left, rect.top})));
        request.groups[0] = rect.columns;
        request.groups[1] = rect.rows;
        request.overlapsPrevious = overlaps && requests.size() > 1;
    }
    const BatchTiming timing = RequireDevice(context_.DispatchBatch(requests));
    double seconds = timing.gpuSeconds.empty() ? timing.wallSeconds : 0.0;
    for (const double each : timing.gpuSeconds)
        seconds += each;
    return seconds;
}

std::vector<std::size_t> Renderer::ListInstances(AlphaMode mode) const {
    std::vector<std::size_t> list;
    for (std::size_t i = 0; i < scene_.instances.size(); ++i) {
        if (GetMaterial(i).alphaMode == mode)
            list.push_back(i);
    }
    return list;
}

double Renderer::DispatchScreen(const ComputePipeline& pipeline) {
    DispatchRequest screen;
    screen.buffers = frameBuffers_;
    screen.images = frameImages_;
    screen.groups[0] = CountGroups(options_.width);
    screen.groups[1] = CountGroups(options_.height);
    screen.pipeline = &pipeline;
    return GetSeconds(RequireDevice(context_.Dispatch(screen)));
}

void Renderer::DrawFrame(PassSeconds& seconds) {
    seconds[At(Pass::Sky)] += DispatchScreen(sky_);
    const std::vector<std::size_t> masked = ListInstances(AlphaMode::Mask);
    std::vector<std::size_t> opaque = ListInstances(AlphaMode::Opaque);
    const bool collects = candidates_.GetSize() > 0;
    if (!collects) {
        opaque.insert(opaque.end(), masked.begin(), masked.end());
        std::sort(opaque.begin(), opaque.end());
    }
    // On feedback fragment shaders, too, must know what is hidden.
    if (options_.path == ShadingPath::Compute || textures_.GetFeedback() != nullptr)
        seconds[At(Pass::Visibility)] += Draw(opaque, &MaterialState::draw, visible_, true);
    if (collects)
        seconds[At(Pass::Masks)] += DrawMasks(masked);
    if (options_.path == ShadingPath::Fragment)
        seconds[At(Pass::Shade)] += Draw(opaque, &MaterialState::forward, picture_, true);
    else
        seconds[At(Pass::Shade)] +=
            DispatchTiles(&MaterialState::shade, true); // each pixel is of one material
    if (const std::vector<std::size_t> blended = buffers_.SortBlended(toClip_); !blended.empty())
        seconds[At(Pass::Blend)] += Draw(blended, &MaterialState::forward, picture_, false);
}

PassSeconds Renderer::Render(const Camera& camera, std::uint32_t frame, bool isJittered) {
    WriteFrame(camera, frame, isJittered);
    PassSeconds seconds{};
    DrawFrame(seconds);
    if (FeedbackStore* const feedback = textures_.GetFeedback()) {
        TileSeconds ofTiles;
        isSettled_ = feedback->Advance(ofTiles);
        for (int again = 0; !isSettled_ && again != options_.settle; ++again) {
            DrawFrame(seconds);
            isSettled_ = feedback->Advance(ofTiles);
        }
        seconds[At(Pass::Resolve)] = ofTiles.resolve;
        seconds[At(Pass::Decode)] = ofTiles.decode;
        seconds[At(Pass::Transcode)] = ofTiles.transcode;
    }
    seconds[At(Pass::Accumulate)] = DispatchScreen(accumulate_);
    return seconds;
}

std::vector<std::uint8_t> Renderer::ReadPicture() {
    std::vector<std::uint8_t> texels(static_cast<std::size_t>(pixels_.GetSize()));
    RequireDevice(context_.Read(pixels_, 0, std::as_writable_bytes(std::span(texels))));
    return texels;
}

TexelCounts Renderer::TakeCounts() {
    std::array<std::uint32_t, 4> words{};
    RequireDevice(context_.Read(counters_, 0, std::as_writable_bytes(std::span(words))));
    const std::array<std::uint32_t, 4> none{};
    RequireDevice(context_.Write(counters_, 0, std::as_bytes(std::span(none))));
    return {words[0] | std::uint64_t{words[1]} << 32, words[2] | std::uint64_t{words[3]} << 32};
}

} // namespace openntc::renderer
