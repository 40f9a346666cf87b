// SPDX-License-Identifier: MIT
// Where the mips of a tail lie in its one tile.
#ifndef OPENNTC_RENDERER_FEEDBACK_TAIL_H
#define OPENNTC_RENDERER_FEEDBACK_TAIL_H

#include "openntc/Portability.h"

NTC_NAMESPACE_BEGIN

/// The first texel of mip `index` of a tail, whose first mip has at most half the texels of a tile along each axis, each
/// other one half of the one before; a multiple of 4 for blocks. tileSize: 16 or more, a power of two.
NTC_FUNCTION int2 NtcrGetTailPlace(int tileSize, int index) {
    if (index == 0)
        return int2(0, 0);
    int y = 0;
    NTC_LOOP for (int i = 1; i < index; i++) y += max(tileSize >> (i + 1), 4);
    return int2(tileSize / 2, y);
}

NTC_NAMESPACE_END

#endif
