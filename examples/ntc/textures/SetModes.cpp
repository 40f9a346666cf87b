// SPDX-License-Identifier: MIT
#include "textures/SetModes.h"

#include "Failure.h"
#include "TextureSizes.h"
#include "textures/HintMaps.h"

#include "openntc/texture_set/Rewrite.h"

#include <memory>
#include <optional>
#include <utility>

namespace openntc::tool {

std::vector<std::byte> PutModes(const TextureSetMetadata& metadata, Stream& stream,
                                std::span<const bc::BlockHintMap> maps, bool compress,
                                const std::string& subject) {
    constexpr bool kWithoutOldModes = false;
    WritableTextureSet set =
        Require(MakeWritableCopy(metadata, stream, GetDefaultAllocator(), kWithoutOldModes),
                ExitCode::BadInput, subject);
    CompressionOptions compression;
    compression.blockModes = compress;
    Require(set.SetCompression(compression), ExitCode::Failed, subject);
    for (const bc::BlockHintMap& map : maps) {
        Require(set.AddBlockModes(map.texture, static_cast<int>(map.mip), map.packed), ExitCode::Failed,
                subject);
        BlockCompressedFormat& declared = set.GetDocument().textures[map.texture].bcFormat;
        if (declared == BlockCompressedFormat::None)
            declared = BlockCompressedFormat::BC7;
    }
    MemoryStream file;
    Require(set.Write(file), ExitCode::Failed, subject);
    return {file.GetBytes().begin(), file.GetBytes().end()};
}

SetModes AddModes(std::span<const std::byte> file, bool compress, int threads, const std::string& subject,
                  const std::function<void(std::uint64_t, std::uint64_t)>& advance) {
    ReadOnlyMemoryStream stream(file);
    const TextureSetMetadata metadata = Require(TextureSetMetadata::Load(stream), ExitCode::Failed, subject);
    HintMapMaker maker(metadata, BlockEffort::Best, threads, subject);
    const std::span<const Texture> textures = metadata.GetTextures();
    for (std::size_t i = 0; i < textures.size(); ++i) {
        const std::optional<ChosenFormat> chosen =
            ChooseBlockFormat(textures[i]) == BlockCompressedFormat::BC7
                ? ChooseFormat(textures[i], {false, bc::BlockFormat::Bc7}, false)
                : std::nullopt;
        if (chosen)
            maker.AddTexture(i, chosen->format);
    }
    SetModes result;
    result.textures = maker.GetTextures().size();
    if (result.textures == 0)
        return result;
    const DecodeData data = LoadDecodeData(metadata, stream, subject);
    BackendOptions backend;
    backend.threads = threads;
    const std::unique_ptr<Decoder> decoder = RequireDecoder(subject, data, backend);
    maker.Run(*decoder, DecodeMath::Int8,
              [&, all = maker.GetTexels()](std::uint64_t texels) { advance(texels, all); });
    for (const HintMapMaker::TextureWork& work : maker.GetTextures())
        result.statistics += work.gatherer.GetStatistics();
    result.file = PutModes(metadata, stream, maker.GetMaps(), compress, subject);
    return result;
}

} // namespace openntc::tool
