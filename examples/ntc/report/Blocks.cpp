// SPDX-License-Identifier: MIT
#include "report/Blocks.h"

#include "Failure.h"
#include "Interrupt.h"
#include "Output.h"
#include "TextureSizes.h"

#include "openntc/MathModes.h"
#include "openntc/bc/BlockFormat.h"
#include "openntc/bc/BlockHints.h"
#include "openntc/core/ThreadTeam.h"
#include "openntc/image/ColorEncoding.h"

#include <algorithm>
#include <cstring>

namespace openntc::report {

using bc::BlockFormat;
using tool::CommandError;
using tool::ExitCode;

namespace {

/// Which textures of the sample material a format is for: colour, and what its fourth channel is.
struct Content {
    const char* texture;
    const char* alpha; ///< or null
    bool isLinear;
};

Content GetContent(BlockFormat format) {
    switch (format) {
    case BlockFormat::Bc2:
    case BlockFormat::Bc3:
        return {"BaseColor", "Roughness", false};
    case BlockFormat::Bc4Unsigned:
        return {"Height", nullptr, false};
    case BlockFormat::Bc5Unsigned:
        return {"Normal", nullptr, false};
    case BlockFormat::Bc6Unsigned:
        return {"BaseColor", nullptr, true};
    default:
        return {"BaseColor", nullptr, false};
    }
}

const Texture& FindTexture(const TextureSetMetadata& metadata, const std::string& name,
                           const std::string& subject) {
    for (const Texture& texture : metadata.GetTextures()) {
        if (std::string_view(texture.name) == name)
            return texture;
    }
    throw CommandError(ExitCode::BadInput, subject, "cache: no texture " + name + ": remove it");
}

template <typename T>
std::vector<T> Repeat(std::span<const T> values, std::size_t copies) {
    std::vector<T> all;
    for (std::size_t i = 0; i < copies; ++i)
        all.insert(all.end(), values.begin(), values.end());
    return all;
}

class CpuBlocks final : public PreparedBlocks {
public:
    CpuBlocks(const BlockCase& c, const BlockTexture& texture, int threads)
        : effort_(c.effort), id_(c.GetId()), texture_(texture), threads_(threads) {
        const std::size_t texels =
            static_cast<std::size_t>(texture.width) * static_cast<std::size_t>(texture.height);
        const auto all = static_cast<std::size_t>(std::max(threads, 1));
        if (threads > 1)
            copies_ = std::max<std::size_t>(1, (tool::kTexelsPerThread * all + texels - 1) / texels);
        texels_ = Repeat(texture.decoded.GetTexels(), copies_);
        hints_ = Repeat(std::span<const std::int32_t>(GatherBlockHints(c, texture)), copies_);
    }

    int GetThreads() const override { return threads_; }
    std::vector<std::byte> Encode() override { return Run(texture_.decoded.GetTexels(), 1); }

    std::vector<double> Time(int repeats) override {
        std::vector<double> times;
        for (int i = 0; i < repeats; ++i) {
            tool::ThrowIfInterrupted();
            const double start = tool::GetEncodingSeconds(threads_ == 1);
            Run(texels_, copies_);
            const double seconds = tool::GetEncodingSeconds(threads_ == 1) - start;
            times.push_back(1e9 * seconds / static_cast<double>(copies_) / texture_.width / texture_.height);
        }
        return times;
    }

private:
    std::vector<std::byte> Run(std::span<const std::byte> texels, std::size_t copies) const {
        std::vector<std::byte> blocks;
        tool::EncodeTexelBlocks(
            texture_.decoded.GetFormat(), effort_,
            {texels, static_cast<std::uint32_t>(texture_.width),
             static_cast<std::uint32_t>(static_cast<std::size_t>(texture_.height) * copies)},
            threads_, id_, blocks, std::span(hints_).first(hints_.size() / copies_ * copies));
        return blocks;
    }

