// SPDX-License-Identifier: MIT
#include "consumer_shaders.h"

// SPIR-V begins with its magic number.
static const bool kChecked = [] {
    for (const char* version : {"NETWORK_VERSION=1", "NETWORK_VERSION=4"}) {
        const auto shader = consumer_shaders::FindShader("texel.comp", version);
        if (!shader || shader->empty() || shader->front() != 0x07230203u)
            __builtin_abort();
    }
    return true;
}();
