// SPDX-License-Identifier: MIT
#include "shader/TestDevice.h"

#include <doctest/doctest.h>

#include <cstdlib>
#include <string>

namespace openntc_tests {

using namespace openntc;
using namespace openntc::harness;

std::string GetTestDeviceName() {
    const char* name = std::getenv("OPENNTC_TEST_DEVICE");
    return name != nullptr ? name : kLavapipe;
}

namespace {

struct TestDevice {
    std::unique_ptr<Context> context;
    std::string reason;
};

TestDevice Open() {
    TestDevice result;
    ContextOptions options;
    options.device = GetTestDeviceName();
    options.validation = true;
    Expected<std::unique_ptr<Context>> context = Context::Create(options);
    if (!context && std::string(context.error().GetText()).find("VK_LAYER") != std::string::npos) {
        MESSAGE("SKIP: validation of Vulkan calls: " << std::string(context.error().GetText()));
        options.validation = false;
        context = Context::Create(options);
    }
    if (context) {
        result.context = std::move(*context);
        const DeviceInfo& device = result.context->GetDevice();
        MESSAGE("device: " << device.name << ", driver: " << device.driver);
    } else {
        result.reason = context.error().GetText();
    }
    return result;
}

} // namespace

Context* GetTestContext() {
    static const TestDevice device = Open();
    if (device.context == nullptr)
        MESSAGE("SKIP: " << device.reason);
    return device.context.get();
}

} // namespace openntc_tests
