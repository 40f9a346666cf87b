// SPDX-License-Identifier: MIT
// What everything that runs on one Vulkan device shares.
#pragma once

#include "Failure.h"
#include "Interrupt.h"
#include "report/Device.h"

#include "vulkan_harness/Vulkan.h"

#include <chrono>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace openntc::report {

/// The value of an Expected of the harness.
template <typename T>
T RequireDevice(Expected<T>&& expected, const std::string& subject = "vulkan") {
    const bool isAbsent = !expected && expected.error().GetStatus() == Status::Unsupported;
    return tool::Require(std::move(expected), isAbsent ? tool::ExitCode::NoDevice : tool::ExitCode::Failed,
                         subject);
}

/// The device, and the buffer that all cases write to.
struct SharedDevice {
    std::unique_ptr<harness::Context> context;
    harness::Buffer results = {};
    bool quick = false;
    double busyUntil = -INFINITY; // seconds

    const harness::DeviceInfo& GetInfo() const { return context->GetDevice(); }
    void MakeResults(std::uint64_t size) {
        if (results.GetSize() < size) {
            results = {};
            results = RequireDevice(context->CreateBuffer(size, harness::BufferKind::Storage,
                                                          harness::BufferMemory::DeviceLocal));
        }
    }

    /// Nanoseconds of each dispatch.
    std::vector<double> Time(const harness::DispatchRequest& request, int repeats) {
        std::vector<double> times;
        // One submission on a GPU, whose clocks fall between them; one by one where a dispatch takes long.
        const int batch = GetInfo().isCpu ? 1 : repeats;
        for (int done = 0; done < repeats; done += batch) {
            tool::ThrowIfInterrupted();
            for (const double seconds :
                 RequireDevice(context->TimeDispatches(request, static_cast<std::uint32_t>(batch))))
                times.push_back(1e9 * seconds);
        }
        return times;
    }

    /// run(repeats), after a GPU's clocks have risen; after a pause they were seen to take half a second.
    template <typename Run>
    std::vector<double> TimeWarm(const Run& run, int repeats) {
        const double start = GetSeconds();
        const double warmUp = start - busyUntil > 0.2 ? 1.5 : quick ? 0.05 : 0.1;
        while (!GetInfo().isCpu && GetSeconds() - start < warmUp)
            run(8);
        std::vector<double> times = run(repeats);
        busyUntil = GetSeconds();
        return times;
    }

private:
    static double GetSeconds() {
        return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
    }
};

/// A case whose maths mode is for blocks of texels, on cooperative matrices. Null: none, and why in `skipped`.
std::unique_ptr<PreparedCase> PrepareOnMatrices(SharedDevice& shared, const Case& c, const Encoding& encoding,
                                                std::string& skipped);

/// The compute pass `CompressBlocks`, or nothing, and why in `skipped`.
std::vector<std::unique_ptr<PreparedBlocks>>
PrepareBlocksOnVulkan(SharedDevice& shared, const VulkanSettings& settings, const BlockCase& c,
                      const BlockTexture& texture, std::string& skipped);

} // namespace openntc::report
