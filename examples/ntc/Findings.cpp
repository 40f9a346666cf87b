// SPDX-License-Identifier: MIT
#include "Findings.h"

#include "FileNames.h"
#include "Output.h"
#include "TextureImage.h"

#include "openntc/container/Reader.h"
#include "openntc/texture_set/BlockModes.h"
#include "openntc/texture_set/MipChain.h"

#include <algorithm>
#include <cinttypes>

namespace openntc::tool {

namespace {

enum Number : int {
    kCannotLoad = 1001,
    kCorruptData = 1002,
    kGridScale = 2001,
    kOddChannels = 2002,
    kNoInt8Weights = 2003,
    kTextureWithoutChannels = 2004,
    kNoTextures = 2005,
    kFileNameChanged = 2006,
    kPosition = 2007,
    kLatentSize = 2008,
    kLatentMapping = 2009,
    kBlockModes = 2010,
    kSmallNetwork = 2011,
    kChannelUnused = 3001,
    kChannelShared = 3002,
    kLegacyDocument = 3003,
    kNotPng = 3004,
    kTrailingBytes = 3005,
    kUntestedGeneration = 3006,
};

class Collector {
public:
    Collector(const TextureSetMetadata& metadata, Stream& stream) : metadata_(metadata), stream_(stream) {}

    std::vector<Finding> Run() {
        CheckShape();
        if (metadata_.GetGeneration() > 1)
            CheckLaterGeneration();
        CheckTextures();
        CheckChannels();
        CheckMips();
        CheckLegacy();
        return std::move(findings_);
    }

    /// What LibNTC insists on.
    std::vector<Finding> RunRefusals() {
        CheckShape();
        const int scale = metadata_.GetLatentShape().gridSizeScale;
        if (metadata_.GetGeneration() > 1 && scale >= 1 && scale <= kMaxLayeredGridSizeScale)
            CheckLatentMips(scale);
        CheckMips();
        std::erase_if(findings_, [](const Finding& finding) { return finding.number == kNoInt8Weights; });
        return std::move(findings_);
    }

private:
    void Fail(Number number, std::string text) {
        findings_.insert(findings_.begin(), {number, Severity::Error, std::move(text)});
    }
    void Warn(Number number, std::string text) {
        findings_.push_back({number, Severity::Warning, std::move(text)});
    }
    void Note(Number number, std::string text) {
        findings_.push_back({number, Severity::Note, std::move(text)});
    }

    void CheckShape() {
        const TextureSetDesc& desc = metadata_.GetDesc();
        const LatentShape& shape = metadata_.GetLatentShape();
        const bool isLayered = metadata_.GetGeneration() > 1;
        const int smallest = isLayered ? 1 : kMinGridSizeScale;
        const int largest = isLayered ? kMaxLayeredGridSizeScale : kMaxGridSizeScale;
        if (shape.gridSizeScale < smallest || shape.gridSizeScale > largest)
            Warn(kGridScale, Format("gridSizeScale: %d (derived from the sizes): LibNTC accepts %d ... %d",
                                    shape.gridSizeScale, smallest, largest));
        if (desc.channels % 2 != 0)
            Warn(kOddChannels,
                 Format("numChannels: %d: LibNTC's CUDA loader accepts even numbers", desc.channels));
        if (!metadata_.IsInferenceWeightTypeSupported(InferenceWeightType::GenericInt8))
            Warn(kNoInt8Weights, "weights: no Int8 network: int8 decoding needs one");
        if (shape.gridSizeScale < 1)
            return;
        // Grid sizes that an encoder writes (format specification, latents, "grid dimensions"); LibNTC's CUDA
        // loader insists on them, decoders do not.
        int index = 0;
        for (const LatentImage& image : metadata_.GetLatentImages()) {
            CheckGrid("highRes", index, image.highRes, shape.gridSizeScale);
            CheckGrid("lowRes", index, image.lowRes, 2 * shape.gridSizeScale);
            ++index;
        }
    }

    void CheckGrid(const char* name, int image, const LatentGrid& grid, int scale) {
        const TextureSetDesc& desc = metadata_.GetDesc();
        const int width = std::max((desc.width / scale) >> (2 * image), 1);
        const int height = std::max((desc.height / scale) >> (2 * image), 1);
        if (grid.width != width || grid.height != height)
            Warn(kLatentSize, Format("latents[%d].%s: %d x %d: LibNTC's CUDA loader accepts %d x %d", image,
                                     name, grid.width, grid.height, width, height));
    }

