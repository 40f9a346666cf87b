// SPDX-License-Identifier: MIT
#include "openntc/WrapModes.h"
