// SPDX-License-Identifier: MIT
// Decodes an encoder's file and compares it with the material it was made from.
#pragma once

#include "openntc/core/Stream.h"
#include "openntc/decode/ReferenceDecoder.h"
#include "openntc/encode/Material.h"
#include "openntc/inference/InferenceData.h"
#include "openntc/inference/ReadLatents.h"
#include "openntc/texture_set/TextureSetMetadata.h"

#include <doctest/doctest.h>

#include <cmath>
#include <string>
#include <vector>

namespace openntc::test {

/// A set of any generation with what its decoders read.
struct DecodedSet {
    std::vector<std::byte> file;
    ReadOnlyMemoryStream stream;
    TextureSetMetadata metadata;
    NtcTextureSetConstants constants;
    std::vector<std::byte> latents;
    DecodeSource source;

    /// With the weights that a mode reads.
    DecodedSet(const std::vector<std::byte>& bytes, DecodeMath math)
        : file(bytes), stream(file), metadata(Load(stream)) {
        const DecodeWeights weights = GetDecodeWeights(math);
        const auto type = weights == DecodeWeights::FP8 ? InferenceWeightType::GenericFP8
                                                        : InferenceWeightType::GenericInt8;
        const int mips = metadata.GetDesc().mips;
        const auto made = MakeInferenceData(metadata, 0, mips, type);
        REQUIRE_MESSAGE(made.has_value(), std::string(made ? "" : made.error().GetText()));
        constants = *made;
        latents.resize(*GetLatentBufferBytes(metadata, 0, mips));
        REQUIRE(ReadLatents(metadata, stream, 0, mips, latents).has_value());
        source = {&constants, latents, *metadata.GetInferenceWeights(type), metadata.GetNetworkVersion(),
                  weights};
    }
    DecodedSet(const DecodedSet&) = delete;
    DecodedSet& operator=(const DecodedSet&) = delete;

private:
    static TextureSetMetadata Load(Stream& from) {
        auto loaded = TextureSetMetadata::Load(from);
        REQUIRE_MESSAGE(loaded.has_value(), std::string(loaded ? "" : loaded.error().GetText()));
        return std::move(*loaded);
    }
};

/// All mips of a set, by the network of this mode: 16 floats per texel.
inline std::vector<std::vector<float>> DecodeFile(const std::vector<std::byte>& file,
                                                  DecodeMath math = DecodeMath::Int8) {
    const DecodedSet set(file, math);
    std::vector<std::vector<float>> result;
    for (int m = 0; m < set.metadata.GetDesc().mips; ++m) {
        const ColorMip& mip = set.metadata.GetColorMips()[static_cast<std::size_t>(m)];
        auto& texels = result.emplace_back(static_cast<std::size_t>(mip.width) *
                                           static_cast<std::size_t>(mip.height) * 16);
        const auto decoded =
            DecodeReference(set.source, m, {0, 0, mip.width, mip.height}, {.math = math}, texels);
        REQUIRE_MESSAGE(decoded.has_value(), std::string(decoded ? "" : decoded.error().GetText()));
    }
    return result;
}

/// The same by the file's FP8 network.
inline std::vector<std::vector<float>> DecodeFp8(const std::vector<std::byte>& file) {
    return DecodeFile(file, DecodeMath::FP8);
}

/// PSNR as the project defines it: stored values, all declared channels, all mips weighted by texels. The
/// mask, if any, is clamped to 0 ... 1 as every reader of a mask does.
inline double MeasurePsnr(const encode::Material& material, const std::vector<std::vector<float>>& decoded,
                          int maskChannel = -1) {
    double error = 0.0, count = 0.0;
    for (int m = 0; m < material.GetMipCount(); ++m) {
        for (int c = 0; c < 16; ++c) {
            if ((material.GetDeclaredChannels() >> c & 1u) == 0)
                continue;
            const auto plane = material.GetPlane(m, c);
            for (std::size_t i = 0; i < plane.size(); ++i) {
                float value = decoded[static_cast<std::size_t>(m)][i * 16 + static_cast<std::size_t>(c)];
                if (c == maskChannel)
                    value = std::clamp(value, 0.0f, 1.0f);
                const double difference = static_cast<double>(value) - static_cast<double>(plane[i]);
                error += difference * difference;
                count += 1.0;
            }
        }
    }
    return -10.0 * std::log10(error / count);
}

} // namespace openntc::test
