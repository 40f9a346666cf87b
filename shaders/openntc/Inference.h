// SPDX-License-Identifier: MIT
// Decoding a texel: latents to inputs, inputs through the network, outputs to linear light on request.
//
// A whole GLSL entry file (Vulkan 1.1; compile with -DNETWORK_VERSION=NTC_NETWORK_SMALL, one SPIR-V per
// network):
//
//   #version 460
//   #extension GL_GOOGLE_include_directive : require
//   #include "openntc/Inference.h"
//   layout(local_size_x = 8, local_size_y = 8) in;
//   layout(binding = 0) uniform Constants { NtcTextureSetConstants desc; };    // the 624 bytes, std140
//   layout(binding = 3, rgba8) writeonly uniform image2D result; // bindings 1 and 2: latents and weights
//   void main() {
//       float outputs[NTC_MAX_CHANNELS];
//       int2 texel = int2(gl_GlobalInvocationID.xy);
//       if (NtcSampleTextureSet(desc, NTC_LATENTS, 0u, NTC_WEIGHTS, 0u, texel, 0, false, outputs))
//           imageStore(result, texel, vec4(outputs[0], outputs[1], outputs[2], 1.0));
//   }
//
// Macros, defined before the first include:
//   NETWORK_VERSION   NTC_NETWORK_SMALL ... NTC_NETWORK_GENERATION_3; required in shaders
//   NTC_MATH          NTC_MATH_INT8 (when not defined), _INT8_HALF, _FP8, _FP16 or _FP32: see MathModes.h
//   NTC_DECODES_BLOCKS  by passes that decode blocks of texels with NetworkCoopMat.h, where NTC_MATH is
//                     _COOPMAT_INT8 or _COOPMAT_INT8_HALF
//   NTC_OUTPUT_MASK, NTC_LINEARISE, ...   what a scene needs of the decoder (when not defined: everything):
//                                         see Effects.h
//   NTC_DOT4_SPIRV, NTC_DOT4_SM64, NTC_NO_PRECISE, NTC_OPAQUE_ZERO: see Portability.h
//   NtcBuffer, NtcBufferLoad, NTC_DESCRIPTOR_SET, NTC_LATENTS_BINDING, NTC_WEIGHTS_BINDING: see Buffers.h
// Any header may be included first, and all of them may lie in one folder under another ending (*.ush): their
// includes of each other are names without a folder. In C++ the functions are in namespace openntc::shader
// and take network version and maths mode as first arguments.
#ifndef OPENNTC_INFERENCE_H
#define OPENNTC_INFERENCE_H

#include "InferenceTexel.h"
#include "InferenceTexels.h"

#endif
