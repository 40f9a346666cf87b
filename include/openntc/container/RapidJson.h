// SPDX-License-Identifier: MIT
// Stability: internal
// RapidJSON's reader, included so that its warnings never reach a user's build.
#pragma once

#if defined(__GNUC__) || defined(__clang__)
#pragma GCC system_header
#elif defined(_MSC_VER)
#pragma warning(push, 0)
#endif

// RapidJSON 1.1 asks whether its empty stack has room by adding to a null pointer, which is harmless on every
// machine but stops a build with Clang's sanitizer.
#include "openntc/core/HideMacros.h"
#if defined(__clang__)
#pragma clang attribute push(__attribute__((no_sanitize("pointer-overflow"))), apply_to = function)
#endif
#include <rapidjson/error/en.h>
#include <rapidjson/reader.h>
#if defined(__clang__)
#pragma clang attribute pop
#endif
#include "openntc/core/RestoreMacros.h"

#if defined(_MSC_VER) && !defined(__clang__)
#pragma warning(pop)
#endif
