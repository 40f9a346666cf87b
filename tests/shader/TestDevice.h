// SPDX-License-Identifier: MIT
// The one device that all shader tests share.
#pragma once

#include "vulkan_harness/Vulkan.h"

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace openntc_tests {

/// Name or index of the device under test: the environment variable OPENNTC_TEST_DEVICE, else lavapipe.
std::string GetTestDeviceName();

/// The device with the validation layer on, or null after printing "SKIP: reason" when there is none. Without
/// the layer the tests still run, after printing that nothing is validated.
openntc::harness::Context* GetTestContext();

/// Runs one compute shader over arrays of words: storage buffers 0 … inputs-1 hold the inputs, the next one
/// the result of `resultWords` words. Local size 64 along x, one push constant: `count`. Failures fail the
/// running test.
std::vector<std::uint32_t> RunOverWords(std::span<const std::uint32_t> spirv,
                                        std::span<const std::span<const std::uint32_t>> inputs,
                                        std::uint32_t count, std::size_t resultWords);

} // namespace openntc_tests

/// Declares `context`, or leaves the test after printing why.
#define OPENNTC_REQUIRE_DEVICE(context)                                                                      \
    openntc::harness::Context* const context = openntc_tests::GetTestContext();                              \
    if (context == nullptr)                                                                                  \
    return