    tool::BlockEffort effort_;
    std::string id_;
    const BlockTexture& texture_;
    int threads_;
    std::size_t copies_ = 1; // below one another
    std::vector<std::byte> texels_;
    std::vector<std::int32_t> hints_; // of the copies, as they are whole blocks high
};

double GetPsnr(tool::BlockMeasurement measurement, const tool::BlockError& error) {
    measurement.error = error;
    return measurement.GetPsnr();
}

} // namespace

std::string BlockCase::GetId() const {
    return std::string("blocks ") + bc::BlockFormatToString(format) + " " + tool::GetName(effort) +
           (isHinted ? " hints" : "");
}

std::vector<BlockCase> ListBlockCases(bool quick) {
    std::vector<BlockCase> cases;
    const auto add = [&](BlockFormat format) {
        for (const tool::BlockEffort effort :
             {tool::BlockEffort::Fast, tool::BlockEffort::Normal, tool::BlockEffort::Best})
            cases.push_back({format, effort});
        if (format == BlockFormat::Bc7)
            cases.push_back({format, tool::BlockEffort::Best, true});
    };
    if (quick) {
        for (const BlockFormat format : {BlockFormat::Bc1, BlockFormat::Bc5Unsigned, BlockFormat::Bc7})
            add(format);
        return cases;
    }
    for (const BlockFormat format :
         {BlockFormat::Bc1, BlockFormat::Bc2, BlockFormat::Bc3, BlockFormat::Bc4Unsigned,
          BlockFormat::Bc5Unsigned, BlockFormat::Bc6Unsigned, BlockFormat::Bc7})
        add(format);
    return cases;
}

BlockTexture MakeBlockTexture(BlockFormat format, const Encoding& encoding, ReferenceDecodes& references) {
    const Content content = GetContent(format);
    const tool::TextureSet set = tool::LoadTextureSet(encoding.path);
    std::vector<int> channels;
    const Texture& texture = FindTexture(set.metadata, content.texture, encoding.path);
    for (int c = 0; c < texture.numChannels; ++c)
        channels.push_back(texture.firstChannel + c);
    if (content.alpha != nullptr)
        channels.push_back(FindTexture(set.metadata, content.alpha, encoding.path).firstChannel);

    const std::vector<float>& outputs = references.Get(encoding, NTC_MATH_INT8, content.isLinear);
    const encode::Material& material = encoding.source->material;
    tool::InputImage decoded;
    decoded.width = encoding.record.width;
    decoded.height = encoding.record.height;
    decoded.channels = static_cast<int>(channels.size());
    decoded.bits = content.isLinear ? 32 : 8;
    tool::InputImage original = decoded;
    for (std::size_t i = 0; i < outputs.size() / 16; ++i) {
        for (const int c : channels) {
            const auto channel = static_cast<std::size_t>(c);
            decoded.texels.push_back(outputs[16 * i + channel]);
            const float value = material.GetPlane(0, c)[i];
            const auto space =
                static_cast<ColorSpace>(material.GetChannelColorSpaces() >> (2 * channel) & 3u);
            original.texels.push_back(content.isLinear ? image::DecodeColor(space, value) : value);
        }
    }
    const std::size_t kept =
        std::min<std::size_t>(channels.size(), static_cast<std::size_t>(bc::GetBlockChannels(format)));
    return {content.texture + (content.alpha != nullptr ? std::string(", alpha ") + content.alpha : "") +
                (content.isLinear ? ", in linear light" : ""),
            tool::BlockSource(decoded, format),
            tool::BlockSource(original, format),
            decoded.width,
            decoded.height,
            outputs.size() / 16 * kept * (content.isLinear ? 2 : 1)};
}

BlockSizeRecord MeasureBlockSizes(const Encoding& encoding) {
    const tool::TextureSet set = tool::LoadTextureSet(encoding.path);
    const tool::TextureBytes bytes = tool::GetSetBytes(set.metadata);
    BlockSizeRecord record;
    record.encoding = encoding.record.name;
    for (const Texture& texture : set.metadata.GetTextures())
        record.formats.push_back(std::string(texture.name) + " " +
                                 tool::GetName(tool::ChooseBlockFormat(texture)));
    record.rawBytes = bytes.raw;
    record.blockBytes = bytes.blocks;
    record.memoryBytes = encoding.record.memoryBytes;
    record.fileBytes = encoding.record.fileBytes;
    return record;
}

std::vector<std::int32_t> GatherBlockHints(const BlockCase& c, const BlockTexture& texture) {
    std::vector<std::int32_t> hints;
    if (!c.isHinted)
        return hints;
    if (texture.height % 4 != 0)
        throw CommandError(ExitCode::Failed, c.GetId(),
                           tool::Format("%d rows: hints need a multiple of 4", texture.height));
    const std::vector<std::byte> blocks = PrepareBlocksOnCpu(c.GetSearch(), texture, 0)->Encode();
    for (std::size_t i = 0; i < blocks.size(); i += bc::GetBytesPerBlock(c.format))
        hints.push_back(bc::GetBlockHint(&blocks[i]));
    return hints;
}

std::unique_ptr<PreparedBlocks> PrepareBlocksOnCpu(const BlockCase& c, const BlockTexture& texture,
                                                   int threads) {
    return std::make_unique<CpuBlocks>(c, texture, threads);
}

BlockRecord JudgeBlocks(const BlockCase& c, const BlockTexture& texture, PreparedBlocks& prepared,
                        std::span<const std::byte> expected) {
    const std::vector<std::byte> blocks = prepared.Encode();
    BlockRecord record;
    record.id = c.GetId();
    record.format = bc::BlockFormatToString(c.format);
    record.level = std::string(tool::GetName(c.effort)) + (c.isHinted ? ", hints" : "");
    record.texture = texture.name;
    record.threads = prepared.GetThreads();
    record.width = texture.width;
    record.height = texture.height;
    record.rawBytes = texture.rawBytes;
    record.blockBytes = blocks.size();
    const tool::BlockMeasurement measurement = texture.decoded.MakeMeasurement();
    tool::BlockError toDecoded, toOriginal, neural;
    texture.decoded.Judge(blocks, 0, toDecoded);
    texture.original.Judge(blocks, 0, toOriginal);
    texture.original.Judge(texture.decoded, neural);
    record.psnrDecoded = GetPsnr(measurement, toDecoded);
    record.psnrSource = GetPsnr(measurement, toOriginal);
    record.psnrSourceBefore = GetPsnr(measurement, neural);
    const std::size_t unit = bc::GetBytesPerBlock(c.format);
    for (std::size_t i = 0; i < blocks.size(); i += unit) {
        ++record.comparedWithReference;
        record.differentFromReference += std::memcmp(&blocks[i], &expected[i], unit) != 0 ? 1 : 0;
    }
    return record;
}

} // namespace openntc::report
