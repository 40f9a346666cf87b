// SPDX-License-Identifier: MIT
// What is expected of textures: the constants that MakeDecompressionPass gives and the shader's functions,
// compiled as C++.
#include "TextureSuite.h"

#include "../Failure.h"
#include "../Output.h"
#include "Comparison.h"

#include "openntc/passes/DecompressionPass.h"

#include "openntc/passes/DecompressTexel.h" // and GLM

#include <algorithm>
#include <bit>
#include <cmath>

namespace openntc::conformance {

namespace {

using tool::Format;

NtcDecompressConstants MakePassConstants(const TextureSetMetadata& metadata, const TextureRequest& request) {
    std::vector<DecompressionOutput> outputs;
    for (const TextureOutput& output : request.outputs)
        outputs.push_back({static_cast<int>(outputs.size()), output.firstChannel, output.channels, output.rgb,
                           output.alpha, 0.0f, output.bits});
    DecompressionRequest pass;
    pass.mip = request.mip;
    pass.rect = request.rect;
    pass.destination = TexelOffset{request.destinationLeft, request.destinationTop};
    pass.outputs = outputs;
    return tool::Require(MakeDecompressionPass(metadata, 0, metadata.GetDesc().mips, pass, SceneNeeds{}),
                         tool::ExitCode::Failed, "textures")
        .constants;
}

std::uint32_t LoadComponent(std::span<const std::byte> bytes) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < bytes.size(); ++i)
        value |= std::to_integer<std::uint32_t>(bytes[i]) << (8 * i);
    return value;
}

void StoreComponent(std::uint32_t value, std::span<std::byte> bytes) {
    for (std::size_t i = 0; i < bytes.size(); ++i)
        bytes[i] = static_cast<std::byte>(value >> (8 * i) & 0xFFu);
}

/// The code of a component, or the bits of its binary32 number.
std::uint32_t Quantise(float value, int bits) {
    return bits == 0 ? std::bit_cast<std::uint32_t>(value)
                     : shader::NtcQuantiseUnorm(value, (1u << bits) - 1u);
}

/// By how much a device may be off before it rounds to codes. To linear: GetLinearBound. From linear: pow(x,
/// 1/2.4) has the relative error (3 + 2 |log2 x| / 2.4) 2^-23 of exp2 and ln 2 / 2.4 times log2's 2^-21, or 3
/// ULP of it; log's 2^-21 counts by 0.18; sqrt halves what comes in. Values that reach a code are below 1,
/// and those below 2^-17 give 0, so that |log2 x| is at most 17 and the sum, with what to-linear brings in
/// (times 1/2.4, or 1.4 at HLG's log), below 2^-17.
double GetSlack(ColorSpace source, ColorSpace destination, float stored, const TextureOutput& output) {
    if (source == destination)
        return 0;
    if (destination == ColorSpace::Linear)
        return GetLinearBound(source, stored, Arithmetic::Vulkan);
    return output.bits == 0 ? 0x1p-16 * std::max(1.0, std::fabs(static_cast<double>(stored))) : 0x1p-17;
}

struct StoredRange {
    std::uint32_t least = 0, greatest = 0;
};

/// One component of an output from the stored channels of its texel.
StoredRange MakeComponent(const NtcDecompressConstants& constants, const TextureRequest& request,
                          std::size_t n, std::span<const float, 16> stored, int k) {
    const TextureOutput& output = request.outputs[n];
    NtcDecompressOutput plain = constants.outputs[n];
    const auto component = static_cast<std::uint32_t>(k);
    const int channel = shader::NtcGetOutputChannel(plain, component);
    const float value = stored[static_cast<std::size_t>(channel)];
    const std::uint32_t spaces = constants.desc.channelColorSpaces;
    const std::uint32_t right = [&] {
        const float made = shader::NtcMakeComponent(plain, spaces, component, channel, value, 0);
        return Quantise(made, output.bits); // of codes the pass has rounded already: the same again
    }();
    if (k >= output.channels)
        return {right, right};
    const auto source = static_cast<ColorSpace>(shader::NtcGetChannelColorSpace(spaces, channel));
    const double slack = GetSlack(source, k == 3 ? output.alpha : output.rgb, value, output);
    if (slack == 0)
        return {right, right};
    plain.channels &= 0xFFFu; // without rounding
    const double made =
        static_cast<double>(shader::NtcMakeComponent(plain, spaces, component, channel, value, 0));
    return {Quantise(static_cast<float>(made - slack), output.bits),
            Quantise(static_cast<float>(made + slack), output.bits)};
}

Textures ClearTextures(const TextureRequest& request) {
    Textures textures;
    for (const TextureOutput& output : request.outputs)
        textures.emplace_back(request.GetTextureBytes(output));
    return textures;
}

