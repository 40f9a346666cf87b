// SPDX-License-Identifier: MIT
// Stability: stable
// Macros of X11 (Status, None, Bool, …), of the Windows SDK (min, max) and of small platforms (abs, round)
// that would rewrite our names are put aside here and come back with core/RestoreMacros.h. Every header of
// ours includes the pair around its code, after what it includes; whoever includes a shader header in C++
// below such macros may do the same. No include guard: the pair nests.

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
