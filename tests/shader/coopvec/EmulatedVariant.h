// SPDX-License-Identifier: MIT
// The whole of a source file: InferenceCoopVec.h for EMULATED_NETWORK and EMULATED_MATH as the function EMULATED_NAME. No include
// guard and no unity build: the shader is another one in every file.
#include "EmulatedNetworks.h"
#include "Emulation.h"

// From here on what is compiled belongs to this file.
#undef NTC_MATH
#define NTC_MATH EMULATED_MATH
#define NETWORK_VERSION EMULATED_NETWORK
#undef NTC_FUNCTION
#define NTC_FUNCTION static
#define NTC_COOPVEC_EMULATED 1
#define NTC_COOPVEC_LAYOUT gl_CooperativeVectorMatrixLayoutRowMajorNV
#define NTC_COOPVEC_WEIGHTS gEmulatedWeights

namespace openntc::shader {
static CoopVecBuffer gEmulatedWeights;
}

#include "openntc/InferenceCoopVec.h"

namespace openntc_tests {

NTC_EMULATED_NETWORK(EMULATED_NAME) {
    openntc::shader::gEmulatedWeights = weights;
#if NTC_MATH == NTC_MATH_COOPVEC_FP8
    openntc::shader::NtcEvaluateE4M3CoopVec(0, layers, inputs.numbers, outputs);
#else
    openntc::shader::NtcEvaluateInt8CoopVec(0, layers, inputs.words, outputs);
#endif
}

} // namespace openntc_tests
