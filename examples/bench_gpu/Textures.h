// SPDX-License-Identifier: MIT
// `bench_gpu SHADER_FOLDER --textures 1`: what passes/DecompressToTextures takes beside a decode to a buffer.
#pragma once

#include "Benchmark.h"

namespace openntc::bench {

/// For every line of textures.txt that the device can run, in turns: all 16 channels to a buffer of binary16, and the same
/// channels to four RGBA16F images, the same number of bytes. Returns 1 if a driver refuses or a number is off by more than
/// a step of binary16.
int PrintTextures(harness::Context& device, const Options& options);

} // namespace openntc::bench
