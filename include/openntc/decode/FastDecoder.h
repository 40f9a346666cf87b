// SPDX-License-Identifier: MIT
// Stability: stable
// The fast CPU decoder: SIMD and threads, the same bits as the reference decoder.
#pragma once

#include "openntc/core/Allocator.h"
#include "openntc/core/Processor.h"
#include "openntc/core/ThreadTeam.h"
#include "openntc/decode/DecodeTypes.h"
#include "openntc/decode/fast/SimdAmx.h"
#include "openntc/decode/fast/SimdAvx2.h"
#include "openntc/decode/fast/SimdAvx512.h"
#include "openntc/decode/fast/SimdPortable.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "openntc/core/HideMacros.h"

#include "openntc/ColorSpaces.h" // and GLM: their min, max, abs and round are names too

namespace openntc {

/// Instruction sets that the fast decoder has code for. Best picks the fastest one of the machine at run
/// time.
enum class SimdTarget {
    Best,
    Portable, ///< 16-byte vectors of the baseline processor (SSE2, NEON, …)
    Avx2,
    AvxVnni, ///< AVX2 with 256-bit dot products
    Avx512Vnni,
    Amx, ///< matrix tiles, with AVX-512 VNNI; Linux
};

/// The enumerator's name in lower case: "best", "portable", "avx2", "avxvnni", "avx512vnni", "amx".
constexpr const char* SimdTargetToString(SimdTarget target) noexcept {
    switch (target) {
    case SimdTarget::Portable:
        return "portable";
    case SimdTarget::Avx2:
        return "avx2";
    case SimdTarget::AvxVnni:
        return "avxvnni";
    case SimdTarget::Avx512Vnni:
        return "avx512vnni";
    case SimdTarget::Amx:
        return "amx";
    case SimdTarget::Best:
        break;
    }
    return "best";
}

struct FastDecoderOptions {
    SimdTarget target = SimdTarget::Best;
    int threads = 0; ///< 0: one per hardware thread; otherwise at most this many (small rectangles use fewer)
};

/// True if this build and this machine can run a target, and OPENNTC_SIMD_CAP (core/Processor.h) allows it.
inline bool IsSimdTargetAvailable(SimdTarget target) noexcept {
#if OPENNTC_FAST_X86
    const ProcessorFeatures& features = GetProcessorFeatures();
#else
    const ProcessorFeatures features; // there is no code for them
#endif
    switch (target) {
    case SimdTarget::Avx2:
        return features.avx2;
    case SimdTarget::AvxVnni:
        return features.avxVnni;
    case SimdTarget::Avx512Vnni:
        return features.avx512Vnni;
    case SimdTarget::Amx:
        return OPENNTC_FAST_AMX != 0 && features.amxInt8 && RequestMatrixTiles();
    case SimdTarget::Best:
    case SimdTarget::Portable:
        break;
    }
    return true;
}

/// Decodes rectangles of one texture set. Immutable after Create: Decode may be called from any thread.
/// Refers to the latents of its source, which must outlive it; constants and weights are copied. Results
/// equal DecodeReference bit for bit on every target and for every number of threads.
class FastDecoder {
public:
    /// Reorders the weights for a target (15 to 34 KiB from `allocator`, by network and target) and, where
    /// the target has fused multiply-adds, looks for a cheaper form of the activation with the same results
    /// (half a millisecond). Errors: those of ValidateDecodeSource; Unsupported if the machine lacks the
    /// target or the source has FP8 weights; OutOfRange for a negative number of threads; InvalidArgument
    /// for an OPENNTC_SIMD_CAP that names no cap; OutOfMemory.
    static Expected<FastDecoder> Create(const DecodeSource& source, const FastDecoderOptions& options = {},
                                        Allocator& allocator = GetDefaultAllocator()) noexcept {
        if (source.weightFormat != DecodeWeights::Int8)
            return Fail(Status::Unsupported, "weightFormat: FP8: the fast decoder needs Int8 weights");
        OPENNTC_CHECK(ValidateDecodeSource(source));
        if (options.threads < 0)
            return Fail(Status::OutOfRange, "threads: %d: must not be negative", options.threads);
        OPENNTC_CHECK(GetSimdCap());
        if (!IsSimdTargetAvailable(options.target))
            return Fail(Status::Unsupported, "target: %s: this machine or build does not have it",
                        SimdTargetToString(options.target));
        FastDecoder decoder(allocator);
        decoder.SelectKernel(options);
        decoder.constants_ = *source.constants;
        decoder.latents_ = source.latents;
        decoder.generation_ = GetGeneration(source.networkVersion);
        const NtcTextureSetConstants& c = decoder.constants_;
        fast::NetworkSource network;
        network.weights = source.weights.data();
        network.weightOffsets[0] = c.networkWeightOffset0;
        network.weightOffsets[1] = c.networkWeightOffset1;
        network.weightOffsets[2] = c.networkWeightOffset2;
        network.weightOffsets[3] = c.networkWeightOffset3;
        network.scaleOffset = c.networkScaleBiasOffset;
        network.networkVersion = source.networkVersion;
        network.highResFeatures = c.highResEncoding.numFeatures;
        network.lowResFeatures = c.lowResEncoding.numFeatures;
        OPENNTC_ASSIGN(decoder.network_, fast::PrepareNetwork(network, decoder.kernel_.layout,
                                                              decoder.kernel_.fuses, decoder.weights_));
        return decoder;
    }

