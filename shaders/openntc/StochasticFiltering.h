// SPDX-License-Identifier: MIT
// Texture filtering where a texel is costly: one texel, drawn with the probability that the filter gives it
// as its weight, in the place of all of them (Pharr, Wronski, Salvi and Fajardo 2024); and the same filters
// with all their texels, as the reference. For texture sets, and for anything else that has texels: declares
// no resource, reads nothing. docs/filtering.md shows how to use it.
//
//   NtcStfMakeSampler, NtcStfMakeGaussian   a filter: kernel, mips, what is beyond the edge
//   NtcStfGetFootprint                      derivatives to level of detail and anisotropic taps
//   NtcStfRandom…                           random numbers: hashed, or R2 over frames
//   NtcStfSample, NtcStfSamplePair          the texel to read, or two for kernels with negative weights
//   NTC_STF_DEFINE_FILTER                   a function that reads all texels through a function of yours
// filtering/StfCollaborate.h lets the lanes of a wave divide texels among themselves, filtering/StfShare.h
// lets them share those they drew. Both want subgroup operations and are included by who has them.
//
// Decisions are made in integers, so the same numbers give the same texels in GLSL, HLSL and C++; only the
// weights of the Gaussian hang on the device's exp().
#ifndef OPENNTC_STOCHASTIC_FILTERING_H
#define OPENNTC_STOCHASTIC_FILTERING_H

#include "Portability.h"
#include "TexelCoords.h"
#include "filtering/StfFootprint.h"
#include "filtering/StfKernels.h"
#include "filtering/StfMultiTap.h"
#include "filtering/StfRandom.h"
#include "filtering/StfSample.h"
#include "filtering/StfTypes.h"

#endif
