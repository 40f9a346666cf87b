// SPDX-License-Identifier: MIT
// Stability: internal
// AMX and AVX-512: is it there, and the small conversions that the kernel's parts share.
#pragma once

#include "openntc/core/Processor.h"
#include "openntc/encode/detail/LatentStore.h"

#if OPENNTC_DETECT_AMX
#define OPENNTC_ENCODE_AMX 1

#include <cstring>
#include <immintrin.h>

#if !defined(__clang__)
// g++ 12 warns about its own headers: they initialise "undefined" vectors with themselves (GCC bug 105593).
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wuninitialized"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#pragma GCC diagnostic ignored "-Wsign-conversion" // intrinsics are macros without optimisation
#endif

#define OPENNTC_AMX_TARGET                                                                                   \
    __attribute__((target("avx512f,avx512bw,avx512dq,avx512vl,avx512bf16,fma,avx2,amx-tile,amx-bf16")))

#include "openntc/core/HideMacros.h"

namespace openntc::encode::detail {

/// Two rows of floats to one row of bfloat16 pairs, truncated (exact for integers up to 256).
OPENNTC_AMX_TARGET inline __m512i PackPair(__m512 even, __m512 odd) {
    const __m512i high = _mm512_set1_epi32(static_cast<int>(0xffff0000u));
    return _mm512_ternarylogic_epi32(_mm512_srli_epi32(_mm512_castps_si512(even), 16),
                                     _mm512_castps_si512(odd), high, 0xf8 /* a | (b & c) */);
}
OPENNTC_AMX_TARGET inline __m512i PackTexels(__m512 first, __m512 second) {
    return reinterpret_cast<__m512i>(_mm512_cvtne2ps_pbh(second, first));
}

OPENNTC_AMX_TARGET inline __m512 Floor(__m512 v) {
    return _mm512_roundscale_ps(v, _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC);
}

} // namespace openntc::encode::detail

#if !defined(__clang__)
#pragma GCC diagnostic pop
#endif

#include "openntc/core/RestoreMacros.h"
#endif
