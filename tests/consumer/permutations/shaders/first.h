// SPDX-License-Identifier: MIT
#include "both.h"
#define FIRST_VALUE (BOTH_VALUE + 100)
