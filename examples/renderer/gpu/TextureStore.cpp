// SPDX-License-Identifier: MIT
// Which textures there are, and uploads of source images.
#include "renderer/gpu/TextureStore.h"

#include "Decoder.h"
#include "Failure.h"
#include "renderer/gpu/CommandLine.h"
#include "renderer/gpu/SelfTest.h"

#include "openntc/core/Half.h"
#include "openntc/decode/ShaderMath.h"
#include "openntc/image/ColorEncoding.h"
#include "openntc/image/MipGeneration.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <set>

namespace openntc::renderer {

using namespace openntc::harness;
using tool::CommandError;
using tool::ExitCode;

namespace {

std::uint8_t ToByte(float value) {
    return static_cast<std::uint8_t>(std::lround(255.0f * std::clamp(value, 0.0f, 1.0f)));
}

/// The four channels of an image as floats in linear light.
std::array<std::vector<float>, 4> MakeLinear(const SourceImage& image, bool isColor) {
    std::array<float, 256> linear{};
    for (std::size_t i = 0; i < linear.size(); ++i)
        linear[i] = image::DecodeColor(ColorSpace::sRGB, static_cast<float>(i) / 255.0f);
    std::array<std::vector<float>, 4> channels;
    const std::size_t count = image.texels.size() / 4;
    for (std::size_t c = 0; c < 4; ++c) {
        channels[c].resize(count);
        for (std::size_t i = 0; i < count; ++i) {
            const std::uint8_t code = image.texels[4 * i + c];
            channels[c][i] = isColor && c < 3 ? linear[code] : static_cast<float>(code) / 255.0f;
        }
    }
    return channels;
}

} // namespace

TextureStore::TextureStore(Context& context, ShaderCache& shaders, Scene& scene, const RenderOptions& options)
    : context_(context), shaders_(shaders), scene_(scene), options_(options) {
    const DeviceInfo& device = context_.GetDevice();
    features_.subgroupShuffle = device.hasSubgroupShuffle && device.subgroupSize >= 8;
    features_.isCpu = device.isCpu;
    ChooseMath();
}

void TextureStore::ChooseMath() {
    const DeviceInfo& device = context_.GetDevice();
    const std::vector<TextureSetFile> files = scene_.textureSets;
    const MathOffer offer = {&device, options_.allowsVectorsInt8, options_.allowsVectorsFP8,
                             [this] { return shaders_.WhyNoCooperativeVectors(); }};
    const int wanted = options_.mode == Mode::OnSample ? options_.math : NTC_MATH_INT8;
    math_ = renderer::ChooseMath(wanted, offer, [&](int math) {
        scene_.textureSets = files;
        const std::string reason = OpenSets(math);
        return reason.empty() ? TestDecoding(math) : reason;
    });
    if (math_.math == 0)
        throw CommandError(ExitCode::NoDevice, device.name,
                           math_.reason + ": try another --math or --mode reference");
    features_.cooperativeVectorInt8 = UsesVectors(math_.math);
    features_.cooperativeVectorFP8 = math_.math == NTC_MATH_COOPVEC_FP8;
    if (!math_.reason.empty() && math_.isNotable)
        scene_.warnings.push_back(device.name + ": " + math_.reason + ": " + GetMathName(math_.math) +
                                  " in its place");
}

std::string TextureStore::OpenSets(int math) {
    const bool isFP8 = GetDecodeWeights(GetDecodeMath(math)) == DecodeWeights::FP8;
    const InferenceWeightType weights =
        isFP8 ? InferenceWeightType::GenericFP8 : InferenceWeightType::GenericInt8;
    bool hasOthers = false, hasAny = false;
    files_.clear();
    sets_.clear();
    for (TextureSetFile& file : scene_.textureSets) {
        files_.emplace_back();
        sets_.emplace_back();
        if (!file.error.empty() || options_.mode == Mode::Reference)
            continue;
        try {
            files_.back() = std::make_unique<tool::TextureSet>(tool::LoadTextureSet(file.path));
            hasOthers = true;
            tool::GetWeights(*files_.back(), weights);
            sets_.back().metadata = &files_.back()->metadata;
            hasAny = true;
        } catch (const CommandError& error) {
            file.error = error.what();
        }
    }
    if (hasAny || !hasOthers || math == NTC_MATH_INT8)
        return {};
    return isFP8 ? "no texture set has FP8 weights" : "no texture set has Int8 weights";
}

std::string TextureStore::TestDecoding(int math) {
    features_.integerDotProduct = context_.GetDevice().features.Has(Feature::IntegerDotProduct);
    std::set<int> tested; // network versions: their shaders are the same for all sets
    for (std::size_t i = 0; i < files_.size(); ++i) {
        if (sets_[i].metadata == nullptr)
            continue;
        tool::TextureSet& file = *files_[i];
        if (!tested.insert(file.metadata.GetWeights().networkVersion).second)
            continue;
        const tool::DecodeData data = tool::LoadDecodeData(file, GetDecodeMath(math));
        try {
            const auto agrees = [&] {
                return DecodesAsPromised(context_, shaders_, data, math, features_.integerDotProduct);
            };
            if (agrees())
                continue;
            if (features_.integerDotProduct && !UsesVectors(math)) {
                features_.integerDotProduct = false;
                if (agrees()) {
                    scene_.warnings.push_back(context_.GetDevice().name +
                                              ": self-test: integer dot products give other numbers than "
                                              "the CPU: done without");
                    continue;
                }
            }
        } catch (const CommandError& error) {
            if (!UsesVectors(math)) // the driver may refuse what it lists, and nothing else depends on them
                throw;
            return std::string("self-test: ") + error.what();
        }
        return "self-test: texels are decoded to other numbers than the CPU's";
    }
    return {};
}

TextureStore::Key TextureStore::MakeKey(const SlotPlan& slot, std::size_t index) {
    if (slot.isNeutral)
        return {TexelSource::None, static_cast<int>(index), 0, 0, false, false, false, 0.0f};
    return {slot.source,        slot.source == TexelSource::Image ? slot.image : slot.set,
            slot.firstChannel,  slot.channels,
            HoldsColors(index), slot.isLinear,
            slot.weighsAlpha,   slot.keptCoverage};
}

void TextureStore::Load(const std::vector<MaterialPlan>& plans) {
    std::map<int, std::map<Key, SlotPlan>> decoded; // by set
    for (const MaterialPlan& plan : plans) {
        for (std::size_t i = 0; i < plan.slots.size(); ++i) {
            const SlotPlan& slot = plan.slots[i];
            const Key key = MakeKey(slot, i);
            if (images_.count(key) > 0 || streamed_.count(key) > 0)
                continue;
            if (slot.source == TexelSource::Decoded)
                decoded[slot.set].emplace(key, slot);
            else if (slot.source == TexelSource::Image)
                images_.emplace(key, slot.isNeutral ? UploadNeutral(i) : UploadSource(slot, HoldsColors(i)));
        }
        if (plan.set >= 0 && deviceSets_.count(plan.set) == 0)
            UploadSet(plan.set);
    }
    if (options_.mode == Mode::OnFeedback && !decoded.empty())
        feedback_ = std::make_unique<FeedbackStore>(context_, shaders_, options_, features_);
    for (const auto& [set, textures] : decoded) {
        if (feedback_)
            StreamSet(set, {textures.begin(), textures.end()});
        else
            DecodeSet(set, {textures.begin(), textures.end()});
    }
    if (feedback_ && !decoded.empty())
        feedback_->Start();
}

void TextureStore::StreamSet(int set, const std::vector<std::pair<Key, SlotPlan>>& textures) {
    tool::TextureSet& file = *files_[static_cast<std::size_t>(set)];
    std::vector<StreamedTexture> wanted;
    for (const auto& [key, slot] : textures)
        wanted.push_back({slot, std::get<4>(key)});
    const tool::DecodeData data = tool::LoadDecodeData(file);
    const std::vector<std::size_t> numbers = feedback_->Add(set, file.metadata, data, wanted);
    for (std::size_t i = 0; i < textures.size(); ++i)
        streamed_.emplace(textures[i].first, numbers[i]);
    memory_.latents += data.latents.size();
    memory_.weights += data.weights.size() + sizeof data.constants;
}

const Image& TextureStore::GetImage(const SlotPlan& slot, std::size_t index) const {
    const Key key = MakeKey(slot, index);
    const auto found = streamed_.find(key);
    return found != streamed_.end() ? feedback_->GetAtlas(slot.set, found->second) : images_.at(key);
}

MemoryUse TextureStore::GetMemory() const {
    MemoryUse memory = memory_;
    if (feedback_)
        memory.feedback = feedback_->GetMemory();
    return memory;
}

namespace {

/// Texels as they are stored: bytes, colours as sRGB; or linear halves.
std::vector<std::byte> Store(const std::array<std::vector<float>, 4>& channels, bool isColor, bool isLinear) {
    const std::size_t count = channels[0].size();
    std::vector<std::byte> bytes(count * (isLinear ? 8 : 4));
    for (std::size_t c = 0; c < 4; ++c) {
        const ColorSpace space = isColor && c < 3 ? ColorSpace::sRGB : ColorSpace::Linear;
        for (std::size_t i = 0; i < count; ++i) {
            const float value = channels[c][i];
            if (isLinear) {
                const std::uint16_t half = FloatToHalf(value);
                std::memcpy(&bytes[8 * i + 2 * c], &half, sizeof half);
            } else {
                bytes[4 * i + c] = static_cast<std::byte>(ToByte(image::EncodeColor(space, value)));
            }
        }
    }
    return bytes;
}

} // namespace

Image TextureStore::UploadSource(const SlotPlan& slot, bool isColor) {
    const SourceImage& source = scene_.images[static_cast<std::size_t>(slot.image)];
    const bool isLinear = slot.isLinear;
    const int mips = image::GetFullMipCount(source.width, source.height);
    Image result = RequireDevice(context_.CreateImage(
        isLinear ? ImageFormat::RGBA16F : ImageFormat::RGBA8, static_cast<std::uint32_t>(source.width),
        static_cast<std::uint32_t>(source.height), static_cast<std::uint32_t>(mips)));
    std::array<std::vector<float>, 4> channels = MakeLinear(source, isColor);
    for (std::size_t i = 0; isLinear && i < source.radiance.size(); ++i)
        channels[i % 3][i / 3] = source.radiance[i];
    // The least number that is stored as a byte of the threshold or more.
    const float threshold = (std::ceil(255.0f * slot.keptCoverage) - 0.5f) / 255.0f;
    const double coverage = image::MeasureCoverage(channels[3], threshold);
    int width = source.width, height = source.height;
    for (int mip = 0;; ++mip) {
        std::vector<float> alpha = channels[3]; // the chain goes on from what was averaged
        if (mip > 0 && slot.keptCoverage > 0.0f)
            image::ScaleToCoverage(channels[3], threshold, coverage);
        const std::vector<std::byte> texels = Store(channels, isColor, isLinear);
        channels[3] = std::move(alpha);
        RequireDevice(context_.Write(result, texels, static_cast<std::uint32_t>(mip)));
        memory_.sourceTextures += texels.size();
        if (mip + 1 == mips)
            return result;
        for (std::size_t c = 0; c < 4; ++c) // alpha last: the colours' weights are of the finer mip
            channels[c] = image::MakeNextMip(channels[c], width, height, ColorSpace::Linear,
                                             c < 3 && slot.weighsAlpha ? std::span<const float>(channels[3])
                                                                       : std::span<const float>());
        width = std::max(width / 2, 1);
        height = std::max(height / 2, 1);
    }
}

Image TextureStore::UploadNeutral(std::size_t index) {
    const bool isNormal = index == static_cast<std::size_t>(TextureSlot::Normal);
    const std::array<float, 4> texel =
        isNormal ? std::array{0.5f, 0.5f, 1.0f, 1.0f} : std::array{1.0f, 1.0f, 1.0f, 1.0f};
    Image result = RequireDevice(context_.CreateImage(ImageFormat::RGBA32F, 1, 1));
    RequireDevice(context_.Write(result, std::as_bytes(std::span(texel))));
    memory_.sourceTextures += sizeof texel;
    return result;
}

void TextureStore::UploadSet(int set) {
    tool::TextureSet& file = *files_[static_cast<std::size_t>(set)];
    const tool::DecodeData data = tool::LoadDecodeData(file, GetDecodeMath(math_.math));
    DeviceSet device = UploadDecodeData(context_, data, math_.math);
    memory_.latents += data.latents.size();
    memory_.weights += device.weights.GetSize() + sizeof data.constants;
    deviceSets_.emplace(set, std::move(device));
}

} // namespace openntc::renderer
