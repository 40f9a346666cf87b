// SPDX-License-Identifier: MIT
// What Landscape.comp is given and what it writes: the one layout that C++ and GLSL share.
#ifndef OPENNTC_LANDSCAPE_CONSTANTS_H
#define OPENNTC_LANDSCAPE_CONSTANTS_H

#define LANDSCAPE_SKY 0xFFFFFFFFu // LandscapePixel::field: no ground was hit

// LandscapePixel::state
#define LANDSCAPE_RESIDENT 0x10000u // the mip that was wanted was there
#define LANDSCAPE_DECODED 0x20000u  // something was there, and outputs are its

#if defined(__cplusplus)
#include "openntc/streaming/StreamingConstants.h"
namespace openntc::landscape {
using uint = std::uint32_t;
#define LANDSCAPE_FLOAT4(name) float name[4]
#else
#define LANDSCAPE_FLOAT4(name) vec4 name
#endif

/// A frame: camera, ground and screen, 192 bytes.
struct LandscapeScene {
    NtcStreamingConstants launch;
    LANDSCAPE_FLOAT4(eye);   // metres; y is up
    LANDSCAPE_FLOAT4(right); // per pixel
    LANDSCAPE_FLOAT4(down);  // per pixel
    LANDSCAPE_FLOAT4(first); // direction through the centre of the upper left pixel
    LANDSCAPE_FLOAT4(sun);   // direction to it
    uint width;              // pixels
    uint height;
    uint columns; // fields across (x) and down (z)
    uint rows;
    float fieldSize; // metres
    uint setSize;    // texels of a field
    uint mips;
    uint frame;
    uint padding0;
    uint padding1;
    uint padding2;
    uint padding3;
};

/// A field: a texture set over fieldSize x fieldSize metres, 48 bytes.
struct LandscapeField {
    uint textureId; // of the page table
    uint set;       // number of its constants
    uint weightsOffset;
    uint latentsOffset; // of the whole set, where all of it is there
    uint color;         // first of three outputs
    uint normal;        // likewise; 16: none
    uint padding0;
    uint padding1;
    LANDSCAPE_FLOAT4(tint);
};

/// What a pixel was decoded from and to, 80 bytes.
struct LandscapePixel {
    uint field;
    int x; // texel of the mip that was decoded
    int y;
    uint state; // that mip, bits 0 ... 7; the wanted one, 8 ... 15; LANDSCAPE_*
    float outputs[16];
};

#if defined(__cplusplus)
static_assert(sizeof(LandscapeScene) == 192);
static_assert(sizeof(LandscapeField) == 48);
static_assert(sizeof(LandscapePixel) == 80);
} // namespace openntc::landscape
#endif
#undef LANDSCAPE_FLOAT4

#endif
