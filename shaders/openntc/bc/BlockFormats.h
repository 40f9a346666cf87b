// SPDX-License-Identifier: MIT
// Block-compressed formats by number, and where passes read texels and write blocks.
#ifndef OPENNTC_BC_BLOCK_FORMATS_H
#define OPENNTC_BC_BLOCK_FORMATS_H

// NTC_BC_FORMAT of a permutation; openntc::bc::BlockFormat has the same values.
#define NTC_BC_BC1 0
#define NTC_BC_BC2 1
#define NTC_BC_BC3 2
#define NTC_BC_BC4_UNSIGNED 3
#define NTC_BC_BC4_SIGNED 4
#define NTC_BC_BC5_UNSIGNED 5
#define NTC_BC_BC5_SIGNED 6
#define NTC_BC_BC6_UNSIGNED 7
#define NTC_BC_BC6_SIGNED 8
#define NTC_BC_BC7 9
// NTC_BC_SOURCE and NTC_BC_TARGET of CompressBlocks.
#define NTC_BC_BUFFER 0
#define NTC_BC_IMAGE 1

#endif
