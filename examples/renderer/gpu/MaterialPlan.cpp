// SPDX-License-Identifier: MIT
#include "renderer/gpu/MaterialPlan.h"

#include "Failure.h"
#include "Output.h"
#include "textures/TextureFormat.h"

#include "openntc/image/MipGeneration.h"

#include <algorithm>
#include <sstream>

namespace openntc::renderer {

namespace {

using tool::ExitCode;
using tool::Format;

constexpr const char* kSlotMacros[kTextureSlotCount] = {
    "BASE_COLOR", "METALLIC_ROUGHNESS", "SPECULAR_GLOSSINESS", "NORMAL",
    "OCCLUSION",  "EMISSIVE",           "TRANSMISSION"};

constexpr MaterialEffect kSlotEffects[kTextureSlotCount] = {MaterialEffect::BaseColorTexture,
                                                            MaterialEffect::MetallicRoughnessTexture,
                                                            MaterialEffect::SpecularGlossinessTexture,
                                                            MaterialEffect::NormalMap,
                                                            MaterialEffect::Occlusion,
                                                            MaterialEffect::EmissiveTexture,
                                                            MaterialEffect::TransmissionTexture};

constexpr std::size_t At(TextureSlot slot) {
    return static_cast<std::size_t>(slot);
}

std::uint32_t ToWrap(Wrap wrap) {
    switch (wrap) {
    case Wrap::Clamp:
        return NTC_WRAP_CLAMP;
    case Wrap::Mirror:
        return NTC_WRAP_MIRROR;
    case Wrap::Repeat:
        break;
    }
    return NTC_WRAP_REPEAT;
}

class Planner {
public:
    Planner(const Scene& scene, const Material& material, const std::vector<LoadedSetInfo>& sets,
            const RenderOptions& options, const DeviceFeatures& device)
        : scene_(scene), material_(material), sets_(sets), options_(options), device_(device) {}

    MaterialPlan Plan() {
        const bool usesAlpha = IsForced(MaterialEffect::Alpha) || material_.alphaMode != AlphaMode::Opaque;
        const bool emits = IsForced(MaterialEffect::Emission) || IsForced(MaterialEffect::EmissiveTexture) ||
                           material_.emissiveFactor != glm::vec3(0.0f);
        const bool transmits = IsForced(MaterialEffect::Transmission) ||
                               IsForced(MaterialEffect::TransmissionTexture) ||
                               material_.transmissionFactor > 0.0f;
        for (std::size_t i = 0; i < kTextureSlotCount; ++i)
            plan_.slots[i] = ChooseSource(i, emits, transmits);
        ChooseDecodedSet();
        for (SlotPlan& slot : plan_.slots)
            AddLookup(slot, &slot - plan_.slots.data());
        plan_.isPlanned = true;
        for (std::size_t i = 0; i < kTextureSlotCount; ++i)
            TurnOn(kSlotEffects[i], plan_.slots[i].source != TexelSource::None);
        TurnOn(MaterialEffect::SpecularGlossiness, material_.specularGlossiness);
        TurnOn(MaterialEffect::Emission, emits);
        TurnOn(MaterialEffect::Transmission, transmits);
        TurnOn(MaterialEffect::Alpha, usesAlpha);
        TurnOn(MaterialEffect::AlphaMask, material_.alphaMode == AlphaMode::Mask);
        ChooseFilter();
        plan_.defines = MakeDefines(plan_.slots, usesAlpha, false);
        const auto define = [&](bool isOn, const char* text) {
            if (isOn)
                plan_.defines.emplace_back(text);
        };
        define(material_.specularGlossiness, "NTCR_SPEC_GLOSS=1");
        define(emits, "NTCR_EMISSION=1");
        define(transmits, "NTCR_TRANSMITS=1");
        if (material_.alphaMode == AlphaMode::Mask) {
            if (HasAlpha(plan_.slots[0])) // else the factor alone decides
                plan_.maskSlots[0] = plan_.slots[0];
            plan_.maskDefines = MakeDefines(plan_.maskSlots, true, true);
            plan_.maskDefines.emplace_back("NTCR_MASKED=1");
        }
        return std::move(plan_);
    }

private:
    bool IsForced(MaterialEffect effect) const { return (options_.forcedEffects & MakeBit(effect)) != 0; }

    void TurnOn(MaterialEffect effect, bool isOn) { plan_.effects |= isOn ? MakeBit(effect) : 0; }

