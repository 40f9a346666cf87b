// SPDX-License-Identifier: MIT
// The function that every fuzz test calls: load a hostile file with everything that a load leads to, and say
// which promise was broken, if any.
#pragma once

#include "openntc/container/JsonWriter.h"
#include "openntc/container/Reader.h"
#include "openntc/inference/InferenceData.h"
#include "openntc/texture_set/TextureSetMetadata.h"
#include "support/CountingAllocator.h"

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <span>
#include <string>

namespace openntc::fuzz {

/// A file in two pieces, so that a mutated front can be put before a shared back without copying the latter.
class TwoPartStream final : public Stream {
public:
    TwoPartStream(std::span<const std::byte> front, std::span<const std::byte> back) noexcept
        : front_(front), back_(back) {}

    bool Read(void* destination, std::size_t bytes) noexcept override {
        if (bytes > Size() - position_)
            return false;
        std::byte* to = static_cast<std::byte*>(destination);
        for (const bool isFront : {true, false}) {
            const std::span<const std::byte> part = isFront ? front_ : back_;
            const std::size_t start = static_cast<std::size_t>(position_) - (isFront ? 0 : front_.size());
            const std::size_t count =
                isFront && position_ >= front_.size() ? 0 : std::min(bytes, part.size() - start);
            if (count > 0)
                std::memcpy(to, part.data() + start, count);
            to += count;
            bytes -= count;
            position_ += count;
            if (bytes == 0)
                break;
        }
        return true;
    }
    bool Write(const void*, std::size_t) noexcept override { return false; }
    bool Seek(std::uint64_t offset) noexcept override {
        position_ = offset <= Size() ? offset : position_;
        return offset <= Size();
    }
    std::uint64_t Tell() noexcept override { return position_; }
    std::uint64_t Size() noexcept override { return front_.size() + back_.size(); }

private:
    std::span<const std::byte> front_;
    std::span<const std::byte> back_;
    std::uint64_t position_ = 0;
};

/// Outcome of one load.
struct Outcome {
    bool isContainer = false;  ///< ReadContainer accepted it
    bool isTextureSet = false; ///< TextureSetMetadata::Load accepted it
    Status status = Status::Ok;
    const char* broken = nullptr; ///< the promise that was broken; null if none
};

/// Peak memory of loading: the text itself and what it may grow to (ParseDocument), plus weights of both
/// kinds, their copies on the way, and fixed tables.
constexpr std::size_t MaxPeakBytes(std::uint64_t jsonSize) noexcept {
    return (256u << 10) + 12 * static_cast<std::size_t>(jsonSize);
}

inline const char* CheckTextureSet(const TextureSetMetadata& set, std::uint64_t streamSize) {
    const int mips = set.GetDesc().mips;
    if (mips < 1 || mips > NTC_MAX_MIPS)
        return "mips within limits";
    for (int first = -1; first <= mips; ++first) {
        (void)set.GetFusedMipLevels(first);
        (void)set.GetMipLevelsForLatentImage(first);
        for (int count = -1; count <= mips - first + 1; ++count) {
            const Expected<StreamRange> range = set.GetStreamRangeForLatents(first, count);
            if (!range)
                continue;
            if (!IsRangeInside(range->offset, range->size, streamSize))
                return "latent ranges inside the stream";
            if (first > 0 && count > 1) // the rest is alike: save time
                continue;
            for (const InferenceWeightType type :
                 {InferenceWeightType::GenericInt8, InferenceWeightType::GenericFP8}) {
                const Expected<NtcTextureSetConstants> constants = MakeInferenceData(set, *range, type);
                if (constants && constants->imageMips != mips)
                    return "constants hold the mips";
                if (constants && set.GetInferenceWeights(type)->empty())
                    return "constants only with weights";
            }
        }
    }
    return nullptr;
}

inline Outcome LoadEverything(std::span<const std::byte> front, std::span<const std::byte> back) {
    Outcome outcome;
    openntc::test::CountingAllocator allocator;
    TwoPartStream stream(front, back);
    std::uint64_t jsonSize = 0;
    container::HeaderBytes header;
    if (stream.Read(header.data(), header.size())) {
        if (const Expected<container::Header> decoded = container::DecodeHeader(header, stream.Size()))
            jsonSize = decoded->jsonSize;
    }
    {
        const Expected<container::Container> container = container::ReadContainer(stream, allocator);
        outcome.isContainer = container.has_value();
        if (!container) {
            outcome.status = container.error().GetStatus();
            if (container.error().GetText()[0] == '\0')
                outcome.broken = "errors have a message";
        } else if (!IsRangeInside(container->binaryOffset, container->binarySize, stream.Size())) {
            outcome.broken = "the binary chunk is inside the stream";
        } else {
            // What was read can be written, and reads as the same document again.
            const Expected<Array<char>> text = container::FormatDocument(container->document);
            Array<char> copy;
            if (!text || !copy.Assign(text->AsSpan()) || !copy.PushBack('\0')) {
                outcome.broken = "an accepted document can be written";
            } else {
                const Expected<container::Document> again =
                    container::ParseDocument(copy.AsSpan(), GetDefaultAllocator());
                const Expected<Array<char>> rewritten =
                    again ? container::FormatDocument(*again) : Expected<Array<char>>(PassError(again));
                if (!rewritten || rewritten->size() != text->size() ||
                    std::memcmp(rewritten->data(), text->data(), text->size()) != 0)
                    outcome.broken = "a written document reads as itself";
            }
        }
    }
    if (outcome.broken == nullptr) {
        const Expected<TextureSetMetadata> set = TextureSetMetadata::Load(stream, allocator);
        outcome.isTextureSet = set.has_value();
        if (set) {
            outcome.broken = CheckTextureSet(*set, stream.Size());
        } else {
            outcome.status = set.error().GetStatus();
            if (set.error().GetText()[0] == '\0')
                outcome.broken = "errors have a message";
        }
        if (set && !outcome.isContainer)
            outcome.broken = "a texture set is a container";
    }
    if (allocator.GetPeakBytes() > MaxPeakBytes(jsonSize))
        outcome.broken = "peak memory is bounded";
    if (allocator.GetUsedBytes() != 0)
        outcome.broken = "all memory is given back";
    return outcome;
}

} // namespace openntc::fuzz