    void CheckTextures() {
        FileNames names;
        if (metadata_.GetTextures().empty())
            Warn(kNoTextures, "textures: 0: nothing to decode");
        int index = 0;
        for (const Texture& texture : metadata_.GetTextures()) {
            const std::string name = Printable(texture.name);
            const std::string file = names.Add(texture.name);
            if (file != texture.name)
                Warn(kFileNameChanged,
                     Format("textures[%d].name: %s: written as %s.png", index, name.c_str(), file.c_str()));
            if (texture.numChannels == 0)
                Warn(kTextureWithoutChannels,
                     Format("textures[%d] %s: no channels: its range leaves the set", index, name.c_str()));
            else if (!TextureImage::IsSupported(texture))
                Note(kNotPng, Format("textures[%d] %s: %d channels of %s: cannot be written as PNG", index,
                                     name.c_str(), texture.numChannels, GetName(texture.channelFormat)));
            ++index;
        }
    }

    void CheckChannels() {
        for (int channel = 0; channel < metadata_.GetDesc().channels; ++channel) {
            int users = 0;
            for (const Texture& texture : metadata_.GetTextures()) {
                if (channel >= texture.firstChannel && channel < texture.firstChannel + texture.numChannels)
                    ++users;
            }
            if (users == 0)
                Note(kChannelUnused, Format("channel %d: in no texture: its values are arbitrary", channel));
            if (users > 1)
                Note(kChannelShared, Format("channel %d: in %d textures", channel, users));
        }
    }

    /// What only generations 2 and 3 have, and the data that are compressed.
    void CheckLaterGeneration() {
        if (metadata_.GetGeneration() == 2)
            Note(kUntestedGeneration,
                 "generation: 2: no file of LibNTC 0.8 was at hand: read as the format is described");
        const int scale = metadata_.GetLatentShape().gridSizeScale;
        if (scale >= 1 && scale <= kMaxLayeredGridSizeScale)
            CheckLatentMips(scale);
        CheckNetworkSizes();
        CheckStoredLatents();
        CheckBlockModes();
    }

    /// Sizes, number and mapping that an encoder writes (format specification, generations, "latent
    /// geometry"): LibNTC's CUDA loader insists on them.
    void CheckLatentMips(int scale) {
        const TextureSetDesc& desc = metadata_.GetDesc();
        const std::span<const LatentMip> latents = metadata_.GetLatentMips();
        const auto count = static_cast<int>(latents.size());
        const int width = GetLatentMipDimension(desc.width, scale, 0);
        const int height = GetLatentMipDimension(desc.height, scale, 0);
        if (latents[0].width != width || latents[0].height != height)
            Warn(kLatentSize, Format("latents[0]: %d x %d: LibNTC's CUDA loader accepts %d x %d",
                                     latents[0].width, latents[0].height, width, height));
        if (count != GetLatentMipCount(desc, scale))
            Warn(kLatentSize,
                 Format("latents: %d: LibNTC's encoder makes %d", count, GetLatentMipCount(desc, scale)));
        int index = 0;
        for (const ColorMip& mip : metadata_.GetColorMips()) {
            const int expected = GetLatentMipForColorMip(index, scale, count);
            if (mip.neuralMip != expected)
                Warn(kLatentMapping, Format("colorMips[%d].latentMip: %d: LibNTC's CUDA loader accepts %d",
                                            index, mip.neuralMip, expected));
            ++index;
        }
    }

    /// Channels between layers that the file leaves out.
    void CheckNetworkSizes() {
        const NetworkDescription network = GetNetworkDescription(metadata_.GetNetworkVersion());
        int number = 0;
        for (const container::Mlp& mlp : metadata_.GetDocument().mlpVersions) {
            for (std::size_t layer = 0; layer < mlp.layers.size(); ++layer) {
                const container::MlpLayer& record = mlp.layers[layer];
                if (static_cast<int>(record.inputChannels) != network.inputs[layer] ||
                    static_cast<int>(record.outputChannels) != network.outputs[layer])
                    Warn(kSmallNetwork,
                         Format("mlpVersions[%d].layers[%zu]: %u x %u: padded with zeros to %d x %d", number,
                                layer, record.inputChannels, record.outputChannels, network.inputs[layer],
                                network.outputs[layer]));
            }
            ++number;
        }
    }

