// SPDX-License-Identifier: MIT
#include "Findings.h"

#include "FileNames.h"
#include "Output.h"
#include "TextureImage.h"

#include "openntc/container/Reader.h"

#include <algorithm>
#include <cinttypes>

namespace openntc::tool {

namespace {

enum Number : int {
    kCannotLoad = 1001,
    kGridScale = 2001,
    kOddChannels = 2002,
    kNoInt8Weights = 2003,
    kTextureWithoutChannels = 2004,
    kNoTextures = 2005,
    kFileNameChanged = 2006,
    kPosition = 2007,
    kLatentSize = 2008,
    kChannelUnused = 3001,
    kChannelShared = 3002,
    kLegacyDocument = 3003,
    kNotPng = 3004,
    kTrailingBytes = 3005,
};

class Collector {
public:
    explicit Collector(const TextureSetMetadata& metadata) : metadata_(metadata) {}

    std::vector<Finding> Run() {
        CheckShape();
        CheckTextures();
        CheckChannels();
        CheckMips();
        CheckLegacy();
        return std::move(findings_);
    }

private:
    void Warn(Number number, std::string text) {
        findings_.push_back({number, Severity::Warning, std::move(text)});
    }
    void Note(Number number, std::string text) {
        findings_.push_back({number, Severity::Note, std::move(text)});
    }

    void CheckShape() {
        const TextureSetDesc& desc = metadata_.GetDesc();
        const LatentShape& shape = metadata_.GetLatentShape();
        if (shape.gridSizeScale < 2 || shape.gridSizeScale > 8)
            Warn(kGridScale, Format("gridSizeScale: %d (derived from the sizes): LibNTC accepts 2 ... 8",
                                    shape.gridSizeScale));
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

    void CheckMips() {
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
    std::vector<Finding> findings = Collector(*metadata).Run();
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

} // namespace openntc::tool
