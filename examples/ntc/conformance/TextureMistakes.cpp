// SPDX-License-Identifier: MIT
// Textures as the documentation describes them, by the independent model and in double precision; and what
// wrong passes make of them.
#include "TextureSuite.h"

#include "Model.h"
#include "ModelSet.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace openntc::conformance {

namespace {

using TextureFault = TextureMistake;

constexpr TextureMistakeInfo kTextureMistakes[] = {
    {TextureFault::FirstChannelIgnored, "textures_first_channel", "every output begins with channel 0",
     "textures-last-channels"},
    {TextureFault::FirstOutputForAll, "textures_first_output", "every texture gets the first output",
     "textures-codes"},
    {TextureFault::SwappedRedBlue, "textures_red_blue", "the first and the third component are swapped",
     "textures-codes"},
    {TextureFault::MissingAlphaZero, "textures_alpha_zero",
     "a fourth component that an output lacks is 0; it is 1", "textures-placed"},
    {TextureFault::MissingRepeated, "textures_extra_channels",
     "components that an output lacks show the next channels", "textures-mip"},
    {TextureFault::NoChannel15, "textures_no_channel_15", "channel 15 is left out", "textures-last-channels"},
    {TextureFault::SpaceOfFirst, "textures_first_space",
     "the colour space of an output's first channel counts for three", "textures-to-linear"},
    {TextureFault::AlphaAsRgb, "textures_alpha_space",
     "the fourth component gets the colour space of the others", "textures-to-srgb"},
    {TextureFault::NotConverted, "textures_not_converted", "colour spaces are not converted",
     "textures-to-hlg"},
    {TextureFault::AlwaysLinear, "textures_always_linear",
     "components are linear whatever colour space was asked for", "textures-kept"},
    {TextureFault::AlwaysEncoded, "textures_always_encoded",
     "channels are taken as linear, those of another colour space too", "textures-kept"},
    {TextureFault::Gamma22, "textures_gamma", "sRGB is a power of 2.2", "textures-to-srgb"},
    {TextureFault::DestinationIgnored, "textures_destination", "the rectangle is written at its own place",
     "textures-placed"},
    {TextureFault::SourceAtOrigin, "textures_source_origin", "the rectangle's texels are read from (0, 0) on",
     "textures-placed"},
    {TextureFault::SourceAtDestination, "textures_source_destination",
     "texels are read at the place where they are written", "textures-placed"},
    {TextureFault::InclusiveRect, "textures_inclusive_rect", "a row and a column too many are written",
     "textures-placed"},
    {TextureFault::UpsideDown, "textures_upside_down", "the last row is written as the first",
     "textures-codes"},
    {TextureFault::Dithered, "textures_dithered", "codes are dithered, which was not asked for",
     "textures-codes"},
    {TextureFault::Truncated, "textures_truncated", "codes are rounded down; they are the nearest",
     "textures-codes-16"},
    {TextureFault::PowerOfTwoCodes, "textures_power_of_two", "1 is the code 2^bits; it is 2^bits - 1",
     "textures-codes"},
    {TextureFault::Wrapped, "textures_wrapped", "codes outside wrap round; they are clamped",
     "textures-codes"},
    {TextureFault::ClampedFloats, "textures_clamped_floats", "binary32 is clamped to 0 to 1",
     "textures-floats"},
    {TextureFault::EightBitCodes, "textures_eight_bits", "codes of 16 bits are made of 8",
     "textures-codes-16"},
    {TextureFault::HalfFloats, "textures_half_floats", "binary32 passes through binary16", "textures-floats"},
};

double Encode(double linear, ColorSpace space, TextureFault mistake) {
    if (space == ColorSpace::sRGB) {
        if (mistake == TextureFault::Gamma22)
            return std::copysign(std::pow(std::fabs(linear), 1 / 2.2), linear);
        return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
    }
    if (space == ColorSpace::HLG) {
        const double magnitude = std::fabs(linear);
        const double signal = magnitude < 1 ? std::sqrt(magnitude) / 2
                                            : 0.17883277 * std::log(magnitude - 0.28466892) + 0.55991073;
        return std::copysign(signal, linear);
    }
    return linear;
}

double Decode(double stored, ColorSpace space, TextureFault mistake) {
    if (space == ColorSpace::sRGB && mistake == TextureFault::Gamma22)
        return std::copysign(std::pow(std::fabs(stored), 2.2), stored);
    return ConvertToLinear(stored, space);
}

/// A component before it is stored, and by how much a device may be off: as TextureValues.cpp has it, or
/// wider.
struct TextureComponent {
    double value = 0;
    double slack = 0;
};

/// Which texel of which output.
struct TexturePlace {
    const TextureOutput* output;
    int x, y; ///< of the mip
    int mipWidth;
};

/// One wrong pass, or the right one.
class TexturePass {
public:
    TexturePass(const ModelSet& set, TextureFault mistake) : set_(set), mistake_(mistake) {}

    bool Is(TextureFault mistake) const { return mistake_ == mistake; }