    /// Compressed layers are corrupt, or not: only decompressing tells.
    void CheckStoredLatents() {
        StoredDataReader reader(stream_, GetDefaultAllocator());
        int index = 0;
        for (const LatentMip& mip : metadata_.GetLatentMips()) {
            for (std::size_t layer = 0; layer < static_cast<std::size_t>(mip.layers); ++layer) {
                const Expected<void> sound = reader.Verify(mip.layerData[layer], "latents");
                if (!sound)
                    Fail(kCorruptData,
                         Format("latents[%d].layerViews[%zu]: ", index, layer) + sound.error().GetText());
            }
            ++index;
        }
    }

    void CheckBlockModes() {
        for (const Texture& texture : metadata_.GetTextures()) {
            for (const BlockModeBuffer& modes : texture.blockModes) {
                const ColorMip& mip = metadata_.GetColorMips()[static_cast<std::size_t>(modes.mip)];
                const auto packed = ReadBlockModes(modes, stream_, mip.width, mip.height);
                if (!packed)
                    Warn(kBlockModes, "texture " + Printable(texture.name) + Format(": mip %d: ", modes.mip) +
                                          packed.error().GetText());
            }
        }
    }

    void CheckMips() {
        if (metadata_.GetGeneration() > 1)
            return; // decoders read positions from the file, whatever they are
        int index = 0;
        for (const ColorMip& mip : metadata_.GetColorMips()) {
            const int level = index - 2 * mip.neuralMip;
            const float lod = static_cast<float>(level) / 3.0f;
            const float scale = std::ldexp(1.0f, level);
            if (mip.positionLod != lod || mip.positionScale != scale)
                Warn(kPosition, Format("colorMips[%d]: positionLod %s, positionScale %s: LibNTC's CUDA "
                                       "loader uses %s and %s",
                                       index, FormatFloat(mip.positionLod).c_str(),
                                       FormatFloat(mip.positionScale).c_str(), FormatFloat(lod).c_str(),
                                       FormatFloat(scale).c_str()));
            ++index;
        }
    }

    void CheckLegacy() {
        const container::Document& document = metadata_.GetDocument();
        const auto isLegacy = [](const container::Mlp& mlp) { return mlp.weightType || mlp.scaleBiasType; };
        bool legacy = document.mlp && isLegacy(*document.mlp);
        for (const container::Mlp& mlp : document.mlpVersions)
            legacy = legacy || isLegacy(mlp);
        if (legacy)
            Note(kLegacyDocument, "mlp: types given for the whole network: written by LibNTC 0.5");
    }

    const TextureSetMetadata& metadata_;
    Stream& stream_;
    std::vector<Finding> findings_;
};

} // namespace

const char* GetName(Severity severity) {
    switch (severity) {
    case Severity::Error:
        return "error";
    case Severity::Warning:
        return "warning";
    case Severity::Note:
        return "note";
    }
    return "unknown";
}

std::vector<Finding> FindProblems(const std::string& path) {
    Input input(path);
    const Expected<TextureSetMetadata> metadata = TextureSetMetadata::Load(input.GetStream());
    if (!metadata)
        return {{kCannotLoad, Severity::Error, metadata.error().GetText()}};
    std::vector<Finding> findings = Collector(*metadata, input.GetStream()).Run();
    const Expected<container::Container> file = container::ReadContainer(input.GetStream());
    if (!file)
        return {{kCannotLoad, Severity::Error, file.error().GetText()}};
    if (const std::uint64_t end = file->binaryOffset + file->binarySize; end < file->streamSize)
        findings.push_back(
            {kTrailingBytes, Severity::Note,
             Format("size: %" PRIu64 " bytes: the header accounts for %" PRIu64 ": what follows is ignored",
                    file->streamSize, end)});
    return findings;
}

std::vector<Finding> FindRefusals(const TextureSetMetadata& metadata) {
    ReadOnlyMemoryStream none({});
    return Collector(metadata, none).RunRefusals();
}

} // namespace openntc::tool