    SlotPlan ChooseSource(std::size_t index, bool emits, bool transmits) const {
        const MaterialTexture& texture = material_.textures[index];
        SlotPlan slot;
        const bool isWanted =
            (index != At(TextureSlot::Emissive) || emits) &&
            (index != At(TextureSlot::Transmission) || transmits) &&
            (index == At(TextureSlot::MetallicRoughness)
                 ? !material_.specularGlossiness
                 : index != At(TextureSlot::SpecularGlossiness) || material_.specularGlossiness);
        if (!isWanted)
            return slot;
        const bool hasSet = options_.mode != Mode::Reference && texture.textureSet >= 0 &&
                            sets_[static_cast<std::size_t>(texture.textureSet)].metadata != nullptr;
        if (hasSet) {
            slot.source = TexelSource::Decoded;
            slot.set = texture.textureSet;
            slot.firstChannel = texture.firstChannel;
            slot.channels = texture.channels;
            slot.isLinear = IsOfFloats(slot);
            slot.block = ChooseBlocks(slot, index);
        } else if (texture.image >= 0) {
            slot.source = TexelSource::Image;
            slot.image = texture.image;
            slot.channels = 4;
            slot.weighsAlpha =
                index == At(TextureSlot::BaseColor) && material_.alphaMode != AlphaMode::Opaque;
            slot.keptCoverage = slot.weighsAlpha ? material_.keptCoverage : 0.0f;
            slot.isLinear = HoldsColors(index) &&
                            !scene_.images[static_cast<std::size_t>(texture.image)].radiance.empty();
        } else if (IsForced(kSlotEffects[index])) {
            slot.source = TexelSource::Image;
            slot.isNeutral = true;
            slot.channels = 4;
        }
        return slot;
    }

    bool IsOfFloats(const SlotPlan& slot) const {
        for (const Texture& texture : sets_[static_cast<std::size_t>(slot.set)].metadata->GetTextures()) {
            if (texture.firstChannel <= slot.firstChannel &&
                slot.firstChannel < texture.firstChannel + texture.numChannels)
                return texture.channelFormat != ChannelFormat::UNORM8;
        }
        return false;
    }

    /// The block format of a slot's texture; none: it stays as it is.
    std::optional<bc::BlockFormat> ChooseBlocks(const SlotPlan& slot, std::size_t index) const {
        if (options_.keepsTexels)
            return std::nullopt;
        std::optional<bc::BlockFormat> block = options_.blocks.block;
        if (options_.blocks.isAuto)
            block = FindDeclaredBlocks(slot);
        if (!block || slot.isLinear != (*block == bc::BlockFormat::Bc6Unsigned))
            return std::nullopt;
        const bool isNormal = index == At(TextureSlot::Normal); // two of its channels give the third
        const int most = *block == bc::BlockFormat::Bc4Unsigned   ? 1
                         : *block == bc::BlockFormat::Bc5Unsigned ? (isNormal ? 3 : 2)
                         : *block == bc::BlockFormat::Bc1 || *block == bc::BlockFormat::Bc6Unsigned ? 3
                                                                                                    : 4;
        return slot.channels <= most ? block : std::nullopt;
    }

    std::optional<bc::BlockFormat> FindDeclaredBlocks(const SlotPlan& slot) const {
        for (const Texture& texture : sets_[static_cast<std::size_t>(slot.set)].metadata->GetTextures()) {
            if (texture.firstChannel != slot.firstChannel)
                continue;
            const auto chosen = tool::ChooseFormat(texture, {}, false);
            if (!chosen || !chosen->format.block)
                return std::nullopt;
            // Metalness and roughness are two textures of a set and one slot.
            return texture.numChannels == slot.channels ? chosen->format.block : bc::BlockFormat::Bc5Unsigned;
        }
        return std::nullopt;
    }

    /// A shader decodes one texture set: that of most slots, the first one of equals.
    void ChooseDecodedSet() {
        if (options_.mode != Mode::OnSample)
            return;
        std::size_t most = 0;
        for (const SlotPlan& candidate : plan_.slots) {
            const auto count = static_cast<std::size_t>(
                std::count_if(plan_.slots.begin(), plan_.slots.end(), [&](const SlotPlan& slot) {
                    return slot.source == TexelSource::Decoded && slot.set == candidate.set;
                }));
            if (candidate.source == TexelSource::Decoded && count > most) {
                most = count;
                plan_.set = candidate.set;
            }
        }
        for (SlotPlan& slot : plan_.slots) {
            if (slot.source == TexelSource::Decoded && slot.set == plan_.set)
                slot.source = TexelSource::Set;
        }
    }