    TextureComponent MakeComponent(const std::array<float, 16>& texel, const TexturePlace& place,
                                   int component) const {
        const TextureOutput& output = *place.output;
        int k = component;
        if (Is(TextureFault::SwappedRedBlue) && k < 3)
            k = 2 - k;
        if (k >= output.channels && !Is(TextureFault::MissingRepeated))
            return {k == 3 && !Is(TextureFault::MissingAlphaZero) ? 1.0 : 0.0};
        const int first = Is(TextureFault::FirstChannelIgnored) ? 0 : output.firstChannel;
        const int channel = std::min(first + k, 15);
        if (channel == 15 && Is(TextureFault::NoChannel15))
            return {};
        const int spaceChannel = Is(TextureFault::SpaceOfFirst) && k < 3 ? first : channel;
        ColorSpace source = static_cast<ColorSpace>(set_.colorSpaces[static_cast<std::size_t>(spaceChannel)]);
        ColorSpace destination = k == 3 && !Is(TextureFault::AlphaAsRgb) ? output.alpha : output.rgb;
        if (Is(TextureFault::NotConverted))
            source = destination;
        if (Is(TextureFault::AlwaysLinear))
            destination = ColorSpace::Linear;
        if (Is(TextureFault::AlwaysEncoded))
            source = ColorSpace::Linear;
        const double stored = static_cast<double>(texel[static_cast<std::size_t>(channel)]);
        TextureComponent made{stored, 0};
        if (source != destination) {
            made.value = Encode(Decode(stored, source, mistake_), destination, mistake_);
            made.slack = 0x1p-17 * std::max(1.0, std::fabs(made.value));
        }
        if (Is(TextureFault::Dithered) && output.bits != 0)
            made.value += GetNoise(place, k) / ((1 << output.bits) - 1);
        return made;
    }

    void Store(double value, int bits, std::span<std::byte> to) const {
        std::uint32_t code = 0;
        if (bits == 0) {
            if (Is(TextureFault::ClampedFloats))
                value = std::clamp(value, 0.0, 1.0);
            if (Is(TextureFault::HalfFloats))
                value = RoundToHalf(value);
            code = std::bit_cast<std::uint32_t>(static_cast<float>(value));
        } else {
            code = MakeCode(value, bits);
        }
        for (std::size_t i = 0; i < to.size(); ++i)
            to[i] = static_cast<std::byte>(code >> (8 * i) & 0xFFu);
    }

private:
    /// From -1/2 up to 1/2.
    static double GetNoise(const TexturePlace& place, int k) {
        const auto word = static_cast<std::uint32_t>(place.y * place.mipWidth + place.x) * 4u +
                          static_cast<std::uint32_t>(k);
        return (word * 2654435769u >> 8) / 16777216.0 - 0.5;
    }

    std::uint32_t MakeCode(double value, int bits) const {
        if (bits == 16 && Is(TextureFault::EightBitCodes))
            return 257u * MakeCode(value, 8);
        const double most = (1 << bits) - 1;
        if (std::isnan(value))
            return 0;
        const double scaled = value * (Is(TextureFault::PowerOfTwoCodes) ? most + 1 : most);
        if (Is(TextureFault::Wrapped))
            return static_cast<std::uint32_t>(
                       static_cast<std::int64_t>(std::clamp(std::floor(scaled + 0.5), -1e12, 1e12))) &
                   static_cast<std::uint32_t>(most);
        const double rounded = std::floor(scaled + (Is(TextureFault::Truncated) ? 0.0 : 0.5));
        return static_cast<std::uint32_t>(std::clamp(rounded, 0.0, most));
    }

    const ModelSet& set_;
    TextureFault mistake_;
};

} // namespace

std::span<const TextureMistakeInfo> ListTextureMistakes() {
    return kTextureMistakes;
}

const std::array<float, 16>& TextureModel::GetTexel(int x, int y) {
    const auto [place, isNew] = texels_.try_emplace({x, y});
    if (isNew)
        place->second = model_.Decode(request_.math, false, request_.mip, x, y);
    return place->second;
}

Textures TextureModel::Make(TextureMistake mistake, int side) {
    const TexturePass pass(model_.GetSet(), mistake);
    const ModelMip& mip = model_.GetSet().mips[static_cast<std::size_t>(request_.mip)];
    const Rect& rect = request_.rect;
    Textures textures;
    for (const TextureOutput& output : request_.outputs)
        textures.emplace_back(request_.GetTextureBytes(output));
    const int more = pass.Is(TextureFault::InclusiveRect) ? 1 : 0;
    const int width = rect.width + more, height = rect.height + more;
    for (int i = 0; i < width * height; ++i) {
        const int x = i % width, y = i / width;
        const int row = pass.Is(TextureFault::UpsideDown) ? rect.height - 1 - y : y;
        const int left =
            (pass.Is(TextureFault::DestinationIgnored) ? rect.left : request_.destinationLeft) + x;
        const int top =
            (pass.Is(TextureFault::DestinationIgnored) ? rect.top : request_.destinationTop) + row;
        if (left >= request_.textureWidth || top < 0 || top >= request_.textureHeight)
            continue;
        TexturePlace place{nullptr, rect.left + x, rect.top + y, mip.width};
        if (pass.Is(TextureFault::SourceAtOrigin) || pass.Is(TextureFault::SourceAtDestination)) {
            place.x = pass.Is(TextureFault::SourceAtOrigin) ? x : left;
            place.y = pass.Is(TextureFault::SourceAtOrigin) ? y : top;
        }
        place.x = std::min(place.x, mip.width - 1);
        place.y = std::min(place.y, mip.height - 1);
        const std::array<float, 16>& texel = GetTexel(place.x, place.y);
        for (std::size_t n = 0; n < request_.outputs.size(); ++n) {
            const TextureOutput& written = request_.outputs[n];
            place.output = &request_.outputs[pass.Is(TextureFault::FirstOutputForAll) ? 0 : n];
            const std::size_t size = written.GetComponentBytes();
            const std::size_t at = 4 * size * static_cast<std::size_t>(top * request_.textureWidth + left);
            for (std::size_t k = 0; k < 4; ++k) {
                const TextureComponent component = pass.MakeComponent(texel, place, static_cast<int>(k));
                pass.Store(component.value + side * component.slack, written.bits,
                           std::span(textures[n]).subspan(at + k * size, size));
            }
        }
    }
    return textures;
}

} // namespace openntc::conformance