    /// The target in use; never Best.
    SimdTarget GetTarget() const noexcept { return target_; }

    /// Decodes a rectangle of texels of one mip: 16 binary32 per texel, texels row by row. The rectangle may
    /// lie outside the image: latents are clamped there (of generations 2 and 3 they wrap), positional inputs
    /// are not. Errors: OutOfRange for mip, rectangle or too few outputs; Unsupported if the latents of the
    /// mip are absent or the maths mode is neither Int8 nor Int8Half; OutOfMemory (about 100 KiB per thread
    /// for the duration of the call).
    Expected<void> Decode(int mip, Rect rect, const DecodeOptions& options,
                          std::span<float> outputs) const noexcept {
        if (options.math != DecodeMath::Int8 && options.math != DecodeMath::Int8Half)
            return Fail(Status::Unsupported, "math: %d: the fast decoder has Int8 (%d) and Int8Half (%d)",
                        static_cast<int>(options.math), static_cast<int>(DecodeMath::Int8),
                        static_cast<int>(DecodeMath::Int8Half));
        OPENNTC_CHECK(detail::ValidateDecodeRequest(constants_, mip, rect, outputs.size()));
        const fast::MipView view = MakeMipView(mip);
        const int columns = (rect.width + fast::kTileWidth - 1) / fast::kTileWidth;
        const int rows = (rect.height + fast::kTileHeight - 1) / fast::kTileHeight;
        const int tiles = columns * rows; // far below 2^31: the outputs of so many fit into no memory
        const int available = threads_ > 0 ? threads_ : CountHardwareThreads();
        ThreadTeam team(tiles < available ? tiles : available);
        const auto workers = static_cast<std::size_t>(team.GetThreadCount());

        constexpr std::size_t kAlignment = 64;
        Array<std::byte> scratch(weights_.GetAllocator());
        const std::size_t stride = (kernel_.scratchBytes + kAlignment - 1) / kAlignment * kAlignment;
        OPENNTC_CHECK(scratch.Reserve(stride * workers + kAlignment));
        const std::size_t misalignment = reinterpret_cast<std::uintptr_t>(scratch.data()) % kAlignment;
        std::byte* const firstScratch = scratch.data() + (kAlignment - misalignment) % kAlignment;

        team.Run(tiles, [&](int tile, int thread) noexcept {
            const int x = tile % columns * fast::kTileWidth;
            const int y = tile / columns * fast::kTileHeight;
            fast::TileJob job;
            job.network = &network_;
            job.mip = &view;
            job.epilogue = GetEpilogue(options.math);
            job.outputRowStride = static_cast<std::size_t>(rect.width) * NTC_MAX_CHANNELS;
            job.left = rect.left + x;
            job.top = rect.top + y;
            job.width = rect.width - x < fast::kTileWidth ? rect.width - x : fast::kTileWidth;
            job.height = rect.height - y < fast::kTileHeight ? rect.height - y : fast::kTileHeight;
            job.outputs = outputs.data() + static_cast<std::size_t>(y) * job.outputRowStride +
                          static_cast<std::size_t>(x) * NTC_MAX_CHANNELS;
            kernel_.decode(job, firstScratch + stride * static_cast<std::size_t>(thread));
            if (options.convertToLinear)
                ConvertTileToLinear(job);
        });
        return {};
    }

private:
    explicit FastDecoder(Allocator& allocator) noexcept : weights_(allocator) {}

