// SPDX-License-Identifier: MIT
// bench_encoder MANIFEST [--steps N] [--rounds N]: trains a material with each kernel that this machine runs, in turns, on one
// thread; milliseconds of processor time a step beside what the multiply-adds alone would take. bench_encoder --memory: bytes that an
// encoding takes.
#include "Memory.h"
#include "Peak.h"

#include "Failure.h"
#include "Interrupt.h"
#include "RunMain.h"
#include "encode/EncodeInputs.h"
#include "encode/Training.h"
#include "report/Spread.h"

#include "openntc/encode/Kernels.h"
#include "openntc/format/NetworkDescription.h"

#include <CLI/CLI.hpp>

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

struct Options {
    std::string manifest;
    std::uint64_t steps = 400;
    int rounds = 5;
    float bitsPerPixel = 4.0f;
    bool isMemory = false;
    std::vector<int> sizes = {512, 1024, 2048, 4096};
    std::optional<std::string> device;
};

struct Measured {
    encode::KernelChoice kernel;
    std::vector<double> milliseconds; ///< of processor time a step, one for each round
    double seconds = 0.0;             ///< of processor time, the whole encoding
    double psnr = 0.0;
};

double GetProcessorSeconds() {
    return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

void Train(const Options& options, const tool::EncodeInputs& inputs, Measured& measured) {
    encode::EncodeOptions encode;
    encode.steps = options.steps;
    encode.bitsPerPixel = options.bitsPerPixel;
    encode.threads = 1;
    encode.kernel = measured.kernel;
    encode.maskChannel = inputs.maskChannel;
    encode.lossScales = inputs.lossScales;
    encode.reportSeconds = 0.0; // every step
    // Between the first tenth and the last, in which latents are refined.
    std::uint64_t first = 0, last = 0;
    double begin = 0.0, end = 0.0;
    const double start = GetProcessorSeconds();
    const auto result = tool::Train(inputs.material, encode, [&](const encode::Progress& progress) {
        if (progress.step <= options.steps / 10) {
            first = progress.step;
            begin = GetProcessorSeconds();
        } else if (progress.step < options.steps * 9 / 10) {
            last = progress.step;
            end = GetProcessorSeconds();
        }
        tool::ThrowIfInterrupted();
        return true;
    });
    if (!result)
        throw tool::CommandError(tool::ExitCode::Failed, options.manifest, result.error().GetText());
    measured.seconds = GetProcessorSeconds() - start;
    measured.milliseconds.push_back((end - begin) * 1e3 / static_cast<double>(last - first));
    measured.psnr = result->psnr;
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

int Run(const Options& options) {
    tool::InputOptions input;
    input.paths = {options.manifest};
    const tool::EncodeInputs inputs = tool::LoadInputs(input);
    std::vector<Measured> all;
    for (const encode::KernelChoice kernel : encode::kKernels) {
        if (encode::IsKernelAvailable(kernel))
            all.push_back({kernel, {}});
    }
    for (int round = 0; round < options.rounds; ++round) {
        for (Measured& measured : all)
            Train(options, inputs, measured);
    }
    const NetworkDescription network = GetNetworkDescription(NTC_NETWORK_MEDIUM);
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
    app.add_option("--device", options.device, "Train on this Vulkan device, with --memory")->needs(memory);
    app.add_option("--steps", options.steps, "Training steps of each encoding")
        ->check(CLI::Range(20, 10000000))
        ->capture_default_str();
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
        return Run(options);
    });
}
