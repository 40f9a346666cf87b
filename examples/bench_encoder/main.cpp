// SPDX-License-Identifier: MIT
// bench_encoder MANIFEST [--steps N] [--rounds N]: trains a material with each kernel that this machine runs, in turns, on one
// thread; milliseconds of processor time a step beside what the multiply-adds alone would take. bench_encoder MANIFEST --device NAME: on
// a device; milliseconds that pass in a step of 65 536 texels. bench_encoder --memory: bytes that an encoding takes.
#include "Memory.h"
#include "Peak.h"

#include "Arguments.h"
#include "Failure.h"
#include "Interrupt.h"
#include "RunMain.h"
#include "encode/DeviceTraining.h"
#include "encode/EncodeInputs.h"
#include "encode/Training.h"
#include "report/Spread.h"

#include "openntc/encode/Kernels.h"
#include "openntc/format/NetworkDescription.h"

#include <CLI/CLI.hpp>

#include <chrono>
#include <cstdio>
#include <ctime>
#include <optional>
#include <string>
#include <vector>

namespace {

using namespace openntc;

/// Texels of a training step, and products of the forward pass for each that the backward pass and the weights' gradients
/// need again.
constexpr double kStepTexels = 4096.0;
constexpr double kPasses = 3.0;
constexpr std::uint64_t kMemorySteps = 10;
constexpr double kLargeStepTexels = 65536.0; ///< of devices
constexpr std::uint64_t kSteps = 400, kDeviceSteps = 100000;

struct Options {
    std::string manifest;
    std::uint64_t steps = 0; ///< 0: kSteps or kDeviceSteps
    int rounds = 5;
    float bitsPerPixel = 4.0f;
    int generation = 1;
    int batch = 65536; ///< of a device
    bool isMemory = false;
    std::vector<int> sizes = {512, 1024, 2048, 4096};
    std::optional<std::string> device;
};

struct Measured {
    encode::KernelChoice kernel;
    std::string name; ///< as a result says it
    std::vector<double>
        milliseconds;     ///< of processor time a step, one for each round; of a device all that passes
    double seconds = 0.0; ///< likewise, the whole encoding
    double psnr = 0.0;
};

double GetProcessorSeconds() {
    return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

double GetPassedSeconds() {
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

int GetNetworkVersion(const Options& options) {
    return options.generation == 3 ? NTC_NETWORK_GENERATION_3 : NTC_NETWORK_MEDIUM;
}

/// The steps between the first tenth and the eighth: later latents are refined, and FP8 networks trained.
struct TrainingWindow {
    std::uint64_t steps = 0; ///< of the training
    std::uint64_t first = 0, last = 0;
    double begin = 0.0, end = 0.0;
    bool isOver = false;

    void Add(std::uint64_t step, double seconds) {
        isOver = isOver || step >= steps * 8 / 10;
        if (isOver)
            return;
        if (step <= steps / 10) {
            first = step;
            begin = seconds;
        } else {
            last = step;
            end = seconds;
        }
    }
    /// Of kStepTexels; the first batch must end within the first tenth.
    double GetMilliseconds() const { return (end - begin) * 1e3 / static_cast<double>(last - first); }
};

/// With the kernel of `measured`, or on the device.
void Train(const Options& options, const tool::EncodeInputs& inputs, Measured& measured) {
    encode::EncodeOptions encode;
    encode.steps = options.steps;
    encode.bitsPerPixel = options.bitsPerPixel;
    encode.networkVersion = GetNetworkVersion(options);
    encode.threads = options.device ? 0 : 1;
    encode.kernel = measured.kernel;
    encode.batchTexels = options.device ? options.batch : 0;
    encode.maskChannel = inputs.maskChannel;
    encode.lossScales = inputs.lossScales;
    encode.reportSeconds = 0.0; // every step
    const auto getSeconds = options.device ? GetPassedSeconds : GetProcessorSeconds;
    TrainingWindow window{options.steps};
    const double start = getSeconds();
    const auto watch = [&](const encode::Progress& progress) {
        window.Add(progress.step, getSeconds());
        tool::ThrowIfInterrupted();
        return true;
    };
    const auto result = options.device ? tool::TrainOnVulkan(*options.device, inputs.material, encode, watch)
                                       : tool::Train(inputs.material, encode, watch);
    if (!result) {
        const bool isAbsent = result.error().GetStatus() == Status::Unsupported;
        throw tool::CommandError(isAbsent ? tool::ExitCode::NoDevice : tool::ExitCode::Failed,
                                 options.manifest, result.error().GetText());
    }
    measured.seconds = getSeconds() - start;
    measured.milliseconds.push_back(window.GetMilliseconds());
    measured.psnr = result->psnr;
    measured.name = result->kernel;
}

void Print(const Measured& measured, double products) {
    const report::Spread ms = report::Summarise(measured.milliseconds);
    std::printf("| `%s` | %.2f (%.2f – %.2f) | %.0f | ", encode::KernelToString(measured.kernel), ms.median,
                ms.lowerQuartile, ms.upperQuartile, 1e3 / ms.median);
    const double peak = bench::MeasurePeak(measured.kernel);
    if (peak > 0.0)
        std::printf("%.2f | %.0f %% | ", products * 1e3 / peak, products * 1e5 / peak / ms.median);
    else
        std::printf("– | – | ");
    std::printf("%.2f | %.2f |\n", measured.seconds, measured.psnr);
}

int RunOnDevice(const Options& options, const tool::EncodeInputs& inputs) {
    Measured measured{encode::KernelChoice::Best, {}, {}};
    for (int round = 0; round < options.rounds; ++round)
        Train(options, inputs, measured);
    for (double& ms : measured.milliseconds)
        ms *= kLargeStepTexels / kStepTexels;
    const report::Spread ms = report::Summarise(measured.milliseconds);
    std::printf(
        "| kernel | generation | bits per pixel | texels a step | ms for 65 536 texels (quartiles) | million "
        "texel-samples a second | s of all | PSNR, dB |\n|---|---|---|---|---|---|---|---|\n");
    std::printf("| `%s` | %d | %g | %d | %.4f (%.4f – %.4f) | %.4g | %.2f | %.2f |\n", measured.name.c_str(),
                options.generation, static_cast<double>(options.bitsPerPixel), options.batch, ms.median,
                ms.lowerQuartile, ms.upperQuartile, kLargeStepTexels * 1e-3 / ms.median, measured.seconds,
                measured.psnr);
    return 0;
}

int Run(const Options& options) {
    tool::InputOptions input;
    input.paths = {options.manifest};
    const tool::EncodeInputs inputs = tool::LoadInputs(input);
    if (options.device)
        return RunOnDevice(options, inputs);
    std::vector<Measured> all;
    for (const encode::KernelChoice kernel : encode::kKernels) {
        if (encode::IsKernelAvailable(kernel) && encode::IsKernelFor(kernel, GetNetworkVersion(options)))
            all.push_back({kernel, {}, {}});
    }
    for (int round = 0; round < options.rounds; ++round) {
        for (Measured& measured : all)
            Train(options, inputs, measured);
    }
    const NetworkDescription network = GetNetworkDescription(GetNetworkVersion(options));
    double weights = 0.0;
    for (int layer = 0; layer < kNetworkLayers; ++layer)
        weights += static_cast<double>(network.inputs[static_cast<std::size_t>(layer)] *
                                       network.outputs[static_cast<std::size_t>(layer)]);
    const double products = weights * kPasses * kStepTexels;
    std::printf("| kernel | ms CPU a step (quartiles) | steps/s | limit, ms | of the limit | CPU s of %llu "
                "steps | PSNR, dB "
                "|\n|---|---|---|---|---|---|---|\n",
                static_cast<unsigned long long>(options.steps));
    for (const Measured& measured : all)
        Print(measured, products);
    return 0;
}

int PrintMemory(const Options& options) {
    std::printf("| size | host, MB | device, MB | seconds |\n|---|---|---|---|\n");
    for (const int size : options.sizes) {
        const bench::MemoryUse use =
            bench::MeasureMemory({size, options.bitsPerPixel, kMemorySteps, options.device});
        std::printf("| %d x %d | %.0f | ", size, size, static_cast<double>(use.hostBytes) * 1e-6);
        if (options.device)
            std::printf("%.0f", static_cast<double>(use.deviceBytes) * 1e-6);
        std::printf(" | %.1f |\n", use.seconds);
        std::fflush(stdout);
    }
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    CLI::App app("What a training step costs with each kernel of this machine", "bench_encoder");
    Options options;
    CLI::Option* manifest =
        app.add_option("manifest", options.manifest, "A material, as `ntc encode` takes it");
    CLI::Option* memory =
        app.add_flag("--memory", options.isMemory,
                     "Instead: bytes that encodings of 16 channels take, on the host and on --device")
            ->excludes(manifest);
    app.add_option("--sizes", options.sizes, "Of these square images, with --memory")
        ->delimiter(',')
        ->check(CLI::Range(4, 16384))
        ->needs(memory)
        ->capture_default_str();
    CLI::Option* device = app.add_option("--device", options.device, "Train on this Vulkan device");
    app.add_option("--batch", options.batch, "Texels of a step on the device, multiples of 1024")
        ->check(CLI::Range(1024, 65536))
        ->needs(device)
        ->excludes(memory)
        ->capture_default_str();
    app.add_option("--generation", options.generation, "Of the file, 1 or 3")
        ->check(CLI::IsMember({1, 3}))
        ->excludes(memory)
        ->capture_default_str();
    app.add_option("--steps", options.steps,
                   "Training steps of 4096 texels of each encoding: 400, on a device 100000")
        ->check(CLI::Range(20, 10000000));
    app.add_option("--rounds", options.rounds, "Encodings with each kernel, in turns")
        ->check(CLI::Range(1, 1000))
        ->capture_default_str();
    app.add_option("--bits-per-pixel", options.bitsPerPixel, "Of the latents")->capture_default_str();
    CLI11_PARSE(app, argc, argv);
    return tool::RunMain("bench_encoder", [&options] {
        if (options.isMemory)
            return PrintMemory(options);
        if (options.manifest.empty())
            throw tool::CommandError(tool::ExitCode::Usage, "manifest", "missing: a material is required");
        if (options.steps == 0)
            options.steps = options.device ? kDeviceSteps : kSteps;
        const auto least = static_cast<std::uint64_t>(10.0 * options.batch / kStepTexels);
        if (options.device && options.steps < least)
            tool::FailUsage("--steps", std::to_string(options.steps) + ": must be " + std::to_string(least) +
                                           " or more with this batch");
        return Run(options);
    });
}
