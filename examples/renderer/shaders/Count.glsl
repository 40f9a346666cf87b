// SPDX-License-Identifier: MIT
// Adds what this invocation has read to the counters. NTCR_COUNTED 0: nobody asks.
#ifndef OPENNTC_RENDERER_COUNT_GLSL
#define OPENNTC_RENDERER_COUNT_GLSL

void NtcrCount(uint counter, uint count) {
#if NTCR_COUNTED
    uint before = atomicAdd(gCounters[2u * counter], count);
    if (before + count < before) // the low word has run over
        atomicAdd(gCounters[2u * counter + 1u], 1u);
#endif
}

void NtcrCountTexels() {
    NtcrCount(0u, gTexels);
    NtcrCount(1u, gDecoded);
}

#endif
