// SPDX-License-Identifier: MIT
#define BOTH_VALUE 1000
