// SPDX-License-Identifier: MIT
// What lies beyond the edge of a texture. Declares nothing.
#ifndef OPENNTC_WRAP_MODES_H
#define OPENNTC_WRAP_MODES_H

#define NTC_WRAP_REPEAT 0
#define NTC_WRAP_CLAMP 1
#define NTC_WRAP_MIRROR 2
#define NTC_WRAP_BORDER 3 // no texel; not for tiled textures

#endif
