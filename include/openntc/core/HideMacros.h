// SPDX-License-Identifier: MIT
// Stability: stable
// Macros of X11 (Status, None, Bool, …), of the Windows SDK (min, max) and of small platforms (abs, round)
// that would rewrite our names are put aside here and come back with core/RestoreMacros.h. Every header of
// ours includes the pair around its code, after what it includes; whoever includes a shader header in C++
// below such macros may do the same. No include guard: the pair nests.
// Every header comes here before its first declaration, so this is the place to say what is needed.

#if !defined(OPENNTC_HAS_CXX20)
#define OPENNTC_HAS_CXX20 1
#if (defined(_MSVC_LANG) && _MSVC_LANG < 202002L) || (!defined(_MSVC_LANG) && __cplusplus <= 201703L)
#error "OpenNTC needs C++20: -std=c++20, /std:c++20, or target_compile_features(... cxx_std_20)"
#endif
#endif

#pragma push_macro("Status")
#pragma push_macro("None")
#pragma push_macro("Bool")
#pragma push_macro("True")
#pragma push_macro("False")
#pragma push_macro("Success")
#pragma push_macro("Always")
#pragma push_macro("TileShape")
#pragma push_macro("min")
#pragma push_macro("max")
#pragma push_macro("abs")
#pragma push_macro("round")
#undef Status
#undef None
#undef Bool
#undef True
#undef False
#undef Success
#undef Always
#undef TileShape
#undef min
#undef max
#undef abs
#undef round
