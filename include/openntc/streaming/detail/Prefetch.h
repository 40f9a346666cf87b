// SPDX-License-Identifier: MIT
// Stability: internal
// Asks for memory that is needed soon, where the compiler can say so: misses that would come one after the
// other
// overlap.
#pragma once

#include <cstddef>

#include "openntc/core/HideMacros.h"

namespace openntc::detail {

inline void Prefetch([[maybe_unused]] const void* address) noexcept {
#if defined(__GNUC__) || defined(__clang__)
    __builtin_prefetch(address);
#endif
}

inline void PrefetchBytes(const void* address, std::size_t bytes) noexcept {
    for (std::size_t offset = 0; offset < bytes; offset += 64)
        Prefetch(static_cast<const std::byte*>(address) + offset);
}

} // namespace openntc::detail

#include "openntc/core/RestoreMacros.h"
