// SPDX-License-Identifier: MIT
// Stability: stable
// The other half of core/HideMacros.h.

#pragma pop_macro("Status")
#pragma pop_macro("None")
#pragma pop_macro("Bool")
#pragma pop_macro("True")
#pragma pop_macro("False")
#pragma pop_macro("Success")
#pragma pop_macro("TileShape")
#pragma pop_macro("Always")
#pragma pop_macro("min")
#pragma pop_macro("max")
#pragma pop_macro("abs")
#pragma pop_macro("round")
