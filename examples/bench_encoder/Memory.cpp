// SPDX-License-Identifier: MIT
#include "Memory.h"

#include "Failure.h"
#include "Output.h"
#include "encode/DeviceTraining.h"
#include "encode/EncodeInputs.h"
#include "encode/StateFile.h"
#include "encode/Training.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <span>
#include <vector>

#if !defined(_WIN32)
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#endif
#if defined(OPENNTC_BENCH_HAS_VULKAN)
#include "vulkan_harness/ForwardingDevice.h"
#include "vulkan_harness/TrainingQueue.h"
#endif

namespace openntc::bench {

#if defined(_WIN32)

MemoryUse MeasureMemory(const MemoryRequest&) {
    throw tool::CommandError(tool::ExitCode::Usage, "--memory", "needs processes of POSIX");
}

#else

using tool::CommandError;
using tool::ExitCode;
using tool::Format;

namespace {

namespace fs = std::filesystem;

/// A folder that is removed.
class Scratch {
public:
    Scratch() : path_(fs::temp_directory_path() / Format("bench_encoder-%d", static_cast<int>(getpid()))) {
        fs::create_directories(path_);
    }
    ~Scratch() {
        std::error_code ignored;
        fs::remove_all(path_, ignored);
    }
    Scratch(const Scratch&) = delete;
    Scratch& operator=(const Scratch&) = delete;
    const fs::path& Get() const { return path_; }

private:
    fs::path path_;
};

/// Five images of three channels and one of one: 16 channels, none of them constant.
std::vector<std::string> WriteImages(const fs::path& folder, int size) {
    std::vector<std::string> paths;
    std::uint32_t random = 1;
    for (int i = 0; i < 6; ++i) {
        const bool isGray = i == 5;
        const std::string header = Format("P%d\n%d %d\n255\n", isGray ? 5 : 6, size, size);
        std::vector<std::byte> texels(static_cast<std::size_t>(size) * static_cast<std::size_t>(size) *
                                      (isGray ? 1u : 3u));
        for (std::byte& texel : texels) {
            random = random * 1664525u + 1013904223u;
            texel = static_cast<std::byte>(random >> 27); // 0 ... 31
        }
        paths.push_back((folder / Format("image%d.%s", i, isGray ? "pgm" : "ppm")).string());
        tool::WriteWholeFile(paths.back(), {std::as_bytes(std::span(header)), texels});
    }
    return paths;
}

#if defined(OPENNTC_BENCH_HAS_VULKAN)
/// Adds up the buffers of a plan on its way to the device.
class CountingDevice final : public harness::ForwardingDevice {
public:
    CountingDevice(encode::TrainingDevice& device, std::uint64_t& bytes)
        : ForwardingDevice(device), bytes_(bytes) {}
    Expected<void> Create(const encode::TrainingPlan& wanted) override {
        std::uint64_t sum = 0;
        for (const std::uint64_t bytes : wanted.bytes)
            sum += bytes;
        bytes_ = std::max(bytes_, sum);
        return ForwardingDevice::Create(wanted);
    }

private:
    std::uint64_t& bytes_;
};

Expected<encode::EncodeResult> TrainOnDevice(const std::string& name, encode::Material&& material,
                                             const encode::EncodeOptions& options, std::uint64_t& bytes) {
    harness::ContextOptions contextOptions;
    contextOptions.device = name;
    OPENNTC_ASSIGN(const std::unique_ptr<harness::Context> context, harness::Context::Create(contextOptions));
    OPENNTC_ASSIGN(const std::unique_ptr<encode::TrainingDevice> queue, harness::MakeTrainingQueue(*context));
    CountingDevice device(*queue, bytes);
    return tool::Train(std::move(material), options, device, {});
}
#else
Expected<encode::EncodeResult> TrainOnDevice(const std::string&, encode::Material&&,
                                             const encode::EncodeOptions&, std::uint64_t&) {
    return Fail(Status::Unsupported, "device: this build has no Vulkan");
}
#endif

/// Returns the bytes on the device.
std::uint64_t Encode(const MemoryRequest& request, const std::vector<std::string>& images) {
    tool::InputOptions input;
    input.paths = images;
    tool::EncodeInputs inputs = tool::LoadInputs(input);
    encode::EncodeOptions options;
    options.steps = request.steps;
    options.bitsPerPixel = request.bitsPerPixel;
    std::uint64_t bytes = 0;
    Expected<encode::EncodeResult> result =
        request.device ? TrainOnDevice(*request.device, std::move(inputs.material), options, bytes)
                       : tool::Train(std::move(inputs.material), options, {});
    tool::Require(std::move(result), request.device ? ExitCode::NoDevice : ExitCode::Failed, "memory");
    return bytes;
}

/// Writes the bytes on the device, or why there is no encoding, and ends the process.
[[noreturn]] void RunChild(const MemoryRequest& request, const std::vector<std::string>& images,
                           int answers) {
    ExitCode code = ExitCode::Ok;
    std::string answer;
    try {
        answer = Format("%llu", static_cast<unsigned long long>(Encode(request, images)));
    } catch (const CommandError& error) {
        code = error.GetCode();
        answer = error.what();
    } catch (const std::exception& error) {
        code = ExitCode::Failed;
        answer = error.what();
    }
    const bool isWritten =
        write(answers, answer.data(), answer.size()) == static_cast<ssize_t>(answer.size());
    _exit(isWritten ? static_cast<int>(code) : 1); // no destructors of what belongs to the parent
}

} // namespace

MemoryUse MeasureMemory(const MemoryRequest& request) {
    const Scratch scratch;
    const std::vector<std::string> images = WriteImages(scratch.Get(), request.size);
    const auto start = std::chrono::steady_clock::now();
    int ends[2];
    if (pipe(ends) != 0)
        throw CommandError(ExitCode::Failed, "memory", "pipe: refused by the system");
    const pid_t child = fork();
    if (child == 0)
        RunChild(request, images, ends[1]);
    close(ends[1]);
    std::string answer;
    char part[512];
    for (ssize_t count = 0; (count = read(ends[0], part, sizeof(part))) > 0;)
        answer.append(part, static_cast<std::size_t>(count));
    close(ends[0]);
    int status = 0;
    rusage usage{};
    if (child < 0 || wait4(child, &status, 0, &usage) != child || !WIFEXITED(status))
        throw CommandError(
            ExitCode::Failed, "memory",
            Format("%d x %d: the encoding was ended by the system", request.size, request.size));
    if (WEXITSTATUS(status) != 0)
        throw CommandError(static_cast<ExitCode>(WEXITSTATUS(status)), "memory", answer);
    MemoryUse use;
    use.deviceBytes = std::strtoull(answer.c_str(), nullptr, 10);
    use.hostBytes = static_cast<std::uint64_t>(usage.ru_maxrss) * 1024u; // Linux counts kilobytes
    use.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return use;
}

#endif

} // namespace openntc::bench
