// SPDX-License-Identifier: MIT
// The decoder and the texture filters for WebGL 2, flattened for each network. As ../opengl/functions33.glsl, but with filters:
// latents and weights are words of R32UI textures, 1024 a row; there is no `precise`, so a uniform that is zero keeps roundings apart.
#define NTC_NO_LOOP_ATTRIBUTES
#define NTC_NO_PRECISE
#define NTC_OPAQUE_ZERO ntcZero
uniform uint ntcZero;
#define NtcBuffer usampler2D
#define NtcBufferLoad(buffer, byteOffset) texelFetch(buffer, ivec2(int((byteOffset) >> 2) & 1023, int((byteOffset) >> 12)), 0).x
#define NTC_STF_MOST_TAPS 4
#include "openntc/Inference.h"
#include "openntc/StochasticFiltering.h"

uniform NtcTextureSetConstants ntcDesc;
uniform usampler2D ntcLatents;
uniform usampler2D ntcWeights;

/// All channels of a texel, in storage colour space or as linear light; false where there is no such texel.
bool NtcReadTexel(ivec2 texel, int mip, bool asLinear, out float channels[NTC_MAX_CHANNELS]) {
    return NtcSampleTextureSet(ntcDesc, ntcLatents, 0u, ntcWeights, 0u, texel, mip, asLinear, channels);
}

/// The same as the filters want it.
NtcStfTexel NtcFetchTexel(NtcStfTap tap, bool asLinear) {
    float channels[NTC_MAX_CHANNELS];
    for (int i = 0; i < NTC_MAX_CHANNELS; i++)
        channels[i] = 0.0;
    if (!tap.isBorder)
        NtcReadTexel(tap.texel, tap.mip, asLinear, channels);
    NtcStfTexel texel;
    texel.channels0 = vec4(channels[0], channels[1], channels[2], channels[3]);
    texel.channels4 = vec4(channels[4], channels[5], channels[6], channels[7]);
    texel.channels8 = vec4(channels[8], channels[9], channels[10], channels[11]);
    texel.channels12 = vec4(channels[12], channels[13], channels[14], channels[15]);
    return texel;
}

/// A lookup. Derivatives of uv per pixel choose the mip, or `fixedMip` if it is not negative. `stochastic`: one texel drawn with
/// `random` (two where a kernel has negative weights), else all texels of the filter. One call of the decoder, in a loop: compilers
/// put every call's code in its place.
NtcStfTexel NtcLookUp(NtcStfSampler sampling, int fixedMip, vec2 uv, vec2 ddx, vec2 ddy, bool stochastic, uvec4 random, bool asLinear) {
    NtcStfExtent extent = NtcStfMakeExtent(ntcDesc.imageWidth, ntcDesc.imageHeight, ntcDesc.imageMips);
    NtcStfFootprint footprint = NtcStfGetFootprint(sampling, extent, ddx, ddy);
    if (fixedMip >= 0)
        footprint = NtcStfMakeFootprint(sampling, extent, fixedMip * 65536);
    NtcStfPair pair = NtcStfSamplePair(sampling, extent, uv, footprint, random);
    uint taps = stochastic ? 2u : NtcStfGetTapCount(sampling, extent, footprint);
    NtcStfTexel sum;
    NtcStfClear(sum);
    for (uint i = 0u; i < taps; i++) {
        NtcStfTap tap = pair.second;
        if (!stochastic)
            tap = NtcStfGetTap(sampling, extent, uv, footprint, i);
        else if (i == 0u)
            tap = pair.first;
        if (tap.scale != 0.0)
            NtcStfAdd(sum, NtcFetchTexel(tap, asLinear), tap.scale);
    }
    return sum;
}

/// Random numbers of a pixel and frame: frames fill the filter evenly.
uvec4 NtcDraw(uvec2 pixel, uint frame) {
    return NtcStfRandomR2(NtcStfPcg4d(pixel.x, pixel.y, 0u, 0u), frame);
}
