// SPDX-License-Identifier: MIT
// What benchmarks of passes share: their options, and ending with a message. They say what they are called first.
#pragma once

#include "vulkan_harness/Vulkan.h"

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <type_traits>
#include <utility>

namespace openntc::harness {

/// The program that measures frames, for messages.
struct FrameBench {
    const char* name;
    std::uint32_t leastSize; // a multiple of 64
};

struct FrameOptions {
    std::string device = kLavapipe;
    std::uint32_t size = 512; // of a square picture, a multiple of 64
    std::uint32_t frames = 9;
    bool json = false;
};

/// The value, or the end of the program: 4 without a device, as ntc has it, 1 otherwise.
template <typename T>
T RequireOrExit(const FrameBench& bench, Expected<T> result) {
    if (!result) {
        std::fprintf(stderr, "%s: %s\n", bench.name, result.error().GetText());
        std::exit(result.error().GetStatus() == Status::Unsupported ? 4 : 1);
    }
    if constexpr (!std::is_void_v<T>)
        return std::move(*result);
}

/// `[--device NAME] [--size N] [--frames N] [--json]`; ends with how it is used, and 2, for anything else.
inline FrameOptions ReadFrameOptions(const FrameBench& bench, int count, char** arguments) {
    FrameOptions options;
    for (int i = 1; i < count; ++i) {
        const std::string name = arguments[i];
        if (name == "--json") {
            options.json = true;
            continue;
        }
        const bool isNumber = name == "--size" || name == "--frames";
        const long number = i + 1 < count && isNumber ? std::strtol(arguments[i + 1], nullptr, 10) : 0;
        if (i + 1 < count && name == "--device")
            options.device = arguments[++i];
        else if (name == "--size" && number >= bench.leastSize && number <= 8192 && number % 64 == 0)
            options.size = static_cast<std::uint32_t>(number), ++i;
        else if (name == "--frames" && number >= 1 && number <= 10000)
            options.frames = static_cast<std::uint32_t>(number), ++i;
        else {
            std::fprintf(stderr,
                         "usage: %s [--device NAME] [--size %u ... 8192, a multiple of 64] "
                         "[--frames 1 ... 10000] [--json]\n",
                         bench.name, bench.leastSize);
            std::exit(2);
        }
    }
    return options;
}

} // namespace openntc::harness
