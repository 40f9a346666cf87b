// SPDX-License-Identifier: MIT
// What lookups are described by.
#ifndef OPENNTC_STF_TYPES_H
#define OPENNTC_STF_TYPES_H

#include "openntc/Portability.h"
#include "openntc/WrapModes.h"

// NtcStfSampler::kernelType
#define NTC_KERNEL_NEAREST 0
#define NTC_KERNEL_BILINEAR 1
#define NTC_KERNEL_CUBIC 2       // B-spline: smooth, blurs
#define NTC_KERNEL_CATMULL_ROM 3 // sharp, negative weights
#define NTC_KERNEL_MITCHELL 4    // between both, B = C = 1/3; negative weights
#define NTC_KERNEL_GAUSSIAN 5

// NtcStfSampler::mips
#define NTC_MIPS_NEAREST 0
#define NTC_MIPS_LINEAR 1 // both mips; with a bilinear kernel this is trilinear filtering

// Most taps of a kernel along an axis. 4 or 2 saves registers where that is enough; Gaussians get what room
// there is.
#if !defined(NTC_STF_MOST_TAPS)
#define NTC_STF_MOST_TAPS 8
#endif

NTC_NAMESPACE_BEGIN

/// How a texture is filtered. 32 bytes, and the same in every language: may be a member of a constant
/// buffer.
struct NtcStfSampler {
    uint kernelType;    // NTC_KERNEL_*
    uint mips;          // NTC_MIPS_*
    uint wrapX;         // NTC_WRAP_*
    uint wrapY;         // NTC_WRAP_*
    float sigma;        // of a Gaussian, texels: 0.5 ... 1.35
    int radius;         // of a Gaussian, texels: 2 ... NTC_STF_MOST_TAPS / 2
    uint maxAnisotropy; // 1 ... 16
    int lodBias;        // 2^-16 of a mip
};

/// A texture: texels of mip 0, 1 ... 16384 a side, and mips, of which mip m has max(1, width >> m) by
/// max(1, height >> m).
struct NtcStfExtent {
    int width;
    int height;
    int levels;
};

/// What a pixel covers of a texture.
struct NtcStfFootprint {
    int lod;     // 2^-16 of a mip, inside 0 ... levels - 1
    uint taps;   // anisotropic: number along the axis; else 1
    float2 axis; // texture coordinates
};

/// A texel to read. `scale`: what its value is multiplied by. Where isBorder, texel is outside and the
/// border's colour takes the place of its value.
struct NtcStfTap {
    int2 texel;
    int mip;
    float scale;
    bool isBorder;
};

/// A sampler of one kernel and one way to wrap, trilinear in mips, isotropic.
NTC_FUNCTION NtcStfSampler NtcStfMakeSampler(uint kernelType, uint wrap) {
    NtcStfSampler settings;
    settings.kernelType = kernelType;
    settings.mips = kernelType == uint(NTC_KERNEL_NEAREST) ? uint(NTC_MIPS_NEAREST) : uint(NTC_MIPS_LINEAR);
    settings.wrapX = wrap;
    settings.wrapY = wrap;
    settings.sigma = 0.6f;
    settings.radius = 2;
    settings.maxAnisotropy = 1u;
    settings.lodBias = 0;
    return settings;
}

/// A Gaussian of `sigma` texels, which is brought into 0.5 ... 1.35: point-sampled, narrower ones are no
/// filters any more, and wider ones are better had from the next mip. The radius is one at which what is cut
/// off hardly counts.
NTC_FUNCTION NtcStfSampler NtcStfMakeGaussian(float sigma, uint wrap) {
    NtcStfSampler settings = NtcStfMakeSampler(uint(NTC_KERNEL_GAUSSIAN), wrap);
    settings.sigma = sigma >= 0.5f ? (sigma <= 1.35f ? sigma : 1.35f) : 0.5f;
    settings.radius = settings.sigma <= 0.6f ? 2 : (settings.sigma <= 1.0f ? 3 : 4);
    return settings;
}

NTC_FUNCTION NtcStfExtent NtcStfMakeExtent(int width, int height, int levels) {
    NtcStfExtent extent;
    extent.width = width;
    extent.height = height;
    extent.levels = levels;
    return extent;
}

/// Texels of one side at a mip.
NTC_FUNCTION int NtcStfGetMipSize(int size, int mip) {
    return max(size >> min(max(mip, 0), 15), 1);
}

NTC_NAMESPACE_END

#endif
