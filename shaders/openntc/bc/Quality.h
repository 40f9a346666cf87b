// SPDX-License-Identifier: MIT
// How much search a block encoder does.
#ifndef OPENNTC_BC_QUALITY_H
#define OPENNTC_BC_QUALITY_H

#define NTC_BC_QUALITY_FAST 0
#define NTC_BC_QUALITY_NORMAL 1
#define NTC_BC_QUALITY_BEST 2

#endif