double GetNumber(std::uint32_t bits, const TextureOutput& output) {
    return output.bits == 0 ? static_cast<double>(std::bit_cast<float>(bits)) : bits;
}

std::string DescribeComponent(std::uint32_t bits, const TextureOutput& output) {
    return output.bits == 0 ? tool::FormatFloat(std::bit_cast<float>(bits)) : std::to_string(bits);
}

bool IsComponentInside(std::uint32_t got, std::uint32_t least, std::uint32_t greatest,
                       const TextureOutput& output, float flushBelow) {
    if (output.bits == 0 && least == greatest)
        return IsSame(std::bit_cast<float>(got), std::bit_cast<float>(least), flushBelow);
    const double number = GetNumber(got, output);
    return number >= GetNumber(least, output) && number <= GetNumber(greatest, output);
}

} // namespace

TextureRange MakeTextureRange(const TextureSetMetadata& metadata, const TextureRequest& request,
                              std::span<const std::array<float, 16>> texels) {
    const NtcDecompressConstants constants = MakePassConstants(metadata, request);
    TextureRange range{ClearTextures(request), ClearTextures(request)};
    for (std::size_t n = 0; n < request.outputs.size(); ++n) {
        const std::size_t size = request.outputs[n].GetComponentBytes();
        for (int i = 0; i < request.rect.width * request.rect.height; ++i) {
            const int x = constants.destinationLeft + i % request.rect.width;
            const int y = constants.destinationTop + i / request.rect.width;
            for (int k = 0; k < 4; ++k) {
                const StoredRange stored =
                    MakeComponent(constants, request, n, texels[static_cast<std::size_t>(i)], k);
                const std::size_t at =
                    size * static_cast<std::size_t>(4 * (y * request.textureWidth + x) + k);
                StoreComponent(stored.least, std::span(range.least[n]).subspan(at, size));
                StoreComponent(stored.greatest, std::span(range.greatest[n]).subspan(at, size));
            }
        }
    }
    return range;
}

Textures MakeTextures(const TextureSetMetadata& metadata, const TextureRequest& request,
                      std::span<const std::array<float, 16>> texels) {
    const NtcDecompressConstants constants = MakePassConstants(metadata, request);
    Textures textures = ClearTextures(request);
    for (std::size_t n = 0; n < request.outputs.size(); ++n) {
        const std::size_t size = request.outputs[n].GetComponentBytes();
        for (int i = 0; i < request.rect.width * request.rect.height; ++i) {
            const int x = i % request.rect.width, y = i / request.rect.width;
            float channels[16];
            std::copy_n(texels[static_cast<std::size_t>(i)].data(), 16, channels);
            const shader::float4 texel = shader::NtcMakeOutputTexel(
                constants.outputs[n], constants.desc.channelColorSpaces, channels,
                shader::int2(constants.left + x, constants.top + y), constants.desc.imageWidth);
            const int place =
                (constants.destinationTop + y) * request.textureWidth + constants.destinationLeft + x;
            for (int k = 0; k < 4; ++k)
                StoreComponent(
                    Quantise(texel[k], request.outputs[n].bits),
                    std::span(textures[n]).subspan(size * static_cast<std::size_t>(4 * place + k), size));
        }
    }
    return textures;
}

TextureDifference CompareTextures(const TextureRequest& request, const Textures& textures,
                                  const TextureRange& range, float flushBelow) {
    TextureDifference difference;
    for (std::size_t n = 0; n < request.outputs.size(); ++n) {
        const TextureOutput& output = request.outputs[n];
        const std::size_t size = output.GetComponentBytes();
        const auto load = [&](const Textures& from, std::size_t i) {
            return LoadComponent(std::span(from[n]).subspan(i * size, size));
        };
        for (std::size_t i = 0; i < request.GetTextureBytes(output) / size; ++i) {
            const std::uint32_t got = load(textures, i), least = load(range.least, i),
                                greatest = load(range.greatest, i);
            ++difference.components;
            if (IsComponentInside(got, least, greatest, output, flushBelow))
                continue;
            if (difference.different++ == 0) {
                const std::size_t texel = i / 4, width = static_cast<std::size_t>(request.textureWidth);
                difference.first =
                    Format("output %zu texel (%zu, %zu) component %zu: %s: expected %s", n, texel % width,
                           texel / width, i % 4, DescribeComponent(got, output).c_str(),
                           DescribeComponent(least, output).c_str());
                if (least != greatest)
                    difference.first += " to " + DescribeComponent(greatest, output);
            }
        }
    }
    return difference;
}

} // namespace openntc::conformance
