// SPDX-License-Identifier: MIT
#include "consumer_shaders.h"
#include "openntc/adapter/openntc_adapter.h"

static_assert(OPENNTC_ADAPTER_VERSION == 1); // the header for `ntc conformance run --adapter` is installed

// SPIR-V begins with its magic number.
static const bool kChecked = [] {
    for (const char* version : {"NETWORK_VERSION=1", "NETWORK_VERSION=4"}) {
        const auto shader = consumer_shaders::FindShader("texel.comp", version);
        if (!shader || shader->empty() || shader->front() != 0x07230203u)
            __builtin_abort();
    }
    return true;
}();
