// SPDX-License-Identifier: MIT
// The lookups of StochasticFiltering.h, and what wrong integrations make of them.
#include "FilterSuite.h"

#include "openntc/StochasticFiltering.h" // and GLM

#include <algorithm>
#include <cmath>
#include <utility>

namespace openntc::conformance {

namespace {

namespace stf = shader;
using FilterFault = FilterMistake;

constexpr FilterMistakeInfo kFilterMistakes[] = {
    {FilterFault::HalfTexel, "filtering_half_texel", "coordinates are half a texel off", "filtering-nearest"},
    {FilterFault::NearestOfKernel, "filtering_rounded_texel",
     "the texel that is nearest is read; one of the kernel's is drawn", "filtering-bilinear"},
    {FilterFault::MissingWrap, "filtering_wrap_as_clamp", "coordinates that repeat are clamped",
     "filtering-bilinear"},
    {FilterFault::MirrorAsRepeat, "filtering_mirror_as_repeat", "coordinates that are mirrored repeat",
     "filtering-mirror-border"},
    {FilterFault::BorderAsClamp, "filtering_border_as_clamp", "the border is the texel at the edge",
     "filtering-mirror-border"},
    {FilterFault::OneWrap, "filtering_one_wrap", "both coordinates wrap as the first", "filtering-cubic"},
    {FilterFault::SwappedAxes, "filtering_swapped_axes", "x and y of the texel are swapped",
     "filtering-cubic"},
    {FilterFault::RoundedMip, "filtering_rounded_mip", "the nearest mip is read; one of two is drawn",
     "filtering-trilinear"},
    {FilterFault::FlooredMip, "filtering_floored_mip", "the finer mip is read; one of two is drawn",
     "filtering-trilinear"},
    {FilterFault::ExtraMip, "filtering_extra_mip", "the level may go beyond the last mip", "filtering-level"},
    {FilterFault::SquareDerivatives, "filtering_square", "derivatives are scaled by the width both ways",
     "filtering-level"},
    {FilterFault::TransposedDerivatives, "filtering_transposed",
     "dv/dx and du/dy are swapped in the derivatives", "filtering-anisotropic"},
    {FilterFault::DoubledLevel, "filtering_doubled_level",
     "the level is the logarithm of the squared length, without 1/2", "filtering-nearest"},
    {FilterFault::BiasIgnored, "filtering_bias_ignored", "the bias is left out", "filtering-level"},
    {FilterFault::BiasNegated, "filtering_bias_negated", "the bias is subtracted", "filtering-level"},
    {FilterFault::Isotropic, "filtering_isotropic", "anisotropy is left out", "filtering-anisotropic"},
    {FilterFault::MinorAxis, "filtering_minor_axis", "taps lie along the shorter axis",
     "filtering-all-anisotropic"},
    {FilterFault::ReusedForRow, "filtering_reused_row", "the column's random number draws the row too",
     "filtering-bilinear"},
    {FilterFault::ReusedForMip, "filtering_reused_mip", "the column's random number draws the mip too",
     "filtering-trilinear"},
    {FilterFault::ReusedForTap, "filtering_reused_tap",
     "the mip's random number draws the anisotropic tap too", "filtering-anisotropic"},
    {FilterFault::EightBitRandom, "filtering_eight_bit_random", "random numbers have 8 bits; they need 16",
     "filtering-precise"},
    {FilterFault::InvertedRandom, "filtering_inverted_random", "random numbers count downwards",
     "filtering-gaussian"},
    {FilterFault::SignDropped, "filtering_sign_dropped", "negative weights count as positive ones",
     "filtering-catmull-rom"},
    {FilterFault::SecondDropped, "filtering_second_dropped",
     "the texel of the negative weights is left out, and the first counts once", "filtering-mitchell-pair"},
    {FilterFault::SmoothKernel, "filtering_smooth_kernel", "every kernel of four texels is the B-spline",
     "filtering-all-mitchell"},
    {FilterFault::EightBitWeights, "filtering_eight_bit_weights",
     "weights are rounded to 1/256, as samplers' are", "filtering-all-trilinear"},
    {FilterFault::SwappedMipWeights, "filtering_swapped_mips", "the finer mip gets the coarser one's weight",
     "filtering-all-trilinear"},
};

/// A lookup as the header takes it.
struct Inputs {
    stf::NtcStfSampler settings;
    stf::NtcStfExtent extent;
    stf::float2 uv;
    stf::NtcStfFootprint footprint;
    stf::uint4 random;
};

void SpoilSampler(stf::NtcStfSampler& settings, FilterFault mistake) {
    for (stf::uint* wrap : {&settings.wrapX, &settings.wrapY}) {
        if ((mistake == FilterFault::MissingWrap && *wrap == NTC_WRAP_REPEAT) ||
            (mistake == FilterFault::BorderAsClamp && *wrap == NTC_WRAP_BORDER))
            *wrap = NTC_WRAP_CLAMP;
        if (mistake == FilterFault::MirrorAsRepeat && *wrap == NTC_WRAP_MIRROR)
            *wrap = NTC_WRAP_REPEAT;
    }
    if (mistake == FilterFault::OneWrap)
        settings.wrapY = settings.wrapX;
    if (mistake == FilterFault::NearestOfKernel)
        settings.kernelType = NTC_KERNEL_NEAREST;
    if (mistake == FilterFault::SmoothKernel && stf::NtcStfIsSigned(settings))
        settings.kernelType = NTC_KERNEL_CUBIC;
    if (mistake == FilterFault::RoundedMip)
        settings.mips = NTC_MIPS_NEAREST;
    if (mistake == FilterFault::BiasIgnored)
        settings.lodBias = 0;
    if (mistake == FilterFault::BiasNegated)
        settings.lodBias = -settings.lodBias;
    if (mistake == FilterFault::Isotropic)
        settings.maxAnisotropy = 1;
}

stf::NtcStfFootprint MakeFootprint(const Inputs& inputs, stf::float2 ddx, stf::float2 ddy,
                                   FilterFault mistake) {
    stf::NtcStfExtent extent = inputs.extent;
    if (mistake == FilterFault::TransposedDerivatives)
        std::swap(ddx.y, ddy.x);
    if (mistake == FilterFault::SquareDerivatives)
        extent.height = extent.width;
    stf::NtcStfFootprint footprint = stf::NtcStfGetFootprint(inputs.settings, extent, ddx, ddy);
    if (mistake == FilterFault::DoubledLevel)
        footprint.lod = std::min(2 * footprint.lod, (extent.levels - 1) * 65536);
    if (mistake == FilterFault::MinorAxis && footprint.taps > 1)
        footprint.axis = footprint.axis == ddx ? ddy : ddx;
    return footprint;
}

void SpoilRandom(stf::uint4& random, FilterFault mistake) {
    if (mistake == FilterFault::ReusedForRow)
        random.y = random.x;
    if (mistake == FilterFault::ReusedForMip)
        random.z = random.x;
    if (mistake == FilterFault::ReusedForTap)
        random.w = random.z;
    if (mistake == FilterFault::FlooredMip)
        random.z = 0;
    if (mistake == FilterFault::EightBitRandom)
        random = stf::uint4(random.x & 0xFF00u, random.y & 0xFF00u, random.z & 0xFF00u, random.w & 0xFF00u);
    if (mistake == FilterFault::InvertedRandom)
        random = stf::uint4(65535 - random.x, 65535 - random.y, 65535 - random.z, 65535 - random.w);
}

Inputs MakeInputs(const FilterRequest& request, const FilterLookup& lookup, FilterFault mistake) {
    Inputs inputs;
    inputs.settings = stf::NtcStfMakeSampler(static_cast<stf::uint>(request.kernel), 0);
    inputs.settings.mips = static_cast<stf::uint>(request.mips);
    inputs.settings.wrapX = static_cast<stf::uint>(request.wrapX);
    inputs.settings.wrapY = static_cast<stf::uint>(request.wrapY);
    inputs.settings.sigma = request.sigma;
    inputs.settings.radius = request.radius;
    inputs.settings.maxAnisotropy = static_cast<stf::uint>(request.maxAnisotropy);
    inputs.settings.lodBias = request.lodBias;
    SpoilSampler(inputs.settings, mistake);
    inputs.extent = stf::NtcStfMakeExtent(request.width, request.height, request.levels);
    if (mistake == FilterFault::ExtraMip)
        ++inputs.extent.levels;
    inputs.uv = stf::float2(lookup.uv[0], lookup.uv[1]);
    inputs.random = stf::uint4(lookup.random[0], lookup.random[1], lookup.random[2], lookup.random[3]);
    SpoilRandom(inputs.random, mistake);
    inputs.footprint = MakeFootprint(inputs, stf::float2(lookup.ddx[0], lookup.ddx[1]),
                                     stf::float2(lookup.ddy[0], lookup.ddy[1]), mistake);
    if (mistake == FilterFault::HalfTexel) {
        const int mip =
            stf::NtcStfDrawMip(inputs.settings, inputs.extent, inputs.footprint.lod, inputs.random.z);
        inputs.uv.x -= 0.5f / static_cast<float>(stf::NtcStfGetMipSize(request.width, mip));
        inputs.uv.y -= 0.5f / static_cast<float>(stf::NtcStfGetMipSize(request.height, mip));
    }
    return inputs;
}

std::vector<stf::NtcStfTap> GetTaps(const Inputs& in, FilterWay way, FilterFault mistake) {
    if (way == FilterWay::One)
        return {stf::NtcStfSample(in.settings, in.extent, in.uv, in.footprint, in.random)};
    if (way == FilterWay::Pair) {
        stf::NtcStfPair pair = stf::NtcStfSamplePair(in.settings, in.extent, in.uv, in.footprint, in.random);
        if (mistake == FilterFault::SecondDropped) {
            pair.first.scale = 1;
            pair.second.scale = 0;
        }
        return {pair.first, pair.second};
    }
    std::vector<stf::NtcStfTap> taps;
    const stf::uint count = stf::NtcStfGetTapCount(in.settings, in.extent, in.footprint);
    for (stf::uint i = 0; i < count; ++i)
        taps.push_back(stf::NtcStfGetTap(in.settings, in.extent, in.uv, in.footprint, i));
    if (mistake == FilterFault::SwappedMipWeights &&
        stf::NtcStfReadsTwoMips(in.settings, in.extent, in.footprint)) {
        const float coarser = static_cast<float>(in.footprint.lod & 0xFFFF) / 65536.0f;
        const int finer = in.footprint.lod >> 16;
        for (stf::NtcStfTap& tap : taps)
            tap.scale *= tap.mip == finer ? coarser / (1 - coarser) : (1 - coarser) / coarser;
    }
    return taps;
}

FilterTap MakeTap(const stf::NtcStfTap& tap, FilterWay way, FilterFault mistake) {
    FilterTap made{tap.texel.x, tap.texel.y, tap.mip, tap.scale, tap.isBorder};
    if (mistake == FilterFault::SwappedAxes)
        std::swap(made.x, made.y);
    if (mistake == FilterFault::SignDropped)
        made.scale = std::fabs(made.scale);
    if (mistake == FilterFault::EightBitWeights)
        made.scale = std::round(256.0f * made.scale) / 256.0f;
    if (made.isBorder)
        made.x = made.y = -1;
    const bool isNothing = way == FilterWay::Pair && made.scale == 0;
    return isNothing ? FilterTap{} : made;
}

} // namespace

std::span<const FilterMistakeInfo> ListFilterMistakes() {
    return kFilterMistakes;
}

FilterTaps RunFilter(const FilterRequest& request, std::span<const FilterLookup> lookups,
                     FilterMistake mistake) {
    FilterTaps all;
    for (const FilterLookup& lookup : lookups) {
        std::vector<FilterTap>& taps = all.emplace_back();
        for (const stf::NtcStfTap& tap : GetTaps(MakeInputs(request, lookup, mistake), request.way, mistake))
            taps.push_back(MakeTap(tap, request.way, mistake));
    }
    return all;
}

} // namespace openntc::conformance
