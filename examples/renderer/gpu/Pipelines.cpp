// SPDX-License-Identifier: MIT
// The renderer's pipelines and what is bound to them.
#include "renderer/gpu/Renderer.h"

#include "Output.h"

#include <algorithm>

namespace openntc::renderer {

using namespace openntc::harness;

namespace {

// Bindings of shaders/Scene.glsl, Shade.glsl and MaterialTexels.glsl.
constexpr std::uint32_t kEnvironment = 4, kCounters = 5, kVisible = 6, kPicture = 7, kCandidates = 10,
                        kLists = 11, kDepth = 12;
constexpr std::uint32_t kMaterialSet = 1, kFirstImage = 1, kSetConstants = 8, kSetLatents = 9,
                        kSetWeights = 10;

std::vector<BufferSlot> ListFrameSlots() {
    return {{0, BufferKind::Uniform},
            {1, BufferKind::Storage},
            {2, BufferKind::Storage},
            {3, BufferKind::Storage}};
}

bool Decodes(const std::array<SlotPlan, kTextureSlotCount>& textures) {
    return std::any_of(textures.begin(), textures.end(),
                       [](const SlotPlan& slot) { return slot.source == TexelSource::Set; });
}

void AddMaterialSlots(std::vector<BufferSlot>& slots, const std::array<SlotPlan, kTextureSlotCount>& textures,
                      bool isTiled) {
    slots.push_back({kCounters, BufferKind::Storage});
    slots.push_back({0, BufferKind::Uniform, kMaterialSet});
    for (std::uint32_t i = 0; i < textures.size(); ++i) {
        if (textures[i].source == TexelSource::Image || textures[i].source == TexelSource::Decoded)
            slots.push_back({kFirstImage + i, BufferKind::Texture, kMaterialSet});
    }
    if (isTiled && HasDecoded(textures))
        FeedbackStore::AddSlots(slots);
    if (!Decodes(textures))
        return;
    slots.push_back({kSetConstants, BufferKind::Uniform, kMaterialSet});
    slots.push_back({kSetLatents, BufferKind::Storage, kMaterialSet});
    slots.push_back({kSetWeights, BufferKind::Storage, kMaterialSet});
}

std::vector<std::string> WithFilter(std::vector<std::string> defines, Stochastic filter) {
    defines.push_back(tool::Format("NTCR_FILTER=%d", static_cast<int>(filter)));
    return defines;
}

/// Where lanes have no known arrangement and some are helpers: one texel, or all of them.
Stochastic GetFragmentFilter(Stochastic filter) {
    return filter == Stochastic::OneTap || filter == Stochastic::Quads ? Stochastic::OneTap : Stochastic::Off;
}

shader::NtcrMaterial MakeConstants(const Material& material, const MaterialPlan& plan, std::size_t index) {
    shader::NtcrMaterial constants = {};
    constants.baseColor = material.baseColorFactor;
    constants.specularGlossiness = glm::vec4(material.specularFactor, material.glossinessFactor);
    constants.emissive = glm::vec4(material.emissiveFactor, material.transmissionFactor);
    constants.metallic = material.metallicFactor;
    constants.roughness = material.roughnessFactor;
    constants.normalScale = material.normalScale;
    constants.occlusionStrength = material.occlusionStrength;
    constants.alphaCutoff = material.alphaCutoff;
    constants.index = static_cast<std::uint32_t>(index);
    std::copy(plan.lookups.begin(), plan.lookups.end(), std::begin(constants.lookups));
    return constants;
}

} // namespace

void Renderer::MakeTargets() {
    const auto width = static_cast<std::uint32_t>(options_.width),
               height = static_cast<std::uint32_t>(options_.height);
    visible_ = RequireDevice(context_.CreateImage(ImageFormat::RG32UI, width, height));
    depth_ = RequireDevice(context_.CreateImage(ImageFormat::D32, width, height));
    picture_ = RequireDevice(context_.CreateImage(ImageFormat::RGBA32F, width, height));
    mean_ = RequireDevice(context_.CreateImage(ImageFormat::RGBA32F, width, height));
    frame_ = RequireDevice(
        context_.CreateBuffer(sizeof(shader::NtcrFrame), BufferKind::Uniform, BufferMemory::DeviceLocal));
    counters_ = RequireDevice(context_.CreateBuffer(16, BufferKind::Storage, BufferMemory::DeviceLocal));
    pixels_ = RequireDevice(context_.CreateBuffer(std::uint64_t{4} * width * height, BufferKind::Storage,
                                                  BufferMemory::DeviceLocal));
    frameBuffers_ = {{0, &frame_},
                     {1, &buffers_.GetVertices()},
                     {2, &buffers_.GetIndices()},
                     {3, &buffers_.GetInstances()},
                     {kEnvironment, &buffers_.GetEnvironment()},
                     {kCounters, &counters_},
                     {9, &pixels_}};
    frameImages_ = {{kVisible, &visible_}, {kPicture, &picture_}, {8, &mean_}};
    MakeMaskTargets();
    std::vector<BufferSlot> slots = ListFrameSlots();
    slots.push_back({kPicture, BufferKind::Image});
    sky_ = RequireDevice(context_.CreateComputePipeline(shaders_.Get("Sky.comp", {}), slots, 0));
    slots.push_back({8, BufferKind::Image});
    slots.push_back({9, BufferKind::Storage});
    accumulate_ =
        RequireDevice(context_.CreateComputePipeline(shaders_.Get("Accumulate.comp", {}), slots, 0));
}

bool Renderer::IsShown(int material) const {
    return std::any_of(scene_.instances.begin(), scene_.instances.end(), [&](const Instance& instance) {
        return scene_.primitives[static_cast<std::size_t>(instance.primitive)].material == material;
    });
}

void Renderer::MakeMaterials() {
    plans_.clear();
    materials_.clear();
    RenderOptions options = options_;
    options.math = textures_.GetMath().math;
    for (std::size_t i = 0; i < scene_.materials.size(); ++i) {
        // What nothing shows costs nothing.
        plans_.push_back(IsShown(static_cast<int>(i))
                             ? PlanMaterial(scene_, scene_.materials[i], textures_.GetSets(), options,
                                            textures_.GetFeatures())
                             : MaterialPlan());
    }
    textures_.Load(plans_);
    for (std::size_t i = 0; i < plans_.size(); ++i) {
        MaterialState& state = materials_.emplace_back();
        if (!IsShown(static_cast<int>(i)))
            continue;
        shader::NtcrMaterial constants = MakeConstants(scene_.materials[i], plans_[i], i);
        for (std::size_t n = 0; n < plans_[i].lookups.size(); ++n)
            constants.lookups[n].tiles = textures_.FindTiles(plans_[i].lookupSets[n]);
        state.constants = RequireDevice(context_.CreateBuffer(
            std::as_bytes(std::span(&constants, 1)), BufferKind::Uniform, BufferMemory::DeviceLocal));
        BindMaterial(state, plans_[i]);
        MakePipelines(state, scene_.materials[i], plans_[i]);
    }
}

void Renderer::BindMaterial(MaterialState& state, const MaterialPlan& plan) {
    state.buffers = frameBuffers_;
    state.images = frameImages_;
    state.buffers.push_back({0, &state.constants, kMaterialSet});
    for (std::size_t i = 0; i < plan.slots.size(); ++i) {
        const SlotPlan& slot = plan.slots[i];
        if (slot.source == TexelSource::Image || slot.source == TexelSource::Decoded)
            state.images.push_back(
                {kFirstImage + static_cast<std::uint32_t>(i), &textures_.GetImage(slot, i), kMaterialSet});
    }
    if (const FeedbackStore* const feedback = textures_.GetFeedback())
        feedback->AddBuffers(state.buffers);
    if (plan.set < 0)
        return;
    const DeviceSet& set = textures_.GetSet(plan.set);
    state.buffers.push_back({kSetConstants, &set.constants, kMaterialSet});
    state.buffers.push_back({kSetLatents, &set.latents, kMaterialSet});
    state.buffers.push_back({kSetWeights, &set.weights, kMaterialSet});
}

std::array<ComputePipeline, 2> Renderer::MakeDraws(const char* fragment,
                                                   const std::vector<std::string>& defines,
                                                   const std::vector<BufferSlot>& slots,
                                                   const Material& material, RasterState state) {
    const auto vertices = shaders_.Get("Triangles.vert", {});
    const auto pixels = shaders_.Get(fragment, defines);
    std::array<ComputePipeline, 2> pipelines;
    for (std::size_t flipped = 0; flipped < 2; ++flipped) {
        state.culling = material.doubleSided ? Culling::None : flipped != 0 ? Culling::Front : Culling::Back;
        pipelines[flipped] = RequireDevice(context_.CreateRasterPipeline(vertices, pixels, slots, 0, state));
    }
    return pipelines;
}

void Renderer::MakeVisibility(MaterialState& state, const Material& material, const MaterialPlan& plan) {
    const bool isMasked = material.alphaMode == AlphaMode::Mask;
    if (isMasked && candidates_.GetSize() > 0) {
        MakeMaskPipelines(state, material, plan);
        return;
    }
    std::vector<BufferSlot> slots = ListFrameSlots();
    std::vector<std::string> defines;
    if (isMasked) {
        AddMaterialSlots(slots, plan.maskSlots, textures_.GetFeedback() != nullptr);
        defines = WithFilter(plan.maskDefines, GetFragmentFilter(options_.stochastic));
    }
    RasterState raster;
    raster.color = ImageFormat::RG32UI;
    state.draw = MakeDraws("Visibility.frag", defines, slots, material, raster);
}

void Renderer::MakePipelines(MaterialState& state, const Material& material, const MaterialPlan& plan) {
    const bool isBlended = material.alphaMode == AlphaMode::Blend;
    const bool isMasked = material.alphaMode == AlphaMode::Mask;
    const bool isTiled = textures_.GetFeedback() != nullptr;
    std::vector<BufferSlot> shading = ListFrameSlots();
    shading.push_back({kEnvironment, BufferKind::Storage});
    AddMaterialSlots(shading, plan.slots, isTiled);
    const Stochastic ofFragments = GetFragmentFilter(options_.stochastic);
    const bool isShadedInFragments = isBlended || options_.path == ShadingPath::Fragment;
    const bool isInVisibility = !isBlended && (isTiled || !isShadedInFragments);
    if (isInVisibility) {
        MakeVisibility(state, material, plan);
        shading.push_back({kVisible, BufferKind::Texture});
    }
    if (isShadedInFragments) {
        std::vector<std::string> defines = WithFilter(plan.defines, ofFragments);
        if (isBlended)
            defines.emplace_back("NTCR_BLENDED=1");
        if (isInVisibility)
            defines.emplace_back("NTCR_VISIBLE=1");
        else if (isMasked)
            defines.emplace_back("NTCR_MASKED=1");
        RasterState raster;
        raster.color = ImageFormat::RGBA32F;
        raster.blends = isBlended;
        raster.writesDepth = !isBlended;
        state.forward = MakeDraws("Forward.frag", defines, shading, material, raster);
        return;
    }
    shading.push_back({kPicture, BufferKind::Image});
    state.shade = RequireDevice(context_.CreateComputePipeline(
        shaders_.Get("ShadeTiles.comp", WithFilter(plan.defines, options_.stochastic)), shading,
        2 * sizeof(std::uint32_t)));
}

void Renderer::MakeMaskTargets() {
    candidates_ = Buffer();
    lists_ = Buffer();
    bool hasMasks = false;
    for (const Instance& instance : scene_.instances) {
        const Primitive& primitive = scene_.primitives[static_cast<std::size_t>(instance.primitive)];
        hasMasks = hasMasks || (scene_.materials[static_cast<std::size_t>(primitive.material)].alphaMode ==
                                    AlphaMode::Mask &&
                                primitive.indexCount > 0);
    }
    if (!hasMasks || options_.path == ShadingPath::Fragment || options_.masks == MaskPath::Fragment)
        return;
    const std::uint64_t pixels =
        static_cast<std::uint64_t>(options_.width) * static_cast<std::uint64_t>(options_.height);
    // Grows when a frame has more (CollectCandidates).
    candidates_ = RequireDevice(
        context_.CreateBuffer(16 + 16 * (pixels / 4 + 1), BufferKind::Storage, BufferMemory::DeviceLocal));
    lists_ = RequireDevice(context_.CreateBuffer(8 * pixels, BufferKind::Storage, BufferMemory::DeviceLocal));
    frameBuffers_.push_back({kCandidates, &candidates_});
    frameBuffers_.push_back({kLists, &lists_});
    frameImages_.push_back({kDepth, &depth_});
    const BufferSlot slots[] = {{0, BufferKind::Uniform},           {1, BufferKind::Storage},
                                {2, BufferKind::Storage},           {3, BufferKind::Storage},
                                {kCandidates, BufferKind::Storage}, {kLists, BufferKind::Storage}};
    clearCandidates_ =
        RequireDevice(context_.CreateComputePipeline(shaders_.Get("ClearCandidates.comp", {}), slots, 0));
}

void Renderer::MakeMaskPipelines(MaterialState& state, const Material& material, const MaterialPlan& plan) {
    std::vector<BufferSlot> drawing = ListFrameSlots();
    drawing.push_back({kCandidates, BufferKind::Storage});
    drawing.push_back({kLists, BufferKind::Storage});
    RasterState raster;
    raster.color = ImageFormat::RG32UI;
    raster.passesEqual = true; // of equals the first instance is there: ResolveMasks.comp sees to that
    state.draw = MakeDraws("DrawMasks.frag", {}, drawing, material, raster);
    raster.writesColor = raster.writesDepth = false;
    state.collect = MakeDraws("CollectCandidates.frag", {}, drawing, material, raster);
    AddMaterialSlots(drawing, plan.maskSlots, textures_.GetFeedback() != nullptr);
    drawing.push_back({kVisible, BufferKind::Texture});
    drawing.push_back({kDepth, BufferKind::Texture});
    state.resolve = RequireDevice(context_.CreateComputePipeline(
        shaders_.Get("ResolveMasks.comp",
                     WithFilter(plan.maskDefines, GetFragmentFilter(options_.stochastic))),
        drawing, 2 * sizeof(std::uint32_t)));
}

} // namespace openntc::renderer
