// SPDX-License-Identifier: MIT
// Hints for the BC7 blocks of some textures of a set: every mip decoded, searched and mapped.
#pragma once

#include "Decoder.h"
#include "textures/HintGatherer.h"
#include "textures/TexelConverter.h"

#include "openntc/bc/BlockHints.h"

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <string>
#include <vector>

namespace openntc::tool {

class HintMapMaker {
public:
    struct TextureWork {
        std::size_t index; ///< in the set
        const Texture* texture;
        TextureFormat format;
        TexelConverter converter;
        HintGatherer gatherer;
    };

    /// The set must outlive it. `threads`: 0 is all. `subject` is named in errors.
    HintMapMaker(const TextureSetMetadata& metadata, BlockEffort effort, int threads, std::string subject)
        : metadata_(metadata), effort_(effort), threads_(threads), subject_(std::move(subject)) {}

    /// `format` is of BC7.
    void AddTexture(std::size_t index, const TextureFormat& format);

    const std::deque<TextureWork>& GetTextures() const { return textures_; }
    /// Of all mips of all textures: what `advance` comes to.
    std::uint64_t GetTexels() const;
    /// Once. Throws CommandError(Failed), also when interrupted.
    void Run(Decoder& decoder, DecodeMath math, const std::function<void(std::uint64_t)>& advance);
    /// Texture by texture, so that a loader finds what belongs together; they point into this object.
    std::vector<bc::BlockHintMap> GetMaps() const;

private:
    struct Map {
        bc::BlockHintMap map;
        std::vector<std::byte> packed;
    };

    void GatherMip(Decoder& decoder, DecodeMath math, int mip,
                   const std::function<void(std::uint64_t)>& advance);

    const TextureSetMetadata& metadata_;
    BlockEffort effort_;
    int threads_;
    std::string subject_;
    std::deque<TextureWork> textures_;
    std::deque<Map> maps_;
    std::vector<float> outputs_;
    std::vector<std::byte> texels_;
};

} // namespace openntc::tool