    /// What of the filters is compiled: the others' code goes, and its registers.
    void ChooseFilter() {
        if (plan_.lookups.empty())
            return;
        const shader::NtcStfSampler sampler = MakeSampler(options_.filter, {});
        const bool isMipped = sampler.mips == NTC_MIPS_LINEAR, isAnisotropic = sampler.maxAnisotropy > 1;
        const bool isAnyKernel = IsForced(MaterialEffect::FilterAnyKernel);
        TurnOn(MaterialEffect::FilterAnyKernel, isAnyKernel);
        TurnOn(MaterialEffect::FilterMips, isMipped || IsForced(MaterialEffect::FilterMips));
        TurnOn(MaterialEffect::FilterAnisotropy, isAnisotropic || IsForced(MaterialEffect::FilterAnisotropy));
        if (!isAnyKernel) {
            const int taps = sampler.kernelType == NTC_KERNEL_GAUSSIAN   ? 2 * sampler.radius
                             : sampler.kernelType <= NTC_KERNEL_BILINEAR ? 2
                                                                         : 4;
            filterDefines_.push_back(Format("NTCR_KERNEL=%u", sampler.kernelType));
            filterDefines_.push_back(Format("NTC_STF_MOST_TAPS=%d", taps));
        }
        if (isMipped || !IsForced(MaterialEffect::FilterMips))
            filterDefines_.push_back(Format("NTCR_MIPS=%u", sampler.mips));
        if (!isAnisotropic && !IsForced(MaterialEffect::FilterAnisotropy))
            filterDefines_.emplace_back("NTCR_ISOTROPIC=1");
    }

    void AddLookup(SlotPlan& slot, std::ptrdiff_t index) {
        if (slot.source == TexelSource::None)
            return;
        shader::NtcrLookup lookup = {};
        const TextureAddress& address = material_.textures[static_cast<std::size_t>(index)].address;
        lookup.sampling = MakeSampler(options_.filter, address);
        lookup.row0 = glm::vec4(address.transform.row0, static_cast<float>(address.uvSet));
        lookup.row1 = glm::vec4(address.transform.row1, 0.0f);
        lookup.width = lookup.height = lookup.levels = 1;
        if (slot.source == TexelSource::Image && !slot.isNeutral) {
            const SourceImage& image = scene_.images[static_cast<std::size_t>(slot.image)];
            lookup.width = image.width;
            lookup.height = image.height;
            lookup.levels = image::GetFullMipCount(image.width, image.height);
        } else if (slot.set >= 0) {
            const TextureSetDesc& desc = sets_[static_cast<std::size_t>(slot.set)].metadata->GetDesc();
            lookup.width = desc.width;
            lookup.height = desc.height;
            lookup.levels = desc.mips;
        }
        for (std::size_t i = 0; i < plan_.lookups.size(); ++i) {
            const shader::NtcrLookup& known = plan_.lookups[i];
            int& set = plan_.lookupSets[i];
            if (sources_[i] == (slot.source == TexelSource::Set) &&
                (set < 0 || slot.set < 0 || set == slot.set) && known.row0 == lookup.row0 &&
                known.row1 == lookup.row1 && known.sampling.wrapX == lookup.sampling.wrapX &&
                known.sampling.wrapY == lookup.sampling.wrapY && known.width == lookup.width &&
                known.height == lookup.height && known.levels == lookup.levels) {
                slot.lookup = static_cast<int>(i);
                set = std::max(set, slot.set);
                return;
            }
        }
        slot.lookup = static_cast<int>(plan_.lookups.size());
        plan_.lookups.push_back(lookup);
        plan_.lookupSets.push_back(slot.set);
        sources_.push_back(slot.source == TexelSource::Set);
    }

    static bool HasAlpha(const SlotPlan& color) {
        return color.source != TexelSource::None && (color.set < 0 || color.channels > 3);
    }

    std::vector<std::string> MakeDefines(const std::array<SlotPlan, kTextureSlotCount>& slots, bool usesAlpha,
                                         bool isMask) {
        int lookups = 0;
        std::uint32_t setLookups = 0, channels = 0;
        std::vector<std::string> defines;
        for (std::size_t i = 0; i < slots.size(); ++i) {
            const SlotPlan& slot = slots[i];
            if (slot.source == TexelSource::None)
                continue;
            lookups = std::max(lookups, slot.lookup + 1);
            const char* const macro = kSlotMacros[i];
            defines.push_back(Format("NTCR_%s_SOURCE=%d", macro, static_cast<int>(slot.source)));
            defines.push_back(Format("NTCR_%s_LOOKUP=%d", macro, slot.lookup));
            if (slot.source != TexelSource::Set && slot.isLinear && HoldsColors(i))
                defines.push_back(Format("NTCR_%s_LINEAR=1", macro));
            const bool isOfTwo =
                slot.source == TexelSource::Decoded && slot.block == bc::BlockFormat::Bc5Unsigned;
            if (i == At(TextureSlot::Normal) && slot.set >= 0 && (slot.channels == 2 || isOfTwo))
                defines.emplace_back("NTCR_NORMAL_XY=1");
            if (slot.source != TexelSource::Set)
                continue;
            defines.push_back(Format("NTCR_%s_CHANNEL=%d", macro, slot.firstChannel));
            setLookups |= 1u << slot.lookup;
            const bool isColor = i == At(TextureSlot::BaseColor);
            for (int c = isMask ? 3 : 0; c < slot.channels && (!isColor || c < 3 || usesAlpha); ++c)
                channels |= 1u << (slot.firstChannel + c);
        }
        const bool hasAlpha = HasAlpha(slots[At(TextureSlot::BaseColor)]);
        defines.push_back(Format("NTCR_ALPHA=%d", usesAlpha && hasAlpha ? 1 : 0));
        defines.push_back(Format("NTCR_LOOKUPS=%d", lookups));
        if (lookups > 0)
            defines.insert(defines.end(), filterDefines_.begin(), filterDefines_.end());
        if (options_.mode == Mode::OnFeedback && HasDecoded(slots))
            defines.emplace_back("NTCR_TILED=1");
        defines.push_back(Format("NTCR_COUNTED=%d", options_.counts ? 1 : 0));
        if (setLookups != 0 && channels != 0) {
            defines.push_back(Format("NTCR_SET_LOOKUPS=%u", setLookups));
            AddDecoder(defines, channels, isMask);
        }
        return defines;
    }

