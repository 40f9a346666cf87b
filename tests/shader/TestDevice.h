// SPDX-License-Identifier: MIT
// The one device that all shader tests share.
#pragma once

#include "vulkan_harness/Vulkan.h"

#include <string>

namespace openntc_tests {

/// Name or index of the device under test: the environment variable OPENNTC_TEST_DEVICE, else lavapipe.
std::string GetTestDeviceName();

/// The device with the validation layer on, or null after printing "SKIP: reason" when there is none. Without
/// the layer the tests still run, after printing that nothing is validated.
openntc::harness::Context* GetTestContext();

} // namespace openntc_tests

/// Declares `context`, or leaves the test after printing why.
#define OPENNTC_REQUIRE_DEVICE(context)                                                                      \
    openntc::harness::Context* const context = openntc_tests::GetTestContext();                              \
    if (context == nullptr)                                                                                  \
    return
