// SPDX-License-Identifier: MIT
// The page table in shaders: where a texel's tile is, which coarser mip is there instead, requests for what
// is missing, stamps on what is read.
//
//   NtcStreamingContext context = NtcMakeStreamingContext(constants, NtcGetThreadSeed(thread));
//   bool resident;
//   int sampledMip;
//   if (NtcSampleTextureSetTiled(context, id, desc, NTC_LATENTS, 0u, NTC_WEIGHTS, 0u, texel, mip, false,
//                                outputs, resident, sampledMip))
//       ... // outputs are those of sampledMip; resident: of the mip that was asked for
//
// Works in compute, fragment and ray-tracing shaders. Each missing tile is requested once a launch, by the
// first thread that finds it missing; lookups themselves take no atomics. Helper lanes of fragment shaders
// write nothing (the languages see to that).
//
// An engine with a table of its own defines NtcGetTileSlot(context, header, tile): the slot of a tile, or
// NTC_TILE_MISSING; or the accessors of StreamingBuffers.h, if only the memory is its own.
#ifndef OPENNTC_STREAMING_PAGE_TABLE_H
#define OPENNTC_STREAMING_PAGE_TABLE_H

#include "ResidencyMap.h"
#include "TileLookup.h"
#if defined(NETWORK_VERSION) || defined(__cplusplus)
#include "TextureSetTiles.h"
#endif

#endif
