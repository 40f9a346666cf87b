// SPDX-License-Identifier: MIT
#include "encode/ContentKey.h"

#include "Failure.h"
#include "Interrupt.h"
#include "Output.h"

#include "openntc/core/Crc32.h"
#include "openntc/core/FileStream.h"

#include <algorithm>
#include <cinttypes>
#include <string_view>

namespace openntc::tool {

namespace {

constexpr int kEncoderVersion = 6; // changes when the same input should be encoded anew

/// Fowler, Noll and Vo's FNV-1a, 64 bits.
class Hasher {
public:
    void AddBytes(std::span<const std::byte> bytes) {
        for (const std::byte b : bytes)
            state_ = (state_ ^ static_cast<unsigned char>(b)) * 0x100000001b3u;
    }
    /// With its length, so that parts cannot run into each other.
    void Add(std::string_view text) {
        AddBytes(std::as_bytes(std::span(text)));
        state_ = (state_ ^ text.size()) * 0x100000001b3u;
    }
    void Add(double value) { Add(Format("%a", value)); } // every bit
    std::uint64_t Get() const { return state_; }
    std::string GetText() const { return Format("%016" PRIx64, state_); }

private:
    std::uint64_t state_ = 0xcbf29ce484222325u;
};

class DigestMaker {
public:
    void Add(std::span<const std::byte> bytes) {
        size_ += bytes.size();
        crc_ = Crc32(bytes, crc_);
        hasher_.AddBytes(bytes);
    }
    std::string GetText() const { return Format("%" PRIx64 "-%08x-", size_, crc_) + hasher_.GetText(); }

private:
    std::uint64_t size_ = 0;
    std::uint32_t crc_ = 0;
    Hasher hasher_;
};

// Structured bindings of whole structures: a member that is added to one does not compile here until somebody has
// decided whether it changes the bytes of a file. What does not is left unused.

void AddTraining(Hasher& hasher, const encode::EncodeOptions& options) {
    const auto& [shape, bitsPerPixel, network, effort, steps, seconds, seed, threads, maskChannel, fp8,
                 compress, discardMasked, lossScales, resumeState, resumeFraction, reportSeconds, save,
                 saveSeconds, kernel, batchTexels, rateScale] = options;
    hasher.Add(Format("%d|%d,%d,%d,%d,%d|%d|%d|%" PRIu64 "|%u|%d|%d%d|%d|%d", kEncoderVersion,
                      shape.gridSizeScale, shape.highResFeatures, shape.lowResFeatures,
                      shape.highResQuantBits, shape.lowResQuantBits, network, static_cast<int>(effort), steps,
                      seed, maskChannel, (fp8 ? 1 : 0) + (compress ? 2 : 0), discardMasked ? 1 : 0,
                      kernel == encode::KernelChoice::Portable ? 1 : 0, batchTexels));
    hasher.Add(static_cast<double>(bitsPerPixel));
    hasher.Add(seconds);
    hasher.Add(static_cast<double>(rateScale));
    for (const float scale : lossScales)
        hasher.Add(static_cast<double>(scale));
}

void AddNames(Hasher& hasher, const std::vector<std::string>& names) {
    hasher.Add(Format("%zu", names.size()));
    for (const std::string& name : names)
        hasher.Add(name);
}
void AddNumbers(Hasher& hasher, const std::vector<NamedNumber>& numbers) {
    hasher.Add(Format("%zu", numbers.size()));
    for (const auto& [name, number] : numbers) {
        hasher.Add(name);
        hasher.Add(number);
    }
}

/// A number of an enumeration that may be absent.
template <typename T>
int GetNumber(const std::optional<T>& value) {
    return value ? static_cast<int>(*value) : -1;
}

void AddInputs(Hasher& hasher, const InputOptions& options) {
    const auto& [paths, manifest, mips, strict, srgb, linear, keepCoverage, maskChannel, mipFilter, mipWrap,
                 normalMaps, weights, targets] = options;
    hasher.Add(
        Format("%d|%d|%d|%d", mips, maskChannel.value_or(-2), GetNumber(mipFilter), GetNumber(mipWrap)));
    hasher.Add(static_cast<double>(keepCoverage));
    AddNames(hasher, srgb);
    AddNames(hasher, linear);
    AddNames(hasher, normalMaps);
    AddNumbers(hasher, weights);
    AddNumbers(hasher, targets);
}

void AddTexture(Hasher& hasher, const ManifestTexture& texture) {
    const auto& [path, bytes, name, swizzle, firstChannel, isSrgb, colorReason, bcFormat, mipLevel,
                 lossScales, targetPsnr, mipFilter, normalMap, verticalFlip, maskLetter, keepAlpha,
                 alphaIsData] = texture;
    hasher.Add(name);
    hasher.Add(swizzle);
    hasher.Add(targetPsnr);
    hasher.Add(Format("%d|%d|%d|%d|%d|%d|%d|%d|%d|%zu", firstChannel, GetNumber(isSrgb),
                      static_cast<int>(bcFormat), mipLevel, GetNumber(mipFilter), normalMap ? 1 : 0,
                      verticalFlip ? 1 : 0, maskLetter, keepAlpha ? 1 : 0, lossScales.size()));
    for (const float scale : lossScales)
        hasher.Add(static_cast<double>(scale));
    if (alphaIsData) // not in keys of before, which stay good without it
        hasher.Add("alpha is data");
}

} // namespace

std::string MakeDigest(std::span<const std::byte> bytes) {
    DigestMaker maker;
    maker.Add(bytes);
    return maker.GetText();
}

std::string MakeFileDigest(const std::string& path) {
    FileReader file = Require(FileReader::Open(path), ExitCode::BadInput, path);
    std::vector<std::byte> piece(1u << 20);
    DigestMaker maker;
    for (std::uint64_t left = file.Size(); left > 0;) {
        ThrowIfInterrupted();
        const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(left, piece.size()));
        if (!file.Read(piece.data(), count))
            throw CommandError(ExitCode::BadInput, path, "file: cannot be read to its end");
        maker.Add(std::span(piece).first(count));
        left -= count;
    }
    return maker.GetText();
}

std::string MakeImageDigest(const ManifestTexture& texture) {
    return texture.bytes.buffer == nullptr ? MakeFileDigest(texture.path) : MakeDigest(texture.bytes.Get());
}

std::string MakeSettingsKey(const EncodeJob& job) {
    const auto& [training, generation, targetPsnr, textureTargets, maximumBits, device, hasShape, blockModes,
                 strict] = job.training;
    Hasher hasher;
    AddTraining(hasher, training);
    hasher.Add(targetPsnr);
    AddNumbers(hasher, textureTargets);
    hasher.Add(maximumBits);
    hasher.Add(Format("%d", hasShape ? 1 : 0));
    AddInputs(hasher, job.inputs);
    if (blockModes) // not in keys of before, which stay good without it
        hasher.Add("BC7 modes");
    return hasher.GetText();
}

std::string MakeContentKey(const EncodeJob& job, const ImageDigest& digest) {
    const auto& [textures, width, height, keepCoverage, mips] = *job.inputs.manifest;
    const auto& [mipFilter, mipWrap] = mips;
    Hasher hasher;
    hasher.Add(MakeSettingsKey(job));
    hasher.Add(Format("%d|%d|%d|%d", width, height, static_cast<int>(mipFilter), static_cast<int>(mipWrap)));
    hasher.Add(static_cast<double>(keepCoverage));
    for (const ManifestTexture& texture : textures) {
        AddTexture(hasher, texture);
        hasher.Add(digest(texture));
    }
    return hasher.GetText();
}

} // namespace openntc::tool
