// SPDX-License-Identifier: MIT
#include "gltf/ContentKey.h"

#include "Output.h"
#include "TextureSet.h"

#include "openntc/core/Crc32.h"

#include <cinttypes>
#include <span>
#include <string_view>

namespace openntc::tool {

namespace {

/// Fowler, Noll and Vo's FNV-1a, 64 bits.
class Hasher {
public:
    void Add(std::string_view text) {
        for (const char c : text)
            state_ = (state_ ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
        state_ = (state_ ^ text.size()) * 0x100000001b3u;
    }
    std::uint64_t Get() const { return state_; }

private:
    std::uint64_t state_ = 0xcbf29ce484222325u;
};

} // namespace

std::string MakeContentKey(const EncodeJob& job) {
    constexpr int kEncoderVersion = 5; // changes when the same input should be encoded anew
    const encode::EncodeOptions& e = job.training.encode;
    const LatentShape& s = e.latentShape;
    Hasher hasher;
    hasher.Add(Format("%d|%d,%d,%d,%d,%d|%a|%d|%d|%" PRIu64 "|%a|%u|%d%d%d|%a|%a|%d", kEncoderVersion,
                      s.gridSizeScale, s.highResFeatures, s.lowResFeatures, s.highResQuantBits,
                      s.lowResQuantBits, static_cast<double>(e.bitsPerPixel), e.networkVersion,
                      static_cast<int>(e.effort), e.steps, e.seconds, e.seed, e.discardMasked ? 1 : 0,
                      e.fp8 ? 1 : 0, static_cast<int>(e.kernel), job.training.targetPsnr,
                      job.training.maximumBits, job.inputs.mips));
    hasher.Add(Format("mips %d|%d", static_cast<int>(job.inputs.manifest->mips.filter),
                      static_cast<int>(job.inputs.manifest->mips.wrap)));
    for (const NamedNumber& target : job.training.textureTargets)
        hasher.Add(target.name + Format("|%a", target.number));
    if (job.training.device)
        hasher.Add(Format("device %d", e.batchTexels));
    if (job.inputs.manifest->keepCoverage > 0.0f)
        hasher.Add(Format("coverage %a", static_cast<double>(job.inputs.manifest->keepCoverage)));
    for (const ManifestTexture& texture : job.inputs.manifest->textures) {
        std::vector<std::byte> file;
        if (texture.bytes.buffer == nullptr)
            file = ReadAll(texture.path);
        const std::span<const std::byte> bytes = texture.bytes.buffer == nullptr ? file : texture.bytes.Get();
        hasher.Add(texture.name + "|" + texture.swizzle +
                   Format("|%d|%d|%c|%d|%d|%zu|%08x", texture.firstChannel,
                          texture.isSrgb.value_or(false) ? 1 : 0,
                          texture.maskLetter == 0 ? '-' : texture.maskLetter, texture.keepAlpha ? 1 : 0,
                          static_cast<int>(texture.bcFormat), bytes.size(), Crc32(bytes)));
        hasher.Add({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    }
    return Format("%016" PRIx64, hasher.Get());
}

} // namespace openntc::tool