    void SelectKernel(const FastDecoderOptions& options) noexcept {
        threads_ = options.threads < kMaxThreads ? options.threads : kMaxThreads;
        target_ = SimdTarget::Portable;
        kernel_ = fast::portable::kTileKernel;
#if OPENNTC_FAST_X86
        const ProcessorFeatures& features = GetProcessorFeatures();
        const bool best = options.target == SimdTarget::Best;
#if OPENNTC_FAST_AMX
        if (features.amxInt8 && (best || options.target == SimdTarget::Amx) && RequestMatrixTiles()) {
            target_ = SimdTarget::Amx;
            kernel_ = fast::avx512::amx::kTileKernel;
            return;
        }
#endif
        if (features.avx512Vnni && (best || options.target == SimdTarget::Avx512Vnni)) {
            target_ = SimdTarget::Avx512Vnni;
            kernel_ = fast::avx512::kTileKernel;
        } else if (features.avxVnni && (best || options.target == SimdTarget::AvxVnni)) {
            target_ = SimdTarget::AvxVnni;
            kernel_ = fast::avx2::vnni::kTileKernel;
        } else if (features.avx2 && (best || options.target == SimdTarget::Avx2)) {
            target_ = SimdTarget::Avx2;
            kernel_ = fast::avx2::pairs::kTileKernel;
        }
#endif
    }

    fast::Epilogue GetEpilogue(DecodeMath math) const noexcept {
        if (math == DecodeMath::Int8Half || generation_ == 2)
            return fast::Epilogue::Binary16;
        return generation_ == 3 ? fast::Epilogue::Generation3 : fast::Epilogue::Binary32;
    }

    fast::GridView MakeGridView(const NtcNeuralMipConstants& grid,
                                const NtcLatentEncodingConstants& encoding) const noexcept {
        fast::GridView view;
        view.data = latents_.data() + grid.dataOffset;
        view.imageWidth = static_cast<int>(grid.imageWidthHeight & 0xFFFFu);
        view.imageHeight = static_cast<int>(grid.imageWidthHeight >> 16);
        view.sliceLeft = static_cast<int>(grid.sliceLeftTop & 0xFFFFu);
        view.sliceTop = static_cast<int>(grid.sliceLeftTop >> 16);
        view.sliceWidth = static_cast<int>(grid.sliceWidthHeight & 0xFFFFu);
        view.sliceHeight = static_cast<int>(grid.sliceWidthHeight >> 16);
        view.features = encoding.numFeatures;
        view.bits = encoding.quantBits;
        view.codeScale = encoding.quantizedScale;
        view.codeBias = encoding.quantizedBias;
        view.isLatentMip = generation_ != 1;
        return view;
    }

    fast::MipView MakeMipView(int mip) const noexcept {
        const NtcColorMipConstants& color = constants_.colorMips[mip];
        fast::MipView view;
        view.width = constants_.imageWidth >> mip > 1 ? constants_.imageWidth >> mip : 1;
        view.height = constants_.imageHeight >> mip > 1 ? constants_.imageHeight >> mip : 1;
        view.positionScale = color.positionScale;
        view.lodWord = fast::MakeLodWord(color.positionLod, generation_ == 1);
        view.highRes =
            MakeGridView(constants_.highResNeuralMips[color.neuralMip], constants_.highResEncoding);
        view.highRes.isPerCorner = generation_ == 1;
        view.lowRes = MakeGridView(constants_.lowResNeuralMips[color.neuralMip], constants_.lowResEncoding);
        view.truncates = generation_ == 2;
        return view;
    }

    void ConvertTileToLinear(const fast::TileJob& job) const noexcept {
        for (int channel = 0; channel < NTC_MAX_CHANNELS; ++channel) {
            const int space = shader::NtcGetChannelColorSpace(constants_.channelColorSpaces, channel);
            if (space != NTC_COLOR_SPACE_SRGB && space != NTC_COLOR_SPACE_HLG)
                continue;
            for (int y = 0; y < job.height; ++y) {
                float* value = job.outputs + static_cast<std::size_t>(y) * job.outputRowStride + channel;
                for (int x = 0; x < job.width; ++x, value += NTC_MAX_CHANNELS)
                    *value = shader::NtcConvertToLinear(*value, space);
            }
        }
    }

    NtcTextureSetConstants constants_ = {};
    std::span<const std::byte> latents_;
    fast::PreparedNetwork network_;
    fast::TileKernel kernel_;
    Array<std::int32_t> weights_; // what network_ points into
    SimdTarget target_ = SimdTarget::Portable;
    int threads_ = 0;
    int generation_ = 1;
};

} // namespace openntc

#include "openntc/core/RestoreMacros.h"
