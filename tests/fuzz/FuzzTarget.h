// SPDX-License-Identifier: MIT
// The function that every fuzz test calls: load a hostile file with everything that a load leads to, and say
// which promise was broken, if any.
#pragma once

#include "openntc/container/JsonWriter.h"
#include "openntc/container/Reader.h"
#include "openntc/core/CheckedMath.h"
#include "openntc/decode/ReferenceDecoder.h"
#include "openntc/inference/InferenceData.h"
#include "openntc/inference/LatentDecompression.h"
#include "openntc/inference/PartialInference.h"
#include "openntc/inference/ReadLatents.h"
#include "openntc/texture_set/TextureSetMetadata.h"
#include "support/CountingAllocator.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <vector>

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
    bool isContainer = false;     ///< ReadContainer accepted it, or would
    bool isTextureSet = false;    ///< TextureSetMetadata::Load accepted it
    const char* broken = nullptr; ///< the promise that was broken; null if none
    std::string message;          ///< of the refusal; empty if there was none
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

/// What was read can be written, and reads as the same document again.
inline const char* CheckRewriting(const container::Document& document) {
    const Expected<Array<char>> text = container::FormatDocument(document);
    Array<char> copy;
    if (!text || !copy.Assign(text->AsSpan()) || !copy.PushBack('\0'))
        return "an accepted document can be written";
    const Expected<container::Document> again =
        container::ParseDocument(copy.AsSpan(), GetDefaultAllocator());
    if (!again)
        return "a written document can be read";
    const Expected<Array<char>> rewritten = container::FormatDocument(*again);
    if (!rewritten || rewritten->size() != text->size() ||
        std::memcmp(rewritten->data(), text->data(), text->size()) != 0)
        return "a written document reads as itself";
    return nullptr;
}

/// Latents behind this are not read: mutations can make ranges of any size out of the files' own bytes.
constexpr std::uint64_t kMaxLatentBytes = 1u << 20;

/// A tile of GDeflate, compressed and not, and the largest table of tiles.
constexpr std::size_t kMaxReadingBytes = (192u << 10) + 8 + 4 * 65535;

/// What a device that decompresses tiles is told: as much memory as was promised, and, done on the CPU, the latents that
/// could be read, or none.
inline const char* CheckPlan(const TextureSetMetadata& set, Stream& stream, int mip,
                             const std::vector<std::byte>* latents) {
    const Expected<LatentDecompression> plan = PlanLatentDecompression(set, stream, mip, 1);
    if (!plan)
        return latents == nullptr ? nullptr : "latents that can be read can be planned";
    constexpr std::uint64_t kLayers = 2 * kMaxLatentLayers;
    if (plan->workBytes > 3 * plan->latentBytes + kLayers * (192u << 10))
        return "memory of a plan is bounded";
    std::vector<std::byte> work(static_cast<std::size_t>(plan->workBytes));
    std::vector<std::byte> planned(static_cast<std::size_t>(plan->latentBytes));
    if (!ReadLatentUploads(*plan, stream, std::span(work).first(static_cast<std::size_t>(plan->uploadBytes))))
        return "what is planned can be read";
    for (std::uint32_t tile = 0; tile < plan->tiles.size(); ++tile) {
        if (!DecompressLatentTile(plan->tiles[tile], work, planned, tile))
            return latents == nullptr ? nullptr : "latents that can be read are right tile by tile";
    }
    CopyLatents(*plan, work, planned);
    return latents == nullptr || planned == *latents ? nullptr : "planned latents are those that are read";
}

/// The outermost texel of the first and the last mip, with every kind of weights: what a decoder indexes with numbers of
/// the file lies inside what it was given. AddressSanitizer sees what does not.
inline const char* CheckDecoding(const TextureSetMetadata& set, Stream& stream) {
    const int mips = set.GetDesc().mips;
    for (const int mip : {0, mips - 1}) {
        const Expected<std::size_t> bytes = GetLatentBufferBytes(set, mip, 1);
        if (!bytes || *bytes > kMaxLatentBytes)
            continue;
        std::vector<std::byte> latents(*bytes);
        openntc::test::CountingAllocator allocator;
        const Expected<void> read = ReadLatents(set, stream, mip, 1, latents, allocator);
        if (allocator.GetPeakBytes() > kMaxReadingBytes)
            return "memory of reading latents is bounded";
        if (const char* broken = CheckPlan(set, stream, mip, read ? &latents : nullptr); broken != nullptr)
            return broken;
        if (!read && read.error().GetStatus() == Status::FileUnrecognized)
            continue; // compressed latents that are corrupt
        if (!read)
            return "latents of an accepted set can be read";
        const ColorMip& texels = set.GetColorMips()[static_cast<std::size_t>(mip)];
        for (const DecodeMath math : {DecodeMath::Int8, DecodeMath::FP8}) {
            const InferenceWeightType type =
                math == DecodeMath::FP8 ? InferenceWeightType::GenericFP8 : InferenceWeightType::GenericInt8;
            if (!set.IsInferenceWeightTypeSupported(type))
                continue;
            const Expected<NtcTextureSetConstants> constants = MakeInferenceData(set, mip, 1, type);
            if (!constants)
                continue; // latents off the 4-byte grid of the range
            const DecodeSource source{&*constants, latents, *set.GetInferenceWeights(type),
                                      set.GetNetworkVersion(), GetDecodeWeights(math)};
            std::array<float, NTC_MAX_CHANNELS> outputs;
            if (!DecodeReference(source, mip, {texels.width - 1, texels.height - 1, 1, 1}, {math, false},
                                 outputs))
                return "an accepted set can be decoded";
        }
    }
    return nullptr;
}

