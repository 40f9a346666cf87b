// SPDX-License-Identifier: MIT
#include "Model.h"

namespace openntc::conformance {

namespace {

constexpr MistakeInfo kMistakes[] = {
    {Mistake::TruncatedRequantisation, "truncated_requantisation",
     "activations are truncated to integers; they are rounded to the nearest", "requantisation"},
    {Mistake::HalfAwayTies, "half_away_ties",
     "activations at exact ties are rounded away from zero; they are rounded to even", "requantisation-ties"},
    {Mistake::WrappedTaps, "wrapped_taps", "latent taps wrap around at the edges; they are clamped",
     "edge-taps"},
    {Mistake::SwappedCorners, "swapped_corners",
     "corners 1 and 2 are swapped; the order is (x0,y0), (x1,y0), (x0,y1), (x1,y1)", "corners"},
    {Mistake::MissingLodClamp, "missing_lod_clamp",
     "the level of detail wraps when beyond 1; it is clamped like the waves", "lod-beyond-1"},
    {Mistake::WrongBitOrder, "wrong_bit_order",
     "latent codes are read from the most significant bits first; the lowest bits come first", "latents-1x1"},
    {Mistake::Offset112, "offset_112",
     "the activation's offset is -112 (3 / step in double precision); it is -113", "activation-offset"},
    {Mistake::RoundedWeights, "rounded_weights", "bilinear weights are rounded to 1/256; they are truncated",
     "bilinear-weights"},
    {Mistake::Contraction, "contraction",
     "multiply-adds are contracted; every operation is rounded by itself", "contraction"},
    {Mistake::SrgbTwice, "srgb_twice", "sRGB outputs are decoded twice", "srgb"},
    {Mistake::UnusedSlotsNotZeroed, "unused_slots_not_zeroed",
     "inputs of features that the set does not have are not zero", "unused-slots"},
    {Mistake::FP8SaturationMissing, "fp8_saturation_missing",
     "E4M3 conversion overflows to NaN; it saturates at 448", "fp8-saturation"},
    {Mistake::FP8SubnormalsFlushed, "fp8_subnormals_flushed",
     "E4M3 numbers below 2^-6 become zero; subnormals are kept", "fp8-subnormals"},
    {Mistake::TruncatedShift, "truncated_shift",
     "weighted latents are divided by 256 towards zero; the shift rounds down", "latent-shift"},
    {Mistake::SeparateLowResShifts, "separate_low_res_shifts",
     "low-resolution corners are shifted one by one; their sum is shifted once", "low-res-sum"},
    {Mistake::RoundedWaves, "rounded_waves", "positional inputs are rounded to integers; they are truncated",
     "waves"},
    {Mistake::HalfTexelWaves, "half_texel_waves",
     "positional inputs take the texel's centre; they take its corner", "wave-position"},
    {Mistake::ReorderedCoordinates, "reordered_coordinates",
     "the texel is multiplied by grid / mip; it is divided by the mip and multiplied by the grid",
     "texels-on-latents"},
    {Mistake::FormulaLatentImage, "formula_latent_image",
     "the latent image of a mip is computed; it is stored in the file", "latent-image-of-mip"},
    {Mistake::UnroundedHalfOutputs, "unrounded_half_outputs",
     "outputs of the half epilogue are binary32; they are rounded to binary16", "half-outputs"},
    {Mistake::HalfInfinity, "half_infinity",
     "-infinity * 0 in the half activation makes NaN; z <= -1.5 gives -113 by comparison", "half-overflow"},
    {Mistake::SaturatedLatents, "saturated_latents",
     "8-bit codes 254 and 255 saturate at 127; they are 128 and 129 and wrap after weighting",
     "latent-codes-254-255"},
    {Mistake::NarrowAccumulator, "narrow_accumulator",
     "sums are kept in 24 bits (binary32); they are int32 and wrap", "accumulator"},
    {Mistake::HlgWithoutSign, "hlg_without_sign", "HLG of negative values loses its sign; the curve is odd",
     "hlg"},
};

} // namespace

std::span<const MistakeInfo> ListMistakes() {
    return kMistakes;
}

} // namespace openntc::conformance