    void AddDecoder(std::vector<std::string>& defines, std::uint32_t channels, bool isMask) {
        SceneNeeds needs;
        for (const MaterialEffect effect : {MaterialEffect::DecoderAllChannels,
                                            MaterialEffect::DecoderClamping, MaterialEffect::DecoderSlices})
            TurnOn(effect, IsForced(effect));
        needs.channels =
            IsForced(MaterialEffect::DecoderAllChannels) ? 0 : channels; // 0: all that the set has
        needs.linear = true;
        needs.texelsInside = !IsForced(MaterialEffect::DecoderClamping);
        needs.wholeLatents = !IsForced(MaterialEffect::DecoderSlices);
        needs.preference = MathPreference::Specific;
        needs.math = options_.math;
        needs.device = device_;
        const std::size_t set = static_cast<std::size_t>(plan_.set);
        const Permutation permutation = tool::Require(MakePermutation(*sets_[set].metadata, needs),
                                                      ExitCode::BadInput, scene_.textureSets[set].path);
        const std::string decoder(permutation.key.ToDefines().View());
        std::istringstream words(decoder);
        for (std::string word; words >> word;)
            defines.push_back(word);
        for (const char* const binding :
             {"NTC_DESCRIPTOR_SET=1", "NTC_LATENTS_BINDING=9", "NTC_WEIGHTS_BINDING=10"})
            defines.emplace_back(binding);
        if (isMask)
            return;
        plan_.decoder = decoder;
        plan_.multiplications = permutation.multiplications;
    }

    const Scene& scene_;
    const Material& material_;
    const std::vector<LoadedSetInfo>& sets_;
    const RenderOptions& options_;
    const DeviceFeatures& device_;
    MaterialPlan plan_;
    std::vector<bool> sources_; // of lookups: decoded in the shader
    std::vector<std::string> filterDefines_;
};

} // namespace

bool HasDecoded(const std::array<SlotPlan, kTextureSlotCount>& slots) {
    return std::any_of(slots.begin(), slots.end(),
                       [](const SlotPlan& slot) { return slot.source == TexelSource::Decoded; });
}

bool HoldsColors(std::size_t slot) {
    return slot == At(TextureSlot::BaseColor) || slot == At(TextureSlot::SpecularGlossiness) ||
           slot == At(TextureSlot::Emissive);
}

shader::NtcStfSampler MakeSampler(TextureFilter filter, const TextureAddress& address) {
    constexpr std::uint32_t kKernels[] = {NTC_KERNEL_NEAREST,  NTC_KERNEL_BILINEAR,    NTC_KERNEL_BILINEAR,
                                          NTC_KERNEL_CUBIC,    NTC_KERNEL_CATMULL_ROM, NTC_KERNEL_MITCHELL,
                                          NTC_KERNEL_GAUSSIAN, NTC_KERNEL_BILINEAR};
    shader::NtcStfSampler sampler = shader::NtcStfMakeSampler(kKernels[static_cast<std::size_t>(filter)], 0);
    if (filter == TextureFilter::Gaussian)
        sampler = shader::NtcStfMakeGaussian(0.6f, 0);
    if (filter == TextureFilter::Bilinear)
        sampler.mips = NTC_MIPS_NEAREST;
    if (filter == TextureFilter::Anisotropic)
        sampler.maxAnisotropy = 16;
    sampler.wrapX = ToWrap(address.wrapS);
    sampler.wrapY = ToWrap(address.wrapT);
    return sampler;
}

MaterialPlan PlanMaterial(const Scene& scene, const Material& material,
                          const std::vector<LoadedSetInfo>& sets, const RenderOptions& options,
                          const DeviceFeatures& device) {
    return Planner(scene, material, sets, options, device).Plan();
}

} // namespace openntc::renderer