/// The slice of the last texel of the first mip has the bits of the whole set, from memory that is bounded.
inline const char* CheckSlice(const TextureSetMetadata& set, Stream& stream) {
    const ColorMip& texels = set.GetColorMips()[0];
    const SliceDesc desc{0, 1, {texels.width - 1, texels.height - 1, 1, 1}};
    const Expected<std::uint64_t> bytes = GetPartialLatentBufferSize(set, desc);
    const Expected<std::size_t> wholeBytes = GetLatentBufferBytes(set, 0, 1);
    const InferenceWeightType type = InferenceWeightType::GenericInt8;
    if (set.GetGeneration() == 1 || !bytes || !wholeBytes || *wholeBytes > kMaxLatentBytes ||
        !set.IsInferenceWeightTypeSupported(type))
        return nullptr;
    std::vector<std::byte> slice(static_cast<std::size_t>(*bytes)), whole(*wholeBytes);
    openntc::test::CountingAllocator allocator;
    const LatentMipSliceLayout layout = *GetLatentMipSlices(set, desc);
    const Expected<void> read = ReadLatentMipSlices(set, layout, stream, slice, allocator);
    if (allocator.GetPeakBytes() > kMaxReadingBytes)
        return "memory of reading slices is bounded";
    if (!read)
        return read.error().GetStatus() == Status::FileUnrecognized ? nullptr : "slices can be read";
    if (!ReadLatents(set, stream, 0, 1, whole))
        return nullptr; // corrupt elsewhere, or a wrong CRC-32
    const Expected<NtcTextureSetConstants> ofSlice = MakeSliceInferenceData(set, layout, type);
    const Expected<NtcTextureSetConstants> ofWhole = MakeInferenceData(set, 0, 1, type);
    if (!ofSlice || !ofWhole)
        return "an accepted set has constants";
    std::array<float, NTC_MAX_CHANNELS> outputs[2] = {};
    const auto decode = [&](const NtcTextureSetConstants& constants, std::span<const std::byte> latents,
                            std::array<float, NTC_MAX_CHANNELS>& to) {
        const DecodeSource source{&constants, latents, *set.GetInferenceWeights(type),
                                  set.GetNetworkVersion(), DecodeWeights::Int8};
        return DecodeReference(source, 0, desc.rect, {}, to).has_value();
    };
    if (!decode(*ofSlice, slice, outputs[0]) || !decode(*ofWhole, whole, outputs[1]))
        return "an accepted set can be decoded";
    return std::memcmp(&outputs[0], &outputs[1], sizeof outputs[0]) == 0 ? nullptr
                                                                         : "a slice has the bits of the set";
}

/// `field: value: limit`: what is wrong, what was found, what would be right, on one line.
inline bool NamesFieldValueAndLimit(std::string_view text) {
    const std::size_t value = text.find(": ");
    const std::size_t limit = value == std::string_view::npos ? value : text.find(": ", value + 2);
    return value != 0 && limit != std::string_view::npos && limit > value + 2 && limit + 2 < text.size() &&
           text.find('\n') == std::string_view::npos;
}

inline void LoadTextureSet(Stream& stream, Allocator& allocator, Outcome& outcome) {
    const Expected<TextureSetMetadata> set = TextureSetMetadata::Load(stream, allocator);
    outcome.isTextureSet = set.has_value();
    if (!set) {
        outcome.message = set.error().GetText();
        if (!NamesFieldValueAndLimit(outcome.message))
            outcome.broken = "messages name field, value and limit";
        return;
    }
    outcome.isContainer = true;
    outcome.broken = CheckTextureSet(*set, stream.Size());
    if (outcome.broken == nullptr)
        outcome.broken = CheckRewriting(set->GetDocument());
    if (outcome.broken == nullptr)
        outcome.broken = CheckDecoding(*set, stream);
    if (outcome.broken == nullptr)
        outcome.broken = CheckSlice(*set, stream);
}

inline void LoadContainer(Stream& stream, Allocator& allocator, Outcome& outcome) {
    const Expected<container::Container> container = container::ReadContainer(stream, allocator);
    outcome.isContainer = container.has_value();
    if (!container)
        return;
    if (!IsRangeInside(container->binaryOffset, container->binarySize, stream.Size()))
        outcome.broken = "the binary chunk is inside the stream";
    else
        outcome.broken = CheckRewriting(container->document);
}

/// Loads the file front + back. A refused set is read once more as a container alone if its JSON has a size that is a
/// multiple of 4: the refusal has been through the same code already.
inline Outcome LoadEverything(std::span<const std::byte> front, std::span<const std::byte> back) {
    Outcome outcome;
    openntc::test::CountingAllocator allocator;
    TwoPartStream stream(front, back);
    std::uint64_t jsonSize = 0;
    container::HeaderBytes headerBytes;
    if (stream.Read(headerBytes.data(), headerBytes.size())) {
        if (const Expected<container::Header> header = container::DecodeHeader(headerBytes, stream.Size()))
            jsonSize = header->jsonSize;
    }
    LoadTextureSet(stream, allocator, outcome);
    if (!outcome.isTextureSet && outcome.broken == nullptr && jsonSize % 4 == 0)
        LoadContainer(stream, allocator, outcome);
    if (allocator.GetPeakBytes() > MaxPeakBytes(jsonSize))
        outcome.broken = "peak memory is bounded";
    if (allocator.GetUsedBytes() != 0)
        outcome.broken = "all memory is given back";
    return outcome;
}

} // namespace openntc::fuzz
