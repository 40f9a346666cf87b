// SPDX-License-Identifier: MIT
// RapidJSON's reader, included so that its warnings never reach a user's build.
#pragma once

#if defined(__GNUC__) || defined(__clang__)
#pragma GCC system_header
#elif defined(_MSC_VER)
#pragma warning(push, 0)
#endif

#include <rapidjson/error/en.h>
#include <rapidjson/reader.h>

#if defined(_MSC_VER) && !defined(__clang__)
#pragma warning(pop)
#endif
